/* Projects onto the friction cone: onto its cross section at one normal force, and onto the whole cone. */
#include "law/friction_cone.h"

#include <math.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

/* With equal stiffness along both tangents the closest point of the disc |r_t| <= a is radial: r = a s/|s|. */
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

/* An axis that is nothing beside the longest one has length zero: the square of their ratio must not vanish, as an axis
 * whose c is 0 would have no limit. */
static void drop_negligible_axes(const double given[3], double axis[3])
{
    static const double NEGLIGIBLE = 1e-100;
    double longest = 0.0;
    for (int i = 0; i < 3; i++)
        if (given[i] < INFINITY) longest = fmax(longest, given[i]);
    for (int i = 0; i < 3; i++) axis[i] = given[i] < NEGLIGIBLE * longest ? 0.0 : given[i];
}

static bool project_onto_ellipsoid(const double given[3], const double stiffness[3], const double s[3], double r[3],
                                   double dr_ds[9], double dr_dscale[3])
{
    double axis[3], y[3], c[3], y_max = 0.0, c_max = 0.0, a_min = INFINITY;
    drop_negligible_axes(given, axis);
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

static void stay_inside(const double s[2], double r[2], double dr_ds[4], double dr_dscale[2])
{
    r[0] = s[0];
    r[1] = s[1];
    if (dr_dscale) dr_dscale[0] = dr_dscale[1] = 0.0;
    if (dr_ds) {
        dr_ds[0] = dr_ds[3] = 1.0;
        dr_ds[1] = dr_ds[2] = 0.0;
    }
}

/*
 * In the sector of facet k, with coordinates a along its normal n and b along it, s has |b| <= a tan(pi/faces), and by
 * symmetry its closest point lies in the same sector: inside when a <= apothem, else on the facet at b clamped to the
 * corners +-apothem tan(pi/faces).
 */
bool pinch_limit_polygon_project(int faces, double apothem, const double s[2], double r[2], double dr_ds[4],
                                 double dr_dscale[2])
{
    /* within the inscribed circle no facet is reached, whichever is nearest */
    if (s[0] * s[0] + s[1] * s[1] <= apothem * apothem) {
        stay_inside(s, r, dr_ds, dr_dscale);
        return true;
    }
    double sector = 2.0 * PI / faces;
    double angle = sector * round(atan2(s[1], s[0]) / sector);
    double n[2] = {cos(angle), sin(angle)}, t[2] = {-n[1], n[0]};
    double a = s[0] * n[0] + s[1] * n[1], b = s[0] * t[0] + s[1] * t[1];
    bool inside = a <= apothem;
    double half_edge = faces > 2 ? tan(0.5 * sector) : INFINITY;
    /* 0 * INFINITY must not appear for the strip of zero width */
    bool on_facet = faces == 2 || fabs(b) <= apothem * half_edge;
    double corner = b < 0.0 ? -half_edge : half_edge;
    double c = on_facet ? b : apothem * corner;
    for (int i = 0; i < 2; i++) {
        r[i] = inside ? s[i] : apothem * n[i] + c * t[i];
        if (dr_dscale) dr_dscale[i] = inside ? 0.0 : apothem * (n[i] + (on_facet ? 0.0 : corner * t[i]));
        for (int j = 0; dr_ds && j < 2; j++)
            dr_ds[2 * i + j] = inside ? (i == j ? 1.0 : 0.0) : on_facet ? t[i] * t[j] : 0.0;
    }
    return inside;
}

/* At a prescribed y_0 the closest point is that of the ball of radius y_0. */
static void project_onto_ball(double radius, const double x[4], double y[4], double d[16])
{
    double length = sqrt(x[1] * x[1] + x[2] * x[2] + x[3] * x[3]);
    bool inside = length <= radius;
    y[0] = radius;
    for (int i = 1; i < 4; i++) {
        y[i] = inside ? x[i] : radius / length * x[i];
        for (int j = 1; j < 4; j++) {
            double unit = i == j ? 1.0 : 0.0;
            d[4 * i + j] = inside ? unit : radius / length * (unit - x[i] / length * (x[j] / length));
        }
    }
}

/* The closest point of the second-order cone is the point itself, the apex, or half way between the axis and the
 * mantle's normal. */
static void project_onto_round_cone(double low, double high, const double x[4], double y[4], double d[16])
{
    double length = sqrt(x[1] * x[1] + x[2] * x[2] + x[3] * x[3]);
    double height = length <= x[0] ? x[0] : length <= -x[0] ? 0.0 : 0.5 * (x[0] + length);
    if (height <= low || height >= high) {
        project_onto_ball(fmin(fmax(height, low), high), x, y, d);
        return;
    }
    if (length <= x[0]) {
        memcpy(y, x, 4 * sizeof *y);
        for (int i = 0; i < 4; i++) d[5 * i] = 1.0;
        return;
    }
    double e[4] = {1.0, x[1] / length, x[2] / length, x[3] / length};
    for (int i = 0; i < 4; i++) y[i] = height * e[i];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            double bend = i > 0 && j > 0 ? height / length * ((i == j ? 1.0 : 0.0) - e[i] * e[j]) : 0.0;
            d[4 * i + j] = 0.5 * e[i] * e[j] + bend;
        }
}

