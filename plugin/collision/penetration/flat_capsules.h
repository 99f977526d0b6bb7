#ifndef PINCH_FINGERTIP_FLAT_CAPSULES_H
#define PINCH_FINGERTIP_FLAT_CAPSULES_H

#include "collision/shape/contact_normal.h"

/* A flat capsule and a cylinder, or two flat capsules, whose cores overlap: offers what descents may miss, the caps,
 * the sides against each other and against the rims, rims against rims, and domes against all of these. */
void pinch_offer_flat_capsules(const pinch_core_pair *pair, pinch_contact_normal *best);

#endif
