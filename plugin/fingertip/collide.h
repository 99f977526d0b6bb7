#ifndef PINCH_FINGERTIP_COLLIDE_H
#define PINCH_FINGERTIP_COLLIDE_H

#include "body.h"
#include "touches.h"

/* All contacts; of two bodies in one piece no more than `room`. */
void pinch_collide_bodies(const pinch_tip_body *a, const pinch_tip_body *b, int room, pinch_tip_touches *touches);
void pinch_collide_cores(const pinch_tip_body *a, int piece_a, const pinch_tip_body *b, int piece_b, int room,
                         pinch_tip_touches *touches);

#endif
