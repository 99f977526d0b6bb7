#ifndef PINCH_COLLISION_PAIR_FEATURES_H
#define PINCH_COLLISION_PAIR_FEATURES_H

#include "collision/penetration/face_test.h"
#include "collision/shape/feature.h"
#include "collision/shape/shape_pair.h"
#include "contact_points.h"

/* The parts of two shapes' surfaces at a contact: `which` 0 is A's at -n, 1 is B's at n; all in A's axes. */

/* The direction out of the shape, in its own axes. */
void pinch_outward_direction(const pinch_shape_pair *pair, int which, const double n[3], double d[3]);

/* What is exactly there, of a face the first corner or of a cap the centre; of hulls it may be known, the face and the
 * corner in it. */
void pinch_pair_exact_feature(const pinch_shape_pair *pair, int which, const double n[3],
                              const pinch_least_face faces[2], pinch_feature *part);

/* Is that a face of which one point alone has been given? */
static inline bool pinch_is_face_without_corners(const pinch_feature *part)
{
    return part->face && part->count == 1;
}

/* All its corners. */
void pinch_pair_face_corners(const pinch_shape_pair *pair, int which, const double n[3], const pinch_feature *known,
                             pinch_feature *part);

/* The face or line that is nearest to that, `exact` being what is there exactly. */
void pinch_pair_nearest_feature(const pinch_shape_pair *pair, int which, const double n[3], const pinch_feature *exact,
                                pinch_feature *part);

/* The contact point of a point x of shape `which` that is `depth` deep along n (margins included, m). */
void pinch_contact_point_at(const pinch_shape_pair *pair, int which, const double x[3], const double n[3], double depth,
                            pinch_contact_point *touch);

/* What is pressed into a flat face well inside its border. */

/* The points, and their number; 0: there is more to be looked at. `depth`: of the deepest, margins included (m). */
int pinch_interior_face_points(const pinch_shape_pair *pair, const pinch_contact_normal *normal,
                               const pinch_least_face faces[2], double depth, pinch_contact_point *contacts);

/* Faces that are nearly parallel where something else of both decided on the normal. */

/* On top of the one point that is there: what else of both faces nearest to the normal is pressed in, as deep as they
 * are into each other there. `exact`: what is exactly there, no faces. How many there are now. */
int pinch_near_face_points(const pinch_shape_pair *pair, const pinch_contact_normal *normal,
                           const pinch_feature exact[2], pinch_contact_point *contacts);

/* Contact points of a superellipsoid with flat spots and a shape with faces, edges or a side, each as deep as the pair.
 * 0: another pair, or nothing flat there. */
int pinch_pressure_patch_points(const pinch_shape_pair *pair, const pinch_contact_normal *normal,
                                pinch_contact_point *contacts);

/* Four points in a plane that touches the shape's farthest point along d, for a pressure patch as deep as that (m).
 * Returns false for shapes without flat spots, which have no patch. */
bool pinch_pressure_patch_on_plane(const pinch_shape *shape, const double d[3], double depth, double points[4][3]);

#endif
