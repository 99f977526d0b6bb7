#include "support/lu.h"

#include "support/dense.h"

#include <float.h>
#include <math.h>
#include <string.h>

static int largest_in_column(int n, const double *a, int k)
{
    int p = k;
    double largest = fabs(a[k * n + k]);
    for (int i = k + 1; i < n; i++) {
        double value = fabs(a[i * n + k]);
        if (value > largest) {
            largest = value;
            p = i;
        }
    }
    return p;
}

static void swap_rows(int n, double *a, int i, int j)
{
    double *ai = a + i * n, *aj = a + j * n;
    for (int k = 0; k < n; k++) {
        double t = ai[k];
        ai[k] = aj[k];
        aj[k] = t;
    }
}

/* Two neighbours, which processors multiply and subtract together. Each number comes out as it would alone. */
typedef double pair __attribute__((vector_size(2 * sizeof(double)), aligned(sizeof(double)), may_alias));

/* a -= f b */
static inline void subtract_row(int n, double f, const double *restrict b, double *restrict a)
{
    const pair both = {f, f};
    int j = 0;
    for (; j + 3 < n; j += 4) {
        *(pair *)(a + j) -= both * *(const pair *)(b + j);
        *(pair *)(a + j + 2) -= both * *(const pair *)(b + j + 2);
    }
    for (; j < n; j++) a[j] -= f * b[j];
}

bool pinch_lu_factor(int n, double *a, int *pivot, double *scratch)
{
    /* judging a pivot against its own column makes the verdict independent of the unknowns' units */
    double *column_size = scratch;
    memset(column_size, 0, (size_t)n * sizeof *column_size);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double size = fabs(a[i * n + j]);
            if (size > column_size[j]) column_size[j] = size;
        }

    for (int k = 0; k < n; k++) {
        int p = largest_in_column(n, a, k);
        pivot[k] = p;
        if (p != k) swap_rows(n, a, p, k);
        double *ak = a + k * n;
        /* written so that a NaN fails, too */
        if (!(fabs(ak[k]) > DBL_EPSILON * column_size[k]) || !isfinite(ak[k])) return false;
        double inverse = 1.0 / ak[k];
        for (int i = k + 1; i < n; i++) {
            double *ai = a + i * n;
            if (ai[k] == 0.0) continue;
            ai[k] *= inverse;
            subtract_row(n - k - 1, ai[k], ak + k + 1, ai + k + 1);
        }
    }
    return true;
}

void pinch_lu_solve(int n, const double *lu, const int *pivot, const double *b, double *x)
{
    if (x != b) memcpy(x, b, (size_t)n * sizeof *x);
    /* whole rows were swapped, so all interchanges come before the forward substitution */
    for (int k = 0; k < n; k++) {
        double t = x[k];
        x[k] = x[pivot[k]];
        x[pivot[k]] = t;
    }
    for (int i = 1; i < n; i++) {
        double sum = x[i];
        for (int j = 0; j < i; j++) sum -= lu[i * n + j] * x[j];
        x[i] = sum;
    }
    for (int i = n - 1; i >= 0; i--) {
        double sum = x[i];
        for (int j = i + 1; j < n; j++) sum -= lu[i * n + j] * x[j];
        x[i] = sum / lu[i * n + i];
    }
}

void pinch_lu_solve_strands(int n, const double *lu, const int *pivot, double *x)
{
    for (int k = 0; k < n; k++) {
        double t = x[k];
        x[k] = x[pivot[k]];
        x[pivot[k]] = t;
    }
    for (int i = 1; i < n; i++) x[i] -= pinch_dot_strands(lu + (size_t)i * (size_t)n, x, i);
    for (int i = n - 1; i >= 0; i--) {
        const double *row = lu + (size_t)i * (size_t)n;
        x[i] = (x[i] - pinch_dot_strands(row + i + 1, x + i + 1, n - 1 - i)) / row[i];
    }
}
