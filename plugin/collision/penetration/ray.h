#ifndef PINCH_FINGERTIP_RAY_H
#define PINCH_FINGERTIP_RAY_H

#include "collision/shape/body.h"

/* A ray's contact, normal and depth as in ODE; false: none. */
bool pinch_collide_ray(const pinch_tip_body *body, dGeomID ray, double position[3], double normal[3], double *depth);

#endif
