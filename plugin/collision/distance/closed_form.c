/*
 * The contact normals that have a closed form: balls and capsules with each other, and with boxes and cylinders while a
 * capsule's axis is outside. The nearest point of a box or cylinder to a point is known. Along a segment the squared
 * distance to a convex body is convex, so its derivative has one root.
 */
#include "distance.h"

#include "support/vec3.h"

#include <float.h>
#include <math.h>

/* Shapes nearer than this part of the size count as touching, because the direction of so short a distance is
 * rounding. */
static const double TOUCHING = 1e-10;

static double touching_distance(const pinch_shape_pair *pair)
{
    return TOUCHING * fmin(pair->a->bound, pair->b->bound);
}

/* Offers the direction from an end of A to the nearest point of B, which is p + t w, in A's axes. */
static void from_end_of_a(const pinch_shape_pair *pair, double end, const double *w, double touching,
                          pinch_contact_normal *best)
{
    double e[3] = {pair->p[0], pair->p[1], pair->p[2] - end};
    double half = pair->b->half[2], t = -pinch_v3_dot(e, w);
    bool inside = fabs(t) < half;
    pinch_v3_add_scaled(e, inside ? t : copysign(half, t), w);
    if (inside) pinch_v3_make_perpendicular(e, w); /* a vector so short is perpendicular only to its own rounding */
    double distance = pinch_v3_norm(e);
    if (!(distance > touching)) return;
    pinch_v3_scale(e, -1 / distance);
    pinch_offer_normal(pair, e, best);
}

/* Offers the direction from the nearest point of A to an end of B. */
static void from_end_of_b(const pinch_shape_pair *pair, double end, const double *w, double touching,
                          pinch_contact_normal *best)
{
    double e[3] = {pair->p[0] + end * w[0], pair->p[1] + end * w[1], pair->p[2] + end * w[2]};
    double half = pair->a->half[2];
    e[2] = fabs(e[2]) < half ? 0 : e[2] - copysign(half, e[2]);
    double distance = pinch_v3_norm(e);
    if (!(distance > touching)) return;
    pinch_v3_scale(e, -1 / distance);
    pinch_offer_normal(pair, e, best);
}

/* Segments in line are parted at right angles to the line, from B towards A as far as that has a meaning. */
static void out_of_line(const pinch_shape_pair *pair, const double *w, pinch_contact_normal *best)
{
    double n[3] = {-pair->p[0], -pair->p[1], -pair->p[2]};
    pinch_v3_make_perpendicular(n, w);
    double length = pinch_v3_norm(n);
    if (length > 1e-12 * pair->b->bound)
        pinch_v3_scale(n, 1 / length);
    else
        pinch_v3_any_perpendicular(w, n);
    pinch_offer_normal(pair, n, best);
}

/*
 * The points of one segment seen from those of the other form a parallelogram. The overlap is least along its normal,
 * or where one of its edges is nearest, which is a segment and an end of the other. Segments that cross, as those of
 * bodies with aligned axes do to the bit, have no overlap along the normal. Segments in line have none along any way
 * out of both.
 */
static void two_segments(const pinch_shape_pair *pair, pinch_contact_normal *found)
{
    /* Lines at less than this angle (rad) count as parallel, because their common perpendicular is rounding. */
    static const double PARALLEL = 1e-8;
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]};
    double touching = touching_distance(pair), sine = sqrt(w[0] * w[0] + w[1] * w[1]);
    double half_a = pair->a->half[2], half_b = pair->b->half[2];
    found->overlap = DBL_MAX;
    for (int side = -1; side <= 1; side += 2) {
        if (half_a > 0 || side > 0) from_end_of_a(pair, side * half_a, w, touching, found);
        from_end_of_b(pair, side * half_b, w, touching, found);
    }
    if (sine > PARALLEL) {
        const double common[3] = {-w[1] / sine, w[0] / sine, 0};
        pinch_offer_axis(pair, common, 0, 0, found);
    }
    if (!(found->overlap < -touching)) out_of_line(pair, w, found);
}

