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