/*
 * In the sector of the nearest facet, with a along its normal and b along it, the closest point obeys
 * a <= y_0, |b| <= T y_0 (T = tan(pi/faces)), |x_3| <= y_0, each exceeded by c_j-fold y_0: c = (1, T, 1). y_0 solves
 *
 *     y_0 - x_0 = sum over exceeded j of c_j (v_j - c_j y_0),   v = (a, |b|, |x_3|),
 *
 * whose right-hand side falls as y_0 grows; the limits are exceeded in the order of v_j/c_j.
 */
static void project_onto_prism_cone(int faces, double low, double high, const double x[4], double y[4], double d[16])
{
    double sector = 2.0 * PI / faces, angle = sector * round(atan2(x[2], x[1]) / sector);
    double n[2] = {cos(angle), sin(angle)};
    double a = x[1] * n[0] + x[2] * n[1], b = x[2] * n[0] - x[1] * n[1];
    double c[3] = {1.0, faces > 2 ? tan(0.5 * sector) : 0.0, 1.0};
    double v[3] = {a, fabs(b), fabs(x[3])}, sign[3] = {1.0, copysign(1.0, b), copysign(1.0, x[3])};
    double at[3];
    for (int j = 0; j < 3; j++) at[j] = c[j] > 0.0 ? v[j] / c[j] : -INFINITY; /* a strip has no corners */

    bool exceeded[3] = {false, false, false};
    double sum = x[0], weight = 1.0, height = x[0];
    for (;;) {
        int next = -1;
        for (int j = 0; j < 3; j++)
            if (!exceeded[j] && at[j] > height && (next < 0 || at[j] > at[next])) next = j;
        if (next < 0) break;
        exceeded[next] = true;
        sum += c[next] * v[next];
        weight += c[next] * c[next];
        height = sum / weight;
    }
    bool free = height > low && height < high;
    height = fmin(fmax(height, low), high);
    for (int j = 0; j < 3; j++) exceeded[j] = at[j] > height;

    /* in the sector's axes: e spans the normal force and what moves with it */
    double e[4] = {1.0, 0.0, 0.0, 0.0}, local[4] = {height, a, b, x[3]}, ld[16] = {0};
    for (int j = 0; j < 3; j++) {
        if (exceeded[j]) {
            e[j + 1] = sign[j] * c[j];
            local[j + 1] = e[j + 1] * height;
        } else {
            ld[5 * (j + 1)] = 1.0;
        }
    }
    for (int i = 0; free && i < 4; i++)
        for (int j = 0; j < 4; j++) ld[4 * i + j] += e[i] * e[j] / weight;

    const double turn[16] = {1, 0, 0, 0, 0, n[0], -n[1], 0, 0, n[1], n[0], 0, 0, 0, 0, 1};
    for (int i = 0; i < 4; i++) {
        y[i] = 0.0;
        for (int k = 0; k < 4; k++) {
            y[i] += turn[4 * i + k] * local[k];
            for (int l = 0; l < 4; l++)
                for (int j = 0; j < 4; j++) d[4 * i + j] += turn[4 * i + k] * ld[4 * k + l] * turn[4 * j + l];
        }
    }
}

void pinch_friction_cone_project(int faces, double low, double high, const double x[4], double y[4], double dy_dx[16])
{
    memset(dy_dx, 0, 16 * sizeof *dy_dx);
    if (faces == 0)
        project_onto_round_cone(low, high, x, y, dy_dx);
    else
        project_onto_prism_cone(faces, low, high, x, y, dy_dx);
}
