/* A contact point of two cores. */
#ifndef PINCH_FINGERTIP_TOUCH_H
#define PINCH_FINGERTIP_TOUCH_H

enum { PINCH_TOUCHES = 64 };

typedef struct pinch_touch {
    double position[3]; /* half way through the overlap */
    double depth;       /* m, skins included */
} pinch_touch;

#endif
