#include "solvers/fischer_burmeister.h"

#include "support/lu.h"

#include <math.h>
#include <string.h>

/* Partial sums in a fixed order that the compiler may put into vector registers. */
static double dot(const double *restrict a, const double *restrict b, int n)
{
    enum { LANES = 4 };
    double sum[LANES] = {0.0};
    int j = 0;
    for (; j + LANES <= n; j += LANES)
        for (int l = 0; l < LANES; l++) sum[l] += a[j + l] * b[j + l];
    for (; j < n; j++) sum[0] += a[j] * b[j];
    return (sum[0] + sum[2]) + (sum[1] + sum[3]);
}

static const double *row_of(const pinch_lcp *lcp, int i)
{
    return lcp->m + (size_t)i * (size_t)lcp->size;
}

static bool is_free(const pinch_lcp *lcp, int i)
{
    return lcp->free && lcp->free[i];
}

/*
 * phi(z, w) = sqrt(z^2 + w^2) - z - w. Where z + w > 0 the difference of nearly equal numbers loses the digits of the
 * small one of the two; phi = -2 z w / (sqrt(z^2 + w^2) + z + w) keeps them.
 */
static double phi_at(double z, double w, double rho)
{
    double sum = z + w;
    if (isinf(rho)) rho = hypot(z, w); /* the squares leave double precision at 1e154 */
    return sum > 0.0 ? -2.0 * z * w / (rho + sum) : rho - sum;
}

static double phi(double z, double w)
{
    return phi_at(z, w, sqrt(z * z + w * w));
}

void pinch_lcp_residual(const pinch_lcp *lcp, const double *z, double *w)
{
    for (int i = 0; i < lcp->size; i++) w[i] = dot(row_of(lcp, i), z, lcp->size) + lcp->q[i];
}

double pinch_fischer_burmeister_norm(const pinch_lcp *lcp, const double *z, const double *w)
{
    double sum = 0.0;
    for (int i = 0; i < lcp->size; i++) {
        double f = is_free(lcp, i) ? w[i] : phi(z[i], w[i]);
        sum += f * f;
    }
    return sqrt(sum);
}

/* Takes x as the point, with w and rho there. */
static void move_to(pinch_fischer_burmeister *fb, const double *x)
{
    memcpy(fb->point, x, (size_t)fb->lcp.size * sizeof *x);
    pinch_lcp_residual(&fb->lcp, x, fb->w);
    for (int i = 0; i < fb->lcp.size; i++) fb->rho[i] = sqrt(x[i] * x[i] + fb->w[i] * fb->w[i]);
}

static void residual(void *self, const double *x, double *f)
{
    pinch_fischer_burmeister *fb = self;
    move_to(fb, x);
    for (int i = 0; i < fb->lcp.size; i++) f[i] = is_free(&fb->lcp, i) ? fb->w[i] : phi_at(x[i], fb->w[i], fb->rho[i]);
}

static double residual_row(void *self, const double *x, int i)
{
    const pinch_fischer_burmeister *fb = self;
    double w = dot(row_of(&fb->lcp, i), x, fb->lcp.size) + fb->lcp.q[i];
    return is_free(&fb->lcp, i) ? w : phi(x[i], w);
}

/*
 * Row i of V = (z_i/rho - 1) e_i + (w_i/rho - 1) M_i with rho = sqrt(z_i^2 + w_i^2); at rho = 0 the element with
 * z_i/rho = w_i/rho = 1/sqrt(2). Free rows are M_i itself. Only the two factors are frozen here: n numbers, not n^2.
 */
