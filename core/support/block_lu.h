/*
 * Sparse linear systems of dense blocks, structurally symmetric: what a Newton step on bodies in contact solves. The
 * blocks are eliminated in order of least degree; within a diagonal block rows are pivoted, blocks are not.
 *
 *     plan    which blocks exist and fill in, once per structure
 *     clear, at, factor, solve    per matrix
 */
#ifndef PINCH_SUPPORT_BLOCK_LU_H
#define PINCH_SUPPORT_BLOCK_LU_H

#include "support/arena.h"

typedef struct pinch_block_lu {
    int count;        /* block rows */
    const int *size;  /* per block row: unknowns, > 0 */
    int *first;       /* per block row: its first unknown; count + 1 */
    int *order;       /* block row eliminated k-th */
    int *place;       /* its inverse */
    int *later_start; /* per k: the blocks eliminated after the k-th that it is coupled with then, by their places, */
    int *later;       /* ascending */
    size_t *diagonal; /* per k: where its diagonal block stands in values, row major as all */
    size_t *lower;    /* parallel to `later`: block (later, k) */
    size_t *upper;    /* block (k, later) */
    double *values;
    size_t value_count;
    int *pivot;      /* per unknown, block by block in the order of elimination */
    int *pivot_of;   /* per k: its first in `pivot` */
    double *scratch; /* per unknown of the largest block */
} pinch_block_lu;

/*
 * size[count] must stay; edge[2 edge_count]: pairs of different block rows that are coupled, in any order, repeated or
 * not. False when memory ran out.
 */
bool pinch_block_lu_plan(pinch_arena *arena, int count, const int *size, int edge_count, const int *edge,
                         pinch_block_lu *lu);

void pinch_block_lu_clear(pinch_block_lu *lu);

/* Block (row, column), size[row] x size[column], to be added to; the two must be equal or coupled. */
double *pinch_block_lu_at(const pinch_block_lu *lu, int row, int column);

/* In place; false when a pivot is zero to rounding or not finite. */
bool pinch_block_lu_factor(pinch_block_lu *lu);

/* x = A^-1 x, unknowns in the order of the block rows. */
void pinch_block_lu_solve(const pinch_block_lu *lu, double *x);

#endif
