#ifndef PINCH_LAW_LIMIT_SURFACE_H
#define PINCH_LAW_LIMIT_SURFACE_H

#include <stdbool.h>

/*
 * Projection of the trial friction s = (t1, t2, tau) (N, N, N·m) onto the friction limit surface
 *
 *     sum_i (r_i / axis_i)^2 <= 1        axis = r_n (mu, mu, mu_tau)   (N, N, N·m; each >= 0, infinity allowed)
 *
 * in the compliance metric: r minimizes sum_i (r_i - s_i)^2 / stiffness_i (N/m, N/m, N·m/rad; > 0). An axis of zero
 * length carries nothing: r_i = 0.
 *
 * dr_ds[9] (row-major) and dr_dscale[3] may be NULL. dr_dscale is the derivative with respect to a common factor on all
 * axes, at 1: dr/dr_n = dr_dscale / r_n. On the surface itself they are those of sticking.
 *
 * Returns whether s was inside or on the surface: the contact sticks and r = s.
 */
bool pinch_limit_surface_project(const double axis[3], const double stiffness[3], const double s[3], double r[3],
                                 double dr_ds[9], double dr_dscale[3]);

#endif
