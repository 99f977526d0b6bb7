/*
 * Hertz' law for a fingertip: two smooth bodies of effective modulus E* and relative radius of curvature R press on
 * each other with F = 4/3 E* sqrt(R) delta^(3/2) (Johnson, Contact Mechanics, 1985, eq. 4.23 and 4.26; for unequal
 * principal radii R = sqrt(R' R''), whose error is below 3 % up to R'/R'' = 5).
 *
 * The law of a step is linear, r_n = kn (delta - h w_n) - cn w_n. kn is the secant F/delta at the depth the step starts
 * from: the law holds unchanged within the step, a body at rest carries exactly Hertz' force, and the secant never
 * pulls. (With the tangent 2 E* sqrt(R delta) delta itself would have to be replaced by 2/3 delta for that.)
 */
#include "plugin.h"

#include "support/vec3.h"

#include <pinch/fingertip.h>

#include <math.h>

/* Below this part of R the depth counts as this much: a stiffness must be positive. */
static const double LEAST_DEPTH = 1e-6;

/* Adds a surface's curvature, where its outward normal is `normal`, in the tangent frame; false: an edge or corner, or
 * a shape whose curvature is not known. */
static bool add_curvature(dGeomID geom, const double *normal, const double *t1, const double *t2, double K[3])
{
    double k[2], u[3];
    if (pinch_tip_curvature(geom, normal, k, u) != PINCH_OK || !isfinite(k[0]) || !isfinite(k[1])) return false;
    double c = pinch_v3_dot(u, t1), s = pinch_v3_dot(u, t2);
    K[0] += k[0] * c * c + k[1] * s * s;
    K[1] += (k[0] - k[1]) * c * s;
    K[2] += k[0] * s * s + k[1] * c * c;
    return true;
}

double pinch_hertz_stiffness(const pinch_ode *p, const pinch_pair *pair, double modulus)
{
    const pinch_manifold_point *deepest = pair->manifold.point;
    double K[3] = {0, 0, 0}, t1[3], t2[3], back[3];
    if (pair->manifold.count == 0) return 0;
    for (int k = 1; k < pair->manifold.count; k++)
        if (pair->manifold.point[k].depth > deepest->depth) deepest = &pair->manifold.point[k];
    const double *n = deepest->normal; /* into geom[0] */
    for (int i = 0; i < 3; i++) back[i] = -n[i];
    pinch_v3_any_perpendicular(n, t1);
    pinch_v3_cross(n, t1, t2);
    if (!add_curvature(p->geoms.items[pair->geom[0]].geom, back, t1, t2, K) ||
        !add_curvature(p->geoms.items[pair->geom[1]].geom, n, t1, t2, K))
        return 0;
    double det = K[0] * K[2] - K[1] * K[1], trace = K[0] + K[2];
    if (!(det > 1e-9 * trace * trace)) return 0; /* along a line, or flat: no point contact */
    double R = 1 / sqrt(det);                    /* det K = 1/(R' R'') = 1/R^2 */
    return 4.0 / 3 * modulus * sqrt(R * fmax(deepest->depth, LEAST_DEPTH * R));
}
