#ifndef PINCH_FINGERTIP_SEAMS_H
#define PINCH_FINGERTIP_SEAMS_H

#include "collision/shape/body.h"
#include "touches.h"

/* Drops what pieces of one body have on each other's seams. `which`: the body in pieces. */
void pinch_drop_seams(const pinch_tip_body *body, int which, pinch_tip_touches *touches);

#endif
