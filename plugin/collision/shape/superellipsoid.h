#ifndef PINCH_FINGERTIP_SUPERELLIPSOID_H
#define PINCH_FINGERTIP_SUPERELLIPSOID_H

/* Semi-axes `half` (m) and exponents `power` of the dual norm, along z and around it: the support function at d, the
 * point where it is taken (NULL: not wanted), and its second derivative, added to H (NULL: not wanted). */
void pinch_superellipsoid_at(const double half[3], const double power[2], const double d[3], double *value,
                             double *point, double *H);

/* The norm of x whose unit ball the superellipsoid is, and its gradient: along the normal there (NULL: not wanted). */
double pinch_superellipsoid_norm(const double half[3], const double power[2], const double x[3], double *gradient);

#endif
