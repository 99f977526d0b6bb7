#ifndef PINCH_FINGERTIP_COLLIDE_H
#define PINCH_FINGERTIP_COLLIDE_H

#include "body.h"
#include "touches.h"

void pinch_collide_bodies(const pinch_tip_body *a, const pinch_tip_body *b, pinch_tip_touches *touches);
void pinch_collide_cores(const pinch_tip_body *a, int piece_a, const pinch_tip_body *b, int piece_b,
                         pinch_tip_touches *touches);

#endif
