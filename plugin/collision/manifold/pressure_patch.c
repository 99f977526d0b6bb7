/*
 * A superellipsoid with an exponent below 1 is nearly flat around its poles. The point farthest along d moves with the
 * third or seventh root of d's tilt, and a single contact there would jump to and fro with rounding. The pressure of a
 * pad does not: springs side by side press as deep as they are pressed in, and the middle and spread of that change
 * smoothly as the bodies roll. The middle is where two lines at right angles cross so that each has the middle of its
 * pressure there. The farthest point is only where the search begins.
 */
#include "pair_features.h"

#include "clip.h"
#include "collision/shape/superellipsoid.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* All is in the shape's axes. At y the pad's surface sinks away from the plane that is at right angles to d, by
 * slope.(y - highest). */
typedef struct pressure_patch {
    const pinch_shape *shape;
    double d[3], x[3]; /* the plane touches the shape at x, the point farthest along d */
    double t[2][3];    /* unit, in the plane, at right angles to each other */
    double depth;      /* to which the shape is pressed in there, m */
    double slope[3];   /* in the plane; 0 for a pad parallel to it */
    double highest[3]; /* where the pad meets the plane; without a slope it does not matter */
} pressure_patch;

/* Finds how far the pad extends along the unit vector t from r, both in the plane. NULL stands for a pad without
 * bounds. */
typedef void (*pad_bounds)(const void *pad, const double r[3], const double t[3], double *low, double *high);

enum { STEPS = 60, SWEEPS = 12 };

/* A pad is pressed in no deeper than this part of the shape's support value, and the surface is followed no farther. */
static const double DEEPEST = 0.25;

/* Less deep than this part of the bound, it is a contact at one point. */
static const double SHALLOWEST = 1e-10;

/* The last steps of the secant method and of Newton's, in parts of the bound. */
static const double SETTLED = 1e-10, LAST = 1e-9;

static bool find_patch(const pinch_shape *shape, const double d[3], double depth, pressure_patch *patch)
{
    if (shape->kind != PINCH_SHAPE_SUPERELLIPSOID || !(fmin(shape->power[0], shape->power[1]) < 2)) return false;
    memset(patch, 0, sizeof *patch);
    patch->shape = shape;
    pinch_v3_copy(patch->d, d);
    pinch_support_point(shape, d, patch->x);
    patch->depth = fmin(depth, DEEPEST * pinch_v3_dot(patch->x, d));
    pinch_v3_any_perpendicular(d, patch->t[0]);
    pinch_v3_cross(d, patch->t[0], patch->t[1]);
    return true;
}

/* Returns how far it is from `from`, outside, along u to the shape's surface. Newton's method on a convex function
 * stays outside. */
static double way_in(const pinch_shape *shape, const double *from, const double *u)
{
    double x[3], gradient[3], s = 0;
    for (int k = 0; k < STEPS; k++) {
        pinch_v3_copy(x, from);
        pinch_v3_add_scaled(x, s, u);
        double over = pinch_superellipsoid_norm(shape->half, shape->power, x, gradient) - 1,
               slope = pinch_v3_dot(gradient, u);
        if (!(over > 0) || !(slope < 0)) break;
        double step = -over / slope;
        s += step;
        if (step < LAST * shape->bound) break; /* the square of the step is left */
    }
    return s;
}

/* Returns how far a line through the shape's inside extends in the direction u, which is at least a unit vector. */
static double way_out(const pinch_shape *shape, const double *from, const double *u)
{
    double outside[3], back[3] = {-u[0], -u[1], -u[2]}, far = 2 * shape->bound;
    pinch_v3_copy(outside, from);
    pinch_v3_add_scaled(outside, far, u);
    return far - way_in(shape, outside, back);
}

typedef struct span {
    double middle, spread; /* the middle, measured from r; the standard deviation */
} span;

