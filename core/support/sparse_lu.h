/*
 * LU factors of a matrix most of whose entries are zero, in place of the matrix. Rows and columns are eliminated in the
 * order that they come in: whoever orders them knows where little fills in, as in the joints of a tree from the leaves
 * on. There are no exchanges, so that it serves matrices whose pivots are known to be good in this order, and it says
 * where one is not.
 */
#ifndef PINCH_SUPPORT_SPARSE_LU_H
#define PINCH_SUPPORT_SPARSE_LU_H

#include "support/arena.h"

#include <stdbool.h>
#include <stdint.h>

/* Where the entries of a row of U lie that may not be zero. */
typedef struct pinch_sparse_stretch {
    int first, size; /* size 0: they are few in it, or none */
} pinch_sparse_stretch;

/* Scratch for factors; it may be used again and again. */
typedef struct pinch_sparse_lu {
    int room;        /* rows */
    uint64_t *upper; /* per row a bit per column right of its diagonal: entries of U that may not be zero */
    uint64_t *row;   /* the bits of the row at hand */
    double *inverse; /* of the pivots */
    pinch_sparse_stretch *stretch; /* per row */
} pinch_sparse_lu;

/* Makes room for matrices of up to n rows. Returns false when memory ran out. */
bool pinch_sparse_lu_allocate(pinch_arena *arena, int n, pinch_sparse_lu *lu);

/*
 * Factors a (n x n, row major) as pinch_lu_factor does without exchanges, so that pinch_lu_solve takes the factors.
 * Returns false, with a destroyed, where a pivot is zero, not finite, or so small beside its column that rounding would
 * grow too much.
 */
bool pinch_sparse_lu_factor(const pinch_sparse_lu *lu, int n, double *a);

#endif
