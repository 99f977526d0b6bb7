/* Convex polyhedra: the hull of points (by Qhull) and of a prism, exact mass moments, and the surface. */

#include "common/vector.h"
#include "shape.h"

#include <libqhull_r/qhull_ra.h>
#include <stdlib.h>
#include <string.h>

void scene_hull_free(scene_hull *hull)
{
    free(hull->vertices);
    free(hull->planes);
    free(hull->polygons);
    memset(hull, 0, sizeof *hull);
}

static bool allocate(scene_hull *hull, size_t vertices, size_t faces, size_t polygons)
{
    hull->vertex_count = vertices;
    hull->face_count = faces;
    hull->polygons_length = polygons;
    hull->vertices = malloc(3 * vertices * sizeof *hull->vertices);
    hull->planes = malloc(4 * faces * sizeof *hull->planes);
    hull->polygons = malloc(polygons * sizeof *hull->polygons);
    return hull->vertices && hull->planes && hull->polygons;
}

/* The sum of the cross products around the polygon is twice its area times the normal of its orientation (Newell). */
static void polygon_normal(const scene_hull *hull, const unsigned *corners, unsigned count, double normal[3])
{
    const double *first = hull->vertices + 3 * corners[0];
    normal[0] = normal[1] = normal[2] = 0.0;
    for (unsigned k = 1; k + 1 < count; k++) {
        double a[3], b[3], c[3];
        scene_subtract(hull->vertices + 3 * corners[k], first, a);
        scene_subtract(hull->vertices + 3 * corners[k + 1], first, b);
        scene_cross(a, b, c);
        scene_add_scaled(normal, 1.0, c);
    }
}

static void set_plane(scene_hull *hull, size_t face, const unsigned *corners, unsigned count)
{
    double *plane = hull->planes + 4 * face;
    polygon_normal(hull, corners, count, plane);
    double length = scene_norm(plane);
    for (int i = 0; i < 3; i++) plane[i] /= length;
    double sum = 0.0;
    for (unsigned k = 0; k < count; k++) sum += scene_dot(plane, hull->vertices + 3 * corners[k]);
    plane[3] = sum / count;
}

/* Copies Qhull's facets in its order, with corner numbers of our own: `number[point id]` is 1 + the corner's index. */
static void copy_facets(qhT *qh, const unsigned *number, scene_hull *hull)
{
    facetT *facet;
    vertexT *vertex, **vertexp;
    unsigned *out = hull->polygons;
    size_t face = 0;
    FORALLfacets
    {
        setT *corners = qh_facet3vertex(qh, facet);
        unsigned count = 0;
        FOREACHvertex_(corners)
        {
            out[++count] = number[qh_pointid(qh, vertex->point)] - 1;
        }
        qh_settempfree(qh, &corners);
        out[0] = count;
        double normal[3];
        polygon_normal(hull, out + 1, count, normal);
        if (scene_dot(normal, facet->normal) < 0.0)
            for (unsigned a = 1, b = count; a < b; a++, b--) {
                unsigned swap = out[a];
                out[a] = out[b];
                out[b] = swap;
            }
        set_plane(hull, face++, out + 1, count);
        out += 1 + count;
    }
}

static scene_shape_fault copy_hull(qhT *qh, const double *points, size_t count, scene_hull *hull)
{
    facetT *facet;
    vertexT *vertex;
    unsigned *number = calloc(count, sizeof *number);
    if (!number) return SCENE_SHAPE_OUT_OF_MEMORY;
    size_t polygons = 0;
    FORALLfacets
    {
        polygons += 1 + (size_t)qh_setsize(qh, facet->vertices);
    }
    FORALLvertices
    {
        number[qh_pointid(qh, vertex->point)] = 1;
    }
    scene_shape_fault fault = SCENE_SHAPE_FINE;
    if (!allocate(hull, (size_t)qh->num_vertices, (size_t)qh->num_facets, polygons)) {
        fault = SCENE_SHAPE_OUT_OF_MEMORY;
    } else {
        unsigned next = 0;
        for (size_t i = 0; i < count; i++) {
            if (!number[i]) continue;
            scene_copy(points + 3 * i, hull->vertices + 3 * next);
            number[i] = ++next;
        }
        copy_facets(qh, number, hull);
    }
    free(number);
    return fault;
}

