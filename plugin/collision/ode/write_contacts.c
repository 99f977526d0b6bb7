#include "write_contacts.h"

#include "choose.h"
#include "support/vec3.h"

#include <stdbool.h>

int pinch_write_contacts(const pinch_tip_touches *touches, dGeomID g1, dGeomID g2, int room, dContactGeom *contacts,
                         int skip)
{
    pinch_touch points[PINCH_TOUCHES];
    int chosen[PINCH_TOUCHES], count = touches->count;
    bool all = count <= room;
    for (int k = 0; k < count && !all; k++) {
        pinch_v3_copy(points[k].position, touches->item[k].position);
        points[k].depth = touches->item[k].depth;
    }
    if (!all) count = pinch_choose_touches(points, count, room, chosen);
    for (int k = 0; k < count; k++) {
        const pinch_tip_touch *t = &touches->item[all ? k : chosen[k]];
        pinch_write_contact(t->position, t->normal, t->depth, g1, g2, pinch_contact_at(contacts, k, skip));
    }
    return count;
}
