/*
 * At the minimum n the point of the bodies' difference farthest along n is p n. A rim of radius r whose tangent there
 * is t reaches along any m, at the angle T from n, by at least r (m.t)^2/2 beyond its own point, a side by at least e
 * (m.axis)^2 beyond a point e inside its ends. With m = n cos T + e sin T,
 *
 *     p(m) - p >= 2 sin(T/2)^2 (cos(T/2)^2 e.Be - p),  B = sum of r t t' + 2 e axis axis',
 *
 * so that nothing is less where cos(T/2)^2 >= p/b, b the lower eigenvalue of B. What is left is at larger angles from
 * n, where a ball in both bodies bounds the overlap (pinch_rest_is_deeper).
 */
#include "rim_certain.h"

#include "support/vec3.h"

/* The overlap changes by no more than this part of the size per radian: a minimum. */
static const double LEVEL = 1e-8;

static bool is_least(const pinch_core_pair *pair, const double B[3], const pinch_contact_normal *at)
{
    double half = 0.5 * (B[0] + B[2]), skew = 0.5 * (B[0] - B[2]), lowest = half - sqrt(skew * skew + B[1] * B[1]);
    double p = at->overlap;
    if (!(lowest > 0)) return false;
    if (p <= 0) return true;
    double part = p / lowest;
    return part < 1 && pinch_rest_is_deeper(pair, at->normal, p, 2 * part - 1, 2 * sqrt(part * (1 - part)));
}

/* A rim's unit tangent; false at its cap. */
static bool tangent(const double *axis, const double *n, double *t)
{
    pinch_v3_cross(axis, n, t);
    double length = pinch_v3_norm(t);
    if (!(length > 0)) return false;
    pinch_v3_scale(t, 1 / length);
    return true;
}

bool pinch_rims_are_level(const pinch_core_pair *pair, const pinch_contact_normal *at)
{
    double a[3], gradient[3], size = pair->a->bound < pair->b->bound ? pair->a->bound : pair->b->bound;
    pinch_pair_support_a(pair, at->normal, a);
    pinch_pair_support_b(pair, at->normal, gradient);
    pinch_v3_add_scaled(gradient, -1, a);
    pinch_v3_make_perpendicular(gradient, at->normal);
    return pinch_v3_norm(gradient) < LEVEL * size;
}

bool pinch_rims_are_least(const pinch_core_pair *pair, const pinch_contact_normal *at)
{
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]}, z[3] = {0, 0, 1};
    double ra = pair->a->radius, rb = pair->b->radius, s[3], t[3], across[3];
    if (!pinch_rims_are_level(pair, at) || !tangent(z, at->normal, s) || !tangent(w, at->normal, t)) return false;
    pinch_v3_cross(at->normal, s, across);
    double c = pinch_v3_dot(t, s), d = pinch_v3_dot(t, across);
    const double B[3] = {ra + rb * c * c, rb * c * d, rb * d * d};
    return is_least(pair, B, at);
}

bool pinch_side_and_rim_is_least(const pinch_core_pair *pair, int which, const pinch_contact_normal *at)
{
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]}, z[3] = {0, 0, 1};
    const double *axis = which ? w : z, *other = which ? z : w;
    const pinch_core *straight = which ? pair->b : pair->a, *rim = which ? pair->a : pair->b;
    double x[3], s[3], t[3];
    if (which) {
        pinch_pair_support_a(pair, at->normal, x);
        pinch_v3_add_scaled(x, -1, pair->p);
    } else {
        pinch_pair_support_b(pair, at->normal, x);
    }
    double height = pinch_v3_dot(axis, x), inside = straight->half[2] - fabs(height), beside[3];
    pinch_v3_copy(beside, x); /* the rim's point from the side's line nearest to it: where the overlap is level, none */
    pinch_v3_add_scaled(beside, -height, axis);
    pinch_v3_make_perpendicular(beside, at->normal);
    if (!(pinch_v3_norm(beside) < LEVEL * (pair->a->bound < pair->b->bound ? pair->a->bound : pair->b->bound)))
        return false;
    if (!(inside > 0) || !tangent(other, at->normal, t)) return false;
    pinch_v3_cross(axis, at->normal, s);
    double c = pinch_v3_dot(t, s), d = pinch_v3_dot(t, axis), r = rim->radius;
    const double B[3] = {straight->radius + r * c * c, r * c * d, 2 * inside + r * d * d};
    return is_least(pair, B, at);
}