/* Returns how deep the pad is at y, a point of the plane, if the shape did not curve away from the plane. */
static double pad_depth(const pressure_patch *p, const double *y)
{
    return p->depth - (pinch_v3_dot(p->slope, y) - pinch_v3_dot(p->slope, p->highest));
}

/* Integrates the pressure along the line from r along t, between bounds, by Gauss and Legendre's rule on five
 * points. */
static span span_along(const pressure_patch *p, const double *r, const double *t, double low, double high)
{
    static const double NODE[5] = {-0.90617984593866399, -0.53846931010568309, 0, 0.53846931010568309,
                                   0.90617984593866399};
    static const double WEIGHT[5] = {0.23692688505618909, 0.47862867049936647, 0.56888888888888889, 0.47862867049936647,
                                     0.23692688505618909};
    const span none = {0, 0};
    double base[3], along[3], back[3], in[3] = {-p->d[0], -p->d[1], -p->d[2]}, sum[3] = {0, 0, 0};
    double deep = pad_depth(p, r), falls = pinch_v3_dot(p->slope, t);
    if (!(deep > SHALLOWEST * p->shape->bound)) return none;
    for (int i = 0; i < 3; i++) { /* the pad's surface is followed to where it leaves the shape */
        base[i] = r[i] - deep * p->d[i];
        along[i] = t[i] + falls * p->d[i];
        back[i] = -along[i];
    }
    if (!(pinch_superellipsoid_norm(p->shape->half, p->shape->power, base, NULL) < 1)) return none;
    high = fmin(high, way_out(p->shape, base, along));
    low = fmax(low, -way_out(p->shape, base, back));
    double half = 0.5 * (high - low), centre = 0.5 * (high + low);
    if (!(half > 0)) return none;
    for (int j = 0; j < 5; j++) {
        double x[3], s = centre + half * NODE[j];
        pinch_v3_copy(x, r);
        pinch_v3_add_scaled(x, s, t);
        double pressure = WEIGHT[j] * fmax(0, pad_depth(p, x) - way_in(p->shape, x, in));
        sum[0] += pressure;
        sum[1] += pressure * s;
        sum[2] += pressure * s * s;
    }
    if (!(sum[0] > 0)) return none;
    double middle = sum[1] / sum[0];
    return (span){middle, sqrt(fmax(0, sum[2] / sum[0] - middle * middle))};
}

/* Moves r to the middle along t[k] and returns the spread. */
static double centre_along(const pressure_patch *p, int k, pad_bounds bounds, const void *pad, double *r)
{
    double low = -DBL_MAX, high = DBL_MAX;
    if (bounds) bounds(pad, r, p->t[k], &low, &high);
    span s = span_along(p, r, p->t[k], low, high);
    pinch_v3_add_scaled(r, s.middle, p->t[k]);
    return s.spread;
}

/*
 * Moves along t[0], then along t[1], and so on. The secant method finds where the lines must begin along t[1] to end
 * there. Straight pads that lie straight take two sweeps.
 */
static void find_middle(const pressure_patch *p, pad_bounds bounds, const void *pad, double *r, double *spread)
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
        if (fabs(gain) < SETTLED * p->shape->bound) return;
        at_before = at;
        gain_before = gain;
    }
}

