/* A flat face that is clipped against. */
#ifndef PINCH_FINGERTIP_FLAT_FACE_H
#define PINCH_FINGERTIP_FLAT_FACE_H

#include "collision/shape/shape_pair.h"
#include "collision/shape/feature.h"
#include "touch.h"

/* What is outside of it, seen along n, does not meet it. In A's axes. */
typedef struct pinch_flat_face {
    const pinch_core_pair *pair;
    int which; /* 0: A's face, 1: B's */
    const pinch_core *core;
    const pinch_core_part *part;
    double n[3], d[3]; /* d: n in the core's own axes */
    bool simple;       /* a cap, or a box' or hull's face square to n: its borders are known from one of its points */
    double slack;      /* m: a corner just outside by rounding is kept */
} pinch_flat_face;

#endif
