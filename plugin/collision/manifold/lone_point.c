/*
 * What of a tilted body is pressed into a flat face is a tip with its lowest point deepest. Where all edges that leave
 * that point also leave the plane, and do so over the face, clipping polygons would come to nothing but the point.
 */
#include "lone_point.h"

#include "support/vec3.h"

#include <math.h>

/* Of a body's size: lower by less, another corner is as deep. */
static const double TIE = 1e-8;

static const double NOWHERE = PINCH_NOT_LONE;

static double larger(double a, double b)
{
    return a > b ? a : b;
}

/* How far from the lowest point an edge of that length leaves the plane, falling by `fall` until its end. */
static double leaves_at(double length2, double fall, double depth, double tie)
{
    if (!(fall >= depth && fall > tie)) return NOWHERE;
    double part = depth / fall;
    return part * sqrt(larger(0, length2 - fall * fall));
}

static double spread_of_box(const pinch_core *core, const double *d, double depth)
{
    double most = 0, tie = TIE * core->bound;
    for (int i = 0; i < 3; i++) {
        double length = 2 * core->half[i], at = leaves_at(length * length, length * fabs(d[i]), depth, tie);
        if (at == NOWHERE) return at;
        most = larger(most, at);
    }
    return most;
}

static double spread_of_hull(const pinch_core *core, unsigned corner, const double *d, double depth)
{
    const pinch_core_hull *hull = core->hull;
    const double *x = hull->convex.points + 3 * corner;
    double most = 0, edge[3], tie = TIE * core->bound;
    for (unsigned k = hull->neighbours_at[corner]; k < hull->neighbours_at[corner + 1]; k++) {
        pinch_v3_sub(x, hull->convex.points + 3 * hull->neighbours[k], edge);
        double at = leaves_at(pinch_v3_dot(edge, edge), pinch_v3_dot(edge, d), depth, tie);
        if (at == NOWHERE) return at;
        most = larger(most, at);
    }
    return most;
}

/* The line along the side, or the corners of the rim next to its lowest point (pinch_core_rim): half an eighth of a
 * turn to one and a half. */
static double spread_of_round(const pinch_core *core, const double *d, double depth)
{
    static const double S = 0.70710678118654752;
    double length = 2 * core->half[2], tie = TIE * core->bound;
    double along = leaves_at(length * length, length * fabs(d[2]), depth, tie);
    if (along == NOWHERE || fabs(d[2]) <= 0.7) return along;
    double rho = sqrt(d[0] * d[0] + d[1] * d[1]), x = fabs(d[0]), y = fabs(d[1]);
    double to_axis = larger(x, y), to_diagonal = S * (x + y), most = along;
    /* from the corner that the lowest point stands in for to the next ones: along the axes or the diagonals */
    double cosine[2] = {to_axis > to_diagonal ? to_diagonal : to_axis,
                        to_axis > to_diagonal ? S * fabs(x - y) : (x < y ? x : y)};
    for (int k = 0; k < 2; k++) {
        double fall = core->radius * (rho - cosine[k]),
               chord2 = 2 * core->radius * core->radius * (1 - cosine[k] / rho);
        double at = leaves_at(chord2, fall, depth, tie);
        if (at == NOWHERE) return at;
        most = larger(most, at);
    }
    return most;
}

double pinch_lone_spread(const pinch_core *core, unsigned corner, const double d[3], double depth)
{
    switch (core->kind) {
    case PINCH_CORE_BOX:
        return spread_of_box(core, d, depth);
    case PINCH_CORE_HULL:
        return spread_of_hull(core, corner, d, depth);
    case PINCH_CORE_CYLINDER:
        return spread_of_round(core, d, depth);
    default:
        return NOWHERE;
    }
}
