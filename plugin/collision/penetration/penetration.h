#ifndef PINCH_COLLISION_PENETRATION_H
#define PINCH_COLLISION_PENETRATION_H

#include "collision/shape/shape_pair.h"
#include "face_test.h"

#include <pinch/fingertip.h>

/* Finds the normal of least overlap. Returns false where the bodies, margins included, are apart. `faces` are those
 * that were found on the way, each with `face` -1 if there is none. */
bool pinch_find_contact_normal(const pinch_shape_pair *pair, pinch_contact_normal *found, pinch_least_face faces[2]);

/* Returns the distance of a point to the body (negative inside) and finds the outward normal of the nearest surface
 * point. `piece` is the number of one of its shapes, or -1 for all. */
double pinch_signed_distance(const pinch_posed_body *body, int piece, const double point[3], double normal[3]);

/* Finds the contact of a ray, with normal and depth as ODE has them. Returns false if there is none. */
bool pinch_cast_ray(const pinch_posed_body *body, dGeomID ray, double position[3], double normal[3], double *depth);

pinch_tip_stats *pinch_tip_counters(void);

#endif
