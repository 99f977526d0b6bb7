/* Complementarity problems of up to six unknowns, by every solver. What is called a solution has to be one, and what is
 * called infeasible must have none: where a solver has found one, it has to be one to its tolerance alone. */
#include "target.h"

#include <pinch/lcp.h>

#include <math.h>
#include <stdbool.h>
#include <string.h>

enum { MOST = 6 };

/* Long double, so that the check's own rounding does not count. */
static void check(const pinch_lcp *p, const double *z, double tolerance, const char *solver)
{
    for (int i = 0; i < p->size; i++) {
        long double w = p->q[i], size = fabsl((long double)p->q[i]);
        for (int j = 0; j < p->size; j++) {
            long double part = (long double)p->m[i * p->size + j] * z[j];
            w += part;
            size += fabsl(part);
        }
        long double slack = 4 * tolerance + 1e-13L * size;
        if (!(z[i] >= -slack) || !(w >= -slack) || !(fminl(fabsl(w), fabs(z[i])) <= slack))
            target_found("%s: z[%d] = %g with w = %Lg, rounding %Lg", solver, i, z[i], w, slack);
    }
}

/* Does Farkas' vector y rule z out, beyond the rounding of z? A solution has y^T (M z + q) >= 0. A z for which this is
 * negative misses the inequalities, if only by less than the tolerance: entries of 1e-300 may contradict each other,
 * and what solves the others is an answer to 1e-12 of a problem that has none. */
static bool is_ruled_out(const pinch_lcp *p, const double *y, const double *z)
{
    long double sum = 0, terms = 0;
    for (int i = 0; i < p->size; i++) {
        long double part = (long double)y[i] * p->q[i];
        sum += part;
        terms += fabsl(part);
        for (int j = 0; j < p->size; j++) {
            part = (long double)y[i] * p->m[i * p->size + j] * z[j];
            sum += part;
            terms += fabsl(part);
        }
    }
    return sum < -1e-14L * terms;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    target_bytes b = {data, size};
    double m[MOST * MOST], q[MOST], z[MOST], w[MOST];
    pinch_lcp p = {.size = 1 + (int)(target_byte(&b) % MOST), .m = m, .q = q};
    unsigned symmetric = target_byte(&b) % 3;
    for (int i = 0; i < p.size; i++) {
        q[i] = target_number(&b);
        for (int j = 0; j < p.size; j++) {
            bool mirrored = symmetric && j < i;
            m[i * p.size + j] = mirrored ? (symmetric == 1 ? 1 : -1) * m[j * p.size + i] : target_number(&b);
        }
    }
    static pinch_lcp_workspace *workspace;
    if (!workspace && pinch_lcp_workspace_create(MOST, &workspace) != PINCH_OK) return 0;
    double solutions[PINCH_SOLVER_COUNT][MOST], y[MOST];
    int solved = 0, most = target_iterations(&b);
    for (int s = 0; s < PINCH_SOLVER_COUNT; s++) {
        pinch_solver_settings settings = pinch_default_solver_settings();
        settings.solver = (pinch_solver)s;
        settings.max_iterations = most;
        pinch_solver_result result;
        for (int i = 0; i < p.size; i++) z[i] = 0;
        if (pinch_lcp_solve(&p, &settings, workspace, z, w, &result) != PINCH_OK) continue;
        if (result.status == PINCH_SOLVE_CONVERGED) {
            memcpy(solutions[solved++], z, sizeof z);
            check(&p, z, settings.tolerance, pinch_solver_name(settings.solver));
        } else if (!isnan(z[0])) {
            target_found("%s failed and left z = %g", pinch_solver_name(settings.solver), z[0]);
        }
    }
    if (solved == 0 || !pinch_lcp_prove_infeasible(&p, workspace, y)) return 0;
    for (int s = 0; s < solved; s++)
        if (!is_ruled_out(&p, y, solutions[s])) target_found("a solved problem without a solution");
    return 0;
}
