/*
 * Matrices of 3 x 3 in ODE's layout: rows of four numbers, the last of which is padding and comes along.
 *
 * Each entry of a product is summed from the first factor to the last, as in ODE's header, and so has the bits that it
 * has there. Two entries of a row are computed together.
 */
#ifndef PINCH_BODIES_MATRIX3_H
#define PINCH_BODIES_MATRIX3_H

#include "support/lanes.h"

enum { PINCH_MATRIX3 = 12 }; /* numbers of a matrix */

/* c = a b; c is neither of them. */
static inline void pinch_matrix3_product(const double *a, const double *b, double *c)
{
    for (int i = 0; i < PINCH_MATRIX3; i += 4) {
        const pinch_lanes x = {a[i], a[i]}, y = {a[i + 1], a[i + 1]}, z = {a[i + 2], a[i + 2]};
        for (int j = 0; j < 4; j += 2)
            pinch_lanes_put(x * pinch_lanes_at(b + j) + y * pinch_lanes_at(b + 4 + j) + z * pinch_lanes_at(b + 8 + j),
                            c + i + j);
    }
}

/* t = a^T, with padding of 0 */
static inline void pinch_matrix3_transpose(const double *a, double *t)
{
    for (int i = 0; i < 3; i++) { /* written two at a time, as products read it: what is not, they would wait for */
        pinch_lanes_put((pinch_lanes){a[i], a[4 + i]}, t + 4 * i);
        pinch_lanes_put((pinch_lanes){a[8 + i], 0}, t + 4 * i + 2);
    }
}

/* world = R body R^T, the right product first; turned: R^T */
static inline void pinch_matrix3_turn(const double *body, const double *R, const double *turned, double *world)
{
    double left[PINCH_MATRIX3];
    pinch_matrix3_product(body, turned, left);
    pinch_matrix3_product(R, left, world);
}

#endif
