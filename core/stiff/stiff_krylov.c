/*
 * The stabilized bi-conjugate gradients (van der Vorst, "Bi-CGSTAB: a fast and smoothly converging variant of Bi-CG for
 * the solution of nonsymmetric linear systems", 1992): friction makes the matrix unsymmetric. It is applied contact by
 * contact, and so need not be kept beside its factors.
 */
#include "stiff/stiff_krylov.h"

#include "stiff/stiff_rows.h"

#include <math.h>
#include <string.h>

/* y = (I + h sum G^T D G) x */
static void apply(const pinch_stiff_system *s, const double *x, double *y)
{
    memcpy(y, x, sizeof(double) * (size_t)s->mobility->unknowns);
    for (int k = 0; k < s->element_count; k++) {
        const pinch_stiff_element *e = &s->elements[k];
        double moved[PINCH_STIFF_ROWS] = {0}, impulse[PINCH_STIFF_ROWS];
        const double *slope = pinch_stiff_values(e, PINCH_STIFF_SLOPE);
        int rows = e->rows;
        if (!e->gives) continue;
        for (int b = 0; b < 2; b++)
            pinch_stiff_rows_times(rows, e->block[b].size, e->block[b].g, x + e->block[b].first, moved);
        for (int i = 0; i < rows; i++) {
            double sum = 0;
            for (int j = 0; j < rows; j++) sum += slope[i * rows + j] * moved[j];
            impulse[i] = s->step * sum;
        }
        for (int b = 0; b < 2; b++)
            pinch_stiff_rows_transposed_times(rows, e->block[b].size, e->block[b].g, impulse, y + e->block[b].first);
    }
}

static double dot(int n, const double *a, const double *b)
{
    double even = 0, odd = 0;
    for (int i = 0; i + 1 < n; i += 2) {
        even += a[i] * b[i];
        odd += a[i + 1] * b[i + 1];
    }
    return even + odd + (n % 2 ? a[n - 1] * b[n - 1] : 0);
}

/* preconditioned = A'^-1 direction, image = A preconditioned */
static void precondition(const pinch_stiff_system *s, const double *direction, double *preconditioned, double *image)
{
    memcpy(preconditioned, direction, sizeof(double) * (size_t)s->mobility->unknowns);
    pinch_block_lu_solve(&s->lu, preconditioned);
    apply(s, preconditioned, image);
}

bool pinch_stiff_krylov(pinch_stiff_system *s, double exactness, int limit)
{
    int n = s->mobility->unknowns;
    double *x = s->krylov, *r = x + n, *p = r + n, *v = p + n, *t = v + n, *z = t + n;
    const double *shadow = s->rhs;
    memset(x, 0, sizeof(double) * (size_t)n);
    memcpy(r, s->rhs, sizeof(double) * (size_t)n);
    memcpy(p, r, sizeof(double) * (size_t)n);
    double rho = dot(n, r, r), enough = exactness * exactness * rho;
    s->krylov_steps = 0;
    if (rho == 0) return true;
    for (int iteration = 0; iteration < limit; iteration++) {
        s->krylov_steps = iteration + 1;
        precondition(s, p, z, v);
        double alpha = rho / dot(n, shadow, v);
        if (!isfinite(alpha)) return false;
        for (int i = 0; i < n; i++) {
            r[i] -= alpha * v[i];
            x[i] += alpha * z[i];
        }
        bool done = dot(n, r, r) <= enough;
        if (!done) {
            precondition(s, r, z, t);
            double omega = dot(n, t, r) / dot(n, t, t);
            for (int i = 0; i < n; i++) {
                r[i] -= omega * t[i];
                x[i] += omega * z[i];
            }
            done = dot(n, r, r) <= enough;
            double next = dot(n, shadow, r), beta = next / rho * (alpha / omega);
            if (!done && !isfinite(beta)) return false;
            rho = next;
            for (int i = 0; i < n && !done; i++) p[i] = r[i] + beta * (p[i] - omega * v[i]);
        }
        if (done) {
            memcpy(s->rhs, x, sizeof(double) * (size_t)n);
            return true;
        }
    }
    return false;
}
