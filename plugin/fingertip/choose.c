#include "choose.h"

#include "support/vec3.h"

#include <float.h>

static int deepest_of(const pinch_touch *touches, int count)
{
    int best = 0;
    for (int k = 1; k < count; k++)
        if (touches[k].depth > touches[best].depth) best = k;
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
            next = far[k] > most ? k : next;
            most = far[k] > most ? far[k] : most;
        }
    }
    return room;
}
