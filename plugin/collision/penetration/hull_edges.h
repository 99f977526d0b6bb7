/* Edges of hulls as axes. */
#ifndef PINCH_FINGERTIP_HULL_EDGES_H
#define PINCH_FINGERTIP_HULL_EDGES_H

#include "hull_face_test.h"
#include "candidate_edges.h"

/*
 * Edge against edge: a segment, a box or a hull, and a hull, after pinch_hull_first, which left `faces` and `best`;
 * edges must be better by `bonus` (m). False, and nothing done, for other cores and hulls with too many faces or edges.
 */
bool pinch_hull_edges(const pinch_core_pair *pair, pinch_least_face faces[2], double bonus, pinch_contact_normal *best);

/* Of those edges the ones that have a point x with n.x >= level, all in the hull's axes. */
uint64_t pinch_edges_beyond(const pinch_core_hull *hull, const double n[3], double level, uint64_t edges);

#endif
