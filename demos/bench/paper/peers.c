/*
 * Peers that Pinch does not have among its solvers: ADMM on the exact cone, and modulus-based matrix splitting.
 *
 * ADMM is that of Carpentier, Le Lidec and Montaut, "From compliant to rigid contact simulation" (2024), written from
 * the published method. Contacts are compliant, the object is in equilibrium instead of in motion: with forces r, the
 * displacement u as the multiplier of equilibrium, and c the gap and the slip,
 *
 *     c = C r + W^T u + g,     W r + p = 0,     K ∋ r ⊥ c + s ∈ K*,     s = (mu |c_t|, 0, 0)      C = diag(1/k)
 *
 * s is De Saxce's correction. An iteration is
 *
 *     (C + (eta + rho)) x + W^T u = eta x_last + rho y + z - g - s,     W x + p = 0
 *     y = P_K(x - z / rho)
 *     z <- z - rho (x - y)
 *
 * with s from z. C is diagonal, so that u costs a system of six unknowns. rho grows or shrinks where the primal and the
 * dual residual differ by more than a factor of ten. The published step of rho is a power of the condition number of
 * the Delassus operator, which is 1 for C where all stiffnesses are equal; a least step is ours.
 */
#include "paper.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Solves a x = b in place for n <= 6 by elimination with pivoting. Pivots next to nothing leave their unknown at 0. */
static void solve_small(int n, double a[36], double b[6])
{
    double scale = 0.0;
    for (int i = 0; i < n * n; i++) scale = fmax(scale, fabs(a[i]));
    int order[6];
    bool used[6] = {false};
    for (int k = 0; k < n; k++) {
        int best = -1;
        for (int i = 0; i < n; i++)
            if (!used[i] && (best < 0 || fabs(a[i * n + k]) > fabs(a[best * n + k]))) best = i;
        order[k] = best;
        used[best] = true;
        if (fabs(a[best * n + k]) <= 1e-12 * scale) {
            order[k] = -1;
            used[best] = false;
            continue;
        }
        for (int i = 0; i < n; i++) {
            if (i == best) continue;
            double part = a[i * n + k] / a[best * n + k];
            for (int j = k; j < n; j++) a[i * n + j] -= part * a[best * n + j];
            b[i] -= part * b[best];
        }
    }
    double x[6] = {0};
    for (int k = 0; k < n; k++)
        if (order[k] >= 0) x[k] = b[order[k]] / a[order[k] * n + k];
    memcpy(b, x, (size_t)n * sizeof *x);
}

/* The problem in ADMM's letters: rows of all fingers one after the other, 1 or 3 each. */
typedef struct cone_problem {
    const pinch_grasp *grasp;
    int rows, freedoms;
    double p[6];
    double *w; /* rows x 6: the columns of W */
    double *c; /* the diagonal of C */
    double *g, *s, *x, *y, *z;
    double u[6];
} cone_problem;

static int rows_of(const pinch_finger *f)
{
    return f->model == PINCH_CONTACT_FRICTIONLESS ? 1 : 3;
}

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static void write_row(const pinch_finger *f, const double direction[3], bool planar, double w[6])
{
    double moment[3];
    cross(f->point, direction, moment);
    if (planar) {
        w[0] = direction[0];
        w[1] = direction[1];
        w[2] = moment[2];
        return;
    }
    memcpy(w, direction, 3 * sizeof *w);
    memcpy(w + 3, moment, 3 * sizeof *w);
}

