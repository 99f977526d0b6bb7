#include "support/blocks.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { BODY = 6 }; /* unknowns of a free body */

/* c -= a b for a width that the compiler knows, so that a row of c stays in registers. */
static inline __attribute__((always_inline)) void subtract_narrow(int m, int k, int n, const double *restrict a,
                                                                  const double *restrict b, double *restrict c)
{
    for (int i = 0; i < m; i++) {
        double row[BODY];
        for (int j = 0; j < n; j++) row[j] = c[n * i + j];
        for (int l = 0; l < k; l++) {
            double f = a[k * i + l];
            for (int j = 0; j < n; j++) row[j] -= f * b[n * l + j];
        }
        for (int j = 0; j < n; j++) c[n * i + j] = row[j];
    }
}

/* The same for a depth that is mostly a body's. */
static inline __attribute__((always_inline)) void subtract_of_body(int m, int k, int n, const double *restrict a,
                                                                   const double *restrict b, double *restrict c)
{
    if (k == BODY)
        subtract_narrow(m, BODY, n, a, b, c);
    else
        subtract_narrow(m, k, n, a, b, c);
}

void pinch_block_subtract_product(int m, int k, int n, const double *restrict a, const double *restrict b,
                                  double *restrict c)
{
    switch (n) {
    case 1:
        subtract_of_body(m, k, 1, a, b, c);
        return;
    case 2:
        subtract_of_body(m, k, 2, a, b, c);
        return;
    case 3:
        subtract_of_body(m, k, 3, a, b, c);
        return;
    case 4:
        subtract_of_body(m, k, 4, a, b, c);
        return;
    case 5:
        subtract_of_body(m, k, 5, a, b, c);
        return;
    case BODY:
        subtract_of_body(m, k, BODY, a, b, c);
        return;
    default:
        break;
    }
    for (int i = 0; i < m; i++)
        for (int l = 0; l < k; l++) {
            double f = a[i * k + l];
            if (f == 0) continue;
            for (int j = 0; j < n; j++) c[i * n + j] -= f * b[l * n + j];
        }
}

void pinch_block_multiply(int m, int n, const double *restrict a, double *restrict b, double *restrict scratch)
{
    memcpy(scratch, b, sizeof(double) * (size_t)(m * n));
    if (m == BODY && n == BODY) {
        for (int i = 0; i < BODY; i++) {
            double row[BODY] = {0};
            for (int l = 0; l < BODY; l++) {
                double f = a[BODY * i + l];
                for (int j = 0; j < BODY; j++) row[j] += f * scratch[BODY * l + j];
            }
            for (int j = 0; j < BODY; j++) b[BODY * i + j] = row[j];
        }
        return;
    }
    memset(b, 0, sizeof(double) * (size_t)(m * n));
    for (int i = 0; i < m; i++)
        for (int l = 0; l < m; l++) {
            double f = a[i * m + l];
            for (int j = 0; j < n; j++) b[i * n + j] += f * scratch[l * n + j];
        }
}

/* Does the k-th step of Gauss and Jordan on the rows of a, whose pivot row stands at place k. */
static inline void eliminate_column(int m, double *a, int k)
{
    double *restrict row = a + k * m, inverse = 1 / row[k];
    row[k] = 1;
    for (int j = 0; j < m; j++) row[j] *= inverse;
    for (int i = 0; i < m; i++) {
        if (i == k) continue;
        double *restrict other = a + i * m, f = other[k];
        other[k] = 0;
        for (int j = 0; j < m; j++) other[j] -= f * row[j];
    }
}

bool pinch_block_invert(int m, double *a, int *pivot)
{
    double size = 0;
    for (int i = 0; i < m * m; i++) size = fabs(a[i]) > size ? fabs(a[i]) : size;
    for (int k = 0; k < m; k++) {
        int best = k;
        for (int i = k + 1; i < m; i++)
            if (fabs(a[i * m + k]) > fabs(a[best * m + k])) best = i;
        pivot[k] = best;
        /* written so that a NaN fails, too */
        if (!(fabs(a[best * m + k]) > DBL_EPSILON * DBL_EPSILON * size) || !isfinite(a[best * m + k])) return false;
        for (int j = 0; j < m && best != k; j++) {
            double t = a[k * m + j];
            a[k * m + j] = a[best * m + j];
            a[best * m + j] = t;
        }
        if (m == BODY)
            eliminate_column(BODY, a, k);
        else
            eliminate_column(m, a, k);
    }
    for (int k = m - 1; k >= 0; k--)
        for (int i = 0; i < m && pivot[k] != k; i++) {
            double t = a[i * m + k];
            a[i * m + k] = a[i * m + pivot[k]];
            a[i * m + pivot[k]] = t;
        }
    return true;
}

void pinch_block_subtract_applied(int rows, int columns, const double *a, const double *y, double *x)
{
    if (rows == BODY && columns == BODY) {
        for (int i = 0; i < BODY; i++, a += BODY)
            x[i] -= (a[0] * y[0] + a[2] * y[2] + a[4] * y[4]) + (a[1] * y[1] + a[3] * y[3] + a[5] * y[5]);
        return;
    }
    for (int i = 0; i < rows; i++) {
        double sum = 0;
        for (int j = 0; j < columns; j++) sum += a[i * columns + j] * y[j];
        x[i] -= sum;
    }
}
