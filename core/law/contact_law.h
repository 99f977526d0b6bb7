/*
 * The force law of one contact or compliant joint row over one step, as an explicit function of its relative velocity:
 *
 *     trial  s = a - g w          (componentwise; a: the force at w = 0, g: stiffness times step plus damping)
 *     r_0    = clamp(s_0, low, high)
 *     (r_1, r_2, r_3) = projection of (s_1, s_2, s_3) onto the friction limit surface scaled by r_0
 *
 * Equations (2) to (4) of the step; the statics are the same law with displacements for velocities.
 */
#ifndef PINCH_LAW_CONTACT_LAW_H
#define PINCH_LAW_CONTACT_LAW_H

#include <pinch/problem.h>

typedef struct pinch_law {
    int rows; /* 1, 3 or 4 */
    double a[4], g[4];
    double low, high;   /* of the first row */
    int faces;          /* 0: ellipsoid; otherwise a polygon for rows 1 and 2, and row 3 by itself */
    double friction[3]; /* semi-axes of the limit surface per unit of r_0: mu along the two tangents, mu_tau */
} pinch_law;

/* The law of `contact` over a step of length `step`, friction with `faces` facets (0: the cone). */
void pinch_law_of_contact(const pinch_contact *contact, double step, int faces, pinch_law *law);

/* r[rows] at w[rows]; tangent (rows x rows, row major, may be NULL) = -dr/dw, an element of the generalized Jacobian.
 * Returns open, stick or slip. */
pinch_contact_state pinch_law_evaluate(const pinch_law *law, const double *w, double *r, double *tangent);

#endif
