/* Of more contact points than there is room for those that stand for all. */
#ifndef PINCH_FINGERTIP_CHOOSE_H
#define PINCH_FINGERTIP_CHOOSE_H

#include "collision/manifold/touch.h"

/* Their places; returns how many: count, or room where that is less. */
int pinch_choose_touches(const pinch_touch *touches, int count, int room, int chosen[PINCH_TOUCHES]);

#endif