/* e leads from the box's nearest point to x. */
static void beyond_box(const pinch_shape *box, const double *x, double *e)
{
    for (int i = 0; i < 3; i++) {
        double over = fabs(x[i]) - box->half[i];
        e[i] = over > 0 ? copysign(over, x[i]) : 0;
    }
}

static void beyond_cylinder(const pinch_shape *cylinder, const double *x, double *e)
{
    double rho2 = x[0] * x[0] + x[1] * x[1], over = fabs(x[2]) - cylinder->half[2], part = 0;
    if (rho2 > cylinder->radius * cylinder->radius) part = 1 - cylinder->radius / sqrt(rho2);
    e[0] = part * x[0];
    e[1] = part * x[1];
    e[2] = over > 0 ? copysign(over, x[2]) : 0;
}

static void beyond(const pinch_shape *shape, const double *x, double *e)
{
    if (shape->kind == PINCH_SHAPE_BOX)
        beyond_box(shape, x, e);
    else
        beyond_cylinder(shape, x, e);
}

/* Finds the shortest way out for a point inside, with n in the shape's axes. Returns how far it is. */
static double way_out(const pinch_shape *shape, const double *x, double *n)
{
    pinch_v3_set(n, 0, 0, 0);
    if (shape->kind == PINCH_SHAPE_BOX) {
        int best = 0;
        double least = shape->half[0] - fabs(x[0]);
        for (int i = 1; i < 3; i++)
            if (shape->half[i] - fabs(x[i]) < least) {
                least = shape->half[i] - fabs(x[i]);
                best = i;
            }
        n[best] = copysign(1, x[best]);
        return least;
    }
    double rho = sqrt(x[0] * x[0] + x[1] * x[1]), up = shape->half[2] - fabs(x[2]), aside = shape->radius - rho;
    if (up <= aside) {
        n[2] = copysign(1, x[2]);
        return up;
    }
    n[0] = rho > 0 ? x[0] / rho : 1;
    n[1] = rho > 0 ? x[1] / rho : 0;
    return aside;
}

static void settle(const pinch_shape_pair *pair, const double *n_of_b, double overlap, pinch_contact_normal *found)
{
    pinch_pair_rotate(pair, n_of_b, found->normal);
    found->overlap = overlap;
}

static void point_on(const pinch_shape_pair *pair, const double *x, pinch_contact_normal *found)
{
    double e[3], n[3];
    beyond(pair->b, x, e);
    double distance = pinch_v3_norm(e);
    if (distance > touching_distance(pair)) {
        pinch_v3_scale(e, 1 / distance);
        settle(pair, e, -distance, found);
    } else {
        double overlap = way_out(pair->b, x, n);
        settle(pair, n, overlap, found);
    }
}

/* A segment x + t u beside a box or cylinder. The squared distance falls at `low` and rises at `high`. */
typedef struct bracket {
    const pinch_shape *shape;
    const double *x, *u;
    double low, high, slope_low, slope_high;
} bracket;

/* Returns half the derivative of the squared distance at x + t u, and in e the way from the nearest point to there. */
static double slope_at(const bracket *k, double t, double *e)
{
    const double *x = k->x, *u = k->u;
    const double at[3] = {x[0] + t * u[0], x[1] + t * u[1], x[2] + t * u[2]};
    beyond(k->shape, at, e);
    return pinch_v3_dot(u, e);
}

/* The slope along the segment consists of straight pieces, and where they meet is known. */
static void nearest_to_box(const bracket *k, double *e)
{
    const double *half = k->shape->half;
    double low = k->low, high = k->high, slope_low = k->slope_low, slope_high = k->slope_high;
    for (int side = 0; side < 6; side++) {
        int i = side / 2;
        double t = ((side % 2 ? half[i] : -half[i]) - k->x[i]) / k->u[i]; /* never in between if it is not finite */
        if (!(t > low && t < high)) continue;
        double slope = slope_at(k, t, e);
        if (slope < 0) {
            low = t;
            slope_low = slope;
        } else {
            high = t;
            slope_high = slope;
        }
    }
    double rise = slope_high - slope_low, part = rise > 0 ? -slope_low / rise : 0;
    (void)slope_at(k, low + part * (high - low), e);
}

