#ifndef PINCH_FINGERTIP_TOUCHES_H
#define PINCH_FINGERTIP_TOUCHES_H

#include "touch.h"

/* One contact, world axes. */
typedef struct pinch_tip_touch {
    double position[3], normal[3], depth;
    int piece[2];
} pinch_tip_touch;

typedef struct pinch_tip_touches {
    int count;
    pinch_tip_touch item[PINCH_TOUCHES];
} pinch_tip_touches;

#endif
