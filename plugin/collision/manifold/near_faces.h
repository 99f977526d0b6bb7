/* Faces that are nearly parallel where something else of both decided on the normal. */
#ifndef PINCH_FINGERTIP_NEAR_FACES_H
#define PINCH_FINGERTIP_NEAR_FACES_H

#include "collision/shape/contact_normal.h"
#include "collision/shape/feature.h"
#include "touch.h"

/* On top of the one point that is there: what else of both faces nearest to the normal is pressed in, as deep as they
 * are into each other there. `exact`: what is exactly there, no faces. How many there are now. */
int pinch_touch_near_faces(const pinch_core_pair *pair, const pinch_contact_normal *normal,
                           const pinch_core_part exact[2], pinch_touch *touches);

#endif