/* Newton's method is kept between the bounds. The slope's derivative is 1 less what the curved side takes. */
static void nearest_to_cylinder(const bracket *k, double *e)
{
    enum { STEPS = 60 };
    const double *x = k->x, *u = k->u;
    double low = k->low, high = k->high, t = 0.5 * (low + high), length = high - low, radius = k->shape->radius;
    for (int n = 0; n < STEPS; n++) {
        double slope = slope_at(k, t, e), hessian = 0;
        const double at[3] = {x[0] + t * u[0], x[1] + t * u[1], x[2] + t * u[2]};
        if (e[0] != 0 || e[1] != 0) {
            double rho2 = at[0] * at[0] + at[1] * at[1], out = at[0] * u[0] + at[1] * u[1];
            double outward2 = out * out / rho2;
            hessian += outward2 + (1 - radius / sqrt(rho2)) * (u[0] * u[0] + u[1] * u[1] - outward2);
        }
        if (e[2] != 0) hessian += u[2] * u[2];
        if (slope == 0) return;
        if (slope < 0)
            low = t;
        else
            high = t;
        double step = -slope / hessian;
        bool last = fabs(step) < 1e-9 * length; /* the square of this step is left as an error */
        t = last || (t + step > low && t + step < high) ? t + step : 0.5 * (low + high);
        if (last) break;
    }
    (void)slope_at(k, t, e);
}

static bool segment_on(const pinch_shape_pair *pair, const double *x, pinch_contact_normal *found)
{
    double half = pair->a->half[2], e[3];
    bracket k = {
        .shape = pair->b, .x = x, .u = pair->R + 6, .low = -half, .high = half}; /* u is A's z axis in B's axes */
    k.slope_low = slope_at(&k, -half, e);
    if (k.slope_low < 0) {
        k.slope_high = slope_at(&k, half, e);
        if (k.slope_high > 0 && pair->b->kind == PINCH_SHAPE_BOX) nearest_to_box(&k, e);
        if (k.slope_high > 0 && pair->b->kind == PINCH_SHAPE_CYLINDER) nearest_to_cylinder(&k, e);
    }
    double distance = pinch_v3_norm(e);
    if (!(distance > touching_distance(pair))) return false;
    pinch_v3_scale(e, 1 / distance);
    settle(pair, e, -distance, found);
    return true;
}

static bool is_straight(pinch_shape_kind kind)
{
    return kind == PINCH_SHAPE_POINT || kind == PINCH_SHAPE_SEGMENT;
}

bool pinch_closed_form(const pinch_shape_pair *pair, pinch_contact_normal *found)
{
    double x[3], back[3] = {-pair->p[0], -pair->p[1], -pair->p[2]};
    pinch_shape_kind a = pair->a->kind, b = pair->b->kind;
    if (a == PINCH_SHAPE_POINT && b == PINCH_SHAPE_POINT) {
        double distance = pinch_v3_norm(back);
        if (distance > touching_distance(pair)) {
            found->overlap = -distance;
            for (int i = 0; i < 3; i++) found->normal[i] = back[i] / distance;
            return true;
        }
    }
    if (is_straight(a) && is_straight(b)) {
        two_segments(pair, found);
        return true;
    }
    if (b != PINCH_SHAPE_BOX && b != PINCH_SHAPE_CYLINDER) return false;
    if (!is_straight(a)) return false;
    pinch_pair_rotate_back(pair, back, x);
    if (a == PINCH_SHAPE_SEGMENT) return segment_on(pair, x, found);
    point_on(pair, x, found);
    return true;
}
