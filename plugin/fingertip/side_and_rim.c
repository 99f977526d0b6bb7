#include "side_and_rim.h"

#include "rim_arc.h"
#include "support/vec3.h"

static const double PARALLEL = 1e-8; /* axes, sine */

bool pinch_side_and_rim(const double P[3], const double axis[3], const pinch_core *other, const double w[3], int rim,
                        double n[3], double *overlap)
{
    double x[3], y[3], along = pinch_v3_dot(axis, w), c, s;
    pinch_v3_cross(axis, w, y);
    double sine = pinch_v3_norm(y);
    if (!(sine > PARALLEL)) return false;
    pinch_v3_scale(y, rim / sine);
    pinch_v3_cross(y, axis, x); /* the other's axis, made perpendicular to this one, towards the rim */
    double X = pinch_v3_dot(x, P) + other->half[2] * sine, Y = pinch_v3_dot(y, P), m = along * along, Q2 = sine * sine;
    if (!pinch_rim_least(X, Y, other->radius, m, Q2, &c, &s)) return false;
    *overlap = X * c + Y * s + other->radius * sqrt(m + Q2 * s * s);
    for (int i = 0; i < 3; i++) n[i] = c * x[i] + s * y[i];
    return true;
}
