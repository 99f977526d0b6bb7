/* Products and inverses of dense blocks, row major; narrow ones, as bodies and joints have, are kept in
 * registers. */
#ifndef PINCH_SUPPORT_BLOCKS_H
#define PINCH_SUPPORT_BLOCKS_H

#include <stdbool.h>

/* c (m x n) -= a (m x k) b (k x n) */
void pinch_block_subtract_product(int m, int k, int n, const double *restrict a, const double *restrict b,
                                  double *restrict c);

/* The same for `count` pairs of them, one after the other. */
void pinch_block_subtract_products(int count, int m, int k, int n, const double *const a[], const double *const b[],
                                   double *restrict c);

/* b (n x m) = a^T, a being m x n */
void pinch_block_transpose(int m, int n, const double *restrict a, double *restrict b);

/* b (m x n) = a (m x m) b; scratch: m x n */
void pinch_block_multiply(int m, int n, const double *restrict a, double *restrict b, double *restrict scratch);

/* b (m x n) becomes A^-1 b, with the factors and pivots of A that pinch_lu_factor has made. */
void pinch_block_solve(int m, int n, const double *lu, const int *pivot, double *b);

/* a (m x m) = a^-1 with rows pivoted, pivot[m]. Returns false when a pivot is zero to rounding or not finite. */
bool pinch_block_invert(int m, double *a, int *pivot);

/* Adds left[a]^T D right to to[a] (6 x 6; NULL: to nothing) for both a; left[a] and right are 3 x 6, and D (3 x 3) is 0
 * at 1 and 2: no force moves the normal but the normal velocity. */
void pinch_block_add_contact(const double *const left[2], const double d[9], const double *right, double *const to[2]);

/* x -= a y, a rows x columns */
void pinch_block_subtract_applied(int rows, int columns, const double *a, const double *y, double *x);

/*
 * blocks_wide.c: products of the blocks of bodies, 6 x 6, in registers of more than two numbers, on processors that
 * have such: most of what a large factorization does. Each number is the same sum in the same order as in pairs, and
 * comes out to the bit.
 */

/* Registers hold so many numbers. */
typedef enum pinch_width { PINCH_PAIRS = 2, PINCH_FOURS = 4, PINCH_EIGHTS = 8 } pinch_width;

/* Returns the widest that the processor has. */
static inline pinch_width pinch_widest(void)
{
#if defined(__x86_64__)
    return __builtin_cpu_supports("avx512f") ? PINCH_EIGHTS
           : __builtin_cpu_supports("avx2")  ? PINCH_FOURS
                                             : PINCH_PAIRS;
#else
    return PINCH_PAIRS;
#endif
}

/* These do nothing and return false where there is nothing for registers of that width. */

/* Does c -= sum of a[p] b[p], p < count. */
bool pinch_wide_subtract_products(pinch_width width, int count, const double *const a[], const double *const b[],
                                  double *c);

/* Does c = a b. */
bool pinch_wide_product(pinch_width width, const double *a, const double *b, double *c);

/*
 * blocks_single.c: blocks of bodies, 6 x 6, in single precision: half of the memory, and twice as many numbers in a
 * register. Rows are as long as such a register, with two zeros at their ends: where rows overlap in registers, what
 * has just been written is read late. `width` is at most pinch_widest(); no bit depends on it.
 */
enum { PINCH_SINGLE_ROW = 8, PINCH_SINGLE_BLOCK = 6 * PINCH_SINGLE_ROW };

/* For all b < blocks, does to[b] -= sum of left[p]^T right[p][b], p < count; right[p] has that many blocks. */
void pinch_single_subtract_products(pinch_width width, int count, const float *const left[], const float *const right[],
                                    int blocks, float *const to[]);

/* Does b = a b. */
void pinch_single_multiply(pinch_width width, const float *restrict a, float *restrict b);

/* Does a = a^-1, as pinch_block_invert. */
bool pinch_single_invert(float *a);

/* Does x -= sum of a[e] y[e], e < count, in double precision. */
void pinch_single_subtract_applied(pinch_width width, int count, const float *a, const double *const y[], double *x);

/* Does x -= a^T y, in double precision. */
void pinch_single_subtract_transposed(pinch_width width, const float *a, const double *y, double *x);

/* Does to += left^T D right, left and right being 3 x 6. */
void pinch_single_add_contact(pinch_width width, const double *left, const double d[9], const double *right, float *to);

#endif
