/* Products and inverses of dense blocks, row major; for the blocks of free bodies the loops are unrolled. */
#ifndef PINCH_SUPPORT_BLOCKS_H
#define PINCH_SUPPORT_BLOCKS_H

#include <stdbool.h>

/* c (m x n) -= a (m x k) b (k x n) */
void pinch_block_subtract_product(int m, int k, int n, const double *restrict a, const double *restrict b,
                                  double *restrict c);

/* b (m x n) = a (m x m) b; scratch: m x n */
void pinch_block_multiply(int m, int n, const double *restrict a, double *restrict b, double *restrict scratch);

/* a (m x m) = a^-1 with rows pivoted, pivot[m]. Returns false when a pivot is zero to rounding or not finite. */
bool pinch_block_invert(int m, double *a, int *pivot);

/* x -= a y, a rows x columns */
void pinch_block_subtract_applied(int rows, int columns, const double *a, const double *y, double *x);

#endif
