#ifndef PINCH_FINGERTIP_TWO_CYLINDERS_H
#define PINCH_FINGERTIP_TWO_CYLINDERS_H

#include "collision/shape/contact_normal.h"

/* The normal of least overlap of two cylinders, skins left out. Ends with the first found along which they overlap by
 * no more than `apart` (m; -DBL_MAX: never). */
void pinch_two_cylinders(const pinch_core_pair *pair, double apart, pinch_contact_normal *best);

/* The same of a segment (A) and a cylinder. */
void pinch_segment_cylinder(const pinch_core_pair *pair, pinch_contact_normal *best);

#endif
