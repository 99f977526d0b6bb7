#ifndef PINCH_COLLISION_CANDIDATE_EDGES_H
#define PINCH_COLLISION_CANDIDATE_EDGES_H

#include "collision/shape/convex_shape.h"
#include "face_test.h"

/* The edges of polytopes with their arcs on the Gauss sphere, and which edges of a hull can still meet another shape
 * with less overlap than is known. */

enum { PINCH_MAX_CANDIDATES = 64 };

/* A bit is set for each edge and vertex between faces behind which no point of the other shape is known to be deep. */
typedef struct pinch_candidates {
    uint64_t edges, corners;
} pinch_candidates;

/* `least` is what pinch_hull_face_test has found for that hull, and `limit` is the overlap to be beaten (m). Returns
 * false for hulls with more than 64 faces, edges or vertices. */
bool pinch_find_candidates(const pinch_hull *hull, const pinch_least_face *least, double limit,
                           pinch_candidates *candidates);

enum { PINCH_SHALLOW_WORDS = 256 };

/* A bit is set for each of a hull's faces behind which a part of the other shape is not deep: its point that is farthest
 * in, or the ball inside it. */
typedef struct pinch_shallow_faces {
    const pinch_hull *hull; /* NULL: the shape is no hull, and all of it counts as shallow */
    uint64_t far[PINCH_SHALLOW_WORDS], ball[PINCH_SHALLOW_WORDS];
} pinch_shallow_faces;

/* Finds the shallow faces of shape `which` of the pair. A face or edge that is not shallow has no normal along which
 * the overlap is less than that of `best`. */
void pinch_find_shallow_faces(const pinch_shape_pair *pair, int which, const pinch_contact_normal *best,
                              pinch_shallow_faces *shallow);

static inline bool pinch_is_shallow(const pinch_shallow_faces *shallow, unsigned face)
{
    if (!shallow->hull || face >= 64 * PINCH_SHALLOW_WORDS) return true;
    return (shallow->far[face / 64] & shallow->ball[face / 64]) >> face % 64 & 1;
}

/* Of an edge both faces must be deep for the same part of the other shape. */
static inline bool pinch_is_shallow_edge(const pinch_shallow_faces *shallow, int edge)
{
    if (!shallow->hull) return true;
    unsigned f = shallow->hull->edges[edge].face[0], g = shallow->hull->edges[edge].face[1];
    if (f >= 64 * PINCH_SHALLOW_WORDS || g >= 64 * PINCH_SHALLOW_WORDS) return true;
    return (shallow->far[f / 64] >> f % 64 | shallow->far[g / 64] >> g % 64) &
           (shallow->ball[f / 64] >> f % 64 | shallow->ball[g / 64] >> g % 64) & 1;
}

/* Takes away the lowest bit and returns its place. The bits are not 0. The multiplier is a de Bruijn sequence, in which
 * the six bits from any place on are different. */
static inline int pinch_take_bit(uint64_t *bits)
{
    static const unsigned char PLACE[64] = {0,  1,  48, 2,  57, 49, 28, 3,  61, 58, 50, 42, 38, 29, 17, 4,
                                            62, 55, 59, 36, 53, 51, 43, 22, 45, 39, 33, 30, 24, 18, 12, 5,
                                            63, 47, 56, 27, 60, 41, 37, 16, 54, 35, 52, 21, 44, 32, 23, 11,
                                            46, 26, 40, 15, 34, 20, 31, 10, 25, 14, 19, 9,  13, 8,  7,  6};
    uint64_t low = *bits & (0 - *bits);
    *bits ^= low;
    return PLACE[(low * UINT64_C(0x03f79d71b4cb0a89)) >> 58];
}

/* Keeps those of the edges that have a point x with n.x >= level, all in the hull's axes. */
uint64_t pinch_edges_beyond(const pinch_hull *hull, const double n[3], double level, uint64_t edges);

enum { PINCH_BOX_EDGES = 12 };

/* Returns the arcs of a polytope's edges and their number. A hull has them ready, those of other shapes are written to
 * `own`. A point has none. */
const pinch_edge_arc *pinch_edge_arcs(const pinch_shape *shape, pinch_edge_arc own[PINCH_BOX_EDGES], int *count);

#endif
