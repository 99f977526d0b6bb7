#include "solvers/fischer_burmeister.h"
#include "solvers/methods.h"

#include <math.h>

/* One pass over all rows; returns how many had a step. */
static int sweep(const pinch_lcp *lcp, double *z)
{
    int n = lcp->size, steps = 0;
    for (int i = 0; i < n; i++) {
        const double *m = lcp->m + (size_t)i * (size_t)n;
        if (!(m[i] > 0.0)) continue;
        double w = lcp->q[i];
        for (int j = 0; j < n; j++) w += m[j] * z[j];
        double next = z[i] - w / m[i];
        z[i] = next > 0.0 || (lcp->free && lcp->free[i]) ? next : 0.0;
        steps++;
    }
    return steps;
}

void pinch_pgs(const pinch_lcp *lcp, const pinch_solver_settings *settings, double *z, double *w,
               pinch_solver_result *result)
{
    *result = (pinch_solver_result){.status = PINCH_SOLVE_MAX_ITERATIONS};
    for (;;) {
        pinch_lcp_residual(lcp, z, w);
        result->residual = pinch_fischer_burmeister_norm(lcp, z, w);
        if (settings->progress) settings->progress(settings->progress_context, result->iterations, result->residual);
        if (!isfinite(result->residual)) {
            result->status = PINCH_SOLVE_DIVERGED;
            return;
        }
        if (result->residual <= settings->tolerance) {
            result->status = PINCH_SOLVE_CONVERGED;
            return;
        }
        if (result->iterations == settings->max_iterations) return;
        result->projections += sweep(lcp, z);
        result->iterations++;
    }
}
