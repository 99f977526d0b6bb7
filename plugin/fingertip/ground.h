#ifndef PINCH_FINGERTIP_GROUND_H
#define PINCH_FINGERTIP_GROUND_H

#include "body.h"
#include "touches.h"

void pinch_collide_plane(const pinch_tip_body *body, dGeomID plane, pinch_tip_touches *touches);
void pinch_collide_trimesh(const pinch_tip_body *body, dGeomID mesh, pinch_tip_touches *touches);

#endif
