#include "solvers/fischer_burmeister.h"
#include "solvers/methods.h"
#include "support/double_double.h"
#include "support/lu.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct pinch_lcp_workspace {
    int size;
    double *fb, *solver;                      /* Fischer-Burmeister system, iterative solvers */
    double *wide_m, *wide_q, *wide_z, *scale; /* an LCP of up to 2 size unknowns for Lemke's method */
    double *lemke;
    int *pivot, *basis;
    pinch_row_segment *segments;
    double memory[];
};

pinch_status pinch_lcp_workspace_create(int size, pinch_lcp_workspace **workspace)
{
    *workspace = NULL;
    if (size < 1 || size > 10000) return PINCH_INVALID_ARGUMENT;
    size_t n = (size_t)size;
    size_t doubles[] = {
        pinch_fischer_burmeister_scratch(size), pinch_solver_scratch(size), 4 * n * n, 2 * n, 2 * n, 2 * n,
        pinch_lemke_scratch(2 * size)};
    size_t total = 0;
    for (size_t i = 0; i < sizeof doubles / sizeof *doubles; i++) total += doubles[i];
    pinch_lcp_workspace *ws = malloc(sizeof *ws + total * sizeof(double));
    if (!ws) return PINCH_OUT_OF_MEMORY;
    double *next = ws->memory,
           **arrays[] = {&ws->fb, &ws->solver, &ws->wide_m, &ws->wide_q, &ws->wide_z, &ws->scale, &ws->lemke};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) {
        *arrays[i] = next;
        next += doubles[i];
    }
    ws->size = size;
    ws->pivot = malloc(3 * n * sizeof *ws->pivot);
    ws->segments = malloc(n * sizeof *ws->segments);
    if (!ws->pivot || !ws->segments) {
        pinch_lcp_workspace_destroy(ws);
        return PINCH_OUT_OF_MEMORY;
    }
    ws->basis = ws->pivot + n;
    *workspace = ws;
    return PINCH_OK;
}

void pinch_lcp_workspace_destroy(pinch_lcp_workspace *workspace)
{
    if (!workspace) return;
    free(workspace->pivot);
    free(workspace->segments);
    free(workspace);
}

static bool all_finite(const double *x, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (!isfinite(x[i])) return false;
    return true;
}

/* A free z_f is the difference of two non-negative unknowns with opposite rows: z_f = z+ - z-, both w equal to zero. */
static pinch_lcp split_free_unknowns(const pinch_lcp *lcp, pinch_lcp_workspace *ws, int *negative_of)
{
    int n = lcp->size, wide = n;
    for (int i = 0; i < n; i++)
        if (lcp->free && lcp->free[i]) negative_of[wide++ - n] = i;
    for (int i = 0; i < wide; i++) {
        int row = i < n ? i : negative_of[i - n];
        double row_sign = i < n ? 1.0 : -1.0;
        ws->wide_q[i] = row_sign * lcp->q[row];
        for (int j = 0; j < wide; j++) {
            int column = j < n ? j : negative_of[j - n];
            double sign = j < n ? row_sign : -row_sign;
            ws->wide_m[(size_t)i * (size_t)wide + (size_t)j] = sign * lcp->m[(size_t)row * (size_t)n + (size_t)column];
        }
    }
    return (pinch_lcp){.size = wide, .m = ws->wide_m, .q = ws->wide_q};
}

