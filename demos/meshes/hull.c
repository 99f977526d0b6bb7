/* Convex polyhedra: the hull of points, by Qhull, and exact mass moments. */

#include "hull.h"

#include "common/vector.h"

#include <libqhull_r/qhull_ra.h>
#include <stdlib.h>
#include <string.h>

void mesh_hull_free(mesh_hull *hull)
{
    free(hull->vertices);
    free(hull->planes);
    free(hull->polygons);
    memset(hull, 0, sizeof *hull);
}

bool mesh_hull_allocate(mesh_hull *hull, size_t vertices, size_t faces, size_t polygons)
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
static void polygon_normal(const mesh_hull *hull, const unsigned *corners, unsigned count, double normal[3])
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

void mesh_hull_set_plane(mesh_hull *hull, size_t face, const unsigned *corners, unsigned count)
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
static void copy_facets(qhT *qh, const unsigned *number, mesh_hull *hull)
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
        mesh_hull_set_plane(hull, face++, out + 1, count);
        out += 1 + count;
    }
}

static mesh_hull_fault copy_hull(qhT *qh, const double *points, size_t count, mesh_hull *hull)
{
    facetT *facet;
    vertexT *vertex;
    unsigned *number = calloc(count, sizeof *number);
    if (!number) return MESH_HULL_NO_MEMORY;
    size_t polygons = 0;
    FORALLfacets
    {
        polygons += 1 + (size_t)qh_setsize(qh, facet->vertices);
    }
    FORALLvertices
    {
        number[qh_pointid(qh, vertex->point)] = 1;
    }
    mesh_hull_fault fault = MESH_HULL_FINE;
    if (!mesh_hull_allocate(hull, (size_t)qh->num_vertices, (size_t)qh->num_facets, polygons)) {
        fault = MESH_HULL_NO_MEMORY;
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

mesh_hull_fault mesh_hull_of_points(const double *points, size_t count, mesh_hull *hull)
{
    memset(hull, 0, sizeof *hull);
    double *copy = malloc(3 * count * sizeof *copy);
    FILE *nowhere = fopen("/dev/null", "w"); /* Qhull prints much; our message is one line */
    if (!copy || !nowhere) {
        free(copy);
        if (nowhere) fclose(nowhere);
        return MESH_HULL_NO_MEMORY;
    }
    memcpy(copy, points, 3 * count * sizeof *copy);

    qhT context;
    qh_zero(&context, nowhere);
    char options[] = "qhull Pp";
    int failed = qh_new_qhull(&context, 3, (int)count, copy, False, options, NULL, nowhere);
    mesh_hull_fault fault = failed == qh_ERRmem ? MESH_HULL_NO_MEMORY : MESH_HULL_FLAT;
    if (!failed) fault = copy_hull(&context, points, count, hull);
    context.NOerrexit = True;
    qh_freeqhull(&context, !qh_ALL);
    int current, total;
    qh_memfreeshort(&context, &current, &total);
    fclose(nowhere);
    free(copy);
    if (fault != MESH_HULL_FINE) mesh_hull_free(hull);
    return fault;
}

/* The sum over tetrahedra (o, a, b, c), with o a corner of the hull, so that nothing cancels when the hull lies far
 * from the origin. With a, b, c relative to o, d = a . (b x c) and s = a + b + c, a tetrahedron has volume d/6, first
 * moment d/24 s, and second moment d/120 (s s^T + a a^T + b b^T + c c^T). */
void mesh_hull_moments(const mesh_hull *hull, double *volume, double centre[3], double second[9])
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

void mesh_hull_recentre(mesh_hull *hull, const double shift[3])
{
    for (size_t i = 0; i < hull->vertex_count; i++) scene_add_scaled(hull->vertices + 3 * i, -1.0, shift);
    for (size_t f = 0; f < hull->face_count; f++) hull->planes[4 * f + 3] -= scene_dot(hull->planes + 4 * f, shift);
}
