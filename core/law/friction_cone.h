#ifndef PINCH_LAW_FRICTION_CONE_H
#define PINCH_LAW_FRICTION_CONE_H

/*
 * Closest point of a contact's set of admissible forces, in units in which friction is 1: y = (r_n, r_t1/mu, r_t2/mu,
 * r_tau/mu_tau) with
 *
 *     |(y_1, y_2, y_3)| <= y_0                                         faces = 0, the exact cone
 *     (y_1, y_2) in the polygon of apothem y_0,  |y_3| <= y_0          otherwise
 *
 * and low <= y_0 <= high (0 <= low; low = high prescribes the normal force; high may be INFINITY).
 * x[4] is the point, dy_dx[16] the symmetric derivative.
 */
void pinch_cone_project(int faces, double low, double high, const double x[4], double y[4], double dy_dx[16]);

#endif
