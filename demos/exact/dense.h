#ifndef PINCH_EXACT_DENSE_H
#define PINCH_EXACT_DENSE_H

#include <stdbool.h>

/* Solves the n x n system a x = b (row major) in place: b becomes x, a is used up. Gauss with row and scale pivoting in
 * long double; false where the matrix is singular. */
bool exact_dense_solve(int n, long double *a, long double *b);

#endif
