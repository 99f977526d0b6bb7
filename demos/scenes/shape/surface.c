/* Where a point is relative to a shape's surface, and where a shape ends in a direction. */

#include "common/vector.h"
#include "shape.h"

/* Outside, the distance is the length of the positive parts; inside, it is the largest (least negative) part. */
static double distance_from_parts(const double *part, int count)
{
    double outside = 0.0, inside = -INFINITY;
    for (int i = 0; i < count; i++) {
        if (part[i] > 0.0) outside = hypot(outside, part[i]);
        inside = fmax(inside, part[i]);
    }
    return inside > 0.0 ? outside : inside;
}

/* A rounded body is a sharp one that is smaller by the rounding all around, grown by the rounding. */
static double box_distance(const scene_shape *shape, const double p[3])
{
    double part[3], rounding = shape->u.box.rounding;
    for (int i = 0; i < 3; i++) part[i] = fabs(p[i]) - (0.5 * shape->u.box.size[i] - rounding);
    return distance_from_parts(part, 3) - rounding;
}

static double cylinder_distance(const scene_shape *shape, const double p[3])
{
    double rounding = shape->u.cylinder.rounding;
    double part[2] = {hypot(p[0], p[1]) - (shape->u.cylinder.radius - rounding),
                      fabs(p[2]) - (0.5 * shape->u.cylinder.length - rounding)};
    return distance_from_parts(part, 2) - rounding;
}

/*
 * The closest point of the ellipsoid sum (x_i/e_i)^2 = 1 to y (first octant) is x_i = e_i^2 y_i/(t + e_i^2) with t the
 * largest root of sum (e_i y_i/(t + e_i^2))^2 = 1 (Eberly, Distance from a point to an ellipse, 2013). With
 * s = t + e_min^2 the denominators are s + (e_i^2 - e_min^2): no cancellation. One term alone is 1 at the lower bound
 * of s and all together are at most 1 at the upper one. For a point on the far side of the shortest axis' focal set
 * (s = 0) the closest point leaves the plane y_min = 0. Bisection to the last bit: robust, and nobody waits for it.
 */
static double ellipsoid_distance(const double e[3], const double p[3])
{
    double scale = fmax(e[0], fmax(e[1], e[2]));
    double y[3], r[3], gap[3], low = 0.0, high = 0.0, level = 0.0;
    double shortest = fmin(e[0], fmin(e[1], e[2])) / scale;
    for (int i = 0; i < 3; i++) {
        y[i] = fabs(p[i]) / scale;
        r[i] = e[i] / scale;
        gap[i] = (r[i] - shortest) * (r[i] + shortest);
        low = fmax(low, r[i] * y[i] - gap[i]);
        high = hypot(high, r[i] * y[i]);
        level = hypot(level, y[i] / r[i]);
    }
    double focal = 0.0; /* the sum at s = 0 without the terms that are 0/0 there */
    for (int i = 0; i < 3; i++)
        if (gap[i] > 0.0) focal += r[i] * y[i] / gap[i] * (r[i] * y[i] / gap[i]);
    bool degenerate = low <= 0.0 && focal < 1.0;
    for (int k = 0; k < 2000 && !degenerate; k++) {
        double s = 0.5 * (low + high), sum = 0.0;
        if (s <= low || s >= high) break;
        for (int i = 0; i < 3; i++) sum = hypot(sum, r[i] * y[i] / (s + gap[i]));
        if (sum > 1.0)
            low = s;
        else
            high = s;
    }
    double x[3], rest = 1.0, distance = 0.0;
    for (int i = 0; i < 3; i++) {
        bool lifted = degenerate && gap[i] <= 0.0;
        x[i] = lifted ? 0.0 : r[i] * r[i] * y[i] / ((degenerate ? 0.0 : high) + gap[i]);
        rest -= x[i] / r[i] * (x[i] / r[i]);
    }
    for (int i = 0; i < 3; i++) distance = hypot(distance, x[i] - y[i]);
    if (degenerate) distance = hypot(distance, shortest * sqrt(fmax(rest, 0.0)));
    return (level < 1.0 ? -1.0 : 1.0) * scale * distance;
}

/* Outside, the distance to the nearest piece; inside, to the surface of the piece. A point on the seam of two pieces
 * counts as on the surface. */
static double pieces_distance(const scene_shape *shape, const double p[3])
{
    double distance = INFINITY;
    for (size_t k = 0; k < shape->piece_count; k++)
        distance = fmin(distance, scene_hull_distance(&shape->pieces[k], p));
    return distance;
}