/* Lemke's pivots find the active set; Newton's steps on the same equations keep it and find the last digits. */
static void solve_by_lemke(const pinch_lcp *lcp, const pinch_system *system, const pinch_solver_settings *settings,
                           pinch_lcp_workspace *ws, double *z, pinch_solver_result *result)
{
    int n = lcp->size;
    pinch_lcp wide = split_free_unknowns(lcp, ws, ws->pivot);
    pinch_lemke_scale(&wide, ws->scale);
    *result = (pinch_solver_result){.residual = NAN};
    result->status =
        pinch_lemke(&wide, ws->scale, settings->max_iterations, ws->lemke, ws->basis, ws->wide_z, &result->iterations);
    result->projections = result->iterations;
    if (result->status != PINCH_SOLVE_CONVERGED) return;
    memcpy(z, ws->wide_z, (size_t)n * sizeof *z);
    for (int i = n; i < wide.size; i++) z[ws->pivot[i - n]] -= ws->wide_z[i];

    pinch_solver_settings finish = *settings;
    finish.solver = PINCH_SOLVER_NEWTON;
    finish.max_iterations = 10;
    finish.progress = NULL;
    pinch_solver_result polished;
    pinch_solve_system(system, &finish, ws->solver, z, &polished);
    result->newton_steps = polished.newton_steps;
    result->residual = polished.residual;
    if (polished.status != PINCH_SOLVE_CONVERGED) result->status = PINCH_SOLVE_UNVERIFIED;
}

/*
 * What is returned and checked is max(z, 0), not the z of the method, which may be negative by its tolerance: times a
 * large entry of M even -1e-14 moves w so far that a problem without a solution would seem to have one.
 */
static bool project(const pinch_lcp *lcp, double *z)
{
    bool moved = false;
    for (int i = 0; i < lcp->size; i++) {
        if (!(z[i] < 0.0) || (lcp->free && lcp->free[i])) continue;
        z[i] = 0.0;
        moved = true;
    }
    return moved;
}

/*
 * The check of an answer z >= 0, which knows nothing of the Fischer-Burmeister equations that led to it: by how much
 * row i misses w >= 0, z w = 0 is |min(z_i, w_i)|, at most 1.71 times as much as |F_i|. The sum M z + q is rounded, and
 * so is z; a row is allowed that much more, as long as it is small beside q.
 */
static bool is_solution(const pinch_lcp *lcp, const double *z, double tolerance)
{
    size_t n = (size_t)lcp->size;
    double largest = tolerance;
    for (size_t i = 0; i < n; i++) largest = fmax(largest, fabs(lcp->q[i]));
    for (size_t i = 0; i < n; i++) {
        double w = lcp->q[i], terms = fabs(lcp->q[i]);
        for (size_t j = 0; j < n; j++) {
            w += lcp->m[i * n + j] * z[j];
            terms += fabs(lcp->m[i * n + j] * z[j]);
        }
        double rounding = (double)n * DBL_EPSILON * terms;
        double missed = fabs(lcp->free && lcp->free[i] ? w : fmin(z[i], w));
        if (!(rounding <= 1e-6 * largest && missed <= 2 * tolerance + rounding)) return false;
    }
    return true;
}

/*
 * Is max(z, 0) an answer, z being where a method has converged? Where it misses the tolerance only because it is not z,
 * the method goes on from there to a finer tolerance, which leaves less of z below 0. Each round asks for an eighth of
 * the one before, so that four reach below the thousandth part.
 */
static bool ends_in_solution(const pinch_lcp *lcp, const pinch_system *system, const pinch_solver_settings *settings,
                             pinch_lcp_workspace *ws, double *z, pinch_solver_result *result)
{
    enum { ROUNDS = 4 };
    pinch_solver_settings finer = *settings;
    if (finer.solver == PINCH_SOLVER_LEMKE) finer.solver = PINCH_SOLVER_NEWTON; /* its pivots are done */
    finer.progress = NULL;
    for (int round = 0;; round++) {
        bool moved = project(lcp, z);
        if (is_solution(lcp, z, settings->tolerance)) return true;
        finer.max_iterations = settings->max_iterations - result->iterations;
        if (!moved || round == ROUNDS || finer.max_iterations < 1) return false;
        finer.tolerance /= 8.0;
        finer.goal = fmin(finer.goal, finer.tolerance);
        pinch_solver_result more;
        pinch_solve_system(system, &finer, ws->solver, z, &more);
        result->iterations += more.iterations;
        result->projections += more.projections;
        result->newton_steps += more.newton_steps;
        result->residual = more.residual;
        if (more.status != PINCH_SOLVE_CONVERGED) return false;
    }
}

