/* The rims of two cylinders, or flat capsules: two unknowns. */
#ifndef PINCH_FINGERTIP_RIMS_H
#define PINCH_FINGERTIP_RIMS_H

#include "rim_frame.h"

/* From a face's or side's normal into the region where two rims meet, if that leads down; false where it does, and
 * Newton's method has not settled. */
bool pinch_rims_from(const pinch_rim_frame *frame, const pinch_contact_normal *start, pinch_contact_normal *best);

/* All of the region. `from`: the best face or side, from which pinch_rims_from has gone already. */
void pinch_search_rims(const pinch_rim_frame *frame, const pinch_contact_normal *from, pinch_contact_normal *best);

#endif
