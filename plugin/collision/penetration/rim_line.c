#include "rim_line.h"

#include "support/vec3.h"

#include <math.h>

/*
 * Seen along the line the disc is an ellipse of semi-axes r and b = r sqrt(m), and a minimum is a normal of the ellipse
 * through one point. Everything is mirrored so that Y <= 0. Then the minimum has s >= 0, because for s < 0 f is more
 * than at the mirrored place. With u = c/s, x = X/r and y = -Y/r,
 *
 *     df/dphi = r s g(u),  g(u) = Q2 u/sqrt(1 + m u^2) - y u - x,  and u falls as phi grows.
 *
 * g is concave, so it has two roots at most. A minimum of f, where df/dphi turns positive, is the larger one. To the
 * right of it g < 0 falls, and Newton's method comes down to the root without passing it. It starts at the root of a
 * bound: Q2/sqrt(m) and Q2 u bound the first term of g. Where there is no root it ends where g rises.
 */
typedef struct curve {
    double x, y, m, Q2;
} curve;

/* Returns g and finds its slope. */
static double value_at(const curve *k, double u, double *slope)
{
    double w = 1 + k->m * u * u, over = k->Q2 / sqrt(w);
    *slope = over / w - k->y;
    return over * u - k->y * u - k->x;
}

bool pinch_rim_least(double X, double Y, double r, double m, double Q2, double *c, double *s)
{
    enum { STEPS = 60 };
    static const double SETTLED = 1e-9, OF_U = 1e-5, FLAT = 1e12;
    const curve k = {X / r, fabs(Y) / r, m, Q2};
    double sign = Y > 0 ? -1 : 1, most = Q2 / sqrt(m) - k.x; /* infinite for m = 0 */
    if (!(most > 0)) return false;
    double u = most / k.y;
    if (k.y >= Q2) {
        if (!(k.x < 0)) return false;
        u = fmin(u, -k.x / (k.y - Q2));
    }
    if (!(u < FLAT)) { /* along the ellipse's short axis; for m = 0 that is the disc's own normal, a face */
        *c = 1;
        *s = 0;
        return m > 0;
    }
    for (int n = 0; n < STEPS; n++) {
        double slope, g = value_at(&k, u, &slope);
        if (!(slope < 0)) return false;
        double step = g / slope;
        u -= step;
        if (!(u >= 0)) return false;
        /* the step's square is left as an error of the angle, and of u, whose scale is 1/sqrt(m) for a disc seen edge
         * on */
        if (fabs(step) <= SETTLED * (1 + u * u) && fabs(step) <= OF_U * (1 + u)) break;
    }
    *s = 1 / sqrt(1 + u * u);
    *c = u * *s;
    *s *= sign;
    return true;
}

/*
 * Along the mirrored arc phi grows from its first end to its last. The minimum is at the larger root of g. An end lies
 * beyond it where g has risen, or rises again to the left of its top. An end lies before it where g is still below and
 * c > 0. In the other half, g is convex and tells nothing.
 */
bool pinch_rim_least_is_off(double X, double Y, double r, double m, double Q2, const double ends[2][2])
{
    static const double LEVEL = 1e-3, ROUNDING = 1e-6;
    const curve k = {X / r, fabs(Y) / r, m, Q2};
    double sign = Y > 0 ? -1 : 1;
    int first = sign * (ends[0][0] * ends[1][1] - ends[0][1] * ends[1][0]) < 0;
    bool off = false;
    for (int end = 0; end < 2; end++) {
        double c = ends[end][0], s = sign * ends[end][1], slope;
        if (!(s > LEVEL)) continue; /* it is mirrored, or u is too large to be told from rounding */
        double u = c / s, g = value_at(&k, u, &slope), slack = ROUNDING * (1 + fabs(u));
        off = off || (end == first ? g > slack || slope > slack : c > 0 && g < -slack && slope < -slack);
    }
    return off;
}

static const double PARALLEL = 1e-8; /* sine of the angle between the axes */

bool pinch_rim_line_of(const double axis[3], const double w[3], const double P[3], pinch_rim_line *across)
{
    double cosine = pinch_v3_dot(axis, w), *x = across->x, *y = across->y;
    pinch_v3_cross(axis, w, y);
    double sine = pinch_v3_norm(y);
    if (!(sine > PARALLEL)) return false;
    pinch_v3_scale(y, 1 / sine);
    pinch_v3_cross(y, axis, x);
    across->X = pinch_v3_dot(x, P);
    across->Y = pinch_v3_dot(y, P);
    across->sine = sine;
    across->m = cosine * cosine;
    return true;
}

bool pinch_rim_line_normal(const pinch_rim_line *k, const pinch_shape *body, int rim, double n[3], double *overlap)
{
    double X = rim * k->X + body->half[2] * k->sine, Y = rim * k->Y, Q2 = k->sine * k->sine, c, s;
    if (!pinch_rim_least(X, Y, body->radius, k->m, Q2, &c, &s)) return false;
    *overlap = X * c + Y * s + body->radius * sqrt(k->m + Q2 * s * s);
    for (int i = 0; i < 3; i++) n[i] = rim * (c * k->x[i] + s * k->y[i]);
    return true;
}