pinch_status pinch_lcp_solve(const pinch_lcp *lcp, const pinch_solver_settings *settings,
                             pinch_lcp_workspace *workspace, double *z, double *w, pinch_solver_result *result)
{
    if (lcp->size < 1 || lcp->size > workspace->size || pinch_check_solver_settings(settings) != PINCH_OK)
        return PINCH_INVALID_ARGUMENT;
    size_t n = (size_t)lcp->size;
    if (!all_finite(lcp->m, n * n) || !all_finite(lcp->q, n)) return PINCH_INVALID_ARGUMENT;

    pinch_fischer_burmeister fb;
    pinch_system system = pinch_fischer_burmeister_init(&fb, lcp, workspace->fb, workspace->pivot, workspace->segments);
    if (settings->solver == PINCH_SOLVER_LEMKE)
        solve_by_lemke(lcp, &system, settings, workspace, z, result);
    else if (settings->solver == PINCH_SOLVER_PGS)
        pinch_pgs(lcp, settings, z, w, result);
    else
        pinch_solve_system(&system, settings, workspace->solver, z, result);

    if (result->status == PINCH_SOLVE_CONVERGED) {
        if (ends_in_solution(lcp, &system, settings, workspace, z, result)) {
            pinch_lcp_residual(lcp, z, w);
            return PINCH_OK;
        }
        result->status = PINCH_SOLVE_UNVERIFIED;
    }
    for (size_t i = 0; i < n; i++) z[i] = w[i] = NAN;
    return PINCH_OK;
}

/* x.y by double-doubles, x at every `stride`; adds up |x_i y_i| in *terms */
static double exact_product(int n, const double *x, size_t stride, const double *y, double *terms)
{
    pinch_double_double sum = {0};
    *terms = 0.0;
    for (int i = 0; i < n; i++) {
        sum = pinch_dd_add(sum, pinch_dd_product(x[(size_t)i * stride], y[i]));
        *terms += fabs(x[(size_t)i * stride] * y[i]);
    }
    return sum.high;
}

/*
 * Checks with arithmetic of its own that y >= 0, M^T y <= 0 and q^T y < 0. As y is rounded, (M^T y)_j may be positive
 * by a rounding error of its terms. A z that meets the inequalities then has to meet
 *
 *     0 <= y^T (M z + q) <= sum_j max(0, (M^T y)_j) z_j + q^T y,
 *
 * which large z do. No method takes a z for a solution whose M z is rounded by more than 1e-6 max |q_i| (see
 * is_solution), so that z_j <= Z_j = 1e-6 max |q_i| / (eps max_i |M_ij|): the sum over Z has to stay below -q^T y.
 * Without this a y proves nothing where its rows differ in scale: what q sees of it may be smaller than the rounding of
 * M^T y.
 */
static bool proves_infeasible(const pinch_lcp *lcp, const double *y)
{
    const double rounding = 8 * DBL_EPSILON;
    int n = lcp->size;
    double terms, most_q = 0.0, left = 0.0;
    for (int i = 0; i < n; i++) {
        if (!(y[i] >= 0.0)) return false;
        most_q = fmax(most_q, fabs(lcp->q[i]));
    }
    for (int j = 0; j < n; j++) {
        double sum = exact_product(n, lcp->m + j, (size_t)n, y, &terms), most_m = 0.0;
        if (!(sum <= rounding * terms)) return false;
        for (int i = 0; i < n; i++) most_m = fmax(most_m, fabs(lcp->m[(size_t)i * (size_t)n + (size_t)j]));
        if (sum > 0.0) left += sum / most_m * (1e-6 / DBL_EPSILON * most_q);
    }
    double qy = exact_product(n, lcp->q, 1, y, &terms);
    return qy < 0.0 && qy <= -1e-7 * terms && left < -qy; /* a y that q does not see proves nothing */
}

/*
 * Lemke's method ends on a ray y with the errors of all its pivots. Those columns of M^T y that should be 0 are brought
 * there by changes y_i u_i of y, u the least solution of
 *
 *     sum_i (M_ij y_i / t_j) u_i = -(M^T y)_j / t_j,   t_j = sum_i |M_ij| y_i.
 *
 * Its normal equations are regularized, because columns may depend on each other. What is left goes with the next call.
 * Returns false where y is lost on the way: then there is no such ray near it.
 */
