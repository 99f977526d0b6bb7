#ifndef PINCH_FINGERTIP_FLAT_SPOTS_H
#define PINCH_FINGERTIP_FLAT_SPOTS_H

#include "collision/shape/contact_normal.h"
#include "touch.h"

/* Contact points of a superellipsoid with flat spots and a core with faces, edges or a side, each as deep as the pair.
 * 0: another pair, or nothing flat there. */
int pinch_touch_flat_spot(const pinch_core_pair *pair, const pinch_contact_normal *normal, pinch_touch *touches);

#endif
