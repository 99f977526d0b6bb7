#ifndef PINCH_FINGERTIP_GROUND_H
#define PINCH_FINGERTIP_GROUND_H

#include "collision/shape/body.h"
#include "collision/manifold/touches.h"

void pinch_collide_plane(const pinch_tip_body *body, dGeomID plane, pinch_tip_touches *touches);
void pinch_collide_trimesh(const pinch_tip_body *body, dGeomID mesh, pinch_tip_touches *touches);

#endif
