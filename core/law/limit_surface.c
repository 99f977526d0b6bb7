#include "law/limit_surface.h"

#include <math.h>
#include <string.h>

/* The disc |r_t| <= a with equal stiffness along both tangents: the closest point is radial, r = a s/|s|. */
static bool project_onto_disc(double a, const double s[3], double r[3], double dr_ds[9], double dr_dscale[3])
{
    double length2 = s[0] * s[0] + s[1] * s[1];
    bool inside = length2 <= a * a;
    double length = inside ? 1.0 : sqrt(length2);
    double factor = inside ? 1.0 : a / length;
    r[0] = factor * s[0];
    r[1] = factor * s[1];
    r[2] = 0.0;
    if (dr_ds) {
        double e0 = inside ? 0.0 : s[0] / length, e1 = inside ? 0.0 : s[1] / length;
        memset(dr_ds, 0, 9 * sizeof *dr_ds);
        dr_ds[0] = factor * (1.0 - e0 * e0);
        dr_ds[1] = dr_ds[3] = -factor * e0 * e1;
        dr_ds[4] = factor * (1.0 - e1 * e1);
    }
    if (dr_dscale) {
        dr_dscale[0] = inside ? 0.0 : r[0];
        dr_dscale[1] = inside ? 0.0 : r[1];
        dr_dscale[2] = 0.0;
    }
    return inside;
}

/*
 * With c_i = stiffness_i / axis_i^2 the closest point is r_i = s_i / (1 + lambda c_i), where lambda > 0 puts it on the
 * surface. In units that keep nearly vanishing axes from overflowing, y_i = (s_i / axis_i) q with q = 1 / max |s_i /
 * axis_i|, c_i relative to the largest c, and t = lambda q, it solves
 *
 *     phi(t) = sum_i y_i^2 / (q + t c_i)^2 = 1.
 *
 * 1/sqrt(phi) is concave and increases, so Newton's method on 1/sqrt(phi) = 1 climbs to the root from any point left of
 * it without overshooting, and it is exact at once when all c_i are equal. Left of the root are all (|y_i| - q)/c_i,
 * what one axis alone would need: the largest of them is the start.
 */
static double secular_root(const double y[3], const double c[3], double q)
{
    double t = 0.0;
    for (int i = 0; i < 3; i++)
        if (c[i] > 0.0) t = fmax(t, (fabs(y[i]) - q) / c[i]);
    for (int iteration = 0; iteration < 50; iteration++) {
        double phi = 0.0, slope = 0.0; /* slope = -phi'/2 */
        for (int i = 0; i < 3; i++) {
            double m = 1.0 / (q + t * c[i]);
            double term = y[i] * y[i] * m * m;
            phi += term;
            slope += term * m * c[i];
        }
        double step = phi * (sqrt(phi) - 1.0) / slope; /* (1 - 1/sqrt(phi)) / (slope / phi^(3/2)) */
        double next = t + step;
        if (!(next > t)) break;
        t = next;
        if (step <= 1e-16 * t) break;
    }
    return t;
}

/*
 * Differentiating r_i = m_i s_i, m_i = 1/(1 + lambda c_i) = q/(q + t c_i), along the surface sum (r_i/axis_i)^2 = 1:
 *
 *     dr = m ds - h (g . ds) / D       h_i = r_i c_i m_i,  g_i = r_i m_i / axis_i^2,  D = sum_i h_i r_i / axis_i^2
 *     dr/dscale = h / D                (c_i falls with the square of the scale; lambda absorbs that common factor)
 */
static void differentiate(const double axis[3], const double c[3], const double m[3], const double r[3],
                          double dr_ds[9], double dr_dscale[3])
{
    double h[3], g[3], d = 0.0;
    for (int i = 0; i < 3; i++) {
        /* in units of the axes, so that short ones do no harm */
        double unit = axis[i] > 0.0 && axis[i] < INFINITY ? r[i] / axis[i] : 0.0;
        h[i] = r[i] * c[i] * m[i];
        g[i] = unit == 0.0 ? 0.0 : unit * m[i] / axis[i];
        d += unit * unit * c[i] * m[i];
    }
    for (int i = 0; i < 3; i++) {
        if (dr_dscale) dr_dscale[i] = h[i] / d;
        if (!dr_ds) continue;
        for (int j = 0; j < 3; j++) dr_ds[3 * i + j] = (i == j ? m[i] : 0.0) - h[i] * g[j] / d;
    }
}

static bool project_onto_ellipsoid(const double axis[3], const double stiffness[3], const double s[3], double r[3],
                                   double dr_ds[9], double dr_dscale[3])
{
    double y[3], c[3], y_max = 0.0, c_max = 0.0, a_min = INFINITY;
    for (int i = 0; i < 3; i++)
        if (axis[i] > 0.0) a_min = fmin(a_min, axis[i]);
    for (int i = 0; i < 3; i++) {
        double relative = axis[i] > 0.0 ? a_min / axis[i] : 0.0; /* 0 for an infinite axis, too */
        if (!isfinite(relative)) relative = 0.0;
        y[i] = axis[i] > 0.0 ? s[i] / axis[i] : 0.0;
        c[i] = stiffness[i] * relative * relative;
        y_max = fmax(y_max, fabs(y[i]));
        c_max = fmax(c_max, c[i]);
    }
    double m[3] = {axis[0] > 0.0, axis[1] > 0.0, axis[2] > 0.0};
    bool inside = y[0] * y[0] + y[1] * y[1] + y[2] * y[2] <= 1.0;
    if (!inside) {
        double q = 1.0 / y_max;
        for (int i = 0; i < 3; i++) {
            y[i] *= q;
            c[i] /= c_max;
        }
        double t = secular_root(y, c, q);
        for (int i = 0; i < 3; i++) m[i] *= q / (q + t * c[i]);
    }
    for (int i = 0; i < 3; i++) r[i] = m[i] == 0.0 ? 0.0 : m[i] * s[i];
    if (!inside) {
        differentiate(axis, c, m, r, dr_ds, dr_dscale);
        return false;
    }
    if (dr_ds)
        for (int i = 0; i < 9; i++) dr_ds[i] = i % 4 == 0 ? m[i / 4] : 0.0;
    if (dr_dscale) memset(dr_dscale, 0, 3 * sizeof *dr_dscale);
    /* a load on an axis that carries nothing slips */
    for (int i = 0; i < 3; i++) inside = inside && (axis[i] > 0.0 || s[i] == 0.0);
    return inside;
}

bool pinch_limit_surface_project(const double axis[3], const double stiffness[3], const double s[3], double r[3],
                                 double dr_ds[9], double dr_dscale[3])
{
    if (axis[2] == 0.0 && axis[0] == axis[1] && stiffness[0] == stiffness[1]) {
        bool inside = project_onto_disc(axis[0], s, r, dr_ds, dr_dscale);
        return inside && s[2] == 0.0;
    }
    return project_onto_ellipsoid(axis, stiffness, s, r, dr_ds, dr_dscale);
}
