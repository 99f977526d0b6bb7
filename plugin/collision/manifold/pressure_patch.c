/*
 * A superellipsoid with an exponent below 1 is nearly flat around its poles: the point that reaches farthest along d
 * moves with the third or seventh root of d's tilt, and one contact there would jump to and fro with rounding. A pad's
 * pressure does not: springs side by side press where they are pressed in, each by as much, and middle and spread of
 * that change smoothly as the bodies roll. The middle is where two lines at right angles cross so that each has the
 * middle of its pressure there; the farthest point is only where the search for it begins.
 */
#include "pressed.h"

#include "collision/shape/superellipsoid.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { STEPS = 60, SWEEPS = 12 };

/* Of the core's reach: so deep no pad is pressed, and the surface is followed no farther. */
static const double DEEPEST = 0.25;

/* Of the bound: less deep, it is a touch at one point. */
static const double SHALLOWEST = 1e-10;

/* Of the bound: a last step of the secant method, and of Newton's. */
static const double SETTLED = 1e-10, LAST = 1e-9;

bool pinch_press(const pinch_core *core, const double d[3], double depth, pinch_pressed *pressed)
{
    if (core->kind != PINCH_CORE_SUPERELLIPSOID || !(fmin(core->power[0], core->power[1]) < 2)) return false;
    memset(pressed, 0, sizeof *pressed);
    pressed->core = core;
    pinch_v3_copy(pressed->d, d);
    pinch_core_support(core, d, pressed->x);
    pressed->depth = fmin(depth, DEEPEST * pinch_v3_dot(pressed->x, d));
    pinch_v3_any_perpendicular(d, pressed->t[0]);
    pinch_v3_cross(d, pressed->t[0], pressed->t[1]);
    return true;
}

/* From `from`, outside, along u to the core's surface: how far. Newton's method on a convex function stays outside. */
static double way_in(const pinch_core *core, const double *from, const double *u)
{
    double x[3], gradient[3], s = 0;
    for (int k = 0; k < STEPS; k++) {
        pinch_v3_copy(x, from);
        pinch_v3_add_scaled(x, s, u);
        double over = pinch_superellipsoid_norm(core->half, core->power, x, gradient) - 1,
               slope = pinch_v3_dot(gradient, u);
        if (!(over > 0) || !(slope < 0)) break;
        double step = -over / slope;
        s += step;
        if (step < LAST * core->bound) break; /* its square is what is left */
    }
    return s;
}

/* How far a line through the core's inside reaches in the direction u, not shorter than a unit vector. */
static double way_out(const pinch_core *core, const double *from, const double *u)
{
    double outside[3], back[3] = {-u[0], -u[1], -u[2]}, far = 2 * core->bound;
    pinch_v3_copy(outside, from);
    pinch_v3_add_scaled(outside, far, u);
    return far - way_in(core, outside, back);
}

typedef struct span {
    double middle, spread; /* from r; standard deviation */
} span;

/* How deep the pad is at y, a point of the plane, where the core does not curve away from the plane. */
static double pad_depth(const pinch_pressed *p, const double *y)
{
    return p->depth - (pinch_v3_dot(p->slope, y) - pinch_v3_dot(p->slope, p->highest));
}

