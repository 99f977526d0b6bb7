#ifndef PINCH_COLLISION_PAIR_FEATURES_H
#define PINCH_COLLISION_PAIR_FEATURES_H

#include "collision/penetration/face_test.h"
#include "collision/shape/feature.h"
#include "collision/shape/shape_pair.h"
#include "contact_points.h"

/* The features of two shapes at a contact, in A's axes. `which` is 0 for A's at -n and 1 for B's at n. */

/* Finds the direction out of the shape, in its own axes. */
void pinch_outward_direction(const pinch_shape_pair *pair, int which, const double n[3], double d[3]);

/* Finds the exact feature there, a face with its first corner or a cap with its centre. Of a hull, the face or the
 * vertex may be known from `faces`. */
void pinch_pair_exact_feature(const pinch_shape_pair *pair, int which, const double n[3],
                              const pinch_least_face faces[2], pinch_feature *part);

/* Tells whether the feature is a face with only one of its points. */
static inline bool pinch_is_face_without_corners(const pinch_feature *part)
{
    return part->face && part->count == 1;
}

/* Fills in all corners of such a face. */
void pinch_pair_face_corners(const pinch_shape_pair *pair, int which, const double n[3], const pinch_feature *known,
                             pinch_feature *part);

/* Finds the face or line that is nearest, where `exact` is the exact feature. */
void pinch_pair_nearest_feature(const pinch_shape_pair *pair, int which, const double n[3], const pinch_feature *exact,
                                pinch_feature *part);

/* Makes the contact point from a point x of shape `which` that is `depth` (m) deep along n, margins included. */
void pinch_contact_point_at(const pinch_shape_pair *pair, int which, const double x[3], const double n[3], double depth,
                            pinch_contact_point *point);

/* Finds the points of what is pressed into a flat face well inside its border (interior_face.c). Returns their number,
 * or 0 where there is more to be looked at. `depth` (m) is that of the deepest, margins included. */
int pinch_interior_face_points(const pinch_shape_pair *pair, const pinch_contact_normal *normal,
                               const pinch_least_face faces[2], double depth, pinch_contact_point *contacts);

/* Where faces are nearly parallel and a single point has given the normal, adds what else of both faces is pressed in
 * (near_faces.c). `exact` are the exact features there, which are no faces. Returns how many points there are now. */
int pinch_near_face_points(const pinch_shape_pair *pair, const pinch_contact_normal *normal,
                           const pinch_feature exact[2], pinch_contact_point *contacts);

/* Finds the contact points of a superellipsoid with flat spots and a shape with faces, edges or a side, each as deep as
 * the pair (pressure_patch.c). Returns their number, or 0 for another pair or where nothing is flat. */
int pinch_pressure_patch_points(const pinch_shape_pair *pair, const pinch_contact_normal *normal,
                                pinch_contact_point *contacts);

/* Finds four points in the plane that touches the shape's farthest point along d, for a pressure patch of that depth
 * (m). Returns false for shapes without flat spots, which have no patch. */
bool pinch_pressure_patch_on_plane(const pinch_shape *shape, const double d[3], double depth, double points[4][3]);

#endif
