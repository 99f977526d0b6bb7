#ifndef PINCH_FINGERTIP_SIDE_AND_RIM_H
#define PINCH_FINGERTIP_SIDE_AND_RIM_H

#include "collision/shape/convex_shape.h"

/* The axis of a round body across something straight, seen along that: x is the axis made perpendicular to it, y across
 * both, unit; X and Y where the body's middle is. */
typedef struct pinch_across {
    double x[3], y[3], X, Y;
    double sine, m; /* of the angle between both; the squared cosine */
} pinch_across;

/* `axis`: of what is straight, w: of the round body; both unit. P leads from any point of the first to the body's
 * middle where the rims are B's; where they are A's, which ends at -n, from A's middle to the first. False: parallel.
 */
bool pinch_across_of(const double axis[3], const double w[3], const double P[3], pinch_across *across);

/*
 * At right angles to the first axis the normal of least overlap with one rim of the body: the one at its end along w
 * (`rim` 1) or against it (-1), of A the opposite one. `overlap`: what is straight having no radius. False: there is
 * none.
 */
bool pinch_side_and_rim(const pinch_across *across, const pinch_core *body, int rim, double n[3], double *overlap);

#endif
