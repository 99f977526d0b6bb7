#ifndef PINCH_COLLISION_DISTANCE_H
#define PINCH_COLLISION_DISTANCE_H

#include "collision/shape/shape_pair.h"

/* The distance of two shapes by GJK (Gilbert, Johnson, Keerthi 1988), with the simplex on which it ended. */

typedef enum pinch_gjk_outcome {
    PINCH_GJK_APART = 0,
    PINCH_GJK_BEYOND,  /* farther apart than the cutoff */
    PINCH_GJK_TOUCHING /* the shapes overlap, or touch to rounding */
} pinch_gjk_outcome;

typedef struct pinch_gjk_result {
    double normal[3]; /* unit, into A; only if apart */
    double distance;
    int count; /* number of points in the simplex */
    double a[4][3], b[4][3];
    bool limited; /* stopped at the iteration limit */
} pinch_gjk_result;

/*
 * A is moved by `shift` (NULL for none). With `eroded`, balls are taken off curved shapes (pinch_shape.erosion).
 * `guess` is any vector from B towards A. The squared distance gets the relative accuracy `precision`; for polytopes it
 * is exact to rounding.
 */
pinch_gjk_outcome pinch_gjk(const pinch_shape_pair *pair, const double *shift, bool eroded, const double guess[3],
                            double cutoff, double precision, pinch_gjk_result *result);

/* The contact normal of balls and capsules with each other, and with boxes and cylinders while a capsule's axis is
 * outside. Returns false where there is no closed form for the pair as it lies. */
bool pinch_closed_form(const pinch_shape_pair *pair, pinch_contact_normal *found);

#endif
