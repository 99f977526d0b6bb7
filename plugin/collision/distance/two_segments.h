/* Balls and capsules: points and segments with a skin. */
#ifndef PINCH_FINGERTIP_TWO_SEGMENTS_H
#define PINCH_FINGERTIP_TWO_SEGMENTS_H

#include "collision/shape/contact_normal.h"

/* The normal of two cores that are points or segments, however they lie. */
void pinch_two_segments(const pinch_core_pair *pair, pinch_contact_normal *found);

#endif
