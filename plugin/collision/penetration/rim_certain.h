/* Minima on rims that are certain to be the least. */
#ifndef PINCH_FINGERTIP_RIM_CERTAIN_H
#define PINCH_FINGERTIP_RIM_CERTAIN_H

#include "collision/shape/contact_normal.h"

/* Where two rims meet: does the overlap change by nothing to rounding, as at a minimum? */
bool pinch_rims_are_level(const pinch_core_pair *pair, const pinch_contact_normal *at);

/* Two sharp cylinders, and a local minimum of their overlap where two rims meet. True only if nothing is less. */
bool pinch_rims_are_least(const pinch_core_pair *pair, const pinch_contact_normal *at);

/* The same where the side of A (`which` 0) or B (1) meets the other's rim. */
bool pinch_side_and_rim_is_least(const pinch_core_pair *pair, int which, const pinch_contact_normal *at);

#endif
