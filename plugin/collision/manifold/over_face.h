/* What is pressed into a flat face well inside its border. */
#ifndef PINCH_FINGERTIP_OVER_FACE_H
#define PINCH_FINGERTIP_OVER_FACE_H

#include "pair_features.h"

/* The points, and their number; 0: there is more to be looked at. `depth`: of the deepest, skins included (m). */
int pinch_touch_over_face(const pinch_core_pair *pair, const pinch_contact_normal *normal,
                          const pinch_least_face faces[2], double depth, pinch_touch *touches);

#endif
