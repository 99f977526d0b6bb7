/*
 * Which of many detected points a manifold keeps.
 *
 * Those that span what all of them can carry: for each direction of the normals the corners of the convex hull of their
 * places, and the deepest point. What rests on all of them then rests on those that are kept. Where more may stay than
 * points that share a stiffness need, others follow that spread evenly over each kind: those of a face, of the same
 * surface parameters and of nearly the same friction direction. Points where the surfaces only cross, beside deep ones,
 * bear nothing and are left out first.
 */
#ifndef PINCH_CONTACTS_REDUCTION_H
#define PINCH_CONTACTS_REDUCTION_H

#include "contacts/manifold.h"

/* Of a pair with more points none are compared with each other: it would take longer than all the rest of a step. */
enum { PINCH_MOST_COMPARED = 512 };

/* The most kinds: each has some points that stay. */
enum { PINCH_MOST_KINDS = PINCH_MANIFOLD_POINTS / 4 };

/* Puts points where surfaces only cross, beside deep ones, behind the others, which stay in order. They are redundant
 * then. Returns how many others there are. */
int pinch_leave_out_rims(pinch_detected_point *points, int count);

/*
 * Chooses at most `most` of the points, 1 to PINCH_MANIFOLD_POINTS, and returns how many. The choice depends on their
 * order only where rounding decides. Of points that are equal in all else it prefers those near points of the manifold,
 * so that it stays from step to step. Those that are left out first are redundant then, and the last.
 */
int pinch_reduce_points(const pinch_manifold *known, double merge_distance, int most, pinch_detected_point *points,
                        int count, pinch_detected_point **kept);

/*
 * Finds for how many contacts each point stands that has a place in the manifold, and its part of the most: for those
 * that bear and have none. Points of a kind bear together as many do as there were, and where enough of them stay, in
 * the same place and with the same stiffness against tilting.
 */
void pinch_share_out(pinch_detected_point *points, int count);

#endif
