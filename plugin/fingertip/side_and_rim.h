#ifndef PINCH_FINGERTIP_SIDE_AND_RIM_H
#define PINCH_FINGERTIP_SIDE_AND_RIM_H

#include "core.h"

/*
 * At right angles to a body's `axis`, where its side is straight, the normal of least overlap with one rim of another
 * body of axis `w`: the rim at its end along w (`rim` 1) or against it (-1); both axes unit. P leads from any point of
 * the first axis to the other's middle where the rims are B's; where they are A's, which ends at -n, from A's middle to
 * the first axis, and `rim` is the opposite one. `overlap`: less the first one's radius. False: there is none, or the
 * axes are parallel.
 */
bool pinch_side_and_rim(const double P[3], const double axis[3], const pinch_core *other, const double w[3], int rim,
                        double n[3], double *overlap);

#endif
