#include "known_convex.h"

#include "hull.h"
#include "tip_data.h"

#include <stdlib.h>

/* What is known about ODE's convex geoms, which have no public way in. */
typedef struct known_convex {
    dGeomID geom;
    pinch_core_hull hull;
} known_convex;

static known_convex *known;
static int known_count, known_room;

void pinch_forget_convexes(void)
{
    for (int k = 0; k < known_count; k++) pinch_hull_free(&known[k].hull);
    free(known);
    known = NULL;
    known_count = known_room = 0;
}

const pinch_core_hull *pinch_known_hull(dGeomID geom)
{
    for (int k = 0; k < known_count; k++)
        if (known[k].geom == geom) return &known[k].hull;
    return NULL;
}

pinch_status pinch_tip_know_convex(dGeomID geom, const pinch_convex *convex)
{
    if (!geom || (convex && dGeomGetClass(geom) != dConvexClass)) return PINCH_INVALID_ARGUMENT;
    pinch_core_hull hull;
    pinch_tip tip = {.type = PINCH_TIP_CONVEX, .pieces = convex, .piece_count = 1};
    if (convex && !pinch_tip_legal(&tip)) return PINCH_INVALID_ARGUMENT;
    if (convex && !pinch_hull_of_convex(convex, &hull)) return PINCH_OUT_OF_MEMORY;
    for (int k = 0; k < known_count; k++) {
        if (known[k].geom != geom) continue;
        pinch_hull_free(&known[k].hull);
        known[k] = known[--known_count];
        break;
    }
    if (!convex) return PINCH_OK;
    if (known_count == known_room) {
        int room = known_room ? 2 * known_room : 16;
        known_convex *more = realloc(known, (size_t)room * sizeof *more);
        if (!more) {
            pinch_hull_free(&hull);
            return PINCH_OUT_OF_MEMORY;
        }
        known = more;
        known_room = room;
    }
    known[known_count++] = (known_convex){geom, hull};
    return PINCH_OK;
}
