#ifndef PINCH_COLLISION_RIM_LINE_H
#define PINCH_COLLISION_RIM_LINE_H

#include "collision/shape/convex_shape.h"

#include <stdbool.h>

/* A round rim against a straight line, which is an edge or a cylinder's side: one unknown. */

/*
 * The rim of a disc of radius r meets a straight line at normals n = c e_x + s e_y at right angles to the line, where
 * e_x is the disc's axis made perpendicular to the line. With m and Q2 = 1 - m > 0, the squared cosine and sine of the
 * angle between line and axis, the overlap is
 *
 *     f = X c + Y s + r sqrt(m + Q2 s^2).
 *
 * Finds the only local minimum over the half circle c > 0, c^2 + s^2 = 1. Returns false where there is none.
 */
bool pinch_rim_least(double X, double Y, double r, double m, double Q2, double *c, double *s);

/* Tells whether that minimum is certainly not on the arc between these two (c, s), which is less than a half turn. */
bool pinch_rim_least_is_off(double X, double Y, double r, double m, double Q2, const double ends[2][2]);

/* A round body's axis and a straight line, seen along the line: x is the axis made perpendicular to the line, y is
 * across both (unit vectors), and X and Y are where the body's middle is. */
typedef struct pinch_rim_line {
    double x[3], y[3], X, Y;
    double sine, m; /* sine of the angle between both; its squared cosine */
} pinch_rim_line;

/* `axis` is along the line and w along the round body, both unit. Where the rims are B's, P leads from any point of the
 * line to the body's middle. Where they are A's, P leads from A's middle to a point of the line. Returns false if both
 * are parallel. */
bool pinch_rim_line_of(const double axis[3], const double w[3], const double P[3], pinch_rim_line *across);

/*
 * Finds the normal of least overlap of the line with one rim of the body: the one at its end along w (`rim` 1) or
 * against w (-1), for A the opposite one. `overlap` is that of a line without a radius. Returns false where there is
 * none.
 */
bool pinch_rim_line_normal(const pinch_rim_line *across, const pinch_shape *body, int rim, double n[3],
                           double *overlap);

#endif
