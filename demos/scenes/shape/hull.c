/* Convex polyhedra of scenes: the hull of points and of a prism, and the surface. */

#include "common/vector.h"
#include "shape.h"

#include <stdlib.h>
#include <string.h>

scene_shape_fault scene_hull_of_points(const double *points, size_t count, scene_hull *hull)
{
    switch (mesh_hull_of_points(points, count, hull)) {
    case MESH_HULL_FINE:
        return SCENE_SHAPE_FINE;
    case MESH_HULL_FLAT:
        return SCENE_SHAPE_FLAT;
    default:
        return SCENE_SHAPE_OUT_OF_MEMORY;
    }
}

/* Every corner must turn left, and all together must go around once: a star turns left everywhere, too, but goes around
 * twice. */
static scene_shape_fault check_corners(const double *corners, size_t count)
{
    double turned = 0.0, area = 0.0;
    bool left = true;
    for (size_t i = 0; i < count; i++) {
        const double *a = corners + 2 * i, *b = corners + 2 * ((i + 1) % count), *c = corners + 2 * ((i + 2) % count);
        const double *o = corners;
        double u[2] = {b[0] - a[0], b[1] - a[1]}, v[2] = {c[0] - b[0], c[1] - b[1]};
        double cross = u[0] * v[1] - u[1] * v[0], lengths = hypot(u[0], u[1]) * hypot(v[0], v[1]);
        left = left && cross > 1e-9 * lengths;
        turned += atan2(cross, u[0] * v[0] + u[1] * v[1]);
        area += (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
    }
    if (area < 0.0) return SCENE_SHAPE_CLOCKWISE;
    return left && turned < 7.0 ? SCENE_SHAPE_FINE : SCENE_SHAPE_NOT_CONVEX;
}

scene_shape_fault scene_hull_of_prism(const double *corners, size_t count, double height, scene_hull *hull)
{
    memset(hull, 0, sizeof *hull);
    scene_shape_fault fault = check_corners(corners, count);
    if (fault != SCENE_SHAPE_FINE) return fault;
    if (!mesh_hull_allocate(hull, 2 * count, count + 2, 2 * (1 + count) + 5 * count)) {
        mesh_hull_free(hull);
        return SCENE_SHAPE_OUT_OF_MEMORY;
    }
    unsigned n = (unsigned)count;
    unsigned *bottom = hull->polygons, *top = bottom + 1 + n, *side = top + 1 + n;
    bottom[0] = top[0] = n;
    for (unsigned i = 0; i < n; i++) {
        double low[3] = {corners[2 * i], corners[2 * i + 1], -0.5 * height};
        double high[3] = {low[0], low[1], 0.5 * height};
        scene_copy(low, hull->vertices + 3 * i);
        scene_copy(high, hull->vertices + 3 * (n + i));
        bottom[1 + i] = n - 1 - i;
        top[1 + i] = n + i;
        unsigned next = (i + 1) % n;
        unsigned polygon[5] = {4, i, next, n + next, n + i};
        memcpy(side + 5 * i, polygon, sizeof polygon);
    }
    mesh_hull_set_plane(hull, 0, bottom + 1, n);
    mesh_hull_set_plane(hull, 1, top + 1, n);
    for (unsigned i = 0; i < n; i++) mesh_hull_set_plane(hull, 2 + i, side + 5 * i + 1, 4);
    return SCENE_SHAPE_FINE;
}

/* ---- Where a point is relative to the surface, and where the polyhedron ends in a direction. ---- */

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
        if (scene_dot(plane, p) - plane[3] > -tolerance && scene_points_inward(plane, d)) return true;
    }
    return false;
}

/* The centroid is the area-weighted mean of the fan's triangles. */
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
