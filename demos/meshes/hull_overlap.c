/* Do two convex polyhedra overlap? libccd answers for hulls that have been shrunk a little, so that pieces which only
 * touch stay apart in spite of rounding. */
#include "common/vector.h"
#include "hull.h"

#include <ccd/ccd.h>
#include <math.h>

typedef struct shrunk_hull {
    const mesh_hull *hull;
    double centre[3];
    double scale; /* of the hull about the centre */
} shrunk_hull;

static double depth_in(const mesh_hull *hull, const double *x)
{
    double most = -INFINITY;
    for (size_t f = 0; f < hull->face_count; f++)
        most = fmax(most, scene_dot(hull->planes + 4 * f, x) - hull->planes[4 * f + 3]);
    return -most;
}

/* Scaling about a point moves each face in by its distance from that point, so that the nearest face fixes the scale.
 */
static shrunk_hull shrink(const mesh_hull *hull, double layer)
{
    shrunk_hull s = {.hull = hull};
    for (size_t k = 0; k < hull->vertex_count; k++)
        scene_add_scaled(s.centre, 1.0 / (double)hull->vertex_count, hull->vertices + 3 * k);
    s.scale = fmax(0.0, 1.0 - layer / fmax(depth_in(hull, s.centre), layer));
    return s;
}

static void support(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *point)
{
    const shrunk_hull *s = object;
    const double d[3] = {ccdVec3X(direction), ccdVec3Y(direction), ccdVec3Z(direction)};
    const double *best = s->hull->vertices;
    double x[3], most = -INFINITY;
    for (size_t k = 0; k < s->hull->vertex_count; k++) {
        double reach = scene_dot(s->hull->vertices + 3 * k, d);
        if (reach > most) {
            most = reach;
            best = s->hull->vertices + 3 * k;
        }
    }
    for (int i = 0; i < 3; i++) x[i] = s->centre[i] + s->scale * (best[i] - s->centre[i]);
    ccdVec3Set(point, x[0], x[1], x[2]);
}

static void centre(const void *object, ccd_vec3_t *point)
{
    const shrunk_hull *s = object;
    ccdVec3Set(point, s->centre[0], s->centre[1], s->centre[2]);
}

/* Is a face of `a` between the hulls, but for the layer? Then nothing has to be searched. */
static bool face_separates(const mesh_hull *a, const mesh_hull *b, double layer)
{
    for (size_t f = 0; f < a->face_count; f++) {
        const double *plane = a->planes + 4 * f;
        double least = INFINITY;
        for (size_t k = 0; k < b->vertex_count && least >= plane[3] - layer; k++)
            least = fmin(least, scene_dot(plane, b->vertices + 3 * k));
        if (least >= plane[3] - layer) return true;
    }
    return false;
}

bool mesh_hulls_overlap(const mesh_hull *a, const mesh_hull *b, double layer)
{
    if (face_separates(a, b, layer) || face_separates(b, a, layer)) return false;
    /* A corner that is deep inside needs no search. Thin pieces shrink much, which would hide it. */
    for (size_t k = 0; k < a->vertex_count; k++)
        if (depth_in(b, a->vertices + 3 * k) > layer) return true;
    for (size_t k = 0; k < b->vertex_count; k++)
        if (depth_in(a, b->vertices + 3 * k) > layer) return true;

    shrunk_hull one = shrink(a, layer / 2), other = shrink(b, layer / 2);
    ccd_t ccd;
    CCD_INIT(&ccd);
    ccd.support1 = ccd.support2 = support;
    ccd.center1 = ccd.center2 = centre;
    ccd.max_iterations = 1000;
    return ccdMPRIntersect(&one, &other, &ccd);
}
