#ifndef PINCH_FINGERTIP_NORMAL_H
#define PINCH_FINGERTIP_NORMAL_H

#include "contact_normal.h"

/* The normal of least overlap; false where the bodies, skins included, are apart. */
bool pinch_find_normal(const pinch_core_pair *pair, pinch_tip_stats *stats, pinch_contact_normal *found);

#endif
