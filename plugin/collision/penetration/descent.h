#ifndef PINCH_FINGERTIP_DEEP_H
#define PINCH_FINGERTIP_DEEP_H

#include "collision/shape/contact_normal.h"

/* Least overlap of cores that penetrate each other, by descents from many directions. */
void pinch_descend(const pinch_core_pair *pair, pinch_tip_stats *stats, pinch_contact_normal *best);

#endif