/* Of the pressure along the line from r along t, between bounds, by Gauss and Legendre's rule on five points. */
static span span_along(const pinch_pressed *p, const double *r, const double *t, double low, double high)
{
    static const double NODE[5] = {-0.90617984593866399, -0.53846931010568309, 0, 0.53846931010568309,
                                   0.90617984593866399};
    static const double WEIGHT[5] = {0.23692688505618909, 0.47862867049936647, 0.56888888888888889, 0.47862867049936647,
                                     0.23692688505618909};
    const span none = {0, 0};
    double base[3], along[3], back[3], in[3] = {-p->d[0], -p->d[1], -p->d[2]}, sum[3] = {0, 0, 0};
    double deep = pad_depth(p, r), falls = pinch_v3_dot(p->slope, t);
    if (!(deep > SHALLOWEST * p->core->bound)) return none;
    for (int i = 0; i < 3; i++) { /* the pad's surface, followed to where it leaves the core */
        base[i] = r[i] - deep * p->d[i];
        along[i] = t[i] + falls * p->d[i];
        back[i] = -along[i];
    }
    if (!(pinch_superellipsoid_norm(p->core->half, p->core->power, base, NULL) < 1)) return none;
    high = fmin(high, way_out(p->core, base, along));
    low = fmax(low, -way_out(p->core, base, back));
    double half = 0.5 * (high - low), centre = 0.5 * (high + low);
    if (!(half > 0)) return none;
    for (int j = 0; j < 5; j++) {
        double x[3], s = centre + half * NODE[j];
        pinch_v3_copy(x, r);
        pinch_v3_add_scaled(x, s, t);
        double pressure = WEIGHT[j] * fmax(0, pad_depth(p, x) - way_in(p->core, x, in));
        sum[0] += pressure;
        sum[1] += pressure * s;
        sum[2] += pressure * s * s;
    }
    if (!(sum[0] > 0)) return none;
    double middle = sum[1] / sum[0];
    return (span){middle, sqrt(fmax(0, sum[2] / sum[0] - middle * middle))};
}

/* Moves r to the middle along t[k]. Returns the spread. */
static double centre_along(const pinch_pressed *p, int k, pinch_pad_bounds bounds, const void *pad, double *r)
{
    double low = -DBL_MAX, high = DBL_MAX;
    if (bounds) bounds(pad, r, p->t[k], &low, &high);
    span s = span_along(p, r, p->t[k], low, high);
    pinch_v3_add_scaled(r, s.middle, p->t[k]);
    return s.spread;
}

/*
 * Along t[0], then along t[1], and again: where the lines begin along t[1] the secant method finds so that they end
 * there. Straight pads that lie straight take two sweeps.
 */
static void find_middle(const pinch_pressed *p, pinch_pad_bounds bounds, const void *pad, double *r, double *spread)
{
    double at_before = 0, gain_before = 0;
    pinch_v3_copy(r, p->x);
    for (int k = 0; k < SWEEPS; k++) {
        double at = pinch_v3_dot(r, p->t[1]);
        for (int i = 0; i < 2; i++) spread[i] = centre_along(p, i, bounds, pad, r);
        double gain = pinch_v3_dot(r, p->t[1]) - at;
        if (gain == 0) return;
        double rise = k > 0 ? (gain - gain_before) / (at - at_before) : -1;
        if (rise < -0.1) pinch_v3_add_scaled(r, -gain / rise - gain, p->t[1]);
        if (fabs(gain) < SETTLED * p->core->bound) return;
        at_before = at;
        gain_before = gain;
    }
}

void pinch_pressed_points(const pinch_pressed *p, pinch_pad_bounds bounds, const void *pad, double points[4][3])
{
    /* of a disc's spread: that of a line across it, 2 r/sqrt(12), is wider than its own, r/2 */
    static const double OF_DISC = 0.8660254037844386;
    static const double TURN[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
    double r[3], spread[2];
    find_middle(p, bounds, pad, r, spread);
    for (int c = 0; c < 4; c++) {
        pinch_v3_copy(points[c], r);
        for (int k = 0; k < 2; k++) pinch_v3_add_scaled(points[c], TURN[c][k] * OF_DISC * spread[k], p->t[k]);
    }
}

void pinch_pressed_line(const pinch_pressed *p, const double r[3], double low, double high, double points[2][3])
{
    span s = span_along(p, r, p->t[0], low, high);
    for (int c = 0; c < 2; c++) {
        pinch_v3_copy(points[c], r);
        pinch_v3_add_scaled(points[c], s.middle + (c ? s.spread : -s.spread), p->t[0]);
    }
}
