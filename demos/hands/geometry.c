/* Meshes of a hand: hulls and masses. */

#include "geometry.h"

#include "inertia.h"

#include <ctype.h>
#include <stdlib.h>

int geometry_mesh(hand_reader *r, const xmlNode *at, const char *name, const char *file, const double scale[3])
{
    hand *h = r->h;
    for (size_t i = 0; i < h->mesh_count; i++)
        if (strcmp(h->meshes[i].file, file) == 0 && strcmp(h->meshes[i].name, name) == 0 &&
            memcmp(h->meshes[i].scale, scale, sizeof h->meshes[i].scale) == 0)
            return (int)i;
    for (int i = 0; i < 3; i++)
        if (scale[i] == 0) reader_refuse(r, at, "expected a scale that is not 0");
    char *own_name = reader_text(r, "%s", name), *own_file = reader_text(r, "%s", file);
    hand_mesh *mesh = reader_append(r, &h->meshes, &h->mesh_count, sizeof *mesh);
    if (!mesh) return -1;
    *mesh = (hand_mesh){.name = own_name, .file = own_file};
    scene_copy(scale, mesh->scale);
    return (int)h->mesh_count - 1;
}

void geometry_hull(hand_reader *r, const xmlNode *at, int index, const mesh_file *triangles)
{
    if (r->status != HAND_OK || index < 0) return;
    hand_mesh *mesh = &r->h->meshes[index];
    if (mesh->hull.vertex_count) return;
    switch (mesh_hull_of_points(triangles->corners, 3 * triangles->triangle_count, &mesh->hull)) {
    case MESH_HULL_FINE:
        return;
    case MESH_HULL_FLAT:
        reader_refuse(r, at, "expected a mesh that spans a volume: %s is flat", mesh->file);
        return;
    default:
        reader_no_memory(r);
    }
}

bool geometry_read(hand_reader *r, const xmlNode *at, const char *file, mesh_file *mesh)
{
    char error[256];
    memset(mesh, 0, sizeof *mesh);
    if (r->status != HAND_OK) return false;
    switch (mesh_read_any(file, mesh, error)) {
    case MESH_OK:
        return true;
    case MESH_BAD:
        return reader_refuse(r, at, "mesh %s: %s", file, error);
    default:
        return reader_no_memory(r);
    }
}

/* Area, unit normal and middle of a triangle. Slivers have area 0. */
static double triangle(const double *x, double normal[3], double middle[3])
{
    double b[3], c[3];
    scene_subtract(x + 3, x, b);
    scene_subtract(x + 6, x, c);
    scene_cross(b, c, normal);
    for (int i = 0; i < 3; i++) middle[i] = (x[i] + x[3 + i] + x[6 + i]) / 3;
    double length = sqrt(scene_dot(normal, normal));
    if (!(length >= 1e-15)) return 0;
    for (int i = 0; i < 3; i++) normal[i] /= length;
    return 0.5 * length;
}

static void middle_of_faces(const mesh_file *mesh, double middle[3])
{
    double sum = 0, at[3] = {0}, normal[3], own[3];
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        double area = triangle(mesh->corners + 9 * t, normal, own);
        scene_add_scaled(at, area, own);
        sum += area;
    }
    for (int i = 0; i < 3; i++) middle[i] = sum > 0 ? at[i] / sum : 0;
}

/* What a triangle weighs: its area, or the volume of the tetrahedron to the point o. */
static double weight(const double *corners, const double o[3], mesh_inertia mode, double middle[3])
{
    double normal[3], d[3], area = triangle(corners, normal, middle);
    if (mode == MESH_SHELL) return area;
    scene_subtract(middle, o, d);
    double volume = scene_dot(d, normal) * area / 3;
    return mode == MESH_LEGACY ? fabs(volume) : volume;
}

/* With the corners a, b, c relative to o and s = a + b + c, a tetrahedron of volume v has the second moment
 * v/20 (s s^T + a a^T + b b^T + c c^T), and a triangle of area v has it with 12 in place of 20. */
static void add_second_moment(const double *corners, const double o[3], double v, double part, double second[9])
{
    double e[3][3], s[3] = {0};
    for (int k = 0; k < 3; k++) {
        scene_subtract(corners + 3 * k, o, e[k]);
        scene_add_scaled(s, 1, e[k]);
    }
    for (int i = 0; i < 9; i++) {
        double sum = s[i / 3] * s[i % 3];
        for (int k = 0; k < 3; k++) sum += e[k][i / 3] * e[k][i % 3];
        second[i] += v / part * sum;
    }
}

