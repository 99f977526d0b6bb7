#ifndef PINCH_SUPPORT_LU_H
#define PINCH_SUPPORT_LU_H

#include <stdbool.h>

/*
 * Small dense linear systems by LU with partial pivoting; matrices are row-major n x n. No allocation.
 *
 * pinch_lu_factor overwrites `a` with its factors and fills pivot[n]; scratch: n doubles. Returns false when the matrix
 * is not finite or singular to working precision: a pivot no larger than rounding of the largest entry its column began
 * with. `a` is then unspecified.
 */
bool pinch_lu_factor(int n, double *a, int *pivot, double *scratch);

/* x = A^-1 b with the factors of pinch_lu_factor; b and x may be the same array. */
void pinch_lu_solve(int n, const double *lu, const int *pivot, const double *b, double *x);

/* The same in place, with the sums in two strands (dense.h). */
void pinch_lu_solve_strands(int n, const double *lu, const int *pivot, double *x);

#endif
