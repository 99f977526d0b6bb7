#include "system.h"

#include <math.h>
#include <string.h>

void exact_law_of(const pinch_contact *c, double step, exact_law *law)
{
    long double h = step;
    memset(law, 0, sizeof *law);
    law->rows = (int)c->model;
    law->start[0] = (long double)c->stiffness[0] * c->depth;
    law->rate[0] = h * c->stiffness[0] + c->damping[0];
    for (int i = 1; i < law->rows; i++) {
        int kind = i < 3 ? 1 : 2;
        law->start[i] = -(long double)c->stiffness[kind] * c->elastic[i - 1];
        law->rate[i] = h * c->stiffness[kind] + c->damping[kind];
        law->friction[i - 1] = i < 3 ? c->friction[i - 1] : c->torsional_friction;
    }
    law->most = c->max_force;
}

/*
 * The closest point of the ellipsoid sum (r_i / mu_i)^2 = limit^2 to the trial force s in the compliance metric,
 * sum (r_i - s_i)^2 / g_i:
 *
 *     r_i = q_i s_i,  q_i = 1 / (1 + k g_i / mu_i^2),  with k >= 0 from  reach(k) = |(q_i s_i / mu_i)| = limit.
 *
 * 1/reach is concave and nearly straight in k: Newton's method on it comes from k = 0 without overshooting
 * (as in trust-region methods; Conn, Gould and Toint 2000, section 7.3).
 */
static long double multiplier(int n, const long double *a, const long double *s, long double limit, long double *q)
{
    long double k = 0;
    for (int iteration = 0; iteration < 100; iteration++) {
        long double reach2 = 0, falls = 0;
        for (int i = 0; i < n; i++) {
            q[i] = 1 / (1 + k * a[i]);
            long double part = q[i] * s[i];
            reach2 += part * part;
            falls += part * part * q[i] * a[i];
        }
        long double reach = sqrtl(reach2), step = (reach - limit) / limit * reach2 / falls;
        if (!(step > 0) || k + step == k) break;
        k += step;
    }
    return k;
}

/* Friction where its limit binds. dr = q ds + s dq, where dq follows from the change of the multiplier, which follows
 * from those of s and of the limit. */
static void sliding_force(const exact_law *law, const long double *s, long double limit, const long double *limit_slope,
                          long double *r, long double *slope)
{
    long double a[3] = {0}, unit[3] = {0}, q[3] = {0};
    int n = law->rows - 1;
    for (int i = 0; i < n; i++) { /* measured in units of the limit surface's axes */
        bool acts = law->friction[i] > 0 && isfinite(law->friction[i]);
        a[i] = acts ? law->rate[1 + i] / (law->friction[i] * law->friction[i]) : 0;
        unit[i] = acts ? s[i] / law->friction[i] : 0;
    }
    (void)multiplier(n, a, unit, limit, q);
    long double falls = 0, change[3];
    for (int i = 0; i < n; i++) falls += q[i] * q[i] * q[i] * unit[i] * unit[i] * a[i];
    for (int i = 0; i < n; i++) {
        if (law->friction[i] <= 0) q[i] = 0;
        r[1 + i] = q[i] * s[i];
        change[i] = law->friction[i] > 0 ? q[i] * q[i] * unit[i] / law->friction[i] : 0; /* 1/2 d reach^2 / d s_i */
    }
    for (int i = 0; i < n; i++) {
        long double *row = slope + 4 * (1 + i);
        long double dq = -q[i] * q[i] * a[i] * s[i] / falls; /* times what the multiplier has to make up for */
        for (int j = 0; j < n; j++) row[1 + j] = (dq * change[j] + (i == j ? q[i] : 0)) * -law->rate[1 + j];
        for (int j = 0; j < 4; j++) row[j] -= dq * limit * limit_slope[j];
    }
}

void exact_law_force(const exact_law *law, const long double w[4], long double limit, long double r[4],
                     long double slope[16])
{
    long double trial = law->start[0] - law->rate[0] * w[0], s[3], reach2 = 0, limit_slope[4] = {0};
    memset(r, 0, 4 * sizeof *r);
    memset(slope, 0, 16 * sizeof *slope);
    r[0] = trial > 0 ? trial : 0;
    if (trial > 0 && trial < law->most) slope[0] = -law->rate[0];
    if (r[0] > law->most) r[0] = law->most;
    if (limit < 0) {
        limit = r[0];
        limit_slope[0] = slope[0];
    }
    int n = law->rows - 1;
    bool inside = n > 0 && limit > 0;
    for (int i = 0; i < n; i++) {
        s[i] = law->start[1 + i] - law->rate[1 + i] * w[1 + i];
        if (law->friction[i] > 0) {
            long double part = isinf(law->friction[i]) ? 0 : s[i] / law->friction[i];
            reach2 += part * part;
        }
    }
    if (!inside) return;
    if (reach2 > limit * limit) {
        sliding_force(law, s, limit, limit_slope, r, slope);
        return;
    }
    for (int i = 0; i < n; i++) {
        if (!(law->friction[i] > 0)) continue;
        r[1 + i] = s[i];
        slope[4 * (1 + i) + 1 + i] = -law->rate[1 + i];
    }
}
