#include "write_contacts.h"

#include "choose.h"
#include "support/vec3.h"

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
        dContactGeom *c = (dContactGeom *)(void *)((char *)contacts + (size_t)k * (size_t)skip);
        pinch_v3_copy(c->pos, t->position);
        pinch_v3_copy(c->normal, t->normal);
        c->pos[3] = c->normal[3] = 0;
        c->depth = t->depth;
        c->g1 = g1;
        c->g2 = g2;
        c->side1 = c->side2 = -1;
    }
    return count;
}
