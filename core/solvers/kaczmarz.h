#ifndef PINCH_SOLVERS_KACZMARZ_H
#define PINCH_SOLVERS_KACZMARZ_H

#include "solvers/iterate.h"
#include "support/random.h"

/*
 * One iteration of the greedy Kaczmarz methods from the current point, with V already linearized there. The trial point
 * is filled and evaluated; its norm is in *norm (not finite where the method left the domain of F), and the number of
 * rows projected onto is returned: 0 when no row of V can reduce F.
 */

/* NSNMGK: projects onto every candidate row in index order, each with its residual at the point reached so far. */
int pinch_nsnmgk_sweep(pinch_iterate *it, double *norm);

/* NSNGRK: projects onto one candidate row, drawn with probability proportional to F_i^2. */
int pinch_nsngrk_draw(pinch_iterate *it, pinch_random *random, double *norm);

#endif
