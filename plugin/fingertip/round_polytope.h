#ifndef PINCH_FINGERTIP_ROUND_POLYTOPE_H
#define PINCH_FINGERTIP_ROUND_POLYTOPE_H

#include "contact_normal.h"

/* The normal of least overlap of a polytope (A) and a cylinder or flat capsule (B) whose cores overlap, skins left out;
 * `best` is only ever improved. False where the polytope has more edges than there is room for. */
bool pinch_round_polytope(const pinch_core_pair *pair, pinch_contact_normal *best);

#endif
