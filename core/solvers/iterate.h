#ifndef PINCH_SOLVERS_ITERATE_H
#define PINCH_SOLVERS_ITERATE_H

#include <pinch/nonsmooth.h>

/*
 * What every iterative method works on: the current point with its residual, and room for a trial point. A method fills
 * the trial and either accepts it (buffers swap, nothing is copied) or leaves the current point as it was.
 */
typedef struct pinch_iterate {
    const pinch_system *system;
    double *x, *f;             /* current point, F there */
    double norm;               /* ||F(x)||_2, finite */
    double *x_trial, *f_trial; /* trial point, F there */
    double *direction;         /* Newton's or the gradient's direction */
    double *row_norm2;         /* ||V_i||^2 */
} pinch_iterate;

enum { PINCH_ITERATE_ARRAYS = 5 };

/* ||f||_2 */
double pinch_norm(const double *f, int n);
/* F at the trial point; returns its norm, which is not finite where F is not. */
double pinch_iterate_evaluate_trial(pinch_iterate *it);
/* Makes the trial point, whose F has the norm `norm`, the current one. */
void pinch_iterate_accept(pinch_iterate *it, double norm);

/* ||V_i||^2 and x += step V_i of the system's frozen V, by the system's shortcut where it has one. */
double pinch_row_norm2(const pinch_system *system, int row);
void pinch_row_add(const pinch_system *system, int row, double step, double *x);

#endif
