/*
 * Solves by the method of stabilized bi-conjugate gradients (van der Vorst, "Bi-CGSTAB: a fast and smoothly converging
 * variant of Bi-CG for the solution of nonsymmetric linear systems", 1992): friction makes the matrix unsymmetric.
 */
#include "force/force_system.h"

#include "support/block_dilu.h"
#include "support/dense.h"

#include <math.h>
#include <string.h>

enum { LIMIT = 80 };

bool pinch_force_bicgstab(pinch_force_system *s, double exactness)
{
    int n = s->mobility->unknowns;
    double *x = s->krylov, *r = x + n, *p = r + n, *v = p + n, *t = v + n, *y = t + n;
    const double *shadow = s->rhs;
    pinch_block_dilu_lower(&s->lu, s->rhs);
    memset(x, 0, sizeof(double) * (size_t)n);
    memcpy(r, s->rhs, sizeof(double) * (size_t)n);
    memcpy(p, r, sizeof(double) * (size_t)n);
    double rho = pinch_dot_strands(r, r, n), enough = exactness * exactness * rho;
    bool done = rho == 0;
    /* a product with a vector streams what a product with a block keeps in the cache */
    double blocks = s->lu.count + 2.0 * s->lu.later_start[s->lu.count];
    for (int iteration = 0; iteration < LIMIT && !done; iteration++) {
        s->work += 2.0 / 3 * blocks;
        pinch_block_dilu_times(&s->lu, p, v, y);
        double alpha = rho / pinch_dot_strands(shadow, v, n);
        if (!isfinite(alpha)) return false;
        for (int i = 0; i < n; i++) {
            r[i] -= alpha * v[i];
            x[i] += alpha * p[i];
        }
        done = pinch_dot_strands(r, r, n) <= enough;
        if (done) break;
        pinch_block_dilu_times(&s->lu, r, t, y);
        double omega = pinch_dot_strands(t, r, n) / pinch_dot_strands(t, t, n);
        for (int i = 0; i < n; i++) {
            x[i] += omega * r[i];
            r[i] -= omega * t[i];
        }
        done = pinch_dot_strands(r, r, n) <= enough;
        double next = pinch_dot_strands(shadow, r, n), beta = next / rho * (alpha / omega);
        if (!done && !isfinite(beta)) return false;
        rho = next;
        for (int i = 0; i < n && !done; i++) p[i] = r[i] + beta * (p[i] - omega * v[i]);
    }
    if (!done) return false;
    memcpy(s->rhs, x, sizeof(double) * (size_t)n);
    pinch_block_dilu_upper(&s->lu, s->rhs);
    return true;
}
