/*
 * Sparse linear systems of dense blocks, structurally symmetric: what a Newton step on bodies in contact solves. The
 * blocks are eliminated in order of least degree; within a diagonal block rows are pivoted, blocks are not. Where that
 * would take too much, the plan is left without the blocks that fill in: for an iteration (block_dilu.h).
 *
 * The factors of free bodies may be in single precision (block_lu_single.c): they take half of the memory and half of
 * the time. Solutions are then good for one step of a refinement, whose residuals are the caller's.
 *
 *     plan    which blocks exist and fill in, once per structure
 *     clear, at, factor, solve    per matrix; an incomplete one is not factored
 */
#ifndef PINCH_SUPPORT_BLOCK_LU_H
#define PINCH_SUPPORT_BLOCK_LU_H

#include "support/block_order.h"
#include "support/blocks.h"

#include <pinch/problem.h>
#include <stdatomic.h>

/* A block eliminated before another one that it is coupled with then: its place, and the other one in its `later`. */
typedef struct pinch_block_lu_earlier {
    int place, entry;
} pinch_block_lu_earlier;

/* So many blocks of a run are eliminated together at most. */
enum { PINCH_BLOCK_LU_RUN = 8 };

typedef struct pinch_block_lu {
    int count; /* block rows */
    int early; /* from this block row on, the diagonal blocks may be near to singular, as those of saddle points are.
                * They are solved with their factors: in an inverse, what belongs together in large entries would be
                * rounded apart. */
    bool incomplete;
    bool symmetric;   /* the caller's, before the matrix is cleared: of a complete matrix that is symmetric, the blocks
                       * below the diagonal ones are not read. This takes half of the products. */
    bool single;      /* it is in single precision: in `singles`, and `values` is NULL */
    double products;  /* what a factorization takes, in products of 6 x 6 blocks */
    const int *size;  /* per block row: unknowns, > 0 */
    int *first;       /* per block row: its first unknown; count + 1 */
    int *order;       /* block row eliminated k-th */
    int *place;       /* its inverse */
    int *visit;       /* the order in which threads take the rows of blocks; NULL: as they are eliminated */
    int *run;         /* per k: how many bodies follow each other from the k-th on, itself included, which have the same
                       * later blocks but for each other, up to where the run ends; 1 for other blocks */
    int *later_start; /* per k: the blocks eliminated after the k-th that it is coupled with then, by their places, */
    int *later;       /* ascending */
    size_t *diagonal; /* per k: where its diagonal block stands in values, row major as all; factored, its inverse
                       * or its factors */
    size_t *lower;    /* parallel to `later`: block (later, k); to_upper behind it block (k, later), of the same size */
    size_t to_upper;
    double *values;    /* the diagonal blocks, those below and those above them: an iteration streams each in a pass */
    float *singles;    /* the same where it is in single precision, in rows of PINCH_SINGLE_ROW; below the diagonal
                        * ones they are transposed */
    pinch_width width; /* of the registers that single precision uses */
    size_t value_count;
    int *pivot;                      /* per unknown */
    double *scratch;                 /* a block of the largest, and a row of it */
    int *earlier_start;              /* for many threads: per k, those eliminated before it, */
    pinch_block_lu_earlier *earlier; /* ascending. NULL: not shared */
    atomic_int *done;                /* scratch: per k, how far it is */
} pinch_block_lu;

/*
 * graph: the block rows, and which are coupled. size[count] must stay. The plan is left incomplete where the
 * factorization would take more than `limit` (INFINITY: never) products of blocks. memory: of orders, NULL for none;
 * nothing else may be ordered with it as long as the plan is used. Returns false when memory ran out.
 */
bool pinch_block_lu_plan(pinch_arena *arena, const pinch_block_graph *graph, const int *size, double limit,
                         pinch_block_order_memory *memory, pinch_block_lu *lu);

/* The same, in single precision if it is complete. All sizes are 6, and graph->early is graph->count. */
bool pinch_block_lu_plan_single(pinch_arena *arena, const pinch_block_graph *graph, const int *size, double limit,
                                pinch_block_order_memory *memory, pinch_block_lu *lu);

void pinch_block_lu_clear(pinch_block_lu *lu);

/* Does the part of it from a value on up to another; all value_count of them are the matrix. */
void pinch_block_lu_clear_part(pinch_block_lu *lu, size_t first, size_t end);

/* Is the block below the diagonal ones? */
static inline bool pinch_block_lu_is_lower(const pinch_block_lu *lu, int row, int column)
{
    return lu->place[row] > lu->place[column];
}

/* Is the block read? All are but those below the diagonal ones of a symmetric matrix. */
static inline bool pinch_block_lu_reads(const pinch_block_lu *lu, int row, int column)
{
    return !lu->symmetric || !pinch_block_lu_is_lower(lu, row, column);
}

/* Returns where block (row, column), size[row] x size[column], stands in `values` or `singles`, to be added to; the two
 * must be equal or coupled. */
size_t pinch_block_lu_offset(const pinch_block_lu *lu, int row, int column);

/* The block itself, in double precision. */
static inline double *pinch_block_lu_at(const pinch_block_lu *lu, int row, int column)
{
    return lu->values + pinch_block_lu_offset(lu, row, column);
}

/* Block (k, later) of an entry of `later`. */
static inline double *pinch_block_lu_upper(const pinch_block_lu *lu, int entry)
{
    return lu->values + lu->lower[entry] + lu->to_upper;
}

/* Prepares a complete plan for many threads: where no block is wide, a crew's do then what follows, to the same bits.
 * crew NULL: the caller's does. Returns false when memory ran out. */
bool pinch_block_lu_share(pinch_arena *arena, pinch_block_lu *lu);

/* x = A^-1 x, unknowns in the order of the block rows. */
void pinch_block_lu_solve(const pinch_block_lu *lu, const pinch_crew *crew, double *x);

/* Factors the matrix in place, and does what pinch_block_lu_solve does. Returns false when a pivot is zero to rounding
 * or not finite. */
bool pinch_block_lu_factor_and_solve(pinch_block_lu *lu, const pinch_crew *crew, double *x);

/* block_lu_single.c: the steps of block_lu.c, in single precision. */

/* For the blocks from the k-th on, `count` of a run: A_ij -= A_ik U_kj and A_ji -= A_jk U_ki with all j >= i among
 * their last `later` later blocks, of which i is the first. Of a symmetric matrix it does the first of the two. */
void pinch_block_lu_single_update_row(const pinch_block_lu *lu, int k, int count, int later);

/* Inverts the k-th diagonal block, and forms U_kj = A_kk^-1 A_kj. Returns false when a pivot is none. */
bool pinch_block_lu_single_factor_own(const pinch_block_lu *lu, int k);

/* Does x_k = A_kk^-1 x_k. */
void pinch_block_lu_single_solve_own(const pinch_block_lu *lu, int k, double *x);

/* Does x_i -= A_ik x_k, i being that of the entry a. */
void pinch_block_lu_single_subtract_earlier(const pinch_block_lu *lu, int k, int a, double *x);

/* Does x_k -= U_kj x_j for all j. */
void pinch_block_lu_single_subtract_later(const pinch_block_lu *lu, int k, double *x);

#endif