static bool cone_problem_create(const pinch_grasp *grasp, cone_problem *q)
{
    *q = (cone_problem){.grasp = grasp, .freedoms = grasp->planar ? 3 : 6};
    for (int i = 0; i < grasp->finger_count; i++) q->rows += rows_of(&grasp->fingers[i]);
    size_t n = (size_t)q->rows;
    q->w = calloc(12 * n, sizeof *q->w);
    if (!q->w) return false;
    double *next = q->w + 6 * n, **arrays[] = {&q->c, &q->g, &q->s, &q->x, &q->y, &q->z};
    for (size_t i = 0; i < 6; i++, next += n) *arrays[i] = next;
    static const int planar[3] = {0, 1, 5};
    for (int j = 0; j < q->freedoms; j++) q->p[j] = grasp->wrench[grasp->planar ? planar[j] : j];
    int row = 0;
    for (int i = 0; i < grasp->finger_count; i++) {
        const pinch_finger *f = &grasp->fingers[i];
        double tangent2[3];
        cross(f->normal, f->tangent1, tangent2);
        const double *directions[3] = {f->normal, f->tangent1, tangent2};
        q->g[row] = -f->closing;
        for (int k = 0; k < rows_of(f); k++, row++) {
            write_row(f, directions[k], grasp->planar, q->w + 6 * row);
            q->c[row] = 1.0 / f->stiffness[k > 0];
        }
    }
    return true;
}

/* The closest point of the cone, or of the disc at a prescribed normal force. */
static void project(const pinch_finger *f, double r[3])
{
    if (f->force_controlled)
        r[0] = f->normal_force;
    else if (rows_of(f) == 1)
        r[0] = fmax(r[0], 0.0);
    if (rows_of(f) == 1) return;
    double mu = f->friction, t = hypot(r[1], r[2]);
    double normal = f->force_controlled ? r[0] : (r[0] + mu * t) / (1.0 + mu * mu);
    if (!f->force_controlled && t <= mu * r[0]) return;
    if (t <= mu * normal && f->force_controlled) return;
    normal = fmax(normal, 0.0); /* negative in the polar cone, whose points go to the apex */
    double part = t > 0.0 ? mu * normal / t : 0.0;
    r[0] = normal;
    r[1] *= part;
    r[2] *= part;
}

/* x and u from the linear system. */
static void step_x(cone_problem *q, double eta, double rho)
{
    int m = q->freedoms;
    double a[36] = {0}, b[6];
    memcpy(b, q->p, sizeof b);
    for (int i = 0; i < q->rows; i++) {
        double inverse = 1.0 / (q->c[i] + eta + rho), *w = q->w + 6 * i;
        q->x[i] = inverse * (eta * q->x[i] + rho * q->y[i] + q->z[i] - q->g[i] - q->s[i]);
        for (int j = 0; j < m; j++) {
            b[j] += w[j] * q->x[i];
            for (int k = 0; k < m; k++) a[j * m + k] += inverse * w[j] * w[k];
        }
    }
    solve_small(m, a, b);
    memcpy(q->u, b, sizeof b);
    for (int i = 0; i < q->rows; i++) {
        double sum = 0.0;
        for (int j = 0; j < m; j++) sum += q->w[6 * i + j] * b[j];
        q->x[i] -= sum / (q->c[i] + eta + rho);
    }
}

/* y, z and the correction. Returns the primal residual, and the dual one in *dual. */
static double step_y(cone_problem *q, double rho, double *dual)
{
    double primal = 0.0;
    *dual = 0.0;
    for (int i = 0, row = 0; i < q->grasp->finger_count; i++) {
        const pinch_finger *f = &q->grasp->fingers[i];
        int rows = rows_of(f);
        double r[3] = {0};
        for (int k = 0; k < rows; k++) r[k] = q->x[row + k] - q->z[row + k] / rho;
        project(f, r);
        for (int k = 0; k < rows; k++) {
            primal = fmax(primal, fabs(q->x[row + k] - r[k]));
            *dual = fmax(*dual, rho * fabs(r[k] - q->y[row + k]));
            q->y[row + k] = r[k];
            q->z[row + k] -= rho * (q->x[row + k] - r[k]);
        }
        double correction = rows == 3 && !f->force_controlled ? f->friction * hypot(q->z[row + 1], q->z[row + 2]) : 0.0;
        *dual = fmax(*dual, fabs(correction - q->s[row]));
        q->s[row] = correction;
        row += rows;
    }
    return primal;
}

