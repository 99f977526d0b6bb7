/* One point of a manifold: where it touches, as the bodies carry it and as colliders return it. */
#ifndef PINCH_PLUGIN_MANIFOLD_POINT_H
#define PINCH_PLUGIN_MANIFOLD_POINT_H

#include "contacts/manifold.h"

/* From a fresh point. The touching points lie half the depth to either side of the contact position: body 1's deepest
 * point is inside body 2, and moving body 1 by depth along the normal brings the two together. */
void pinch_point_set_geometry(pinch_manifold_point *p, const pinch_pose pose[2], const pinch_fresh_point *fresh);

/* A known point goes on as a fresh one; steady: m, see pinch_manifold_update. */
void pinch_point_continue(pinch_manifold_point *p, const pinch_pose pose[2], double steady,
                          const pinch_fresh_point *fresh);

/*
 * Recomputes a point that the collider did not return from its anchors; false when it is no contact any more. A corner
 * that has lifted by less than the others are pressed in (`slack`, m) still belongs to the patch: its share of the
 * fingertip's stiffness must not go to the others each time it loses touch.
 */
bool pinch_point_refresh(pinch_manifold_point *p, const pinch_pose pose[2], double merge_distance, double stale_tilt,
                         double slack);

/* Squared distance (m^2) from a fresh point to a known one: the smaller of the two anchors' motions, as a point may be
 * fixed on either body and slide over the other. */
double pinch_point_distance2(const pinch_manifold_point *p, const pinch_pose pose[2], const pinch_fresh_point *fresh);

#endif
