#ifndef PINCH_COLLISION_METHODS_H
#define PINCH_COLLISION_METHODS_H

#include "collision/shape/shape_pair.h"
#include "face_test.h"

/* Finds the normal of least overlap of a box (A) and a cylinder, margins left out. Stops at the first normal along
 * which they overlap by no more than `apart` (m; -DBL_MAX: never). */
void pinch_box_cylinder(const pinch_shape_pair *pair, double apart, pinch_contact_normal *best);

/* Does the same for two cylinders. */
void pinch_cylinder_cylinder(const pinch_shape_pair *pair, double apart, pinch_contact_normal *best);

/* Finds the normal of least overlap of a segment (A) and a cylinder, margins left out. */
void pinch_segment_cylinder(const pinch_shape_pair *pair, pinch_contact_normal *best);

/* For a flat capsule and a cylinder, or two flat capsules, that overlap: offers normals that EPA may miss where it ends
 * unproven. These are of caps, of sides against each other and against rims, of rims against rims, and of domes against
 * all of these. */
void pinch_flat_capsules(const pinch_shape_pair *pair, pinch_contact_normal *best);

/* Finds the normal of least overlap of a polytope (A) and a cylinder or flat capsule (B) that overlap, margins left
 * out, if it is better than `best`. For a hull, `faces` are those that pinch_hull_face_test has found, otherwise NULL.
 */
void pinch_polytope_round(const pinch_shape_pair *pair, const pinch_least_face *faces, pinch_contact_normal *best);

/* Searches all axes at which the overlap of two polytopes can be least. For a pair with a hull, `faces` and `best` are
 * those that pinch_hull_face_test has found, otherwise `faces` is NULL. */
void pinch_separating_axes(const pinch_shape_pair *pair, pinch_least_face *faces, pinch_contact_normal *best);

/*
 * Finds the normal of least overlap of shapes that overlap by the expanding polytope algorithm (EPA). Returns false
 * where the polytope stopped at its largest size, before it was proven that no other normal has less.
 */
bool pinch_epa(const pinch_shape_pair *pair, pinch_contact_normal *best);

#endif