static bool refine_ray(const pinch_lcp *lcp, pinch_lcp_workspace *workspace, double *y)
{
    const double tight = 1e-7, regular = 1e-14;
    int n = lcp->size, count = 0, *pivot = workspace->pivot;
    size_t wide = (size_t)n;
    double *rows = workspace->wide_m, *normal = rows + wide * wide;
    double *rhs = workspace->wide_q, *scratch = workspace->wide_z, largest = 0.0;
    for (int j = 0; j < n; j++) {
        double terms, sum = exact_product(n, lcp->m + j, wide, y, &terms);
        if (!(terms > 0.0) || sum < -tight * terms) continue;
        for (int i = 0; i < n; i++)
            rows[(size_t)count * wide + (size_t)i] = lcp->m[(size_t)i * wide + (size_t)j] * y[i] / terms;
        rhs[count++] = -sum / terms;
    }
    for (int a = 0; a < count; a++)
        for (int b = 0; b < count; b++) {
            double sum = a == b ? regular : 0.0;
            for (int i = 0; i < n; i++) sum += rows[(size_t)a * wide + (size_t)i] * rows[(size_t)b * wide + (size_t)i];
            normal[(size_t)a * (size_t)count + (size_t)b] = sum;
        }
    if (count == 0 || !pinch_lu_factor(count, normal, pivot, scratch)) return false;
    pinch_lu_solve(count, normal, pivot, rhs, rhs);
    for (int i = 0; i < n; i++) {
        double u = 0.0;
        for (int a = 0; a < count; a++) u += rows[(size_t)a * wide + (size_t)i] * rhs[a];
        y[i] = fmax(0.0, y[i] * (1.0 + u));
        largest = fmax(largest, y[i]);
    }
    if (!(largest > 0.5)) return false;
    for (int i = 0; i < n; i++) y[i] /= largest;
    return true;
}

/*
 * The least ||z|| with z >= 0 and M z + q >= 0 is the monotone LCP
 *
 *     [ I  -M^T ] [z]   [0]
 *     [ M    0  ] [y] + [q]
 *
 * on which Lemke's method either finds z or ends on a ray whose y part is Farkas' vector.
 */
bool pinch_lcp_prove_infeasible(const pinch_lcp *lcp, pinch_lcp_workspace *workspace, double *y)
{
    enum { REFINEMENTS = 4 };
    int n = lcp->size, wide = 2 * n;
    if (n > workspace->size || lcp->free) return false;
    double *m = workspace->wide_m;
    memset(m, 0, (size_t)wide * (size_t)wide * sizeof *m);
    for (int i = 0; i < n; i++) {
        workspace->wide_q[i] = 0.0;
        workspace->wide_q[n + i] = lcp->q[i];
        m[(size_t)i * (size_t)wide + (size_t)i] = 1.0;
        for (int j = 0; j < n; j++) {
            double value = lcp->m[(size_t)i * (size_t)n + (size_t)j];
            m[(size_t)(n + i) * (size_t)wide + (size_t)j] = value;
            m[(size_t)j * (size_t)wide + (size_t)(n + i)] = -value;
        }
    }
    pinch_lcp least = {.size = wide, .m = m, .q = workspace->wide_q};
    pinch_lemke_scale(&least, workspace->scale);
    int pivots;
    if (pinch_lemke(&least, workspace->scale, 100 * wide, workspace->lemke, workspace->basis, workspace->wide_z,
                    &pivots) != PINCH_SOLVE_RAY)
        return false;
    double largest = 0.0;
    for (int i = 0; i < n; i++) largest = fmax(largest, workspace->wide_z[n + i]);
    if (!(largest > 0.0)) return false;
    for (int i = 0; i < n; i++) y[i] = workspace->wide_z[n + i] / largest;
    for (int attempt = 0; attempt < REFINEMENTS && !proves_infeasible(lcp, y); attempt++)
        if (!refine_ray(lcp, workspace, y)) return false;
    return proves_infeasible(lcp, y);
}
