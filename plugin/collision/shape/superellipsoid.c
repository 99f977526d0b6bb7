#include "superellipsoid.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/*
 * The superellipsoid is the unit ball of a norm that nests two p-norms. Its support function is the dual norm, h(d) =
 * ((|a x|^q2 + |b y|^q2)^(q1/q2) + |c z|^q1)^(1/q1), and its support point is the gradient of that.
 */
typedef struct dual_norm {
    double value, d[2]; /* N(u, v) = (u^q + v^q)^(1/q) for u, v >= 0, and its gradient */
    double d11, d12, d22;
} dual_norm;

/*
 * Let t = least/most, s = t^q and S = (1 + s)^(1/q). Then N = S most, and the derivatives are powers of what is known
 * already, because S^(q-1) is (1 + s)/S. At t = 0 with q < 2 the second derivative is infinite: the surface is flat
 * there. It is replaced by the largest value that a double can be divided by.
 */
static dual_norm dual_norm_at(double u, double v, double q, bool hessian)
{
    static const double SMALL = 1e-100;
    dual_norm n;
    memset(&n, 0, sizeof n);
    int most = u < v;
    double large = most ? v : u, t = most ? u : v;
    if (!(large > 0)) return n;
    t /= large;
    double s = pow(t, q), S = pow(1 + s, 1 / q), first = S / (1 + s);
    n.value = large * S;
    n.d[most] = first;
    n.d[!most] = t > 0 ? s / t * first : 0;
    if (!hessian) return n;
    double scale = (q - 1) / n.value * first * first, along = scale * s;
    if (t < SMALL) {
        t = SMALL;
        s = pow(t, q);
    }
    double across = scale * (s / t) / t;
    n.d11 = most ? across : along;
    n.d22 = most ? along : across;
    n.d12 = -(q - 1) / n.value * n.d[0] * n.d[1];
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
    dual_norm across = dual_norm_at(u[0], u[1], power[1], H != NULL);
    dual_norm all = dual_norm_at(across.value, u[2], power[0], H != NULL);
    double g[3] = {across.d[0] * half[0] * sign[0], across.d[1] * half[1] * sign[1], 0};
    double z[3] = {0, 0, half[2] * sign[2]};
    *value = all.value;
    if (point)
        for (int i = 0; i < 3; i++) point[i] = all.d[0] * g[i] + all.d[1] * z[i];
    if (!H) return;
    double x = half[0] * sign[0], y = half[1] * sign[1];
    H[0] += all.d[0] * across.d11 * x * x;
    H[4] += all.d[0] * across.d22 * y * y;
    H[1] += all.d[0] * across.d12 * x * y;
    H[3] += all.d[0] * across.d12 * x * y;
    for (int i = 0; i < 9; i++) {
        int r = i / 3, c = i % 3;
        H[i] += all.d11 * g[r] * g[c] + all.d12 * (g[r] * z[c] + z[r] * g[c]) + all.d22 * z[r] * z[c];
    }
}

/* The dual of a dual norm has the same form with conjugate exponents, 1/p + 1/q = 1. */
double pinch_superellipsoid_norm(const double half[3], const double power[2], const double x[3], double *gradient)
{
    double inverse[3], conjugate[2], value;
    for (int i = 0; i < 3; i++) inverse[i] = 1 / half[i];
    for (int i = 0; i < 2; i++) conjugate[i] = power[i] / (power[i] - 1);
    pinch_superellipsoid_at(inverse, conjugate, x, &value, gradient, NULL);
    return value;
}
