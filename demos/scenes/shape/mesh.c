/* A mesh as convex pieces: hulls, mass properties. */
#include "common/vector.h"
#include "meshes/mesh_file.h"
#include "shape.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A piece's own volume may differ from its hull's by this part. Single-precision coordinates cause that much, a dent
 * more. */
static const double CONVEX = 1e-4;

/* Pieces may touch. A corner that is deeper than this (over the size) in another piece is an overlap, whose mass would
 * count twice. */
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
    double centre[3], second[9], whole, own = mesh_piece_volume(mesh, piece);
    scene_shape_fault fault = scene_hull_of_points(mesh->corners + 9 * piece->first, 3 * piece->count, hull);
    if (fault == SCENE_SHAPE_FLAT)
        snprintf(error, 256, "expected pieces that span a volume, but piece %s is flat", named(piece, index, name));
    if (fault != SCENE_SHAPE_FINE) return fault;
    mesh_hull_moments(hull, &whole, centre, second);
    if (fabs(fabs(own) - whole) <= CONVEX * whole) return SCENE_SHAPE_FINE;
    snprintf(error, 256,
             "expected convex, closed pieces (one o or g each), but piece %s has %g of the volume of its convex hull",
             named(piece, index, name), fabs(own) / whole);
    return SCENE_SHAPE_NOT_CONVEX;
}

static double depth_in(const scene_hull *hull, const double *x)
{
    double most = -INFINITY;
    for (size_t f = 0; f < hull->face_count; f++)
        most = fmax(most, scene_dot(hull->planes + 4 * f, x) - hull->planes[4 * f + 3]);
    return -most;
}

/* Two pieces overlap where a corner or the middle of one lies inside the other. */
static bool pieces_overlap(const scene_shape *shape, double size, const mesh_file *mesh, char *error)
{
    for (size_t i = 0; i < shape->piece_count; i++)
        for (size_t j = 0; j < shape->piece_count; j++) {
            const scene_hull *a = &shape->pieces[i], *b = &shape->pieces[j];
            double middle[3] = {0};
            bool overlap = false;
            if (i == j) continue;
            for (size_t k = 0; k < a->vertex_count; k++) {
                scene_add_scaled(middle, 1.0 / (double)a->vertex_count, a->vertices + 3 * k);
                overlap = overlap || depth_in(b, a->vertices + 3 * k) > OVERLAP * size;
            }
            if (!overlap && depth_in(b, middle) <= OVERLAP * size) continue;
            char one[96], other[96];
            snprintf(error, 256, "expected pieces that do not overlap, but %s reaches into %s",
                     named(&mesh->pieces[i], i, one), named(&mesh->pieces[j], j, other));
            return true;
        }
    return false;
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
    if (fault == SCENE_SHAPE_FINE && pieces_overlap(shape, size, &mesh, error)) fault = SCENE_SHAPE_BAD_FILE;
    mesh_free(&mesh);
    return fault == SCENE_SHAPE_FINE ? complete(shape) : fault;
}
