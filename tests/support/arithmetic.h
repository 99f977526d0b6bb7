#ifndef PINCH_TEST_ARITHMETIC_H
#define PINCH_TEST_ARITHMETIC_H

#include <math.h>

/* Vectors of three, and the order of numbers. The tests have their own, so that a reference shares nothing with what it
 * judges. */

static inline double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double length(const double *a)
{
    return sqrt(dot(a, a));
}

/* c = a x b; c is neither of them */
static inline void cross(const double *a, const double *b, double *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* for qsort: the smallest number first */
static inline int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

#endif
