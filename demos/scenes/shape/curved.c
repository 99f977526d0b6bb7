/* Flat capsules and superellipsoids. */

#include "common/vector.h"
#include "shape.h"

/* The body is a cylinder of volume pi r^2 l with a half ball on it, whose own centre is 3 r/8 above its flat side. */
double scene_flat_capsule_middle(const scene_shape *shape)
{
    double r = shape->u.flat_capsule.radius, l = shape->u.flat_capsule.length, dome = 2.0 / 3.0 * r;
    return -dome * (0.5 * l + 0.375 * r) / (l + dome);
}

static double low_end(const scene_shape *shape)
{
    return scene_flat_capsule_middle(shape) - 0.5 * shape->u.flat_capsule.length;
}

static double dome_centre(const scene_shape *shape)
{
    return scene_flat_capsule_middle(shape) + 0.5 * shape->u.flat_capsule.length;
}

double scene_flat_capsule_radius(const scene_shape *shape)
{
    double r = shape->u.flat_capsule.radius;
    return fmax(dome_centre(shape) + r, hypot(r, low_end(shape)));
}

double scene_flat_capsule_distance(const scene_shape *shape, const double p[3])
{
    double r = shape->u.flat_capsule.radius, rho = hypot(p[0], p[1]), over = p[2] - dome_centre(shape);
    double side = over > 0.0 ? hypot(rho, over) - r : rho - r, below = low_end(shape) - p[2];
    return side > 0.0 && below > 0.0 ? hypot(side, below) : fmax(side, below);
}

bool scene_flat_capsule_points_in(const scene_shape *shape, const double p[3], const double d[3], double tolerance)
{
    double side[3] = {p[0], p[1], fmax(p[2] - dome_centre(shape), 0.0)};
    bool on_side = scene_norm(side) > shape->u.flat_capsule.radius - tolerance;
    bool on_end = p[2] < low_end(shape) + tolerance;
    return (on_side && scene_points_inward(side, d)) || (on_end && scene_points_inward((double[3]){0.0, 0.0, -1.0}, d));
}

void scene_flat_capsule_support(const scene_shape *shape, const double d[3], double middle[3])
{
    double r = shape->u.flat_capsule.radius, radial = hypot(d[0], d[1]);
    double across = d[2] > SCENE_SUPPORT_TIE ? r : radial > SCENE_SUPPORT_TIE ? r / radial : 0.0;
    middle[0] = across * d[0];
    middle[1] = across * d[1];
    if (d[2] > SCENE_SUPPORT_TIE)
        middle[2] = dome_centre(shape) + r * d[2];
    else
        middle[2] = d[2] < -SCENE_SUPPORT_TIE ? low_end(shape) : scene_flat_capsule_middle(shape);
}

/*
 * The superellipsoid is the unit ball of N(x) = (g^p + |z/c|^p)^(1/p), g = (|x/a|^q + |y/b|^q)^(1/q), p = 2/e_0,
 * q = 2/e_1. Its support function is the dual norm, of the same form with 1/p + 1/p' = 1 and the axes a, b, c times
 * the direction: the support point is its gradient.
 */
static double power_norm(double x, double y, double power)
{
    double scale = fmax(x, y);
    return scale > 0.0 ? scale * pow(pow(x / scale, power) + pow(y / scale, power), 1.0 / power) : 0.0;
}

/* `u` holds scaled |coordinates|; the gradient is with respect to u. */
static double nested_norm(const double u[3], double p, double q, double gradient[3])
{
    double g = power_norm(u[0], u[1], q), all = power_norm(g, u[2], p);
    double over = all > 0.0 ? pow(g / all, p - 1.0) : 0.0;
    for (int i = 0; i < 2; i++) gradient[i] = g > 0.0 ? over * pow(u[i] / g, q - 1.0) : 0.0;
    gradient[2] = all > 0.0 ? pow(u[2] / all, p - 1.0) : 0.0;
    return all;
}

void scene_superellipsoid_normal(const scene_shape *shape, const double point[3], double normal[3])
{
    const double *r = shape->u.superellipsoid.radii, *e = shape->u.superellipsoid.exponents;
    double u[3], shortest = fmin(r[0], fmin(r[1], r[2]));
    for (int i = 0; i < 3; i++) u[i] = fabs(point[i]) / r[i];
    (void)nested_norm(u, 2.0 / e[0], 2.0 / e[1], normal);
    for (int i = 0; i < 3; i++) normal[i] = copysign(normal[i] * shortest / r[i], point[i]);
}

void scene_superellipsoid_support(const scene_shape *shape, const double d[3], double middle[3])
{
    const double *r = shape->u.superellipsoid.radii, *e = shape->u.superellipsoid.exponents;
    double u[3];
    for (int i = 0; i < 3; i++) u[i] = r[i] * fabs(d[i]);
    (void)nested_norm(u, 2.0 / (2.0 - e[0]), 2.0 / (2.0 - e[1]), middle);
    for (int i = 0; i < 3; i++) middle[i] = copysign(middle[i] * r[i], d[i]);
}

/* The distance of the farthest point of |x/a|^p + |y/b|^p = 1 from the origin. For p <= 2 it is at the end of an axis,
 * otherwise it is the norm of (a, b) of the power 2 p/(p - 2), by Hoelder's inequality. */
static double farthest(double a, double b, double p)
{
    return p <= 2.0 ? fmax(a, b) : power_norm(a, b, 2.0 * p / (p - 2.0));
}

double scene_superellipsoid_radius(const scene_shape *shape)
{
    const double *r = shape->u.superellipsoid.radii, *e = shape->u.superellipsoid.exponents;
    return farthest(farthest(r[0], r[1], 2.0 / e[1]), r[2], 2.0 / e[0]);
}

/* How far the point is beyond the tangent plane of normal n. */
static double beyond_plane(const scene_shape *shape, const double n[3], const double p[3])
{
    double support[3];
    scene_superellipsoid_support(shape, n, support);
    return scene_dot(n, p) - scene_dot(n, support);
}

/* The distance is the largest amount by which the point is beyond a tangent plane; inside, it is minus the distance to
 * the nearest one. A compass search on the unit sphere finds it, starting from the normal of the level surface through
 * the point. It need not be fast. */
double scene_superellipsoid_distance(const scene_shape *shape, const double p[3])
{
    const double *r = shape->u.superellipsoid.radii;
    double n[3], best, step = 0.25;
    scene_superellipsoid_normal(shape, p, n);
    double length = scene_norm(n);
    if (!(length > 0.0)) { /* at the centre the nearest point is the end of the shortest axis */
        int least = r[0] <= r[1] && r[0] <= r[2] ? 0 : r[1] <= r[2] ? 1 : 2;
        for (int i = 0; i < 3; i++) n[i] = i == least;
        length = 1.0;
    }
    for (int i = 0; i < 3; i++) n[i] /= length;
    best = beyond_plane(shape, n, p);
    while (step > 1e-9) {
        bool better = false;
        for (int k = 0; k < 6; k++) {
            double m[3] = {n[0], n[1], n[2]};
            m[k / 2] += k % 2 ? step : -step;
            length = scene_norm(m);
            for (int i = 0; i < 3; i++) m[i] /= length;
            double beyond = beyond_plane(shape, m, p);
            if (!(beyond > best)) continue;
            best = beyond;
            scene_copy(m, n);
            better = true;
        }
        if (!better) step *= 0.5;
    }
    return best;
}
