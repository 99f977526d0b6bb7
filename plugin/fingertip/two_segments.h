/* Balls and capsules: points and segments with a skin. */
#ifndef PINCH_FINGERTIP_TWO_SEGMENTS_H
#define PINCH_FINGERTIP_TWO_SEGMENTS_H

#include "contact_normal.h"

/* The normal of a point or a segment (A) and a segment (B), however they lie. */
void pinch_two_segments(const pinch_core_pair *pair, pinch_contact_normal *found);

#endif
