/*
 * The linear complementarity problem of one step with the linearized friction cone, in the reduced coordinates of the
 * velocity system: for the pivoting and sweeping methods that need the matrix.
 *
 * With z = (r_n; lambda; s) per contact, r_t = a_t - g_t (w_t + N lambda) and S = 1 + h sum G_t^T g_t G_t + h sum G_c^T
 * g_c G_c (c: compliant joint rows), the motion q = S^-1 (h G_n^T r_n - h G_t^T g_t N lambda + p) is linear in z, and
 *
 *     0 <= r_n     ⊥  r_n / g_n + w_n - a_n / g_n + s   >= 0
 *     0 <= lambda  ⊥  mu r_n - N^T r_t                  >= 0
 *     0 <= s       ⊥  f_max - r_n                       >= 0      (contacts with a force limit)
 */
#ifndef PINCH_VELOCITY_VELOCITY_LCP_H
#define PINCH_VELOCITY_VELOCITY_LCP_H

#include "velocity/velocity_system.h"

#include <pinch/lcp.h>

/*
 * Solves the step with `settings->solver` on that problem; x[unknowns] receives q. The counts and the status are in
 * *result. PINCH_UNSUPPORTED for one-sided joint rows and massless drives, whose laws are not of this form;
 * PINCH_OUT_OF_MEMORY.
 */
pinch_status pinch_velocity_lcp_solve(pinch_arena *arena, pinch_velocity_system *vs,
                                      const pinch_solver_settings *settings, double *x, pinch_solver_result *result);

#endif
