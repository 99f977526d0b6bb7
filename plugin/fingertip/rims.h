/* The rims of two cylinders, or flat capsules: two unknowns. */
#ifndef PINCH_FINGERTIP_RIMS_H
#define PINCH_FINGERTIP_RIMS_H

#include "contact_normal.h"

/* From a face's or side's normal into the region where two rims meet, if that leads down; false where it does, and
 * Newton's method has not settled. */
bool pinch_rims_from(const pinch_core_pair *pair, const pinch_contact_normal *start, pinch_contact_normal *best);

/* All of the region. `size`: what counts as length. */
void pinch_search_rims(const pinch_core_pair *pair, double size, pinch_contact_normal *best);

#endif
