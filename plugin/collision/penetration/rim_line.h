#ifndef PINCH_COLLISION_RIM_LINE_H
#define PINCH_COLLISION_RIM_LINE_H

#include "collision/shape/convex_shape.h"

#include <stdbool.h>

/* A round rim and something straight. */

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

/* The axis of a round body across something straight, seen along that: x is the axis made perpendicular to it, y across
 * both, unit; X and Y where the body's middle is. */
typedef struct pinch_rim_line {
    double x[3], y[3], X, Y;
    double sine, m; /* of the angle between both; the squared cosine */
} pinch_rim_line;

/* `axis`: of what is straight, w: of the round body; both unit. P leads from any point of the first to the body's
 * middle where the rims are B's; where they are A's, which ends at -n, from A's middle to the first. False: parallel.
 */
bool pinch_rim_line_of(const double axis[3], const double w[3], const double P[3], pinch_rim_line *across);

/*
 * At right angles to the first axis the normal of least overlap with one rim of the body: the one at its end along w
 * (`rim` 1) or against it (-1), of A the opposite one. `overlap`: what is straight having no radius. False: there is
 * none.
 */
bool pinch_rim_line_normal(const pinch_rim_line *across, const pinch_shape *body, int rim, double n[3],
                           double *overlap);

#endif
