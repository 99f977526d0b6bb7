#ifndef PINCH_FINGERTIP_BODY_DISTANCE_H
#define PINCH_FINGERTIP_BODY_DISTANCE_H

#include "collision/shape/body.h"

/* Distance of a point to the body (negative inside) and the outward normal of the nearest surface point; of the core
 * `piece`, or of all (-1). */
double pinch_body_distance(const pinch_tip_body *body, int piece, const double point[3], double normal[3]);

#endif
