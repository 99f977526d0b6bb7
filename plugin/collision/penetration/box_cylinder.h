#ifndef PINCH_FINGERTIP_BOX_CYLINDER_H
#define PINCH_FINGERTIP_BOX_CYLINDER_H

#include "collision/shape/contact_normal.h"

/* The normal of least overlap of a box (A) and a cylinder, skins left out. Ends with the first found along which they
 * overlap by no more than `apart` (m; -DBL_MAX: never). */
void pinch_box_cylinder(const pinch_core_pair *pair, double apart, pinch_contact_normal *best);

#endif
