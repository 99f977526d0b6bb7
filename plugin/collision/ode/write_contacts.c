#include "collide.h"

#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

/* Of points that are as good as others to rounding the first one stays: moving the pair does not change what is kept.
 */
static const double TIE = 1e-9;

static double extent_of(const pinch_touch *touches, int count)
{
    double most = 0, d[3];
    for (int k = 1; k < count; k++) {
        pinch_v3_sub(touches[k].position, touches[0].position, d);
        double apart2 = pinch_v3_dot(d, d);
        most = apart2 > most ? apart2 : most;
    }
    return sqrt(most);
}

static int deepest_of(const pinch_touch *touches, int count)
{
    double tie = TIE * extent_of(touches, count);
    int best = 0;
    for (int k = 1; k < count; k++)
        if (touches[k].depth > touches[best].depth + tie) best = k;
    return best;
}

/* The deepest, then always the one farthest from those already chosen. */
int pinch_choose_touches(const pinch_touch *touches, int count, int room, int chosen[PINCH_TOUCHES])
{
    double far[PINCH_TOUCHES];
    if (count <= room) {
        for (int k = 0; k < count; k++) chosen[k] = k;
        return count;
    }
    for (int k = 0; k < count; k++) far[k] = DBL_MAX;
    for (int n = 0, next = deepest_of(touches, count); n < room; n++) {
        const double *from = touches[next].position;
        double most = -1;
        chosen[n] = next;
        far[next] = -1;
        for (int k = 0; k < count; k++) {
            double d[3];
            pinch_v3_sub(touches[k].position, from, d);
            double apart = pinch_v3_dot(d, d);
            far[k] = apart < far[k] ? apart : far[k];
            if (!(far[k] > most + TIE * fabs(most))) continue;
            next = k;
            most = far[k];
        }
    }
    return room;
}

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
