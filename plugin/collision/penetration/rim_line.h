/* A round rim and something straight. */
#ifndef PINCH_FINGERTIP_RIM_ARC_H
#define PINCH_FINGERTIP_RIM_ARC_H

#include <stdbool.h>

/*
 * The only local minimum over the half circle c > 0, c^2 + s^2 = 1, of the overlap
 *
 *     f = X c + Y s + r sqrt(m + Q2 s^2),
 *
 * the rim of a disc of radius r over normals n = c e_x + s e_y at right angles to a straight line: e_x is the disc's
 * axis made perpendicular to the line, m and Q2 = 1 - m the squared cosine and sine of the angle between line and axis
 * (Q2 > 0). False: there is none.
 */
bool pinch_rim_least(double X, double Y, double r, double m, double Q2, double *c, double *s);

/* Is that minimum certainly not on the arc, of less than a half turn, between these c and s? */
bool pinch_rim_least_is_off(double X, double Y, double r, double m, double Q2, const double ends[2][2]);

#endif
