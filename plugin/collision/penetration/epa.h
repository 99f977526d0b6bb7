#ifndef PINCH_FINGERTIP_EXPAND_H
#define PINCH_FINGERTIP_EXPAND_H

#include "collision/shape/contact_normal.h"

/*
 * Least overlap of cores that penetrate each other, by a polytope that grows inside their difference until no other
 * direction can have less. False where it stopped at its largest size, short of that proof.
 */
bool pinch_expand(const pinch_core_pair *pair, pinch_contact_normal *best);

#endif
