#include "support/block_lu.h"

#include "support/block_order.h"
#include "support/lu.h"

#include <string.h>

enum { BODY = 6 }; /* a free body's block: its loops are unrolled */

static bool place_blocks(pinch_arena *arena, pinch_block_lu *lu, int entries)
{
    int n = lu->count, largest = 0;
    lu->first = PINCH_ARENA_ARRAY(arena, int, n + 1);
    lu->diagonal = PINCH_ARENA_ARRAY(arena, size_t, n + 1);
    lu->lower = PINCH_ARENA_ARRAY(arena, size_t, entries + 1);
    lu->upper = PINCH_ARENA_ARRAY(arena, size_t, entries + 1);
    lu->pivot_of = PINCH_ARENA_ARRAY(arena, int, n + 1);
    if (arena->failed) return false;
    lu->first[0] = 0;
    for (int b = 0; b < n; b++) {
        lu->first[b + 1] = lu->first[b] + lu->size[b];
        if (lu->size[b] > largest) largest = lu->size[b];
    }
    size_t at = 0;
    int pivots = 0;
    for (int k = 0; k < n; k++) {
        size_t mine = (size_t)lu->size[lu->order[k]];
        lu->diagonal[k] = at;
        at += mine * mine;
        lu->pivot_of[k] = pivots;
        pivots += (int)mine;
        for (int e = lu->later_start[k]; e < lu->later_start[k + 1]; e++) {
            size_t block = mine * (size_t)lu->size[lu->order[lu->later[e]]];
            lu->lower[e] = at;
            lu->upper[e] = at + block;
            at += 2 * block;
        }
    }
    lu->value_count = at;
    lu->values = PINCH_ARENA_ARRAY(arena, double, at + 1);
    lu->pivot = PINCH_ARENA_ARRAY(arena, int, pivots + 1);
    lu->scratch = PINCH_ARENA_ARRAY(arena, double, largest + 1);
    return !arena->failed;
}

bool pinch_block_lu_plan(pinch_arena *arena, int count, const int *size, int edge_count, const int *edge,
                         pinch_block_lu *lu)
{
    pinch_block_order order;
    if (!pinch_block_order_make(arena, count, edge_count, edge, &order)) return false;
    lu->count = count;
    lu->size = size;
    lu->order = order.order;
    lu->place = order.place;
    lu->later_start = order.start;
    lu->later = order.later;
    return place_blocks(arena, lu, order.entries);
}

void pinch_block_lu_clear(pinch_block_lu *lu)
{
    memset(lu->values, 0, sizeof(double) * lu->value_count);
}

