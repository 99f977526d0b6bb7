/*
 * The contact law in projection form, where the force is the unknown:
 *
 *     r = P(z),   z = (1 - rho C) r - rho (w - b),   C = 1/(h k + c),   b = the relative velocity at which r = 0
 *
 * It has the same solutions as r = law(w) (law/contact_law.h) for every rho > 0, but where the contact is stiff,
 * r = (b - w)/C is all rounding. rho = 1/(C + h W) with W the diagonal of the Delassus operator G M^-1 G^T makes z the
 * force of a step in which this contact alone would move.
 *
 * Rows: normal; tangent1, tangent2; torsional; rolling about tangent1, tangent2. A joint row is a normal alone.
 */
#ifndef PINCH_FORCE_FORCE_LAW_H
#define PINCH_FORCE_FORCE_LAW_H

#include <pinch/problem.h>

enum { PINCH_FORCE_ROWS = 6 };

typedef struct pinch_force_law {
    int rows; /* 1, 3, 4 (torsion in the ellipsoid with the tangents) or 6 (torsion and rolling by themselves) */
    double low, high;             /* of the normal force */
    double friction[5], limit[5]; /* semi-axis i of the limit surface: limit + friction r_n; N, N, N m, N m, N m */
} pinch_force_law;

void pinch_force_law_of_contact(const pinch_contact *contact, pinch_force_law *law);

/*
 * r[rows] = P(z), in the metric sum (r - z)^2 / rho; derivative (rows x rows, row major; may be NULL) = dP/dz, an
 * element of the generalized Jacobian.
 */
pinch_contact_state pinch_force_project(const pinch_force_law *law, const double *rho, const double *z, double *r,
                                        double *derivative);

#endif
