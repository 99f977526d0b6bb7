#ifndef PINCH_FINGERTIP_LIBCCD_H
#define PINCH_FINGERTIP_LIBCCD_H

#include "collision/shape/shape_pair.h"

/* libccd's answer for two cores that overlap; false when it has none. */
bool pinch_ask_libccd(const pinch_core_pair *pair, pinch_tip_stats *stats, double normal[3]);

#endif