/* Where `place` stands among the later blocks of the k-th; it is there. */
static int entry_of(const pinch_block_lu *lu, int k, int place)
{
    int low = lu->later_start[k], high = lu->later_start[k + 1] - 1;
    while (low < high) {
        int middle = (low + high) / 2;
        if (lu->later[middle] < place)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

double *pinch_block_lu_at(const pinch_block_lu *lu, int row, int column)
{
    int r = lu->place[row], c = lu->place[column];
    if (r == c) return lu->values + lu->diagonal[r];
    if (r < c) return lu->values + lu->upper[entry_of(lu, r, c)];
    return lu->values + lu->lower[entry_of(lu, c, r)];
}

/* c (m x n) -= a (m x k) b (k x n) */
static void subtract_product(int m, int k, int n, const double *a, const double *b, double *c)
{
    if (m == BODY && k == BODY && n == BODY) {
        for (int i = 0; i < BODY; i++) {
            double row[BODY];
            for (int j = 0; j < BODY; j++) row[j] = c[BODY * i + j];
            for (int l = 0; l < BODY; l++) {
                double f = a[BODY * i + l];
                for (int j = 0; j < BODY; j++) row[j] -= f * b[BODY * l + j];
            }
            for (int j = 0; j < BODY; j++) c[BODY * i + j] = row[j];
        }
        return;
    }
    for (int i = 0; i < m; i++)
        for (int l = 0; l < k; l++) {
            double f = a[i * k + l];
            if (f == 0) continue;
            for (int j = 0; j < n; j++) c[i * n + j] -= f * b[l * n + j];
        }
}

/* b (m x n) = A^-1 b with the factors of A, all columns at once */
static void solve_columns(int m, int n, const double *a, const int *pivot, double *b)
{
    for (int k = 0; k < m; k++) {
        if (pivot[k] == k) continue;
        double *x = b + k * n, *y = b + pivot[k] * n;
        for (int j = 0; j < n; j++) {
            double t = x[j];
            x[j] = y[j];
            y[j] = t;
        }
    }
    for (int i = 1; i < m; i++)
        for (int l = 0; l < i; l++) {
            double f = a[i * m + l];
            for (int j = 0; j < n; j++) b[i * n + j] -= f * b[l * n + j];
        }
    for (int i = m - 1; i >= 0; i--) {
        for (int l = i + 1; l < m; l++) {
            double f = a[i * m + l];
            for (int j = 0; j < n; j++) b[i * n + j] -= f * b[l * n + j];
        }
        double inverse = 1 / a[i * m + i];
        for (int j = 0; j < n; j++) b[i * n + j] *= inverse;
    }
}

/* Eliminating the k-th: U_kj = A_kk^-1 A_kj, A_ij -= A_ik U_kj. */
bool pinch_block_lu_factor(pinch_block_lu *lu)
{
    for (int k = 0; k < lu->count; k++) {
        int mine = lu->size[lu->order[k]];
        double *diagonal = lu->values + lu->diagonal[k];
        const int *pivot = lu->pivot + lu->pivot_of[k];
        if (!pinch_lu_factor(mine, diagonal, lu->pivot + lu->pivot_of[k], lu->scratch)) return false;
        for (int e = lu->later_start[k]; e < lu->later_start[k + 1]; e++)
            solve_columns(mine, lu->size[lu->order[lu->later[e]]], diagonal, pivot, lu->values + lu->upper[e]);
        for (int a = lu->later_start[k]; a < lu->later_start[k + 1]; a++) {
            int i = lu->later[a], rows = lu->size[lu->order[i]];
            const double *left = lu->values + lu->lower[a];
            int inside = lu->later_start[i]; /* both lists ascend: no search from the start */
            for (int b = lu->later_start[k]; b < lu->later_start[k + 1]; b++) {
                int j = lu->later[b], columns = lu->size[lu->order[j]];
                double *to;
                if (j == i) {
                    to = lu->values + lu->diagonal[i];
                } else if (j > i) {
                    while (lu->later[inside] != j) inside++;
                    to = lu->values + lu->upper[inside];
                } else {
                    to = lu->values + lu->lower[entry_of(lu, j, i)];
                }
                subtract_product(rows, mine, columns, left, lu->values + lu->upper[b], to);
            }
        }
    }
    return true;
}

/* x -= a y, a rows x columns */
static void subtract_applied(int rows, int columns, const double *a, const double *y, double *x)
{
    for (int i = 0; i < rows; i++) {
        double sum = 0;
        for (int j = 0; j < columns; j++) sum += a[i * columns + j] * y[j];
        x[i] -= sum;
    }
}

void pinch_block_lu_solve(const pinch_block_lu *lu, double *x)
{
    for (int k = 0; k < lu->count; k++) {
        int block = lu->order[k], mine = lu->size[block];
        double *part = x + lu->first[block];
        pinch_lu_solve(mine, lu->values + lu->diagonal[k], lu->pivot + lu->pivot_of[k], part, part);
        for (int e = lu->later_start[k]; e < lu->later_start[k + 1]; e++) {
            int other = lu->order[lu->later[e]];
            subtract_applied(lu->size[other], mine, lu->values + lu->lower[e], part, x + lu->first[other]);
        }
    }
    for (int k = lu->count - 1; k >= 0; k--) {
        int block = lu->order[k], mine = lu->size[block];
        for (int e = lu->later_start[k]; e < lu->later_start[k + 1]; e++) {
            int other = lu->order[lu->later[e]];
            subtract_applied(mine, lu->size[other], lu->values + lu->upper[e], x + lu->first[other],
                             x + lu->first[block]);
        }
    }
}
