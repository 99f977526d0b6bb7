#include "support/blocks.h"

#include "support/lanes.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { BODY = 6, BALL = 3 }; /* unknowns of a free body, rows of a ball joint */

static bool of_bodies(int m, int k, int n)
{
    return m == BODY && k == BODY && n == BODY;
}

/*
 * Some rows of c -= a b, or c = a b, for numbers of rows and columns that the compiler knows. They stay in registers,
 * and two rows share what is read of b.
 */
static inline __attribute__((always_inline)) void product_rows(bool subtract, int rows, int k, int n,
                                                               const double *restrict a, const double *restrict b,
                                                               double *restrict c)
{
    pinch_lanes row[2][BODY / 2];
    double last[2];
    const int pairs = n / 2;
#pragma GCC unroll 2
    for (int i = 0; i < rows; i++) {
#pragma GCC unroll 3
        for (int j = 0; j < pairs; j++)
            row[i][j] = subtract ? *(const pinch_lanes *)(c + n * i + 2 * j) : (pinch_lanes){0, 0};
        last[i] = subtract ? c[n * i + n - 1] : 0;
    }
    for (int l = 0; l < k; l++, b += n) {
        if (k > BODY && a[l] == 0 && (rows == 1 || a[k + l] == 0)) continue; /* few of many freedoms move one body */
#pragma GCC unroll 2
        for (int i = 0; i < rows; i++) {
            double f = a[k * i + l];
            pinch_lanes both = {f, f};
#pragma GCC unroll 3
            for (int j = 0; j < pairs; j++)
                row[i][j] = subtract ? row[i][j] - both * *(const pinch_lanes *)(b + 2 * j)
                                     : row[i][j] + both * *(const pinch_lanes *)(b + 2 * j);
            if (n % 2) last[i] = subtract ? last[i] - f * b[n - 1] : last[i] + f * b[n - 1];
        }
    }
#pragma GCC unroll 2
    for (int i = 0; i < rows; i++) {
#pragma GCC unroll 3
        for (int j = 0; j < pairs; j++) *(pinch_lanes *)(c + n * i + 2 * j) = row[i][j];
        if (n % 2) c[n * i + n - 1] = last[i];
    }
}

/* The same for any number of rows. */
static inline __attribute__((always_inline)) void product_of_width(bool subtract, int m, int k, int n, const double *a,
                                                                   const double *b, double *c)
{
    for (; m >= 2; m -= 2, a += 2 * k, c += 2 * n) product_rows(subtract, 2, k, n, a, b, c);
    if (m > 0) product_rows(subtract, 1, k, n, a, b, c);
}

/* The same for the widths that joints and bodies have. Returns false for others. */
static inline __attribute__((always_inline)) bool narrow_product(bool subtract, int m, int k, int n, const double *a,
                                                                 const double *b, double *c)
{
    switch (n) {
    case 1:
        product_of_width(subtract, m, k, 1, a, b, c);
        return true;
    case 2:
        product_of_width(subtract, m, k, 2, a, b, c);
        return true;
    case 3:
        product_of_width(subtract, m, k, 3, a, b, c);
        return true;
    case 4:
        product_of_width(subtract, m, k, 4, a, b, c);
        return true;
    case 5:
        product_of_width(subtract, m, k, 5, a, b, c);
        return true;
    case BODY:
        product_of_width(subtract, m, k, BODY, a, b, c);
        return true;
    default:
        return false;
    }
}

void pinch_block_subtract_product(int m, int k, int n, const double *restrict a, const double *restrict b,
                                  double *restrict c)
{
    if (of_bodies(m, k, n) &&
        pinch_wide_subtract_products(pinch_widest(), 1, &(const double *){a}, &(const double *){b}, c))
        return;
    if (narrow_product(true, m, k, n, a, b, c)) return;
    for (int i = 0; i < m; i++)
        for (int l = 0; l < k; l++) {
            double f = a[i * k + l];
            if (f == 0) continue;
            for (int j = 0; j < n; j++) c[i * n + j] -= f * b[l * n + j];
        }
}

