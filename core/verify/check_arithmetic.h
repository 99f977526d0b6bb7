/* The few operations on vectors that the checks need; what solves has its own. */
#ifndef PINCH_VERIFY_CHECK_ARITHMETIC_H
#define PINCH_VERIFY_CHECK_ARITHMETIC_H

#include <math.h>

static inline double pinch_check_larger(double a, double b)
{
    return a > b || isnan(a) ? a : b;
}

static inline double pinch_check_square3(const double *a)
{
    return a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
}

static inline double pinch_check_norm3(const double *a)
{
    return sqrt(pinch_check_square3(a));
}

/* Finds x with the symmetric positive definite a x = b, by Cramer's rule. */
static inline void pinch_check_solve3(const double *a, const double *b, double *x)
{
    double minor[3] = {a[4] * a[8] - a[5] * a[7], a[5] * a[6] - a[3] * a[8], a[3] * a[7] - a[4] * a[6]};
    double determinant = a[0] * minor[0] + a[1] * minor[1] + a[2] * minor[2];
    x[0] = (b[0] * minor[0] + b[1] * (a[2] * a[7] - a[1] * a[8]) + b[2] * (a[1] * a[5] - a[2] * a[4])) / determinant;
    x[1] = (b[0] * minor[1] + b[1] * (a[0] * a[8] - a[2] * a[6]) + b[2] * (a[2] * a[3] - a[0] * a[5])) / determinant;
    x[2] = (b[0] * minor[2] + b[1] * (a[1] * a[6] - a[0] * a[7]) + b[2] * (a[0] * a[4] - a[1] * a[3])) / determinant;
}

#endif
