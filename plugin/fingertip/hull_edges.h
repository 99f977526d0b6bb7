/* Edges of hulls as axes. */
#ifndef PINCH_FINGERTIP_HULL_EDGES_H
#define PINCH_FINGERTIP_HULL_EDGES_H

#include "contact_normal.h"

/*
 * Edge against edge: a segment, a box or a hull, and a hull. `best` holds the faces' least overlap; edges must be
 * better by `bonus` (m). False, and nothing done, for other cores or more than 64 faces or edges.
 */
bool pinch_hull_edges(const pinch_core_pair *pair, double bonus, pinch_contact_normal *best);

/* Edges of A that may meet B with less overlap than `best`; count. */
int pinch_edges_in_reach(const pinch_core_pair *pair, const pinch_contact_normal *best, int room, int *edges);

#endif
