/*
 * Dense vectors, inline. The order in which a sum is taken decides its last bits: each function says it, and code that
 * wants another order keeps its own.
 */
#ifndef PINCH_SUPPORT_DENSE_H
#define PINCH_SUPPORT_DENSE_H

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
    double even = 0, odd = 0;
    for (int i = 0; i + 1 < n; i += 2) {
        even += a[i] * b[i];
        odd += a[i + 1] * b[i + 1];
    }
    return even + odd + (n % 2 ? a[n - 1] * b[n - 1] : 0);
}

/* The six components of one body are summed in the same two strands. */
static inline double pinch_dot6(const double *a, const double *b)
{
    double even = a[0] * b[0] + a[2] * b[2] + a[4] * b[4], odd = a[1] * b[1] + a[3] * b[3] + a[5] * b[5];
    return even + odd;
}

/* ||x||_2 is summed from the first entry to the last. */
static inline double pinch_norm(const double *x, int n)
{
    return sqrt(pinch_dot(x, x, n));
}

#endif
