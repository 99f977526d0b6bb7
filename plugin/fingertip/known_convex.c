#include "known_convex.h"

#include "core_of_shape.h"
#include "hull.h"
#include "tip_data.h"

#include <stdlib.h>

/* What is found once; it stays where it is, the core points to the hull. */
typedef struct convex_body {
    pinch_core_hull hull;
    pinch_core core;
} convex_body;

/* What is known about ODE's convex geoms, which have no public way in. */
typedef struct known_convex {
    dGeomID geom;
    convex_body *body;
} known_convex;

static known_convex *known;
static int known_count, known_room;

static void free_body(convex_body *body)
{
    pinch_hull_free(&body->hull);
    free(body);
}

void pinch_forget_convexes(void)
{
    for (int k = 0; k < known_count; k++) free_body(known[k].body);
    free(known);
    known = NULL;
    known_count = known_room = 0;
}

const pinch_core *pinch_known_core(dGeomID geom)
{
    for (int k = 0; k < known_count; k++)
        if (known[k].geom == geom) return &known[k].body->core;
    return NULL;
}

/* NULL: out of memory, or faces that do not close. */
static convex_body *make_body(const pinch_tip *tip)
{
    convex_body *body = malloc(sizeof *body);
    if (!body) return NULL;
    if (!pinch_hull_of_convex(tip->pieces, &body->hull)) {
        free(body);
        return NULL;
    }
    body->core = pinch_core_of_tip(tip, &body->hull);
    return body;
}

static void forget(dGeomID geom)
{
    for (int k = 0; k < known_count; k++) {
        if (known[k].geom != geom) continue;
        free_body(known[k].body);
        known[k] = known[--known_count];
        return;
    }
}

pinch_status pinch_tip_know_convex(dGeomID geom, const pinch_convex *convex)
{
    if (!geom || (convex && dGeomGetClass(geom) != dConvexClass)) return PINCH_INVALID_ARGUMENT;
    pinch_tip tip = {.type = PINCH_TIP_CONVEX, .pieces = convex, .piece_count = 1};
    if (convex && !pinch_tip_legal(&tip)) return PINCH_INVALID_ARGUMENT;
    convex_body *body = convex ? make_body(&tip) : NULL;
    if (convex && !body) return PINCH_OUT_OF_MEMORY;
    forget(geom);
    if (!convex) return PINCH_OK;
    if (known_count == known_room) {
        int room = known_room ? 2 * known_room : 16;
        known_convex *more = realloc(known, (size_t)room * sizeof *more);
        if (!more) {
            free_body(body);
            return PINCH_OUT_OF_MEMORY;
        }
        known = more;
        known_room = room;
    }
    known[known_count++] = (known_convex){geom, body};
    return PINCH_OK;
}