double scene_shape_distance(const scene_shape *shape, const double p[3])
{
    switch (shape->type) {
    case SCENE_BOX:
        return box_distance(shape, p);
    case SCENE_SPHERE:
        return scene_norm(p) - shape->u.sphere.radius;
    case SCENE_CAPSULE: {
        double over = fmax(fabs(p[2]) - 0.5 * shape->u.capsule.length, 0.0);
        return hypot(hypot(p[0], p[1]), over) - shape->u.capsule.radius;
    }
    case SCENE_CYLINDER:
        return cylinder_distance(shape, p);
    case SCENE_FLAT_CAPSULE:
        return scene_flat_capsule_distance(shape, p);
    case SCENE_ELLIPSOID:
        return ellipsoid_distance(shape->u.ellipsoid.radii, p);
    case SCENE_SUPERELLIPSOID:
        return scene_superellipsoid_distance(shape, p);
    case SCENE_CONVEX:
    case SCENE_PRISM:
        return scene_hull_distance(&shape->hull, p);
    case SCENE_MESH:
        return pieces_distance(shape, p);
    default:
        return NAN;
    }
}

/* On the rounding the normal leads away from the sharp body inside; flat parts have their own normal. */
static bool rounded_points_in(const double over[3], const double p[3], const double d[3])
{
    double outward[3];
    for (int i = 0; i < 3; i++) outward[i] = copysign(fmax(over[i], 0.0), p[i]);
    return scene_points_inward(outward, d);
}

static bool box_points_in(const scene_shape *shape, const double p[3], const double d[3], double tolerance)
{
    double rounding = shape->u.box.rounding, over[3];
    for (int i = 0; i < 3; i++) over[i] = fabs(p[i]) - (0.5 * shape->u.box.size[i] - rounding);
    if (rounding > tolerance) return rounded_points_in(over, p, d);
    for (int i = 0; i < 3; i++)
        if (over[i] > rounding - tolerance && copysign(1.0, p[i]) * d[i] < -1e-9) return true;
    return false;
}

static bool cylinder_points_in(const scene_shape *shape, const double p[3], const double d[3], double tolerance)
{
    double rounding = shape->u.cylinder.rounding, rho = hypot(p[0], p[1]);
    if (rounding > tolerance) {
        double out = fmax(rho - (shape->u.cylinder.radius - rounding), 0.0), part = rho > 0.0 ? out / rho : 0.0;
        double over[3] = {part * fabs(p[0]), part * fabs(p[1]),
                          fabs(p[2]) - (0.5 * shape->u.cylinder.length - rounding)};
        return rounded_points_in(over, p, d);
    }
    double side[3] = {p[0], p[1], 0.0}, cap[3] = {0.0, 0.0, p[2]};
    bool on_side = rho > shape->u.cylinder.radius - tolerance;
    bool on_cap = fabs(p[2]) > 0.5 * shape->u.cylinder.length - tolerance;
    return (on_side && scene_points_inward(side, d)) || (on_cap && scene_points_inward(cap, d));
}

bool scene_shape_points_in(const scene_shape *shape, const double p[3], const double d[3], double tolerance)
{
    double outward[3];
    scene_copy(p, outward);
    switch (shape->type) {
    case SCENE_SPHERE:
        return scene_points_inward(outward, d);
    case SCENE_CAPSULE: {
        double half = 0.5 * shape->u.capsule.length;
        outward[2] -= fmin(half, fmax(-half, p[2]));
        return scene_points_inward(outward, d);
    }
    case SCENE_ELLIPSOID: {
        const double *r = shape->u.ellipsoid.radii;
        double longest = fmax(r[0], fmax(r[1], r[2]));
        for (int i = 0; i < 3; i++) outward[i] = p[i] * (longest / r[i]) * (longest / r[i]);
        return scene_points_inward(outward, d);
    }
    case SCENE_CYLINDER:
        return cylinder_points_in(shape, p, d, tolerance);
    case SCENE_BOX:
        return box_points_in(shape, p, d, tolerance);
    case SCENE_FLAT_CAPSULE:
        return scene_flat_capsule_points_in(shape, p, d, tolerance);
    case SCENE_SUPERELLIPSOID:
        scene_superellipsoid_normal(shape, p, outward);
        return scene_points_inward(outward, d);
    case SCENE_CONVEX:
    case SCENE_PRISM:
        return scene_hull_points_in(&shape->hull, p, d, tolerance);
    case SCENE_MESH:
        for (size_t k = 0; k < shape->piece_count; k++)
            if (scene_hull_distance(&shape->pieces[k], p) < tolerance &&
                scene_hull_points_in(&shape->pieces[k], p, d, tolerance))
                return true;
        return false;
    default:
        return false;
    }
}