void pinch_block_subtract_products(int count, int m, int k, int n, const double *const a[], const double *const b[],
                                   double *restrict c)
{
    if (of_bodies(m, k, n) && pinch_wide_subtract_products(pinch_widest(), count, a, b, c)) return;
    for (int p = 0; p < count; p++) pinch_block_subtract_product(m, k, n, a[p], b[p], c);
}

void pinch_block_transpose(int m, int n, const double *restrict a, double *restrict b)
{
    if (m != BODY || n != BODY) {
        for (int i = 0; i < m; i++)
            for (int j = 0; j < n; j++) b[j * m + i] = a[i * n + j];
        return;
    }
#pragma GCC unroll 3
    for (int i = 0; i < BODY; i += 2)
#pragma GCC unroll 3
        for (int j = 0; j < BODY; j += 2) {
            pinch_lanes above = pinch_lanes_at(a + BODY * i + j), below = pinch_lanes_at(a + BODY * i + BODY + j);
            pinch_lanes_put((pinch_lanes){above[0], below[0]}, b + BODY * j + i);
            pinch_lanes_put((pinch_lanes){above[1], below[1]}, b + BODY * j + BODY + i);
        }
}

void pinch_block_multiply(int m, int n, const double *restrict a, double *restrict b, double *restrict scratch)
{
    memcpy(scratch, b, sizeof(double) * (size_t)(m * n));
    if (of_bodies(m, m, n) && pinch_wide_product(pinch_widest(), a, scratch, b)) return;
    if (narrow_product(false, m, m, n, a, scratch, b)) return;
    memset(b, 0, sizeof(double) * (size_t)(m * n));
    for (int i = 0; i < m; i++)
        for (int l = 0; l < m; l++) {
            double f = a[i * m + l];
            for (int j = 0; j < n; j++) b[i * n + j] += f * scratch[l * n + j];
        }
}

