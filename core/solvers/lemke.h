#ifndef PINCH_SOLVERS_LEMKE_H
#define PINCH_SOLVERS_LEMKE_H

#include <pinch/lcp.h>

/* Doubles of scratch and ints of basis for `size` unknowns. */
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

#endif
