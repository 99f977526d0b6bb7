#include "drawing.h"

#include "common/json_output.h"
#include "common/vector.h"
#include "scenes/shape/shape.h"

#include <string.h>

enum { DIRECTIONS = 72 };

/* The hull's corner that lies farthest along `direction`. */
static void farthest_corner(const scene_hull *hull, const double direction[3], double corner[3])
{
    size_t best = 0;
    for (size_t i = 1; i < hull->vertex_count; i++)
        if (scene_dot(hull->vertices + 3 * i, direction) > scene_dot(hull->vertices + 3 * best, direction)) best = i;
    scene_copy(hull->vertices + 3 * best, corner);
}

/* The point of a shape that lies farthest along a world direction; piece: of a mesh. */
static void farthest(const scene_shape *shape, size_t piece, const double pose[7], const double direction[3],
                     double point[3])
{
    double local[3], found[3];
    scene_rotate_back(pose + 3, direction, local);
    if (shape->type == SCENE_MESH)
        farthest_corner(&shape->pieces[piece], local, found);
    else
        scene_shape_support(shape, local, found);
    scene_rotate(pose + 3, found, point);
    scene_add_scaled(point, 1, pose);
}

/* The silhouette: farthest points along directions all around, a hair out of the view's plane so that faces and edges
 * seen edge on give their corners and not their middles. */
static json_t *silhouette(const scene_shape *shape, size_t piece, const double pose[7], const int axes[2])
{
    json_t *points = json_array();
    double last[2] = {NAN, NAN};
    for (int k = 0; k < DIRECTIONS; k++) {
        double angle = 2 * SCENE_PI * (k + 0.3183) / DIRECTIONS, direction[3] = {1e-7, 2e-7, 3e-7}, point[3];
        direction[axes[0]] += cos(angle);
        direction[axes[1]] += sin(angle);
        scene_add_scaled(direction, 1 / scene_norm(direction) - 1, direction);
        farthest(shape, piece, pose, direction, point);
        const double seen[2] = {point[axes[0]], point[axes[1]]};
        double near_by = 1e-6 * shape->bounding_radius;
        if (fabs(seen[0] - last[0]) <= near_by && fabs(seen[1] - last[1]) <= near_by) continue;
        (void)json_array_append_new(points, json_numbers(seen, 2));
        memcpy(last, seen, sizeof last);
    }
    return points;
}

static void add_outlines(json_t *list, const char *kind, const char *name, const scene_shape *shape,
                         const double pose[7], const int axes[2])
{
    size_t pieces = shape->type == SCENE_MESH ? shape->piece_count : 1;
    for (size_t piece = 0; piece < pieces; piece++)
        (void)json_array_append_new(list, json_pack("{s:s, s:s, s:o}", "kind", kind, "name", name, "points",
                                                    silhouette(shape, piece, pose, axes)));
}

static json_t *view_document(const world *w, const sample *s, const int axes[2])
{
    const scene *scene_of = w->scene;
    json_t *outlines = json_array();
    double centre[2] = {s->poses[0][axes[0]], s->poses[0][axes[1]]}, size = scene_of->object.shape.bounding_radius;
    for (size_t i = 0; i < scene_of->environment_count; i++) {
        const scene_environment *e = &scene_of->environment[i];
        double pose[7];
        memcpy(pose, e->position, sizeof e->position);
        memcpy(pose + 3, e->orientation, sizeof e->orientation);
        add_outlines(outlines, "environment", e->name, &e->shape, pose, axes);
    }
    add_outlines(outlines, "object", "object", &scene_of->object.shape, s->poses[0], axes);
    for (int i = 0; i < w->finger_count && i < SAMPLE_FINGERS; i++) {
        const scene_finger *f = w->fingers[i].finger;
        add_outlines(outlines, "finger", f->name, &f->tip, s->poses[1 + i], axes);
        for (int a = 0; a < 2; a++) /* the whole of small tips, and of large ones the part that touches */
            size = fmax(size, fmin(fabs(s->poses[1 + i][axes[a]] - centre[a]) + f->tip.bounding_radius,
                                   1.8 * scene_of->object.shape.bounding_radius));
    }
    return json_pack("{s:[i,i], s:o, s:f, s:o}", "axes", axes[0], axes[1], "centre", json_numbers(centre, 2), "size",
                     1.1 * size, "outlines", outlines);
}

json_t *drawing_document(const world *w, const sample *s)
{
    static const int sides[2][2][2] = {{{0, 2}, {1, 2}}, {{0, 1}, {2, 1}}};
    const int(*side)[2] = sides[w->scene->dimension == 2];
    return json_pack("{s:f, s:i, s:[o, o]}", "time", s->time, "step", (int)s->at.step, "views",
                     view_document(w, s, side[0]), view_document(w, s, side[1]));
}