/* +1 or -1, or 0 where the direction is perpendicular to the axis to rounding. */
static double side_of(double component)
{
    return fabs(component) > SCENE_SUPPORT_TIE ? copysign(1.0, component) : 0.0;
}

void scene_shape_support(const scene_shape *shape, const double d[3], double middle[3])
{
    switch (shape->type) {
    case SCENE_BOX:
        for (int i = 0; i < 3; i++) {
            double rounding = shape->u.box.rounding;
            middle[i] = side_of(d[i]) * (0.5 * shape->u.box.size[i] - rounding) + rounding * d[i];
        }
        return;
    case SCENE_SPHERE:
        for (int i = 0; i < 3; i++) middle[i] = shape->u.sphere.radius * d[i];
        return;
    case SCENE_CAPSULE:
        for (int i = 0; i < 3; i++) middle[i] = shape->u.capsule.radius * d[i];
        middle[2] += 0.5 * side_of(d[2]) * shape->u.capsule.length;
        return;
    case SCENE_CYLINDER: {
        double rounding = shape->u.cylinder.rounding, radial = hypot(d[0], d[1]);
        double factor = radial > SCENE_SUPPORT_TIE ? (shape->u.cylinder.radius - rounding) / radial : 0.0;
        middle[0] = (factor + rounding) * d[0];
        middle[1] = (factor + rounding) * d[1];
        middle[2] = side_of(d[2]) * (0.5 * shape->u.cylinder.length - rounding) + rounding * d[2];
        return;
    }
    case SCENE_FLAT_CAPSULE:
        scene_flat_capsule_support(shape, d, middle);
        return;
    case SCENE_SUPERELLIPSOID:
        scene_superellipsoid_support(shape, d, middle);
        return;
    case SCENE_ELLIPSOID: {
        const double *r = shape->u.ellipsoid.radii;
        double scaled[3] = {r[0] * d[0], r[1] * d[1], r[2] * d[2]};
        double length = scene_norm(scaled);
        for (int i = 0; i < 3; i++) middle[i] = r[i] * scaled[i] / length;
        return;
    }
    case SCENE_CONVEX:
    case SCENE_PRISM:
        scene_hull_support(&shape->hull, shape->bounding_radius, d, middle);
        return;
    case SCENE_MESH: { /* the first of the pieces that reach farthest */
        double most = -INFINITY, candidate[3];
        for (size_t k = 0; k < shape->piece_count; k++) {
            scene_hull_support(&shape->pieces[k], shape->bounding_radius, d, candidate);
            if (scene_dot(candidate, d) <= most + SCENE_SUPPORT_TIE * shape->bounding_radius) continue;
            most = scene_dot(candidate, d);
            scene_copy(candidate, middle);
        }
        return;
    }
    default:
        middle[0] = middle[1] = middle[2] = NAN;
    }
}

/* The gradient of the signed distance points straight away from the nearest surface point, and has length 1. Where the
 * distance is only nearly one, as of ellipsoids, several steps lead there. */
bool scene_shape_nearest(const scene_shape *shape, const double point[3], double tolerance, double nearest[3])
{
    const double step = 1e-5 * shape->bounding_radius;
    for (int i = 0; i < 3; i++) nearest[i] = point[i];
    for (int round = 0; round < 50; round++) {
        double gap = scene_shape_distance(shape, nearest), gradient[3], length2 = 0;
        if (fabs(gap) <= 1e-3 * tolerance) return true;
        for (int i = 0; i < 3; i++) {
            double ahead[3] = {nearest[0], nearest[1], nearest[2]}, behind[3] = {nearest[0], nearest[1], nearest[2]};
            ahead[i] += step;
            behind[i] -= step;
            gradient[i] = (scene_shape_distance(shape, ahead) - scene_shape_distance(shape, behind)) / (2 * step);
            length2 += gradient[i] * gradient[i];
        }
        if (!(length2 > 0.25)) return false;
        for (int i = 0; i < 3; i++) nearest[i] -= gap * gradient[i] / length2;
    }
    return fabs(scene_shape_distance(shape, nearest)) <= 0.1 * tolerance;
}
