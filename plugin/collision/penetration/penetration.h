#ifndef PINCH_COLLISION_PENETRATION_H
#define PINCH_COLLISION_PENETRATION_H

#include "collision/shape/shape_pair.h"
#include "face_test.h"

#include <pinch/fingertip.h>

/* The normal of least overlap; false where the bodies, margins included, are apart. `faces`: those that were found on
 * the way; without any their `face` is -1. */
bool pinch_find_contact_normal(const pinch_shape_pair *pair, pinch_contact_normal *found, pinch_least_face faces[2]);

/* Distance of a point to the body (negative inside) and the outward normal of the nearest surface point; of the shape
 * `piece`, or of all (-1). */
double pinch_signed_distance(const pinch_posed_body *body, int piece, const double point[3], double normal[3]);

/* A ray's contact, normal and depth as in ODE; false: none. */
bool pinch_cast_ray(const pinch_posed_body *body, dGeomID ray, double position[3], double normal[3], double *depth);

pinch_tip_stats *pinch_tip_counters(void);

#endif
