#ifndef PINCH_FINGERTIP_CLOSED_H
#define PINCH_FINGERTIP_CLOSED_H

#include "collision/shape/contact_normal.h"

typedef enum pinch_closed {
    PINCH_CLOSED_UNKNOWN = 0, /* no closed form for this pair as it lies */
    PINCH_CLOSED_FOUND
} pinch_closed;

/* Pairs whose normal has a closed form. */
pinch_closed pinch_closed_normal(const pinch_core_pair *pair, pinch_contact_normal *found);

#endif