static void linearize(void *self, const double *x)
{
    pinch_fischer_burmeister *fb = self;
    int n = fb->lcp.size;
    /* the methods linearize where they have just evaluated */
    if (memcmp(fb->point, x, (size_t)n * sizeof *x) != 0) move_to(fb, x);
    for (int i = 0; i < n; i++) {
        bool corner = fb->rho[i] == 0.0;
        double inverse = corner ? 0.0 : 1.0 / fb->rho[i];
        fb->alpha[i] = (corner ? sqrt(0.5) : x[i] * inverse) - 1.0;
        fb->beta[i] = (corner ? sqrt(0.5) : fb->w[i] * inverse) - 1.0;
        if (is_free(&fb->lcp, i)) {
            fb->alpha[i] = 0.0;
            fb->beta[i] = 1.0;
        }
    }
}

static void form_row(const pinch_fischer_burmeister *fb, int i, double *v)
{
    const double *m = row_of(&fb->lcp, i);
    for (int j = 0; j < fb->lcp.size; j++) v[j] = fb->beta[i] * m[j];
    v[i] += fb->alpha[i];
}

static pinch_row row(void *self, int i)
{
    pinch_fischer_burmeister *fb = self;
    double *v = fb->v + (size_t)i * (size_t)fb->lcp.size;
    form_row(fb, i, v);
    fb->segments[i] = (pinch_row_segment){0, fb->lcp.size, v};
    return (pinch_row){1, &fb->segments[i]};
}

static double row_norm2(void *self, int i)
{
    const pinch_fischer_burmeister *fb = self;
    double a = fb->alpha[i], b = fb->beta[i];
    return b * b * fb->m_row_norm2[i] + a * (a + 2.0 * b * fb->m_ii[i]);
}

static void row_norms2(void *self, double *norm2)
{
    const pinch_fischer_burmeister *fb = self;
    for (int i = 0; i < fb->lcp.size; i++) norm2[i] = row_norm2(self, i);
}

static void add_row(void *self, int i, double step, double *x)
{
    const pinch_fischer_burmeister *fb = self;
    const double *restrict m = row_of(&fb->lcp, i);
    double *restrict out = x;
    double factor = step * fb->beta[i];
    for (int j = 0; j < fb->lcp.size; j++) out[j] += factor * m[j];
    out[i] += step * fb->alpha[i];
}

static bool solve(void *self, const double *rhs, double *dx)
{
    pinch_fischer_burmeister *fb = self;
    int n = fb->lcp.size;
    for (int i = 0; i < n; i++) form_row(fb, i, fb->lu + (size_t)i * (size_t)n);
    if (!pinch_lu_factor(n, fb->lu, fb->pivot, fb->scratch)) return false;
    pinch_lu_solve(n, fb->lu, fb->pivot, rhs, dx);
    return true;
}

size_t pinch_fischer_burmeister_scratch(int size)
{
    return 2 * (size_t)size * (size_t)size + 8 * (size_t)size;
}

pinch_system pinch_fischer_burmeister_init(pinch_fischer_burmeister *fb, const pinch_lcp *lcp, double *scratch,
                                           int *pivot, pinch_row_segment *segments)
{
    size_t n = (size_t)lcp->size;
    *fb = (pinch_fischer_burmeister){.lcp = *lcp, .pivot = pivot, .segments = segments};
    double **vectors[] = {&fb->point, &fb->w,           &fb->rho,  &fb->alpha,
                          &fb->beta,  &fb->m_row_norm2, &fb->m_ii, &fb->scratch};
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; i++, scratch += n) *vectors[i] = scratch;
    fb->v = scratch;
    fb->lu = scratch + n * n;
    for (int i = 0; i < lcp->size; i++) {
        fb->m_row_norm2[i] = dot(row_of(lcp, i), row_of(lcp, i), lcp->size);
        fb->m_ii[i] = row_of(lcp, i)[i];
        fb->point[i] = NAN; /* nothing evaluated yet */
    }
    pinch_system system = {
        .size = lcp->size,
        .self = fb,
        .residual = residual,
        .residual_row = residual_row,
        .linearize = linearize,
        .row = row,
        .solve = solve,
        .row_norm2 = row_norm2,
        .row_norms2 = row_norms2,
        .add_row = add_row,
    };
    return system;
}
