#ifndef PINCH_SOLVERS_FISCHER_BURMEISTER_H
#define PINCH_SOLVERS_FISCHER_BURMEISTER_H

#include <pinch/lcp.h>

/* A (mixed) LCP becomes the non-smooth system F(z) = 0 of the Fischer-Burmeister function, equations (31) and (32) of
 * core/README.md. */
typedef struct pinch_fischer_burmeister {
    pinch_lcp lcp;
    double *point, *w;           /* the last point evaluated, and M point + q there */
    double *rho;                 /* sqrt(point_i^2 + w_i^2), which both F and V need */
    double *alpha, *beta;        /* frozen row i of V: alpha_i e_i + beta_i M_i */
    double *m_row_norm2, *m_ii;  /* ||M_i||^2; the diagonal */
    double *v, *lu;              /* rows of V on demand; factors of V */
    double *scratch;             /* size */
    int *pivot;                  /* size */
    pinch_row_segment *segments; /* one per row */
} pinch_fischer_burmeister;

/* Doubles of scratch for a system of `size` unknowns. */
size_t pinch_fischer_burmeister_scratch(int size);

/* Borrows the LCP's arrays, scratch, pivot[size] and segments[size]; the returned system borrows `fb`. */
pinch_system pinch_fischer_burmeister_init(pinch_fischer_burmeister *fb, const pinch_lcp *lcp, double *scratch,
                                           int *pivot, pinch_row_segment *segments);

/* w = M z + q */
void pinch_lcp_residual(const pinch_lcp *lcp, const double *z, double *w);
/* ||F||_2 at z, whose w is given. */
double pinch_fischer_burmeister_norm(const pinch_lcp *lcp, const double *z, const double *w);

#endif
