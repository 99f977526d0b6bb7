/*
 * Dense vectors, inline. The order in which a sum is taken decides its last bits: each function says it, and code that
 * wants another order keeps its own.
 */
#ifndef PINCH_SUPPORT_DENSE_H
#define PINCH_SUPPORT_DENSE_H

#include "support/lanes.h"

#include <math.h>

/* a . b is summed from the first entry to the last. */
static inline double pinch_dot(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += a[i] * b[i];
    return sum;
}

/* a . b is summed in two strands, even entries and odd ones, so that additions wait half as long for each other. */
static inline double pinch_dot_strands(const double *a, const double *b, int n)
{
    pinch_lanes sum = {0, 0};
    for (int i = 0; i + 1 < n; i += 2) sum += *(const pinch_lanes *)(a + i) * *(const pinch_lanes *)(b + i);
    return sum[0] + sum[1] + (n % 2 ? a[n - 1] * b[n - 1] : 0);
}

/* The six components of one body are summed in the same two strands. */
static inline double pinch_dot6(const double *a, const double *b)
{
    pinch_lanes sum = pinch_lanes_at(a) * pinch_lanes_at(b) + pinch_lanes_at(a + 2) * pinch_lanes_at(b + 2) +
                      pinch_lanes_at(a + 4) * pinch_lanes_at(b + 4);
    return sum[0] + sum[1];
}

/* y += f x, for the six components of one body */
static inline void pinch_add_multiple6(double f, const double *x, double *y)
{
    const pinch_lanes both = {f, f};
    for (int i = 0; i < 6; i += 2) pinch_lanes_put(pinch_lanes_at(y + i) + both * pinch_lanes_at(x + i), y + i);
}

/* y += f x, n >= 0 */
static inline void pinch_add_multiple(int n, double f, const double *restrict x, double *restrict y)
{
    const pinch_lanes both = {f, f};
    int i = 0;
    for (; i + 3 < n; i += 4) {
        *(pinch_lanes *)(y + i) += both * *(const pinch_lanes *)(x + i);
        *(pinch_lanes *)(y + i + 2) += both * *(const pinch_lanes *)(x + i + 2);
    }
    if (n & 2) *(pinch_lanes *)(y + i) += both * *(const pinch_lanes *)(x + i);
    if (n & 1) y[n - 1] += f * x[n - 1];
}

/* y += f[0] x[0] + ... + f[3] x[3], added one after the other to each number, as by four calls for one vector each. It
 * reads and writes y but once. */
static inline void pinch_add_four_multiples(int n, const double f[4], const double *const x[4], double *restrict y)
{
    const double *restrict a = x[0], *restrict b = x[1], *restrict c = x[2], *restrict d = x[3];
    const pinch_lanes fa = {f[0], f[0]}, fb = {f[1], f[1]}, fc = {f[2], f[2]}, fd = {f[3], f[3]};
    int i = 0;
    for (; i + 1 < n; i += 2) {
        pinch_lanes sum = *(const pinch_lanes *)(y + i);
        sum += fa * *(const pinch_lanes *)(a + i);
        sum += fb * *(const pinch_lanes *)(b + i);
        sum += fc * *(const pinch_lanes *)(c + i);
        sum += fd * *(const pinch_lanes *)(d + i);
        *(pinch_lanes *)(y + i) = sum;
    }
    if (i < n) y[i] = (((y[i] + f[0] * a[i]) + f[1] * b[i]) + f[2] * c[i]) + f[3] * d[i];
}

/* Writes the products of four vectors with x. Each is summed in two strands, even entries and odd ones; none waits for
 * another, and x is read but once. */
static inline void pinch_four_dots(int n, const double *const a[4], const double *x, double dots[4])
{
    pinch_lanes s0 = {0, 0}, s1 = {0, 0}, s2 = {0, 0}, s3 = {0, 0};
    int i = 0;
    for (; i + 1 < n; i += 2) {
        const pinch_lanes both = *(const pinch_lanes *)(x + i);
        s0 += *(const pinch_lanes *)(a[0] + i) * both;
        s1 += *(const pinch_lanes *)(a[1] + i) * both;
        s2 += *(const pinch_lanes *)(a[2] + i) * both;
        s3 += *(const pinch_lanes *)(a[3] + i) * both;
    }
    dots[0] = s0[0] + s0[1];
    dots[1] = s1[0] + s1[1];
    dots[2] = s2[0] + s2[1];
    dots[3] = s3[0] + s3[1];
    if (i < n)
        for (int k = 0; k < 4; k++) dots[k] += a[k][i] * x[i];
}

/* ||x||_2 is summed from the first entry to the last. */
static inline double pinch_norm(const double *x, int n)
{
    return sqrt(pinch_dot(x, x, n));
}

#endif
