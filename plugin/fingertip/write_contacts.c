#include "write_contacts.h"

#include "support/vec3.h"

#include <math.h>

/* More than there is room for: the deepest, then always the one farthest from those already chosen. */
static void choose(const pinch_tip_touches *touches, int room, int *chosen)
{
    double far[PINCH_TOUCHES];
    int next = 0;
    for (int k = 0; k < touches->count; k++) {
        far[k] = INFINITY;
        if (touches->item[k].depth > touches->item[next].depth) next = k;
    }
    for (int n = 0; n < room; n++) {
        chosen[n] = next;
        far[next] = -1;
        int best = -1;
        for (int k = 0; k < touches->count; k++) {
            double d[3];
            if (far[k] < 0) continue;
            pinch_v3_sub(touches->item[k].position, touches->item[chosen[n]].position, d);
            double apart = pinch_v3_dot(d, d);
            if (apart < far[k]) far[k] = apart;
            if (best < 0 || far[k] > far[best]) best = k;
        }
        next = best < 0 ? next : best;
    }
}

int pinch_write_contacts(const pinch_tip_touches *touches, dGeomID g1, dGeomID g2, int room, dContactGeom *contacts,
                         int skip)
{
    int chosen[PINCH_TOUCHES], count = touches->count;
    for (int k = 0; k < count; k++) chosen[k] = k;
    if (count > room) {
        choose(touches, room, chosen);
        count = room;
    }
    for (int k = 0; k < count; k++) {
        const pinch_tip_touch *t = &touches->item[chosen[k]];
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
