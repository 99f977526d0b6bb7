#ifndef PINCH_FINGERTIP_SUPERELLIPSOID_H
#define PINCH_FINGERTIP_SUPERELLIPSOID_H

/* A superellipsoid has the semi-axes `half` (m), and its dual norm has the exponents `power`, along z and around z.
 * Computes the support value at d, the support point (NULL if not wanted), and adds the support Hessian to H (NULL if
 * not wanted). */
void pinch_superellipsoid_at(const double half[3], const double power[2], const double d[3], double *value,
                             double *point, double *H);

/* Returns the norm of x whose unit ball the superellipsoid is. Its gradient (NULL if not wanted) leads along the
 * surface normal. */
double pinch_superellipsoid_norm(const double half[3], const double power[2], const double x[3], double *gradient);

#endif
