#ifndef PINCH_COLLISION_DISTANCE_H
#define PINCH_COLLISION_DISTANCE_H

#include "collision/shape/shape_pair.h"

/* Distance of two shapes (Gilbert, Johnson, Keerthi 1988), with the simplex it ended on. */

typedef enum pinch_gjk_outcome {
    PINCH_GJK_APART = 0,
    PINCH_GJK_BEYOND,  /* farther apart than the cutoff */
    PINCH_GJK_TOUCHING /* the shapes overlap, or touch to rounding */
} pinch_gjk_outcome;

typedef struct pinch_gjk_result {
    double normal[3]; /* unit, into A; only if apart */
    double distance;
    int count; /* of the simplex' points */
    double a[4][3], b[4][3];
    bool limited; /* stopped at the iteration limit */
} pinch_gjk_result;

/*
 * `shift` (NULL: none) is added to A. With `eroded`, balls are taken off curved shapes (pinch_shape.erosion). `guess`:
 * any vector from B towards A. Relative accuracy of the squared distance `precision`; polytopes are exact to rounding.
 */
pinch_gjk_outcome pinch_gjk(const pinch_shape_pair *pair, const double *shift, bool eroded, const double guess[3],
                            double cutoff, double precision, pinch_gjk_result *result);

/* The contact normal of balls and capsules with each other, and with boxes and cylinders while a capsule's axis is
 * outside. Returns false where there is no closed form for the pair as it lies. */
bool pinch_closed_form(const pinch_shape_pair *pair, pinch_contact_normal *found);

#endif
