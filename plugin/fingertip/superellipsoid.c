#include "superellipsoid.h"

#include <math.h>
#include <string.h>

/*
 * The superellipsoid is the unit ball of a norm that nests two p-norms; its support function is the dual norm,
 * h(d) = ((|a x|^q2 + |b y|^q2)^(q1/q2) + |c z|^q1)^(1/q1), and its support point the gradient.
 */
typedef struct dual_norm {
    double value, d1, d2; /* of N(u, v) = (u^q + v^q)^(1/q), u, v >= 0 */
    double d11, d12, d22;
} dual_norm;

static dual_norm dual_norm_at(double u, double v, double q)
{
    dual_norm n;
    memset(&n, 0, sizeof n);
    double scale = fmax(u, v);
    if (!(scale > 0)) return n;
    u /= scale;
    v /= scale;
    n.value = pow(pow(u, q) + pow(v, q), 1 / q);
    u /= n.value; /* now u^q + v^q = 1 */
    v /= n.value;
    n.value *= scale;
    n.d1 = pow(u, q - 1);
    n.d2 = pow(v, q - 1);
    /* d1 = u^(q-1) at norm 1; its derivatives are of degree -1. At u or v = 0 with q < 2 they are infinite: a flat
     * spot, bent as far as a double can be divided by. */
    double small = 1e-100, uu = pow(fmax(u, small), q - 2), vv = pow(fmax(v, small), q - 2);
    n.d11 = (q - 1) / n.value * uu * pow(v, q);
    n.d22 = (q - 1) / n.value * vv * pow(u, q);
    n.d12 = -(q - 1) / n.value * n.d1 * n.d2;
    return n;
}

void pinch_superellipsoid_at(const double half[3], const double power[2], const double d[3], double *value,
                             double *point, double *H)
{
    double u[3], sign[3];
    for (int i = 0; i < 3; i++) {
        u[i] = half[i] * fabs(d[i]);
        sign[i] = d[i] < 0 ? -1 : 1;
    }
    dual_norm across = dual_norm_at(u[0], u[1], power[1]);
    dual_norm all = dual_norm_at(across.value, u[2], power[0]);
    double g[3] = {across.d1 * half[0] * sign[0], across.d2 * half[1] * sign[1], 0};
    double z[3] = {0, 0, half[2] * sign[2]};
    *value = all.value;
    if (point)
        for (int i = 0; i < 3; i++) point[i] = all.d1 * g[i] + all.d2 * z[i];
    if (!H) return;
    double x = half[0] * sign[0], y = half[1] * sign[1];
    H[0] += all.d1 * across.d11 * x * x;
    H[4] += all.d1 * across.d22 * y * y;
    H[1] += all.d1 * across.d12 * x * y;
    H[3] += all.d1 * across.d12 * x * y;
    for (int i = 0; i < 9; i++) {
        int r = i / 3, c = i % 3;
        H[i] += all.d11 * g[r] * g[c] + all.d12 * (g[r] * z[c] + z[r] * g[c]) + all.d22 * z[r] * z[c];
    }
}
