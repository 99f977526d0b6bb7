/* Distance of two cores (Gilbert, Johnson, Keerthi 1988), with the simplex it ended on. */
#ifndef PINCH_FINGERTIP_GJK_H
#define PINCH_FINGERTIP_GJK_H

#include "collision/shape/shape_pair.h"

typedef enum pinch_gjk_outcome {
    PINCH_GJK_APART = 0,
    PINCH_GJK_BEYOND,  /* farther apart than the cutoff */
    PINCH_GJK_TOUCHING /* the cores overlap, or touch to rounding */
} pinch_gjk_outcome;

typedef struct pinch_gjk_result {
    double normal[3]; /* unit, into A; only if apart */
    double distance;
    int count; /* of the simplex' points */
    double a[4][3], b[4][3];
    bool limited; /* stopped at the iteration limit */
} pinch_gjk_result;

/*
 * `shift` (NULL: none) is added to A. With `eroded`, balls are taken off curved cores (pinch_core.erosion). `guess`:
 * any vector from B towards A. Relative accuracy of the squared distance `precision`; polytopes are exact to rounding.
 */
pinch_gjk_outcome pinch_gjk(const pinch_core_pair *pair, const double *shift, bool eroded, const double guess[3],
                            double cutoff, double precision, pinch_gjk_result *result);

#endif
