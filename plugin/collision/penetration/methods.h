#ifndef PINCH_COLLISION_METHODS_H
#define PINCH_COLLISION_METHODS_H

#include "collision/shape/shape_pair.h"
#include "face_test.h"

/* The normal of least overlap of a box (A) and a cylinder, margins left out. Ends with the first found along which they
 * overlap by no more than `apart` (m; -DBL_MAX: never). */
void pinch_box_cylinder(const pinch_shape_pair *pair, double apart, pinch_contact_normal *best);

/* The normal of least overlap of two cylinders, margins left out. Ends with the first found along which they overlap by
 * no more than `apart` (m; -DBL_MAX: never). */
void pinch_cylinder_cylinder(const pinch_shape_pair *pair, double apart, pinch_contact_normal *best);

/* The same of a segment (A) and a cylinder. */
void pinch_segment_cylinder(const pinch_shape_pair *pair, pinch_contact_normal *best);

/* A flat capsule and a cylinder, or two flat capsules, whose shapes overlap: offers what descents may miss, the caps,
 * the sides against each other and against the rims, rims against rims, and domes against all of these. */
void pinch_flat_capsules(const pinch_shape_pair *pair, pinch_contact_normal *best);

/* The normal of least overlap of a polytope (A) and a cylinder or flat capsule (B) whose shapes overlap, margins left
 * out; `best` is only ever improved. Of a hull `faces` are those of the pair (pinch_hull_face_test), otherwise NULL.
 * False where the polytope has more edges than there is room for. */
bool pinch_polytope_round(const pinch_shape_pair *pair, const pinch_least_face *faces, pinch_contact_normal *best);

/* Over all axes at which the overlap of two polytopes can be least; false where there are more edges than there is room
 * for. `faces`: those of a pair with a hull, and `best` the better one (pinch_hull_face_test); NULL for others. */
bool pinch_separating_axes(const pinch_shape_pair *pair, pinch_least_face *faces, pinch_contact_normal *best);

/*
 * Least overlap of shapes that penetrate each other, by a polytope that grows inside their difference until no other
 * direction can have less. False where it stopped at its largest size, short of that proof.
 */
bool pinch_epa(const pinch_shape_pair *pair, pinch_contact_normal *best);

/* Least overlap of shapes that penetrate each other, by descents from many directions. */
void pinch_descent(const pinch_shape_pair *pair, pinch_tip_stats *stats, pinch_contact_normal *best);

#endif
