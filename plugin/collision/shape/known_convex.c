#include "tip_data.h"

#include "convex_shape.h"
#include "hull.h"
#include "util/key_map.h"

#include <stdlib.h>

/* What is computed once of a convex. It must not move, because the shape points to the hull. */
typedef struct convex_body {
    pinch_hull hull;
    pinch_shape shape;
} convex_body;

/* ODE has no public way to read a convex geom, so programs make its arrays known. The convexes are places in a list,
 * found by their geoms. A forgotten place (NULL) waits for a geom at the same address. */
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

const pinch_shape *pinch_known_convex(dGeomID geom)
{
    int k = pinch_key_map_get(&places, key_of(geom));
    return k >= 0 && known[k] ? &known[k]->shape : NULL;
}

/* Returns NULL when memory runs out or the faces do not close. */
static convex_body *make_body(const pinch_tip *tip)
{
    convex_body *body = malloc(sizeof *body);
    if (!body) return NULL;
    if (!pinch_hull_of_convex(tip->pieces, &body->hull)) {
        free(body);
        return NULL;
    }
    body->shape = pinch_shape_of_tip(tip, &body->hull);
    return body;
}

/* Returns the geom's place, a new one if it has none, or -1 when memory runs out. */
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
