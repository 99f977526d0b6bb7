/* The rims of two cylinders, or flat capsules: two unknowns. */
#ifndef PINCH_FINGERTIP_RIMS_H
#define PINCH_FINGERTIP_RIMS_H

#include "rim_frame.h"

/* From a face's or side's normal into the region where two rims meet, if that leads down; false where it does, and
 * Newton's method has not settled. */
bool pinch_rims_from(const pinch_rim_frame *frame, const pinch_contact_normal *start, pinch_contact_normal *best);

/* All of the region. `on_rims`: what is best so far is such a place, and has no other next to it. */
void pinch_search_rims(const pinch_rim_frame *frame, bool on_rims, pinch_contact_normal *best);

#endif