pinch_solver_result paper_admm(const pinch_grasp *grasp, double tolerance, int max_iterations,
                               pinch_finger_result *fingers)
{
    pinch_solver_result result = {.status = PINCH_SOLVE_DIVERGED};
    cone_problem q;
    if (!cone_problem_create(grasp, &q)) return result;
    double least = INFINITY, largest = 0.0, rho, step, dual;
    for (int i = 0; i < q.rows; i++) {
        least = fmin(least, q.c[i]);
        largest = fmax(largest, q.c[i]);
    }
    rho = sqrt(least * largest);
    step = fmax(pow(largest / least, 0.05), 1.2);
    result.status = PINCH_SOLVE_MAX_ITERATIONS;
    while (result.iterations < max_iterations) {
        step_x(&q, 1e-6 * least, rho);
        double primal = step_y(&q, rho, &dual);
        result.iterations++;
        result.residual = fmax(primal, dual);
        if (result.residual <= tolerance) {
            result.status = PINCH_SOLVE_CONVERGED;
            break;
        }
        if (!isfinite(result.residual)) {
            result.status = PINCH_SOLVE_DIVERGED;
            break;
        }
        /* residuals in units of their own: forces, and displacements as forces of the mean stiffness */
        double ratio = primal * sqrt(least * largest) / dual;
        if (ratio > 10.0) rho *= step;
        if (ratio < 0.1) rho /= step;
    }
    for (int i = 0, row = 0; i < grasp->finger_count; row += rows_of(&grasp->fingers[i]), i++) {
        memset(fingers[i].r, 0, sizeof fingers[i].r);
        memcpy(fingers[i].r, q.y + row, (size_t)rows_of(&grasp->fingers[i]) * sizeof(double));
    }
    free(q.w);
    return result;
}

/*
 * Modulus-based splitting: z = |v| + v and w = |v| - v turn the problem into (M + I) v = (I - M) |v| - q, which the
 * Gauss-Seidel splitting of M solves row by row:
 *
 *     (D + L + I) v_next = (I - D - L) |v| - U (v + |v|) - q          with M = D + L + U.
 */
pinch_solver_result paper_modulus(const pinch_lcp *lcp, double tolerance, int max_iterations, double *z, double *v)
{
    pinch_solver_result result = {.status = PINCH_SOLVE_MAX_ITERATIONS};
    int n = lcp->size;
    memset(v, 0, (size_t)n * sizeof *v);
    for (; result.iterations <= max_iterations; result.iterations++) {
        double sum2 = 0.0;
        for (int i = 0; i < n; i++) z[i] = fabs(v[i]) + v[i];
        for (int i = 0; i < n; i++) {
            double w = lcp->q[i];
            for (int j = 0; j < n; j++) w += lcp->m[(size_t)i * (size_t)n + (size_t)j] * z[j];
            double f = hypot(z[i], w) - z[i] - w;
            sum2 += f * f;
        }
        result.residual = sqrt(sum2);
        if (result.residual <= tolerance) {
            result.status = PINCH_SOLVE_CONVERGED;
            return result;
        }
        if (!isfinite(result.residual)) {
            result.status = PINCH_SOLVE_DIVERGED;
            return result;
        }
        /* z still has the old |v| + v of the rows that are not updated yet */
        for (int i = 0; i < n; i++) {
            const double *m = lcp->m + (size_t)i * (size_t)n;
            double right = -lcp->q[i] + (1.0 - m[i]) * fabs(v[i]);
            for (int j = 0; j < n; j++)
                if (j != i) right -= m[j] * z[j];
            v[i] = right / (1.0 + m[i]);
            z[i] = fabs(v[i]) + v[i];
        }
    }
    result.iterations = max_iterations;
    return result;
}
