#include "known_convex.h"

#include "core_of_shape.h"
#include "hull.h"
#include "key_map.h"
#include "tip_data.h"

#include <stdlib.h>

/* What is found once; it stays where it is, the core points to the hull. */
typedef struct convex_body {
    pinch_core_hull hull;
    pinch_core core;
} convex_body;

/* What is known about ODE's convex geoms, which have no public way in: places in a list, found by their geoms. A place
 * that is forgotten (NULL) waits for a geom at the same address. */
static convex_body **known;
static int known_count, known_room;
static pinch_key_map places;

static uint64_t key_of(dGeomID geom)
{
    return (uint64_t)(uintptr_t)geom;
}

static void free_body(convex_body *body)
{
    if (!body) return;
    pinch_hull_free(&body->hull);
    free(body);
}

void pinch_forget_convexes(void)
{
    for (int k = 0; k < known_count; k++) free_body(known[k]);
    free(known);
    pinch_key_map_free(&places);
    known = NULL;
    known_count = known_room = 0;
}

const pinch_core *pinch_known_core(dGeomID geom)
{
    int k = pinch_key_map_get(&places, key_of(geom));
    return k >= 0 && known[k] ? &known[k]->core : NULL;
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

/* The geom's place, a new one if it has none; -1: out of memory. */
static int place_of(dGeomID geom)
{
    int k = pinch_key_map_get(&places, key_of(geom));
    if (k >= 0) return k;
    if (known_count == known_room) {
        int room = known_room ? 2 * known_room : 16;
        convex_body **more = realloc(known, (size_t)room * sizeof *more);
        if (!more) return -1;
        known = more;
        known_room = room;
    }
    if (!pinch_key_map_add(&places, key_of(geom), known_count)) return -1;
    known[known_count] = NULL;
    return known_count++;
}

pinch_status pinch_tip_know_convex(dGeomID geom, const pinch_convex *convex)
{
    if (!geom || (convex && dGeomGetClass(geom) != dConvexClass)) return PINCH_INVALID_ARGUMENT;
    pinch_tip tip = {.type = PINCH_TIP_CONVEX, .pieces = convex, .piece_count = 1};
    if (convex && !pinch_tip_legal(&tip)) return PINCH_INVALID_ARGUMENT;
    int place = convex ? place_of(geom) : pinch_key_map_get(&places, key_of(geom));
    if (!convex && place < 0) return PINCH_OK;
    convex_body *body = convex ? make_body(&tip) : NULL;
    if (convex && (place < 0 || !body)) {
        free_body(body);
        return PINCH_OUT_OF_MEMORY;
    }
    free_body(known[place]);
    known[place] = body;
    return PINCH_OK;
}