static void patch_points(const pressure_patch *p, pad_bounds bounds, const void *pad, double points[4][3])
{
    /* The spread of a disc is r/2, and that of a line across it is 2 r/sqrt(12). This is their ratio. */
    static const double OF_DISC = 0.8660254037844386;
    static const double TURN[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
    double r[3], spread[2];
    find_middle(p, bounds, pad, r, spread);
    for (int c = 0; c < 4; c++) {
        pinch_v3_copy(points[c], r);
        for (int k = 0; k < 2; k++) pinch_v3_add_scaled(points[c], TURN[c][k] * OF_DISC * spread[k], p->t[k]);
    }
}

static void line_points(const pressure_patch *p, const double r[3], double low, double high, double points[2][3])
{
    span s = span_along(p, r, p->t[0], low, high);
    for (int c = 0; c < 2; c++) {
        pinch_v3_copy(points[c], r);
        pinch_v3_add_scaled(points[c], s.middle + (c ? s.spread : -s.spread), p->t[0]);
    }
}

/* A face or side that is steeper than this (cosine) does not press. */
static const double STEEP = 0.7;

/* The superellipsoid is shape `which` of the pair. The pad belongs to the other shape. */
typedef struct pad {
    const pinch_shape_pair *pair;
    int which;
    const pinch_feature *part;
    pinch_flat_face face;
} pad;

/* Rotates from the axes of shape `which` to A's, and back. */
static void rotate_to_a(const pad *p, const double *v, double *out)
{
    if (p->which)
        pinch_pair_rotate(p->pair, v, out);
    else
        pinch_v3_copy(out, v);
}

static void rotate_from_a(const pad *p, const double *v, double *out)
{
    if (p->which)
        pinch_pair_rotate_back(p->pair, v, out);
    else
        pinch_v3_copy(out, v);
}

static void point_to_a(const pad *p, const double *x, double *out)
{
    if (p->which)
        pinch_pair_point_to_a(p->pair, x, out);
    else
        pinch_v3_copy(out, x);
}

static void point_from_a(const pad *p, const double *x, double *out)
{
    if (p->which)
        pinch_pair_point_to_b(p->pair, x, out);
    else
        pinch_v3_copy(out, x);
}

static void bound_by_face(const void *data, const double *r, const double *t, double *low, double *high)
{
    const pad *p = data;
    double far = 2 * (p->pair->a->bound + p->pair->b->bound), x[PINCH_MAX_CONTACT_POINTS][3], from[3], along[3];
    bool whole;
    point_to_a(p, r, from);
    rotate_to_a(p, t, along);
    for (int end = 0; end < 2; end++) {
        pinch_v3_copy(x[end], from);
        pinch_v3_add_scaled(x[end], end ? far : -far, along);
    }
    *low = *high = 0;
    if (pinch_clip_to_face(&p->face, x, 2, NULL, &whole) != 2) return;
    *low = pinch_v3_dot(along, x[0]) - pinch_v3_dot(along, from);
    *high = pinch_v3_dot(along, x[1]) - pinch_v3_dot(along, from);
}

/* Finds the face or line of the other shape that is nearest to facing `out`, in A's axes. It is the pad. */
static void find_part(const pad *p, const double *out, pinch_feature *part)
{
    double d[3];
    pinch_v3_copy(d, out);
    if (!p->which) pinch_pair_rotate_back(p->pair, out, d);
    pinch_feature_at(p->which ? p->pair->a : p->pair->b, d, false, part);
    for (int k = 0; k < part->count && !p->which; k++) pinch_pair_point_to_a(p->pair, part->x[k], part->x[k]);
}

/* Finds the face's normal on the side of `out`. */
static void normal_of(const pinch_feature *part, const double *out, double *f)
{
    double c[3];
    pinch_v3_set(f, 0, 0, 0);
    for (int k = 1; k + 1 < part->count; k++) {
        double u[3], v[3];
        pinch_v3_sub(part->x[k], part->x[0], u);
        pinch_v3_sub(part->x[k + 1], part->x[0], v);
        pinch_v3_cross(u, v, c);
        pinch_v3_add_scaled(f, 1, c);
    }
    double length = pinch_v3_norm(f);
    if (length > 0) pinch_v3_scale(f, (pinch_v3_dot(f, out) < 0 ? -1 : 1) / length);
}

/* Returns the corner that is farthest along `out`. */
static const double *highest_of(const pinch_feature *part, const double *out)
{
    int best = 0;
    for (int k = 1; k < part->count; k++)
        if (pinch_v3_dot(part->x[k], out) > pinch_v3_dot(part->x[best], out)) best = k;
    return part->x[best];
}

/* `out` leads out of the face, at right angles to the plane. */
static int by_face(pad *p, const double *n, const double *out, pressure_patch *patch,
                   double x[PINCH_MAX_CONTACT_POINTS][3])
{
    double f[3], points[4][3];
    bool whole;
    normal_of(p->part, out, f);
    double cosine = pinch_v3_dot(f, out);
    if (!(cosine > STEEP)) return 0;
    pinch_v3_make_perpendicular(f, out);
    pinch_v3_scale(f, 1 / cosine);
    rotate_from_a(p, f, patch->slope);
    point_from_a(p, highest_of(p->part, out), patch->highest);
    p->face = pinch_flat_face_of(p->pair, !p->which, p->part, n);
    patch_points(patch, bound_by_face, p, points);
    for (int k = 0; k < 4; k++) point_to_a(p, points[k], x[k]);
    return pinch_clip_to_face(&p->face, x, 4, NULL, &whole);
}

static int by_line(const pad *p, const double *out, pressure_patch *patch, double x[PINCH_MAX_CONTACT_POINTS][3])
{
    double u[3], end[3], from[3], r[3], points[2][3];
    pinch_v3_sub(p->part->x[1], p->part->x[0], u);
    double length = pinch_v3_norm(u), rise = pinch_v3_dot(u, out);
    pinch_v3_make_perpendicular(u, out);
    double flat = pinch_v3_norm(u);
    if (!(flat > STEEP * length)) return 0;
    pinch_v3_scale(u, 1 / flat);
    rotate_from_a(p, u, patch->t[0]);
    pinch_v3_copy(patch->slope, patch->t[0]);
    pinch_v3_scale(patch->slope, -rise / flat);
    point_from_a(p, highest_of(p->part, out), patch->highest);
    point_from_a(p, p->part->x[0], end);
    pinch_v3_sub(patch->x, end, from);
    double along = pinch_v3_dot(from, patch->t[0]);
    pinch_v3_copy(r, end); /* over the line, and in the plane */
    pinch_v3_add_scaled(r, along, patch->t[0]);
    pinch_v3_add_scaled(r, pinch_v3_dot(patch->x, patch->d) - pinch_v3_dot(r, patch->d), patch->d);
    line_points(patch, r, -along, flat - along, points);
    for (int k = 0; k < 2; k++) point_to_a(p, points[k], x[k]);
    return 2;
}

int pinch_pressure_patch_points(const pinch_shape_pair *pair, const pinch_contact_normal *normal,
                                pinch_contact_point *contacts)
{
    if (pair->a->kind != PINCH_SHAPE_SUPERELLIPSOID && pair->b->kind != PINCH_SHAPE_SUPERELLIPSOID) return 0;
    const double *n = normal->normal, out_of_a[3] = {-n[0], -n[1], -n[2]};
    double depth = normal->overlap + pair->a->margin + pair->b->margin, d[3], x[PINCH_MAX_CONTACT_POINTS][3];
    pressure_patch patch;
    pinch_feature part;
    for (int which = 0; which < 2; which++) {
        pad p = {.pair = pair, .which = which, .part = &part};
        rotate_from_a(&p, which ? n : out_of_a, d);
        if (!find_patch(which ? pair->b : pair->a, d, depth, &patch)) continue;
        const double *out = which ? out_of_a : n; /* out of the pad */
        find_part(&p, out, &part);
        int count = part.face ? by_face(&p, n, out, &patch, x) : part.count == 2 ? by_line(&p, out, &patch, x) : 0;
        for (int k = 0; k < count; k++) { /* half way through the overlap, back out of the superellipsoid */
            pinch_v3_copy(contacts[k].position, x[k]);
            pinch_v3_add_scaled(contacts[k].position, 0.5 * depth, out);
            contacts[k].depth = depth;
        }
        return count;
    }
    return 0;
}

bool pinch_pressure_patch_on_plane(const pinch_shape *shape, const double d[3], double depth, double points[4][3])
{
    pressure_patch patch;
    if (!find_patch(shape, d, depth, &patch)) return false;
    patch_points(&patch, NULL, NULL, points);
    return true;
}
