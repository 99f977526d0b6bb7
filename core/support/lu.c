#include "support/lu.h"

#include "support/dense.h"

#include <float.h>
#include <math.h>
#include <string.h>

static int largest_in_column(int n, const double *a, int k)
{
    int p = k;
    const double *at = a + k * n + k;
    double largest = fabs(*at);
    for (int i = k + 1; i < n; i++) {
        double value = fabs(*(at += n));
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

/* Below this size, columns are eliminated one by one. */
enum { PANEL = 4, SMALLEST_BY_PANELS = 10 };

/* Brings the pivot of column k to its row. Returns false where it is too small, or no number. */
static bool bring_pivot(int n, double *a, int k, const double *column_size, int *pivot)
{
    int p = largest_in_column(n, a, k);
    double value = a[p * n + k];
    pivot[k] = p;
    if (p != k) swap_rows(n, a, p, k);
    /* written so that a NaN fails, too */
    return fabs(value) > DBL_EPSILON * column_size[k] && isfinite(value);
}

/* Eliminates column k from the rows below, in the next `columns` columns. */
static inline void eliminate(int n, double *restrict a, int k, int columns)
{
    const double *ak = a + k * n + k;
    const double inverse = 1.0 / *ak;
    for (int i = k + 1; i < n; i++) {
        double *ai = a + i * n + k;
        if (*ai == 0.0) continue;
        const double f = *ai *= inverse;
        if (columns >= PANEL)
            pinch_add_multiple(columns, -f, ak + 1, ai + 1);
        else
            for (int j = 1; j <= columns; j++) ai[j] -= f * ak[j];
    }
}

/* The same for the columns of a panel that follow column k; `columns` is told to the compiler, which unrolls the loop.
 */
static void eliminate_in_panel(int n, double *a, int k, int columns)
{
    switch (columns) {
    case 3:
        eliminate(n, a, k, 3);
        break;
    case 2:
        eliminate(n, a, k, 2);
        break;
    case 1:
        eliminate(n, a, k, 1);
        break;
    default:
        eliminate(n, a, k, 0);
    }
}

/* Subtracts from row i, behind the panel that begins with column k, what the rows of the panel above it have there. */
static inline void subtract_panel(int n, double *a, int k, int i)
{
    const int behind = k + PANEL;
    const double *above = a + k * n + behind;
    double *ai = a + i * n;
    const double f[PANEL] = {-ai[k], -ai[k + 1], -ai[k + 2], -ai[k + 3]};
    if (i >= behind && f[0] != 0 && f[1] != 0 && f[2] != 0 && f[3] != 0) {
        const double *const rows[PANEL] = {above, above + n, above + 2 * n, above + 3 * n};
        pinch_add_four_multiples(n - behind, f, rows, ai + behind);
        return;
    }
    for (int l = 0; l < PANEL && k + l < i; l++)
        if (f[l] != 0) pinch_add_multiple(n - behind, f[l], above + l * n, ai + behind);
}

bool pinch_lu_factor(int n, double *a, int *pivot, double *scratch)
{
    /* judging a pivot against its own column makes the verdict independent of the unknowns' units */
    double *restrict column_size = scratch;
    memset(column_size, 0, (size_t)n * sizeof *column_size);
    for (int i = 0; i < n; i++) {
        const double *restrict row = a + i * n;
        for (int j = 0; j < n; j++) {
            double size = fabs(row[j]);
            column_size[j] = size > column_size[j] ? size : column_size[j];
        }
    }
    /* Columns behind a panel wait until all of it is eliminated, as in LAPACK's dgetrf. They lose the same multiples in
     * the same order, so that no bit depends on panels, but are read and written once for four of them. */
    int k = 0;
    for (; n >= SMALLEST_BY_PANELS && k + PANEL < n; k += PANEL) {
        for (int l = k; l < k + PANEL; l++) {
            if (!bring_pivot(n, a, l, column_size, pivot)) return false;
            eliminate_in_panel(n, a, l, k + PANEL - 1 - l);
        }
        for (int i = k + 1; i < n; i++) subtract_panel(n, a, k, i);
    }
    for (; k < n; k++) {
        if (!bring_pivot(n, a, k, column_size, pivot)) return false;
        eliminate(n, a, k, n - 1 - k);
    }
    return true;
}

static inline void solve_by_factors(int n, const double *lu, const int *pivot, const double *b, double *x)
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

/* A ball joint has three unknowns, one free body six, and one pressed by a drive seven: with the size known the compiler
 * unrolls all. */
void pinch_lu_solve(int n, const double *lu, const int *pivot, const double *b, double *x)
{
    if (n == 3)
        solve_by_factors(3, lu, pivot, b, x);
    else if (n == 6)
        solve_by_factors(6, lu, pivot, b, x);
    else if (n == 7)
        solve_by_factors(7, lu, pivot, b, x);
    else
        solve_by_factors(n, lu, pivot, b, x);
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