void pinch_block_solve(int m, int n, const double *lu, const int *pivot, double *b)
{
    for (int k = 0; k < m; k++)
        for (int j = 0; j < n && pivot[k] != k; j++) {
            double t = b[n * k + j];
            b[n * k + j] = b[n * pivot[k] + j];
            b[n * pivot[k] + j] = t;
        }
    for (int i = 1; i < m; i++) pinch_block_subtract_product(1, i, n, lu + m * i, b, b + n * i);
    for (int i = m - 1; i >= 0; i--) {
        pinch_block_subtract_product(1, m - 1 - i, n, lu + m * i + i + 1, b + n * (i + 1), b + n * i);
        for (int j = 0; j < n; j++) b[n * i + j] /= lu[m * i + i];
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

/* The same for a body's block and a k that the compiler knows: rows are read and written in pairs alone, because a pair
 * is read late where one of its numbers was just written. */
static inline __attribute__((always_inline)) void eliminate_of_body(double *a, const int k)
{
    double inverse = 1 / a[BODY * k + k];
    pinch_lanes *at = (pinch_lanes *)(a + BODY * k), row[BODY / 2], both = {inverse, inverse};
#pragma GCC unroll 3
    for (int j = 0; j < BODY / 2; j++) row[j] = at[j] * both;
    row[k / 2][k % 2] = inverse;
#pragma GCC unroll 3
    for (int j = 0; j < BODY / 2; j++) at[j] = row[j];
    for (int i = 0; i < BODY; i++) {
        if (i == k) continue;
        pinch_lanes other[BODY / 2];
        at = (pinch_lanes *)(a + BODY * i);
#pragma GCC unroll 3
        for (int j = 0; j < BODY / 2; j++) other[j] = at[j];
        both = (pinch_lanes){other[k / 2][k % 2], other[k / 2][k % 2]};
        other[k / 2][k % 2] = 0;
#pragma GCC unroll 3
        for (int j = 0; j < BODY / 2; j++) at[j] = other[j] - both * row[j];
    }
}

static void eliminate_column_of_body(double *a, int k)
{
    switch (k) {
    case 0:
        eliminate_of_body(a, 0);
        return;
    case 1:
        eliminate_of_body(a, 1);
        return;
    case 2:
        eliminate_of_body(a, 2);
        return;
    case 3:
        eliminate_of_body(a, 3);
        return;
    case 4:
        eliminate_of_body(a, 4);
        return;
    default:
        eliminate_of_body(a, 5);
        return;
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
            eliminate_column_of_body(a, k);
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

/* x -= a y, `columns` being told to the compiler where it is a usual number */
static inline __attribute__((always_inline)) void subtract_dots(int rows, int columns, const double *a, const double *y,
                                                                double *restrict x)
{
    for (int i = 0; i < rows; i++, a += columns) {
        double sum = 0;
        for (int j = 0; j < columns; j++) sum += a[j] * y[j];
        x[i] -= sum;
    }
}

void pinch_block_subtract_applied(int rows, int columns, const double *a, const double *y, double *x)
{
    if (rows == BODY && columns == BODY) {
        const pinch_lanes y0 = pinch_lanes_at(y), y1 = pinch_lanes_at(y + 2), y2 = pinch_lanes_at(y + 4);
#pragma GCC unroll 3
        for (int i = 0; i < BODY; i += 2, a += 2 * BODY) { /* two rows, each summed in two strands, even and odd */
            const double *b = a + BODY;
            pinch_lanes p = pinch_lanes_at(a) * y0 + pinch_lanes_at(a + 2) * y1 + pinch_lanes_at(a + 4) * y2;
            pinch_lanes q = pinch_lanes_at(b) * y0 + pinch_lanes_at(b + 2) * y1 + pinch_lanes_at(b + 4) * y2;
            const pinch_lanes even = {p[0], q[0]}, odd = {p[1], q[1]};
            pinch_lanes_put(pinch_lanes_at(x + i) - (even + odd), x + i);
        }
        return;
    }
    if (columns == BODY)
        subtract_dots(rows, BODY, a, y, x);
    else if (columns == BALL)
        subtract_dots(rows, BALL, a, y, x);
    else
        subtract_dots(rows, columns, a, y, x);
}

/* to (6 x 6) += left^T weighted, both 3 x 6 */
static inline __attribute__((always_inline)) void add_rows(const double *restrict left,
                                                           pinch_lanes weighted[3][BODY / 2], double *restrict to)
{
    for (int l = 0; l < BODY; l++, to += BODY) {
        double g0 = left[l], g1 = left[BODY + l], g2 = left[2 * BODY + l];
#pragma GCC unroll 3
        for (int j = 0; j < BODY / 2; j++)
            *(pinch_lanes *)(to + 2 * j) += g0 * weighted[0][j] + g1 * weighted[1][j] + g2 * weighted[2][j];
    }
}

void pinch_block_add_contact(const double *const left[2], const double d[9], const double *right, double *const to[2])
{
    pinch_lanes weighted[3][BODY / 2];
#pragma GCC unroll 3
    for (int j = 0; j < BODY / 2; j++) {
        pinch_lanes g0 = *(const pinch_lanes *)(right + 2 * j), g1 = *(const pinch_lanes *)(right + BODY + 2 * j),
                    g2 = *(const pinch_lanes *)(right + 2 * BODY + 2 * j);
        weighted[0][j] = d[0] * g0;
        weighted[1][j] = d[3] * g0 + d[4] * g1 + d[5] * g2;
        weighted[2][j] = d[6] * g0 + d[7] * g1 + d[8] * g2;
    }
    for (int a = 0; a < 2; a++)
        if (to[a]) add_rows(left[a], weighted, to[a]);
}
