#include "support/block_lu.h"
#include "support/blocks.h"

#include <string.h>

enum { N = 6 }; /* unknowns of a free body */
enum { BLOCK = PINCH_SINGLE_BLOCK, LONGEST_RUN = PINCH_BLOCK_LU_RUN };

/* U_kj of an entry of `later`; before the k-th is eliminated A_kj, as everywhere in block_lu.h */
static inline float *upper_at(const pinch_block_lu *lu, int entry)
{
    return lu->singles + lu->lower[entry] + lu->to_upper;
}

/* A_jk^T of an entry of `later` */
static inline float *lower_at(const pinch_block_lu *lu, int entry)
{
    return lu->singles + lu->lower[entry];
}

/* A_ij -= A_ik U_kj, and (A_ji)^T -= U_ki^T A_jk^T. In both, all j share the left factor, and the right ones follow
 * each other in memory. */
void pinch_block_lu_single_update_row(const pinch_block_lu *lu, int k, int count, int later)
{
    enum { AT_A_TIME = 64 };
    const float *lower[LONGEST_RUN], *upper[LONGEST_RUN], *right[LONGEST_RUN];
    float *to[AT_A_TIME];
    int entry = lu->later_start[k + count] - later, i = lu->later[entry], inside = lu->later_start[i];
    for (int p = 0; p < count; p++) {
        int e = lu->later_start[k + p + 1] - later;
        lower[p] = lower_at(lu, e);
        upper[p] = upper_at(lu, e);
    }
    to[0] = lu->singles + lu->diagonal[i];
    for (int b = 0, blocks; b < later; b += blocks) {
        int first = b == 0; /* of what lies beside the diagonal */
        blocks = later - b < AT_A_TIME ? later - b : AT_A_TIME;
        for (int t = first; t < blocks; t++) { /* both lists ascend */
            while (lu->later[inside] < lu->later[entry + b + t]) inside++;
            to[t] = upper_at(lu, inside);
        }
        for (int p = 0; p < count; p++) right[p] = upper[p] + BLOCK * b;
        pinch_single_subtract_products(lu->width, count, lower, right, blocks, to);
        if (lu->symmetric) continue;
        for (int t = first; t < blocks; t++) to[t] -= lu->to_upper;
        for (int p = 0; p < count; p++) right[p] = lower[p] + BLOCK * (b + first);
        pinch_single_subtract_products(lu->width, count, upper, right, blocks - first, to + first);
    }
}

bool pinch_block_lu_single_factor_own(const pinch_block_lu *lu, int k)
{
    float *diagonal = lu->singles + lu->diagonal[k];
    if (!pinch_single_invert(diagonal)) return false;
    for (int e = lu->later_start[k]; e < lu->later_start[k + 1]; e++) {
        float *upper = upper_at(lu, e);
        if (lu->symmetric) memcpy(lower_at(lu, e), upper, sizeof *upper * BLOCK);
        pinch_single_multiply(lu->width, diagonal, upper);
    }
    return true;
}

void pinch_block_lu_single_solve_own(const pinch_block_lu *lu, int k, double *x)
{
    double negative[N], *part = x + lu->first[lu->order[k]];
    for (int i = 0; i < N; i++) {
        negative[i] = -part[i];
        part[i] = 0;
    }
    pinch_single_subtract_applied(lu->width, 1, lu->singles + lu->diagonal[k], &(const double *){negative}, part);
}

void pinch_block_lu_single_subtract_earlier(const pinch_block_lu *lu, int k, int a, double *x)
{
    pinch_single_subtract_transposed(lu->width, lower_at(lu, a), x + lu->first[lu->order[k]],
                                     x + lu->first[lu->order[lu->later[a]]]);
}

void pinch_block_lu_single_subtract_later(const pinch_block_lu *lu, int k, double *x)
{
    enum { AT_A_TIME = 64 };
    const double *y[AT_A_TIME];
    for (int e = lu->later_start[k], end = lu->later_start[k + 1], count; e < end; e += count) {
        count = end - e < AT_A_TIME ? end - e : AT_A_TIME;
        for (int j = 0; j < count; j++) y[j] = x + lu->first[lu->order[lu->later[e + j]]];
        pinch_single_subtract_applied(lu->width, count, upper_at(lu, e), y, x + lu->first[lu->order[k]]);
    }
}
