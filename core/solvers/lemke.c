#include "solvers/methods.h"

#include <math.h>
#include <string.h>

/*
 * The tableau of  w - M z - 1 z0 = q  in scaled variables: columns w (0..n-1), z (n..2n-1), z0 (2n), right-hand side
 * (2n+1). basis[i] is the column that is basic in row i.
 */
typedef struct tableau {
    int n, columns;
    double *t;
    int *basis;
} tableau;

/* A pivot or a difference of ratios below this, relative to the numbers it came from, is taken for rounding. */
static const double NEGLIGIBLE = 1e-10;

static double *row_of(const tableau *tab, int i)
{
    return tab->t + (size_t)i * (size_t)tab->columns;
}

size_t pinch_lemke_scratch(int size)
{
    return (size_t)size * (2 * (size_t)size + 2);
}

static double largest_entry(const pinch_lcp *lcp, int i)
{
    const double *row = lcp->m + (size_t)i * (size_t)lcp->size;
    double largest = 0.0;
    for (int j = 0; j < lcp->size; j++) largest = fmax(largest, fabs(row[j]));
    return largest;
}

void pinch_lemke_scale(const pinch_lcp *lcp, double *scale)
{
    const double rounding = 1e-14;
    int n = lcp->size;
    double whole = 0.0;
    for (int i = 0; i < n; i++) whole = fmax(whole, largest_entry(lcp, i));
    for (int i = 0; i < n; i++) {
        /* what cancelled to rounding is a zero, as in the saddle point's zero block */
        double d = lcp->m[(size_t)i * (size_t)n + (size_t)i];
        scale[i] = d > NEGLIGIBLE * largest_entry(lcp, i) ? 1.0 / sqrt(d) : 0.0;
    }
    /* a row whose scale comes from the others must not itself count in the rows after it: noted as negative until then
     */
    for (int i = 0; i < n; i++) {
        if (scale[i] != 0.0) continue;
        double largest = 0.0;
        for (int j = 0; j < n; j++)
            largest = fmax(largest, fabs(lcp->m[(size_t)i * (size_t)n + (size_t)j]) * fmax(scale[j], 0.0));
        /* a row of nothing but rounding has no scale of its own */
        scale[i] = largest > 0.0 && largest_entry(lcp, i) > rounding * whole ? -1.0 / largest : -1.0;
    }
    for (int i = 0; i < n; i++) scale[i] = fabs(scale[i]);
}

static void fill(tableau *tab, const pinch_lcp *lcp, const double *scale)
{
    int n = tab->n;
    double q_max = 0.0;
    for (int i = 0; i < n; i++) q_max = fmax(q_max, fabs(lcp->q[i] * scale[i]));
    memset(tab->t, 0, (size_t)n * (size_t)tab->columns * sizeof *tab->t);
    for (int i = 0; i < n; i++) {
        double *t = row_of(tab, i);
        t[i] = 1.0;
        for (int j = 0; j < n; j++) t[n + j] = -scale[i] * lcp->m[(size_t)i * (size_t)n + (size_t)j] * scale[j];
        t[2 * n] = -1.0;
        t[2 * n + 1] = q_max > 0.0 ? scale[i] * lcp->q[i] / q_max : 0.0;
        tab->basis[i] = i;
    }
}

/* Is row i's (right-hand side, B^-1) divided by |entry| lexicographically before row k's? */
static bool comes_before(const tableau *tab, int i, double entry_i, int k, double entry_k)
{
    const double *a = row_of(tab, i), *b = row_of(tab, k);
    for (int c = -1; c < tab->n; c++) {
        int column = c < 0 ? tab->columns - 1 : c;
        double x = a[column] / entry_i, y = b[column] / entry_k;
        if (fabs(x - y) > NEGLIGIBLE * fmax(1.0, fmax(fabs(x), fabs(y)))) return x < y;
    }
    return false;
}

