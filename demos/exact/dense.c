#include "dense.h"

#include <math.h>

static void swap_rows(int n, long double *a, long double *b, int i, int k)
{
    for (int j = 0; j < n; j++) {
        long double t = a[i * n + j];
        a[i * n + j] = a[k * n + j];
        a[k * n + j] = t;
    }
    long double t = b[i];
    b[i] = b[k];
    b[k] = t;
}

/* Rows of forces and of velocities have different units: each is measured by its largest entry. */
static bool scale_rows(int n, long double *a, long double *b)
{
    for (int i = 0; i < n; i++) {
        long double largest = 0;
        for (int j = 0; j < n; j++) largest = fmaxl(largest, fabsl(a[i * n + j]));
        if (!(largest > 0) || !isfinite(largest)) return false;
        for (int j = 0; j < n; j++) a[i * n + j] /= largest;
        b[i] /= largest;
    }
    return true;
}

bool exact_dense_solve(int n, long double *a, long double *b)
{
    if (!scale_rows(n, a, b)) return false;
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k + 1; i < n; i++)
            if (fabsl(a[i * n + k]) > fabsl(a[pivot * n + k])) pivot = i;
        if (!(fabsl(a[pivot * n + k]) > 0)) return false;
        if (pivot != k) swap_rows(n, a, b, k, pivot);
        for (int i = k + 1; i < n; i++) {
            long double factor = a[i * n + k] / a[k * n + k];
            if (factor == 0) continue;
            for (int j = k + 1; j < n; j++) a[i * n + j] -= factor * a[k * n + j];
            b[i] -= factor * b[k];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int j = k + 1; j < n; j++) b[k] -= a[k * n + j] * b[j];
        b[k] /= a[k * n + k];
    }
    return true;
}
