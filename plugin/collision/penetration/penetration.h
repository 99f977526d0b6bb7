#ifndef PINCH_FINGERTIP_NORMAL_H
#define PINCH_FINGERTIP_NORMAL_H

#include "hull_face_test.h"

/* The normal of least overlap; false where the bodies, skins included, are apart. `faces`: those that were found on the
 * way; without any their `face` is -1. */
bool pinch_find_normal(const pinch_core_pair *pair, pinch_tip_stats *stats, pinch_contact_normal *found,
                       pinch_least_face faces[2]);

#endif