/* The row where the entering column blocks first; -1 when nothing does. z0 leaves as soon as it can. */
static int blocking_row(const tableau *tab, int entering)
{
    double largest = 0.0;
    for (int i = 0; i < tab->n; i++) largest = fmax(largest, fabs(row_of(tab, i)[entering]));
    int best = -1, z0_row = -1;
    for (int i = 0; i < tab->n; i++) {
        double entry = row_of(tab, i)[entering];
        /* a column of nothing but rounding is a ray, so the scaled problem's own size counts, too */
        if (!(entry > NEGLIGIBLE * fmax(largest, 1.0))) continue;
        if (tab->basis[i] == 2 * tab->n) z0_row = i;
        if (best < 0 || comes_before(tab, i, entry, best, row_of(tab, best)[entering])) best = i;
    }
    if (z0_row >= 0 && best != z0_row) {
        int rhs = tab->columns - 1;
        double x = row_of(tab, z0_row)[rhs] / row_of(tab, z0_row)[entering];
        double y = row_of(tab, best)[rhs] / row_of(tab, best)[entering];
        if (x <= y + NEGLIGIBLE * fmax(1.0, fabs(y))) best = z0_row;
    }
    return best;
}

/* Brings `entering` into the basis in row r; returns the column that left. */
static int pivot(tableau *tab, int r, int entering)
{
    double *t = row_of(tab, r);
    double inverse = 1.0 / t[entering];
    for (int j = 0; j < tab->columns; j++) t[j] *= inverse;
    t[entering] = 1.0;
    for (int i = 0; i < tab->n; i++) {
        double *ti = row_of(tab, i), factor = ti[entering];
        if (i == r || factor == 0.0) continue;
        for (int j = 0; j < tab->columns; j++) ti[j] -= factor * t[j];
        ti[entering] = 0.0;
    }
    int leaving = tab->basis[r];
    tab->basis[r] = entering;
    return leaving;
}

/* z0 enters at the most violated row; -1 when q >= 0 and z = 0 is the solution. */
static int first_row(const tableau *tab)
{
    int best = 0;
    for (int i = 1; i < tab->n; i++)
        if (comes_before(tab, i, 1.0, best, 1.0)) best = i;
    return row_of(tab, best)[tab->columns - 1] >= 0.0 ? -1 : best;
}

static void read_solution(const tableau *tab, const pinch_lcp *lcp, const double *scale, double *z)
{
    double q_max = 0.0;
    for (int i = 0; i < tab->n; i++) q_max = fmax(q_max, fabs(lcp->q[i] * scale[i]));
    for (int i = 0; i < tab->n; i++) {
        int k = tab->basis[i] - tab->n;
        if (k >= 0 && k < tab->n) z[k] = fmax(0.0, row_of(tab, i)[tab->columns - 1]) * q_max * scale[k];
    }
}

/* Along the ray the entering variable grows and the basic ones change by minus its column. */
static void read_ray(const tableau *tab, const double *scale, int entering, double *z)
{
    for (int i = 0; i < tab->n; i++) {
        int k = tab->basis[i] - tab->n;
        if (k >= 0 && k < tab->n) z[k] = fmax(0.0, -row_of(tab, i)[entering]) * scale[k];
    }
    if (entering >= tab->n && entering < 2 * tab->n) z[entering - tab->n] = scale[entering - tab->n];
}

pinch_solve_status pinch_lemke(const pinch_lcp *lcp, const double *scale, int max_pivots, double *scratch, int *basis,
                               double *z, int *pivots)
{
    int n = lcp->size;
    tableau tab = {.n = n, .columns = 2 * n + 2, .t = scratch, .basis = basis};
    fill(&tab, lcp, scale);
    for (int i = 0; i < n; i++) z[i] = 0.0;
    *pivots = 0;

    int row = first_row(&tab), entering = 2 * n;
    if (row < 0) return PINCH_SOLVE_CONVERGED;
    for (;;) {
        if (*pivots == max_pivots) return PINCH_SOLVE_MAX_ITERATIONS;
        int left = pivot(&tab, row, entering);
        ++*pivots;
        if (left == 2 * n) {
            read_solution(&tab, lcp, scale, z);
            return PINCH_SOLVE_CONVERGED;
        }
        entering = left < n ? left + n : left - n; /* the complement */
        row = blocking_row(&tab, entering);
        if (row < 0) {
            read_ray(&tab, scale, entering, z);
            return PINCH_SOLVE_RAY;
        }
    }
}
