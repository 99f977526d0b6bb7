#ifndef PINCH_NONSMOOTH_H
#define PINCH_NONSMOOTH_H

#include <pinch/status.h>
#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * A non-smooth system F(x) = 0 and an element V of its generalized Jacobian: the one interface
 * between what is solved (an LCP through the Fischer-Burmeister function, the contact velocities
 * of a step, a static grasp) and the methods that solve it.
 *
 * F is non-dimensional, so that ||F||_2 can be held against one tolerance.
 */

/* `length` consecutive entries of a row of V, from column `start`; columns outside all segments are zero. */
typedef struct pinch_row_segment {
    int start;            /* first column */
    int length;           /* >= 1 */
    const double *values; /* `length` of them */
} pinch_row_segment;

/* One row of V. Segments are disjoint and ascending; they stay valid until the next linearize. */
typedef struct pinch_row {
    int count;                         /* of segments, >= 0 */
    const pinch_row_segment *segments; /* by column */
} pinch_row;

/* A system as the solvers see it: its functions and what they work on. */
typedef struct pinch_system {
    int size;   /* unknowns = equations, >= 1 */
    void *self; /* handed to every function below */

    /* f[size] = F(x[size]) */
    void (*residual)(void *self, const double *x, double *f);
    /* F_row(x) alone, at no more than the cost of that row */
    double (*residual_row)(void *self, const double *x, int row);
    /* freezes V at x for `row` and `solve` */
    void (*linearize)(void *self, const double *x);
    /* row `row` of the frozen V */
    pinch_row (*row)(void *self, int row);
    /* dx = V^-1 rhs with the frozen V; rhs and dx may be the same array. Returns false when V is singular to working
     * precision (dx is then unspecified). */
    bool (*solve)(void *self, const double *rhs, double *dx);

    /* Optional: a system may answer `solve` from a V that is only nearly that of the frozen point. This makes it exact;
     * false when it was already. NULL: always exact. */
    bool (*sharpen)(void *self);

    /* Optional shortcuts for row-action methods; NULL has `row` do the work. */
    /* ||V_row||_2^2 of the frozen V */
    double (*row_norm2)(void *self, int row);
    /* norm2[size]: ||V_row||_2^2 of all rows of the frozen V, the same numbers at once */
    void (*row_norms2)(void *self, double *norm2);
    /* x += step V_row with the frozen V */
    void (*add_row)(void *self, int row, double step, double *x);
} pinch_system;

#ifdef __cplusplus
}
#endif
#endif
