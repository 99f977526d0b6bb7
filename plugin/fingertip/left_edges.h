/* What of a polyhedron can meet another core with less overlap than is known. */
#ifndef PINCH_FINGERTIP_LEFT_EDGES_H
#define PINCH_FINGERTIP_LEFT_EDGES_H

#include "hull_first.h"

enum { PINCH_LEFT_EDGES = 64 };

/* The faces of a hull, a bit each, that a point of the other core is not deep behind: the middle of a ball in it, and
 * the farthest in. */
typedef struct pinch_deep_faces {
    const pinch_core_hull *hull;
    uint64_t not_behind[2];
} pinch_deep_faces;

/* `least` as pinch_hull_first has found it for that hull, `limit`: the overlap to be less than (m). False where the
 * hull has more than PINCH_LEFT_FACES faces or PINCH_LEFT_EDGES edges. */
bool pinch_find_deep_faces(const pinch_core_hull *hull, const pinch_least_face *least, double limit,
                           pinch_deep_faces *deep);

/* The edges between faces that no such point is behind; count. */
int pinch_edges_left(const pinch_deep_faces *deep, int edges[PINCH_LEFT_EDGES]);

/* The same of a corner and its faces. */
bool pinch_corner_left(const pinch_deep_faces *deep, unsigned corner);

#endif
