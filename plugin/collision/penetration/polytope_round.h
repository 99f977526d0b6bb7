#ifndef PINCH_FINGERTIP_ROUND_POLYTOPE_H
#define PINCH_FINGERTIP_ROUND_POLYTOPE_H

#include "hull_face_test.h"

/* The normal of least overlap of a polytope (A) and a cylinder or flat capsule (B) whose cores overlap, skins left out;
 * `best` is only ever improved. Of a hull `faces` are those of the pair (pinch_hull_first), otherwise NULL. False where
 * the polytope has more edges than there is room for. */
bool pinch_round_polytope(const pinch_core_pair *pair, const pinch_least_face *faces, pinch_contact_normal *best);

#endif
