#ifndef PINCH_COLLISION_CANDIDATE_EDGES_H
#define PINCH_COLLISION_CANDIDATE_EDGES_H

#include "collision/shape/convex_shape.h"
#include "face_test.h"

/* What of a polyhedron can meet another shape with less overlap than is known. */

enum { PINCH_MAX_CANDIDATES = 64 };

/* The edges and corners between faces that no point of the other shape is known to be deep behind: a bit for each. */
typedef struct pinch_candidates {
    uint64_t edges, corners;
} pinch_candidates;

/* `least` as pinch_hull_face_test has found it for that hull, `limit`: the overlap to be less than (m). False for hulls
 * with more than 64 faces, edges or corners. */
bool pinch_find_candidates(const pinch_hull *hull, const pinch_least_face *least, double limit, pinch_candidates *left);

/* The place of the lowest bit, which it takes away; bits: not 0. The multiplier is a de Bruijn sequence: its six bits
 * from any place on are different. */
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

/* Of those edges the ones that have a point x with n.x >= level, all in the hull's axes. */
uint64_t pinch_edges_beyond(const pinch_hull *hull, const double n[3], double level, uint64_t edges);

/* The straight edges of polytopes, with their arcs on the Gauss sphere. */

enum { PINCH_MAX_EDGES = 96 };

/* Their number; -1: more than there is room for. A point has none. */
int pinch_edge_arcs(const pinch_shape *shape, pinch_edge_arc arcs[PINCH_MAX_EDGES]);

#endif
