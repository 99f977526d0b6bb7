#include "rim_arc.h"

#include <math.h>

/*
 * Seen along the line the disc is an ellipse of semi-axes r and b = r sqrt(m), and a minimum is a normal of the ellipse
 * through one point. Mirrored so that Y <= 0 the minimum has s >= 0: for s < 0, f is more than at the mirrored place.
 * With u = c/s, x = X/r and y = -Y/r,
 *
 *     df/dphi = r s g(u),  g(u) = Q2 u/sqrt(1 + m u^2) - y u - x,  u falls as phi grows.
 *
 * g is concave: it has two roots at most, and a minimum of f, where df/dphi turns positive, is the larger one. To the
 * right of that g < 0 falls, and Newton's method comes down to the root without passing it; it starts where the bounds
 * Q2/sqrt(m) or Q2 u for the first term have theirs. Where there is no root it ends up where g rises.
 */
bool pinch_rim_least(double X, double Y, double r, double m, double Q2, double *c, double *s)
{
    enum { STEPS = 60 };
    static const double SETTLED = 1e-9, OF_U = 1e-5, FLAT = 1e12;
    double x = X / r, y = fabs(Y) / r, sign = Y > 0 ? -1 : 1, most = Q2 / sqrt(m) - x; /* m = 0: infinite */
    if (!(most > 0)) return false;
    double u = most / y;
    if (y >= Q2) {
        if (!(x < 0)) return false;
        u = fmin(u, -x / (y - Q2));
    }
    if (!(u < FLAT)) { /* along the ellipse's short axis; m = 0: the disc's own normal, a face */
        *c = 1;
        *s = 0;
        return m > 0;
    }
    for (int k = 0; k < STEPS; k++) {
        double w = 1 + m * u * u, over = Q2 / sqrt(w), g = over * u - y * u - x, slope = over / w - y;
        if (!(slope < 0)) return false;
        double step = g / slope;
        u -= step;
        if (!(u >= 0)) return false;
        /* its square is left of the angle, and of u, whose scale is 1/sqrt(m) where the disc is seen edge on */
        if (fabs(step) <= SETTLED * (1 + u * u) && fabs(step) <= OF_U * (1 + u)) break;
    }
    *s = 1 / sqrt(1 + u * u);
    *c = u * *s;
    *s *= sign;
    return true;
}
