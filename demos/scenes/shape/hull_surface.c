/* Where a point is relative to a convex polyhedron's surface, and where that ends in a direction. */

#include "common/vector.h"
#include "shape.h"

static double segment_distance(const double a[3], const double b[3], const double p[3])
{
    double ab[3], ap[3];
    scene_subtract(b, a, ab);
    scene_subtract(p, a, ap);
    double t = fmin(1.0, fmax(0.0, scene_dot(ab, ap) / scene_dot(ab, ab)));
    scene_add_scaled(ap, -t, ab);
    return scene_norm(ap);
}

static double polygon_distance(const scene_hull *hull, const double plane[4], const unsigned *polygon,
                               const double p[3])
{
    double distance = INFINITY;
    bool above = true;
    for (unsigned k = 0; k < polygon[0]; k++) {
        const double *a = hull->vertices + 3 * polygon[1 + k];
        const double *b = hull->vertices + 3 * polygon[1 + (k + 1) % polygon[0]];
        double ab[3], ap[3], inward[3];
        scene_subtract(b, a, ab);
        scene_subtract(p, a, ap);
        scene_cross(plane, ab, inward);
        above = above && scene_dot(inward, ap) >= 0.0;
        distance = fmin(distance, segment_distance(a, b, p));
    }
    return above ? fabs(scene_dot(plane, p) - plane[3]) : distance;
}

double scene_hull_distance(const scene_hull *hull, const double p[3])
{
    double inside = -INFINITY, outside = INFINITY;
    for (size_t f = 0; f < hull->face_count; f++)
        inside = fmax(inside, scene_dot(hull->planes + 4 * f, p) - hull->planes[4 * f + 3]);
    if (inside <= 0.0) return inside;
    const unsigned *polygon = hull->polygons;
    for (size_t f = 0; f < hull->face_count; polygon += 1 + polygon[0], f++)
        outside = fmin(outside, polygon_distance(hull, hull->planes + 4 * f, polygon, p));
    return outside;
}

bool scene_hull_points_in(const scene_hull *hull, const double p[3], const double d[3], double tolerance)
{
    for (size_t f = 0; f < hull->face_count; f++) {
        const double *plane = hull->planes + 4 * f;
        if (scene_dot(plane, p) - plane[3] > -tolerance && scene_goes_in(plane, d)) return true;
    }
    return false;
}

/* area-weighted mean of the fan's triangles */
static void polygon_centroid(const scene_hull *hull, const unsigned *polygon, double middle[3])
{
    const double *o = hull->vertices + 3 * polygon[1];
    double sum[3] = {0}, area = 0.0;
    for (unsigned k = 2; k < polygon[0]; k++) {
        double a[3], b[3], c[3];
        scene_subtract(hull->vertices + 3 * polygon[k], o, a);
        scene_subtract(hull->vertices + 3 * polygon[k + 1], o, b);
        scene_cross(a, b, c);
        double weight = scene_norm(c);
        area += weight;
        scene_add_scaled(sum, weight / 3.0, a);
        scene_add_scaled(sum, weight / 3.0, b);
    }
    scene_copy(o, middle);
    scene_add_scaled(middle, 1.0 / area, sum);
}

void scene_hull_support(const scene_hull *hull, double radius, const double d[3], double middle[3])
{
    double best = -INFINITY;
    for (size_t i = 0; i < hull->vertex_count; i++) best = fmax(best, scene_dot(hull->vertices + 3 * i, d));
    size_t ties = 0;
    double sum[3] = {0};
    for (size_t i = 0; i < hull->vertex_count; i++) {
        if (scene_dot(hull->vertices + 3 * i, d) < best - SCENE_SUPPORT_TIE * radius) continue;
        scene_add_scaled(sum, 1.0, hull->vertices + 3 * i);
        ties++;
    }
    for (int i = 0; i < 3; i++) middle[i] = sum[i] / (double)ties;
    if (ties < 3) return;
    const unsigned *polygon = hull->polygons, *face = polygon;
    double closest = -INFINITY;
    for (size_t f = 0; f < hull->face_count; polygon += 1 + polygon[0], f++) {
        double along = scene_dot(hull->planes + 4 * f, d);
        if (along <= closest) continue;
        closest = along;
        face = polygon;
    }
    polygon_centroid(hull, face, middle);
}
