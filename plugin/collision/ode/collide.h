#ifndef PINCH_FINGERTIP_COLLIDE_H
#define PINCH_FINGERTIP_COLLIDE_H

#include "collision/shape/body.h"
#include "collision/manifold/touches.h"

/* The contacts of two bodies as ODE's, `skip` bytes apart, at most `room`; returns how many. */
int pinch_collide_bodies(const pinch_tip_body *a, const pinch_tip_body *b, int room, dContactGeom *contacts, int skip);
/* Those of two of their pieces come on top of the touches. */
void pinch_collide_cores(const pinch_tip_body *a, int piece_a, const pinch_tip_body *b, int piece_b,
                         pinch_tip_touches *touches);

#endif
