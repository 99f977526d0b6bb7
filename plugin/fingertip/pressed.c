/*
 * A superellipsoid with an exponent below 1 is nearly flat around its poles: the point that reaches farthest along d
 * moves with the seventh or third root of d's tilt, and one contact there jumps from one side to the other with
 * rounding. A pad's pressure does not: with a depth f(s) under the pad at s, a pad of springs side by side presses
 * where f > 0 by as much as f, and middle and spread of that change smoothly as the bodies roll. Its moments are taken
 * along two lines through the farthest point, at right angles.
 */
#include "pressed.h"

#include "superellipsoid.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>

enum { STEPS = 60 };

/* Deeper than this part of the core's reach the surface is followed no farther: so deep no pad is pressed. */
static const double DEEPEST = 0.25;

/* Less than this part of the bound is a touch at one point. */
static const double SHALLOWEST = 1e-10;

bool pinch_press(const pinch_core *core, const double d[3], pinch_pressed *at)
{
    if (core->kind != PINCH_CORE_SUPERELLIPSOID || !(fmin(core->power[0], core->power[1]) < 2)) return false;
    pinch_v3_copy(at->d, d);
    pinch_core_support(core, d, at->x);
    pinch_v3_any_perpendicular(d, at->t[0]);
    pinch_v3_cross(d, at->t[0], at->t[1]);
    for (int k = 0; k < 2; k++) {
        at->low[k] = -DBL_MAX;
        at->high[k] = DBL_MAX;
    }
    return true;
}

/* The norm whose unit ball the core is: the conjugate one of its support function, 1/p + 1/q = 1. */
static double norm_at(const pinch_core *core, const double *x, double *gradient)
{
    double inverse[3], power[2], value;
    for (int i = 0; i < 3; i++) inverse[i] = 1 / core->half[i];
    for (int i = 0; i < 2; i++) power[i] = core->power[i] / (core->power[i] - 1);
    pinch_superellipsoid_at(inverse, power, x, &value, gradient, NULL);
    return value;
}

/* From `from`, outside, along u to the core's surface: how far. Newton's method on a convex function stays outside. */
static double way_in(const pinch_core *core, const double *from, const double *u)
{
    double x[3], gradient[3], s = 0;
    for (int k = 0; k < STEPS; k++) {
        pinch_v3_copy(x, from);
        pinch_v3_add_scaled(x, s, u);
        double over = norm_at(core, x, gradient) - 1, slope = pinch_v3_dot(gradient, u);
        if (!(over > 0) || !(slope < 0)) break;
        double step = -over / slope;
        s += step;
        if (step < 1e-15 * core->bound) break;
    }
    return s;
}

/* How far a line through the core's inside reaches in the direction u. */
static double way_out(const pinch_core *core, const double *from, const double *u)
{
    double outside[3], back[3] = {-u[0], -u[1], -u[2]}, far = 2 * core->bound;
    pinch_v3_copy(outside, from);
    pinch_v3_add_scaled(outside, far, u);
    return far - way_in(core, outside, back);
}

typedef struct span {
    double middle, spread;
} span;

/* Middle and spread (standard deviation) of the pressure along t, by Gauss and Legendre's rule on five points. */
static span span_along(const pinch_core *core, const pinch_pressed *at, int k, double depth)
{
    static const double NODE[5] = {-0.90617984593866399, -0.53846931010568309, 0, 0.53846931010568309,
                                   0.90617984593866399};
    static const double WEIGHT[5] = {0.23692688505618909, 0.47862867049936647, 0.56888888888888889, 0.47862867049936647,
                                     0.23692688505618909};
    double base[3], in[3], back[3], sum[3] = {0, 0, 0};
    const double *t = at->t[k];
    for (int i = 0; i < 3; i++) {
        in[i] = -at->d[i];
        back[i] = -t[i];
        base[i] = at->x[i] - depth * at->d[i];
    }
    if (!(norm_at(core, base, NULL) < 1)) return (span){0, 0};
    double high = fmin(at->high[k], way_out(core, base, t)), low = fmax(at->low[k], -way_out(core, base, back));
    double half = 0.5 * (high - low), centre = 0.5 * (high + low);
    if (!(half > 0)) return (span){centre, 0};
    for (int j = 0; j < 5; j++) {
        double x[3], s = centre + half * NODE[j];
        pinch_v3_copy(x, at->x);
        pinch_v3_add_scaled(x, s, t);
        double pressure = WEIGHT[j] * fmax(0, depth - way_in(core, x, in));
        sum[0] += pressure;
        sum[1] += pressure * s;
        sum[2] += pressure * s * s;
    }
    if (!(sum[0] > 0)) return (span){centre, 0};
    double middle = sum[1] / sum[0];
    return (span){middle, sqrt(fmax(0, sum[2] / sum[0] - middle * middle))};
}

static double pressed_depth(const pinch_pressed *at, double depth)
{
    double most = DEEPEST * pinch_v3_dot(at->x, at->d);
    return depth < most ? depth : most;
}

void pinch_pressed_points(const pinch_core *core, const pinch_pressed *at, double depth, double points[4][3])
{
    /* of a disc's spread: that of a line across it, 2 r/sqrt(12), is wider than its own, r/2 */
    static const double OF_DISC = 0.8660254037844386;
    static const double TURN[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
    span s[2] = {{0, 0}, {0, 0}};
    depth = pressed_depth(at, depth);
    for (int k = 0; k < 2 && depth > SHALLOWEST * core->bound; k++) s[k] = span_along(core, at, k, depth);
    for (int c = 0; c < 4; c++) {
        pinch_v3_copy(points[c], at->x);
        for (int k = 0; k < 2; k++)
            pinch_v3_add_scaled(points[c], s[k].middle + TURN[c][k] * OF_DISC * s[k].spread, at->t[k]);
    }
}

void pinch_pressed_line(const pinch_core *core, const pinch_pressed *at, double depth, double points[2][3])
{
    span s = {0, 0};
    depth = pressed_depth(at, depth);
    if (depth > SHALLOWEST * core->bound) s = span_along(core, at, 0, depth);
    for (int c = 0; c < 2; c++) {
        pinch_v3_copy(points[c], at->x);
        pinch_v3_add_scaled(points[c], s.middle + (c ? s.spread : -s.spread), at->t[0]);
    }
}
