#include "side_and_rim.h"

#include "rim_line.h"
#include "support/vec3.h"

static const double PARALLEL = 1e-8; /* axes, sine */

bool pinch_across_of(const double axis[3], const double w[3], const double P[3], pinch_across *across)
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

bool pinch_side_and_rim(const pinch_across *k, const pinch_core *body, int rim, double n[3], double *overlap)
{
    double X = rim * k->X + body->half[2] * k->sine, Y = rim * k->Y, Q2 = k->sine * k->sine, c, s;
    if (!pinch_rim_least(X, Y, body->radius, k->m, Q2, &c, &s)) return false;
    *overlap = X * c + Y * s + body->radius * sqrt(k->m + Q2 * s * s);
    for (int i = 0; i < 3; i++) n[i] = rim * (c * k->x[i] + s * k->y[i]);
    return true;
}
