/* A mesh as convex pieces: hulls, mass properties. */
#include "common/vector.h"
#include "meshes/mesh_file.h"
#include "shape.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A piece's own volume may differ from its hull's by this part, and as much of its surface may be open.
 * Single-precision coordinates cause that much, a dent or a missing triangle more. */
static const double CONVEX = 1e-4;

/* Pieces may touch. What two share deeper than this (over the size) is an overlap, whose mass would count twice. */
static const double OVERLAP = 1e-4;

static const char *named(const mesh_piece *piece, size_t index, char *text)
{
    if (*piece->name)
        snprintf(text, 96, "\"%s\"", piece->name);
    else
        snprintf(text, 96, "number %zu", index + 1);
    return text;
}

static scene_shape_fault hull_of_piece(const mesh_file *mesh, size_t index, scene_hull *hull, char *error)
{
    const mesh_piece *piece = &mesh->pieces[index];
    char name[96];
    double centre[3], second[9], whole;
    scene_shape_fault fault = scene_hull_of_points(mesh->corners + 9 * piece->first, 3 * piece->count, hull);
    if (fault == SCENE_SHAPE_FLAT)
        snprintf(error, 256, "expected pieces that span a volume, but piece %s is flat", named(piece, index, name));
    if (fault != SCENE_SHAPE_FINE) return fault;
    mesh_hull_moments(hull, &whole, centre, second);
    /* About a point inside, every face adds to the volume, so that none can be missing unseen. */
    mesh_measure own;
    mesh_piece_measure(mesh, piece, centre, &own);
    bool convex = fabs(fabs(own.volume) - whole) <= CONVEX * whole;
    if (convex && scene_norm(own.opening) <= CONVEX * own.area) return SCENE_SHAPE_FINE;
    snprintf(error, 256,
             "expected convex, closed pieces (one o or g each), but piece %s has %g of the volume of its convex hull",
             named(piece, index, name), fabs(own.volume) / whole);
    return SCENE_SHAPE_NOT_CONVEX;
}

/* The least box around a piece, with half of `layer` taken off each side. */
static void piece_box(const scene_hull *hull, double layer, double box[6])
{
    for (int i = 0; i < 3; i++) {
        box[i] = INFINITY;
        box[3 + i] = -INFINITY;
        for (size_t k = 0; k < hull->vertex_count; k++) {
            box[i] = fmin(box[i], hull->vertices[3 * k + (size_t)i] + layer / 2);
            box[3 + i] = fmax(box[3 + i], hull->vertices[3 * k + (size_t)i] - layer / 2);
        }
    }
}

static bool boxes_meet(const double *a, const double *b)
{
    for (int i = 0; i < 3; i++)
        if (a[i] >= b[3 + i] || b[i] >= a[3 + i]) return false;
    return true;
}

static scene_shape_fault check_overlaps(const scene_shape *shape, double size, const mesh_file *mesh, char *error)
{
    double *boxes = malloc(6 * shape->piece_count * sizeof *boxes);
    if (!boxes) return SCENE_SHAPE_OUT_OF_MEMORY;
    scene_shape_fault fault = SCENE_SHAPE_FINE;
    for (size_t i = 0; i < shape->piece_count && fault == SCENE_SHAPE_FINE; i++) {
        piece_box(&shape->pieces[i], OVERLAP * size, boxes + 6 * i);
        for (size_t j = 0; j < i && fault == SCENE_SHAPE_FINE; j++) {
            if (!boxes_meet(boxes + 6 * i, boxes + 6 * j)) continue;
            if (!mesh_hulls_overlap(&shape->pieces[j], &shape->pieces[i], OVERLAP * size)) continue;
            char one[96], other[96];
            snprintf(error, 256, "expected pieces that do not overlap, but %s reaches into %s",
                     named(&mesh->pieces[j], j, one), named(&mesh->pieces[i], i, other));
            fault = SCENE_SHAPE_BAD_FILE;
        }
    }
    free(boxes);
    return fault;
}

/* The moments of the whole about `centre`, from those of its pieces about the origin. */
static void whole_moments(const scene_shape *shape, double *volume, double centre[3], double second[9])
{
    *volume = 0;
    memset(centre, 0, 3 * sizeof *centre);
    memset(second, 0, 9 * sizeof *second);
    for (size_t k = 0; k < shape->piece_count; k++) {
        double v, c[3], s[9];
        mesh_hull_moments(&shape->pieces[k], &v, c, s);
        *volume += v;
        scene_add_scaled(centre, v, c);
        for (int i = 0; i < 9; i++) second[i] += s[i];
    }
    for (int i = 0; i < 3; i++) centre[i] /= *volume;
}

/* Recentres in passes until the centre is at the origin to rounding, as for a polyhedron (shape.c). */
static scene_shape_fault complete(scene_shape *shape)
{
    double centre[3], second[9], trace;
    for (int pass = 0; pass < 8; pass++) {
        whole_moments(shape, &shape->volume, centre, second);
        shape->bounding_radius = 0;
        for (size_t k = 0; k < shape->piece_count; k++)
            for (size_t i = 0; i < shape->pieces[k].vertex_count; i++)
                shape->bounding_radius = fmax(shape->bounding_radius, scene_norm(shape->pieces[k].vertices + 3 * i));
        if (!(scene_norm(centre) > 1e-13 * shape->bounding_radius)) break;
        scene_add_scaled(shape->shift, 1.0, centre);
        for (size_t k = 0; k < shape->piece_count; k++) mesh_hull_recentre(&shape->pieces[k], centre);
    }
    trace = second[0] + second[4] + second[8];
    for (int i = 0; i < 9; i++) shape->unit_inertia[i] = ((i % 4 ? 0.0 : trace) - second[i]) / shape->volume;
    return isfinite(shape->volume) && shape->volume > 0 ? SCENE_SHAPE_FINE : SCENE_SHAPE_OUT_OF_RANGE;
}

scene_shape_fault scene_shape_load_mesh(scene_shape *shape, char *error)
{
    mesh_file mesh;
    mesh_status status = mesh_read(shape->u.mesh.file, &mesh, error);
    if (status == MESH_NO_MEMORY) return SCENE_SHAPE_OUT_OF_MEMORY;
    if (status != MESH_OK) return SCENE_SHAPE_BAD_FILE;
    scene_shape_fault fault = SCENE_SHAPE_FINE;
    double size = 0;
    shape->pieces = calloc(mesh.piece_count, sizeof *shape->pieces);
    if (!shape->pieces) fault = SCENE_SHAPE_OUT_OF_MEMORY;
    for (size_t k = 0; k < mesh.piece_count && fault == SCENE_SHAPE_FINE; k++) {
        fault = hull_of_piece(&mesh, k, &shape->pieces[k], error);
        shape->piece_count++; /* the hull of a refused piece is freed as well */
    }
    for (size_t k = 0; k < 9 * mesh.triangle_count; k++) size = fmax(size, fabs(mesh.corners[k] - mesh.corners[k % 3]));
    if (fault == SCENE_SHAPE_FINE) fault = check_overlaps(shape, size, &mesh, error);
    mesh_free(&mesh);
    return fault == SCENE_SHAPE_FINE ? complete(shape) : fault;
}
