#ifndef PINCH_LCP_H
#define PINCH_LCP_H

#include <pinch/solver.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * The (mixed) linear complementarity problem: find z with
 *
 *     w = M z + q,    0 <= z_i  ⊥  w_i >= 0    or, where row i is free,    w_i = 0.
 *
 * M and q carry whatever units the caller gives them; the residual is that of the Fischer-Burmeister equations
 * F_i = sqrt(z_i^2 + w_i^2) - z_i - w_i (F_i = w_i on free rows) in those units.
 */
typedef struct pinch_lcp {
    int size;         /* >= 1 */
    const double *m;  /* size x size, row-major, finite */
    const double *q;  /* size, finite */
    const bool *free; /* size; NULL when no row is free */
} pinch_lcp;

/* Memory for LCPs of up to `size` unknowns: 14 size^2 doubles and a little. Each thread needs its own: a workspace
 * serves one call at a time. */
typedef struct pinch_lcp_workspace pinch_lcp_workspace;
/* PINCH_INVALID_ARGUMENT for a size outside of 1 to 10,000; PINCH_OUT_OF_MEMORY. */
PINCH_API pinch_status pinch_lcp_workspace_create(int size, pinch_lcp_workspace **workspace);
PINCH_API void pinch_lcp_workspace_destroy(pinch_lcp_workspace *workspace);

/*
 * Solves the LCP with any solver from the start z[size] (which Lemke's method ignores), in place; w[size] receives
 * M z + q. Allocates nothing.
 *
 * The z of an answer is never negative (but on free rows): a method may end up to the tolerance below 0, and this part
 * is set to 0 before the answer is checked; where that spoils the answer, the method goes on to a finer tolerance.
 * result->residual is that of the z before.
 *
 * result->status: converged (||F||_2 <= tolerance), max_iterations, diverged, ray (Lemke; no solution was found, there
 * may be one), unverified (the method ended, but its answer misses the conditions by more than twice the tolerance and
 * rounding; or rounding is above 1e-6 max |q_i|, which happens where z is huge). On anything but convergence z and w
 * are NaN. max_iterations counts sweeps for PGS and pivots for Lemke's method. PINCH_INVALID_ARGUMENT: settings or
 * sizes out of range, entries that are not finite, a workspace too small.
 */
PINCH_API pinch_status pinch_lcp_solve(const pinch_lcp *lcp, const pinch_solver_settings *settings,
                                       pinch_lcp_workspace *workspace, double *z, double *w,
                                       pinch_solver_result *result);

/*
 * Is there no z at all that meets the inequalities? By Farkas' lemma that is so when some y >= 0 has M^T y <= 0 and
 * q^T y < 0. Looks for such a y, scaled to max y_i = 1, and returns true only after checking it against M and q:
 * (M^T y)_j <= 2e-15 sum_i |M_ij| y_i, q^T y < 0 and q^T y <= -1e-7 sum_i |q_i| y_i, the sums by double-doubles. Where
 * (M^T y)_j is above zero by rounding, y proves nothing for a large enough z; it has to do so for every z as long as M
 * z is rounded by at most 1e-6 max |q_i|. y[size] is unspecified otherwise. Problems with free rows are not judged:
 * false. A proof is exact, and an answer is one to its tolerance: where rows contradict each other by less than that,
 * there may be both.
 */
PINCH_API bool pinch_lcp_prove_infeasible(const pinch_lcp *lcp, pinch_lcp_workspace *workspace, double *y);

#ifdef __cplusplus
}
#endif
#endif