static void inertia_of_second(const double second[9], double inertia[9])
{
    double trace = second[0] + second[4] + second[8];
    for (int i = 0; i < 9; i++) inertia[i] = (i % 4 ? 0 : trace) - second[i];
}

/* The centre counts tetrahedra to the middle of the faces, the inertia tetrahedra to that centre. For a closed mesh
 * that is the same; for others it is what MuJoCo does. */
static void triangle_mass(const mesh_file *mesh, mesh_inertia mode, hand_mass *mass)
{
    double o[3], middle[3], second[9] = {0};
    memset(mass, 0, sizeof *mass);
    middle_of_faces(mesh, o);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        double v = weight(mesh->corners + 9 * t, o, mode, middle);
        for (int i = 0; i < 3; i++) mass->centre[i] += v * (0.75 * middle[i] + 0.25 * o[i]);
        mass->mass += v;
    }
    if (!(mass->mass > 0)) return;
    for (int i = 0; i < 3; i++) mass->centre[i] /= mass->mass;
    mass->mass = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        double v = weight(mesh->corners + 9 * t, mass->centre, mode, middle);
        add_second_moment(mesh->corners + 9 * t, mass->centre, v, mode == MESH_SHELL ? 12 : 20, second);
        mass->mass += v;
    }
    inertia_of_second(second, mass->inertia);
}

static bool hull_mass(hand_reader *r, const xmlNode *at, const mesh_file *mesh, hand_mass *mass)
{
    mesh_hull hull;
    double second[9];
    switch (mesh_hull_of_points(mesh->corners, 3 * mesh->triangle_count, &hull)) {
    case MESH_HULL_FINE:
        break;
    case MESH_HULL_FLAT:
        return reader_refuse(r, at, "expected a mesh that spans a volume");
    default:
        return reader_no_memory(r);
    }
    mesh_hull_moments(&hull, &mass->mass, mass->centre, second);
    for (int i = 0; i < 9; i++) second[i] -= mass->mass * mass->centre[i / 3] * mass->centre[i % 3];
    inertia_of_second(second, mass->inertia);
    mesh_hull_free(&hull);
    return true;
}

bool geometry_mesh_mass(hand_reader *r, const xmlNode *at, const mesh_file *mesh, mesh_inertia mode, hand_mass *mass)
{
    memset(mass, 0, sizeof *mass);
    if (r->status != HAND_OK) return false;
    if (mode == MESH_CONVEX) {
        if (!hull_mass(r, at, mesh, mass)) return false;
    } else {
        triangle_mass(mesh, mode, mass);
    }
    if (mass->mass >= 1e-15 && inertia_is_possible(mass->inertia, INERTIA_DIGITS)) return true;
    return reader_refuse(r, at, "expected a mesh with a volume, but its triangles enclose %g m^3", mass->mass);
}

void geometry_check_mass(hand_reader *r, const xmlNode *at, const hand_mass *mass, double part)
{
    if (r->status != HAND_OK) return;
    if (mass->mass < 0)
        reader_refuse(r, at, "expected a mass that is not negative, not %g", mass->mass);
    else if (!inertia_is_possible(mass->inertia, part))
        reader_refuse(r, at,
                      "expected an inertia that a body can have: no moment negative, and none larger than the "
                      "sum of the other two");
    else if (!inertia_is_possible(mass->inertia, INERTIA_DIGITS))
        reader_ignore(r, at, "inertia with a moment larger than the sum of the others");
}

bool geometry_euler(const double angles[3], const char *sequence, double q[4])
{
    double product[4];
    memcpy(q, (double[4]){1, 0, 0, 0}, sizeof product);
    for (int i = 0; i < 3; i++) {
        int letter = tolower((unsigned char)sequence[i]);
        if (letter < 'x' || letter > 'z') return false;
        double turn[4] = {cos(0.5 * angles[i])};
        turn[1 + letter - 'x'] = sin(0.5 * angles[i]);
        if (sequence[i] == letter)
            scene_quaternion_product(q, turn, product);
        else
            scene_quaternion_product(turn, q, product);
        memcpy(q, product, sizeof product);
    }
    return pose_normalize(q);
}
