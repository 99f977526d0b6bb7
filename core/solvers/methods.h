/*
 * The methods, each in a file of its own, and what they share:
 *
 *     newton.c     Newton's method with line search, and steepest descent, equations (37) and (38)
 *     kaczmarz.c   the greedy Kaczmarz methods NSNMGK and NSNGRK of Ai and Li (2025), equations (33) to (36)
 *     lemke.c      Lemke's complementary pivoting
 *     pgs.c        projected Gauss-Seidel, equation (39)
 *     path.c       a path from a solved problem to the one at hand, equations (56) and (57)
 *     registry.c   their names and settings
 *     solve.c      runs the first two on any non-smooth system (pinch_solve_system)
 *     lcp.c        runs all of them on a linear complementarity problem (pinch_lcp_solve)
 *
 * Equations are those of core/README.md, which also says how a method is added.
 */
#ifndef PINCH_SOLVERS_METHODS_H
#define PINCH_SOLVERS_METHODS_H

#include "support/random.h"

#include <pinch/lcp.h>

/* PINCH_INVALID_ARGUMENT when a field is outside the range that solver.h documents. */
pinch_status pinch_check_solver_settings(const pinch_solver_settings *settings);
/* Adds the iterations, projections and Newton steps of a part of a solve to those of all of it. */
static inline void pinch_add_solver_counts(pinch_solver_result *total, const pinch_solver_result *part)
{
    total->iterations += part->iterations;
    total->projections += part->projections;
    total->newton_steps += part->newton_steps;
}

/*
 * What every method for a non-smooth system works on: the current point with its residual, and room for a trial point.
 * A method fills the trial and either accepts it (buffers swap, nothing is copied) or leaves the current point as it
 * was.
 */
typedef struct pinch_iterate {
    const pinch_system *system;
    double *x, *f;             /* current point, F there */
    double norm;               /* ||F(x)||_2, finite */
    double rate;               /* what the last full Newton step left of the norm; infinite where there was none */
    double *x_trial, *f_trial; /* trial point, F there */
    double *direction;         /* Newton's or the gradient's direction */
    double *row_norm2;         /* ||V_i||^2 */
} pinch_iterate;

enum { PINCH_ITERATE_ARRAYS = 5 };

/* F at the trial point; returns its norm, which is not finite where F is not. */
double pinch_iterate_evaluate_trial(pinch_iterate *it);
/* Makes the trial point, whose F has the norm `norm`, the current one. */
void pinch_iterate_accept(pinch_iterate *it, double norm);

/* ||V_i||^2 of all rows and x += step V_i of the system's frozen V, by the system's shortcut where it has one. */
void pinch_row_norms2(const pinch_system *system, double *norm2);
void pinch_row_add(const pinch_system *system, int row, double step, double *x);

/*
 * One Newton step from the current point, with V already linearized there: x - t V^-1 F, t halved from 1 until ||F||
 * falls by Armijo's rule. Accepts it and returns true, or leaves the point and returns false (V singular, or no t that
 * helps).
 */
bool pinch_newton_step(pinch_iterate *it);

/* Does the same along the steepest descent of ||F||^2 / 2, where Newton's own direction fails. */
bool pinch_gradient_step(pinch_iterate *it);

/*
 * Finds the last digits: linearizes and takes full Newton steps while each at least halves ||F||, until ||F|| <= goal,
 * at most `limit` of them. Without a goal (0), steps go on while each reduces ||F|| by at least a hundredth. A step
 * that promises to be the last one, by what the step before gained, is taken with the V of that step where the system
 * knows a V that is only nearly right. Returns the number of steps taken.
 */
int pinch_newton_polish(pinch_iterate *it, double goal, int limit);

/*
 * One iteration of the greedy Kaczmarz methods from the current point, with V already linearized there. The trial point
 * is filled and evaluated; its norm is in *norm (not finite where the method left the domain of F), and the number of
 * rows projected onto is returned: 0 when no row of V can reduce F.
 *
 * NSNMGK projects onto every candidate row in index order, each with its residual at the point reached so far. NSNGRK
 * projects onto one candidate row, drawn with probability proportional to F_i^2.
 */
int pinch_nsnmgk_sweep(pinch_iterate *it, double *norm);
int pinch_nsngrk_draw(pinch_iterate *it, pinch_random *random, double *norm);

/* Where a path of solutions begins. */
typedef struct pinch_path_start {
    const double *anchor; /* a, size of the system */
    double size;          /* > 0: what is a large change of x */
} pinch_path_start;

/* Larger problems are not led along paths, whose steps factor dense matrices; longer paths are given up. */
enum { PINCH_PATH_MOST_UNKNOWNS = 120, PINCH_PATH_MOST_STEPS = 4000 };

/* Doubles of scratch that a path needs for `size` unknowns. */
size_t pinch_path_scratch(int size);

/*
 * Follows the path of solutions of (1 - t) (x - a) / size + t F(x) = 0 from x = a at t = 0 to t = 1, with rows of V as
 * derivatives. Returns true with x where F(x) = 0 to about 1e-9, false where the path could not be followed with
 * *steps factorizations of an (n + 1) x (n + 1) matrix. *steps becomes the number that were made.
 */
bool pinch_path(const pinch_system *system, const pinch_path_start *start, double *scratch, double *x, int *steps);

/* Returns the doubles of scratch that Lemke's method needs for `size` unknowns; besides, it needs `size` ints of basis.
 */
size_t pinch_lemke_scratch(int size);

/*
 * Lemke's complementary pivoting on a pure LCP (no free rows), with the covering vector 1 in the scaled variables
 * z_i / scale_i, w_i scale_i (scale[size] > 0), and lexicographic ratios, so that it cannot cycle.
 *
 * Returns PINCH_SOLVE_CONVERGED (z[size] solves the LCP to pivoting accuracy), PINCH_SOLVE_RAY (z is then the direction
 * of the ray) or PINCH_SOLVE_MAX_ITERATIONS.
 */
pinch_solve_status pinch_lemke(const pinch_lcp *lcp, const double *scale, int max_pivots, double *scratch, int *basis,
                               double *z, int *pivots);

/* scale_i = 1/sqrt(M_ii), the square root of a stiffness where M_ii is a compliance; where M_ii <= 0 the row's largest
 * scaled entry becomes 1. */
void pinch_lemke_scale(const pinch_lcp *lcp, double *scale);

/*
 * Projected Gauss-Seidel, what ODE's quickstep iterates: z_i <- max(0, z_i - w_i / M_ii) row by row (no max on free
 * rows). Rows with M_ii <= 0 have no such step and stay as they are. Works on z in place; w[size] is scratch.
 */
void pinch_pgs(const pinch_lcp *lcp, const pinch_solver_settings *settings, double *z, double *w,
               pinch_solver_result *result);

#endif