scene_shape_fault scene_hull_of_points(const double *points, size_t count, scene_hull *hull)
{
    memset(hull, 0, sizeof *hull);
    double *copy = malloc(3 * count * sizeof *copy);
    FILE *nowhere = fopen("/dev/null", "w"); /* Qhull prints much; our message is one line */
    if (!copy || !nowhere) {
        free(copy);
        if (nowhere) fclose(nowhere);
        return SCENE_SHAPE_OUT_OF_MEMORY;
    }
    memcpy(copy, points, 3 * count * sizeof *copy);

    qhT context;
    qh_zero(&context, nowhere);
    char options[] = "qhull Pp";
    int failed = qh_new_qhull(&context, 3, (int)count, copy, False, options, NULL, nowhere);
    scene_shape_fault fault = failed == qh_ERRmem ? SCENE_SHAPE_OUT_OF_MEMORY : SCENE_SHAPE_FLAT;
    if (!failed) fault = copy_hull(&context, points, count, hull);
    context.NOerrexit = True;
    qh_freeqhull(&context, !qh_ALL);
    int current, total;
    qh_memfreeshort(&context, &current, &total);
    fclose(nowhere);
    free(copy);
    if (fault != SCENE_SHAPE_FINE) scene_hull_free(hull);
    return fault;
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
    if (!allocate(hull, 2 * count, count + 2, 2 * (1 + count) + 5 * count)) {
        scene_hull_free(hull);
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
    set_plane(hull, 0, bottom + 1, n);
    set_plane(hull, 1, top + 1, n);
    for (unsigned i = 0; i < n; i++) set_plane(hull, 2 + i, side + 5 * i + 1, 4);
    return SCENE_SHAPE_FINE;
}

/* The sum over tetrahedra (o, a, b, c), with o a corner of the hull, so that nothing cancels when the hull lies far
 * from the origin. With a, b, c relative to o, d = a . (b x c) and s = a + b + c, a tetrahedron has volume d/6, first
 * moment d/24 s, and second moment d/120 (s s^T + a a^T + b b^T + c c^T). */
void scene_hull_moments(const scene_hull *hull, double *volume, double centre[3], double second[9])
{
    const double *o = hull->vertices;
    double first[3] = {0};
    *volume = 0.0;
    memset(second, 0, 9 * sizeof *second);
    const unsigned *polygon = hull->polygons;
    for (size_t f = 0; f < hull->face_count; polygon += 1 + polygon[0], f++)
        for (unsigned k = 2; k < polygon[0]; k++) {
            double e[3][3], cross[3], s[3] = {0};
            unsigned corner[3] = {polygon[1], polygon[k], polygon[k + 1]};
            for (int j = 0; j < 3; j++) {
                scene_subtract(hull->vertices + 3 * corner[j], o, e[j]);
                scene_add_scaled(s, 1.0, e[j]);
            }
            scene_cross(e[1], e[2], cross);
            double d = scene_dot(e[0], cross);
            *volume += d / 6.0;
            scene_add_scaled(first, d / 24.0, s);
            for (int i = 0; i < 9; i++) {
                int row = i / 3, column = i % 3;
                double sum = s[row] * s[column];
                for (int j = 0; j < 3; j++) sum += e[j][row] * e[j][column];
                second[i] += d / 120.0 * sum;
            }
        }
    /* from the corner o to the origin */
    double mean[3];
    for (int i = 0; i < 3; i++) {
        mean[i] = first[i] / *volume;
        centre[i] = o[i] + mean[i];
    }
    for (int i = 0; i < 9; i++) second[i] += *volume * (centre[i / 3] * centre[i % 3] - mean[i / 3] * mean[i % 3]);
}

void scene_hull_recentre(scene_hull *hull, const double shift[3])
{
    for (size_t i = 0; i < hull->vertex_count; i++) scene_add_scaled(hull->vertices + 3 * i, -1.0, shift);
    for (size_t f = 0; f < hull->face_count; f++) hull->planes[4 * f + 3] -= scene_dot(hull->planes + 4 * f, shift);
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
