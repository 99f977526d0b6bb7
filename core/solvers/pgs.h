#ifndef PINCH_SOLVERS_PGS_H
#define PINCH_SOLVERS_PGS_H

#include <pinch/lcp.h>

/*
 * Projected Gauss-Seidel, what ODE's quickstep iterates: z_i <- max(0, z_i - w_i / M_ii) row by row (no max on free
 * rows). Rows with M_ii <= 0 have no such step and stay as they are. Works on z in place; w[size] is scratch.
 */
void pinch_pgs(const pinch_lcp *lcp, const pinch_solver_settings *settings, double *z, double *w,
               pinch_solver_result *result);

#endif
