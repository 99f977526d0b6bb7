#include "triangles.h"

#include "common/vector.h"
#include "scenes/shape/shape.h"

#include <stdlib.h>
#include <string.h>

/* Around the axis, and from pole to pole. Multiples of four put vertices on the axes. */
enum { AROUND = 32, QUARTER = AROUND / 4 };

/* A vertex: its place and the direction of its normal, which may have any length. */
typedef struct corner {
    double position[3], normal[3];
} corner;

static bool grow(void **list, size_t *room, size_t needed, size_t size)
{
    if (needed <= *room) return true;
    size_t more = 2 * needed + 64;
    void *larger = realloc(*list, more * size);
    if (!larger) return false;
    *list = larger;
    *room = more;
    return true;
}

static bool vertex_room(triangles *t, size_t count)
{
    size_t room = t->vertex_room, needed = t->vertex_count + count;
    return grow((void **)&t->normals, &room, needed, 3 * sizeof *t->normals) &&
           grow((void **)&t->positions, &t->vertex_room, needed, 3 * sizeof *t->positions);
}

static void add_vertex(triangles *t, const corner *c, const double pose[7])
{
    double position[3], normal[3], length = scene_norm(c->normal);
    scene_rotate(pose + 3, c->position, position);
    scene_rotate(pose + 3, c->normal, normal);
    for (int i = 0; i < 3; i++) {
        t->positions[3 * t->vertex_count + (size_t)i] = (float)(position[i] + pose[i]);
        t->normals[3 * t->vertex_count + (size_t)i] = (float)(normal[i] / length);
    }
    t->vertex_count++;
}

static bool same_place(const triangles *t, size_t a, size_t b)
{
    return memcmp(t->positions + 3 * a, t->positions + 3 * b, 3 * sizeof *t->positions) == 0;
}

/* A triangle with two corners in one place, as at a pole, is left out. */
static void add_triangle(triangles *t, size_t a, size_t b, size_t c)
{
    if (same_place(t, a, b) || same_place(t, b, c) || same_place(t, c, a)) return;
    t->indices[t->index_count++] = (uint32_t)a;
    t->indices[t->index_count++] = (uint32_t)b;
    t->indices[t->index_count++] = (uint32_t)c;
}

/* ---- Surfaces that are a grid: from pole to pole in rows, around the axis in columns. ---- */

typedef struct grid {
    int rows, columns;
    corner (*at)(const void *context, int row, int column);
    const void *context;
} grid;

static bool add_grid(triangles *t, const grid *g, const double pose[7])
{
    size_t first = t->vertex_count, columns = (size_t)g->columns, cells = (size_t)(g->rows - 1) * (columns - 1);
    if (!vertex_room(t, (size_t)g->rows * columns)) return false;
    if (!grow((void **)&t->indices, &t->index_room, t->index_count + 6 * cells, sizeof *t->indices)) return false;
    for (int r = 0; r < g->rows; r++)
        for (int c = 0; c < g->columns; c++) {
            corner now = g->at(g->context, r, c);
            add_vertex(t, &now, pose);
        }
    for (int r = 0; r + 1 < g->rows; r++)
        for (size_t c = 0; c + 1 < columns; c++) {
            size_t a = first + (size_t)r * columns + c, b = a + columns;
            add_triangle(t, a, b, b + 1);
            add_triangle(t, a, b + 1, a + 1);
        }
    return true;
}

/* A profile that turns about z: radius, height, and the normal's parts along them, from +z to -z. */
enum { PROFILE_ROOM = 4 * QUARTER + 8 };
typedef struct profile {
    int count;
    double r[PROFILE_ROOM], z[PROFILE_ROOM], nr[PROFILE_ROOM], nz[PROFILE_ROOM];
} profile;

static void add_profile(profile *p, double r, double z, double nr, double nz)
{
    p->r[p->count] = r;
    p->z[p->count] = z;
    p->nr[p->count] = nr;
    p->nz[p->count++] = nz;
}

/* A quarter of a circle about (r, z) from the angle `from` (a multiple of 90 degrees above the plane) downwards. */
static void add_arc(profile *p, const double centre[2], double radius, int from)
{
    for (int k = 0; k <= QUARTER; k++) {
        double angle = 0.5 * SCENE_PI * (from - (double)k / QUARTER);
        bool on_axis = k == (from == 1 ? 0 : QUARTER), level = k == (from == 1 ? QUARTER : 0);
        double c = on_axis ? 0 : cos(angle), s = level ? 0 : sin(angle);
        add_profile(p, centre[0] + radius * c, centre[1] + radius * s, c, s);
    }
}

static corner on_profile(const void *context, int row, int column)
{
    const profile *p = context;
    double angle = 2 * SCENE_PI * (column % AROUND) / AROUND, c = cos(angle), s = sin(angle);
    return (corner){{p->r[row] * c, p->r[row] * s, p->z[row]}, {p->nr[row] * c, p->nr[row] * s, p->nz[row]}};
}

static bool add_turned(triangles *t, const profile *p, const double pose[7])
{
    return add_grid(t, &(grid){p->count, AROUND + 1, on_profile, p}, pose);
}

/* A cylinder between two heights with rounded rims; `top` and `bottom` are the rims' radii of rounding. */
static profile cylinder_profile(double radius, const double heights[2], double top, double bottom)
{
    profile p = {.count = 0};
    if (top < radius) add_profile(&p, 0, heights[1], 0, 1);
    if (top > 0) {
        add_arc(&p, (double[2]){radius - top, heights[1] - top}, top, 1);
    } else {
        add_profile(&p, radius, heights[1], 0, 1);
        add_profile(&p, radius, heights[1], 1, 0);
    }
    if (bottom > 0) {
        add_arc(&p, (double[2]){radius - bottom, heights[0] + bottom}, bottom, 0);
    } else {
        add_profile(&p, radius, heights[0], 1, 0);
        add_profile(&p, radius, heights[0], 0, -1);
    }
    if (bottom < radius) add_profile(&p, 0, heights[0], 0, -1);
    return p;
}

/* An ellipsoid or superellipsoid, by the angles of its ellipses. Powers of the sine and cosine keep the vertices evenly
 * spread over edges that are rounded or pointed. */
static corner on_ellipsoid(const void *context, int row, int column)
{
    const scene_shape *shape = context;
    bool super = shape->type == SCENE_SUPERELLIPSOID;
    const double *radii = super ? shape->u.superellipsoid.radii : shape->u.ellipsoid.radii;
    const double e1 = super ? shape->u.superellipsoid.exponents[0] : 1;
    const double e2 = super ? shape->u.superellipsoid.exponents[1] : 1;
    double up = SCENE_PI * (0.5 - (double)row / (2 * QUARTER)), around = 2 * SCENE_PI * (column % AROUND) / AROUND;
    double cu = row % (2 * QUARTER) ? cos(up) : 0, su = sin(up), ca = cos(around), sa = sin(around);
    if (column % (2 * QUARTER) == QUARTER) ca = 0;
    if (column % (2 * QUARTER) == 0) sa = 0;
    if (row == QUARTER) su = 0;
    double ring = pow(cu, e1);
    corner c = {{radii[0] * ring * copysign(pow(fabs(ca), e2), ca), radii[1] * ring * copysign(pow(fabs(sa), e2), sa),
                 radii[2] * copysign(pow(fabs(su), e1), su)},
                {0, 0, 0}};
    if (super)
        scene_superellipsoid_normal(shape, c.position, c.normal);
    else
        for (int i = 0; i < 3; i++) c.normal[i] = c.position[i] / (radii[i] * radii[i]);
    if (!(scene_norm(c.normal) > 0) || !isfinite(scene_norm(c.normal))) scene_copy(c.position, c.normal);
    return c;
}

/* A box with rounded edges is a ball cut into eight parts, which are drawn apart to the box's corners. The first and
 * the last row are the middles of the flat faces at +z and -z. */
static corner on_rounded_box(const void *context, int row, int column)
{
    const scene_shape *shape = context;
    const double *size = shape->u.box.size, rounding = shape->u.box.rounding;
    int last = 2 * QUARTER + 3, octant = column / (QUARTER + 1) % 4;
    bool upper = row <= QUARTER + 1;
    double up = 0.5 * SCENE_PI * (upper ? 1 - (double)(row - 1) / QUARTER : -(double)(row - QUARTER - 2) / QUARTER);
    double around = 0.5 * SCENE_PI * (octant + (double)(column % (QUARTER + 1)) / QUARTER);
    double sign[3] = {octant == 0 || octant == 3 ? 1 : -1, octant < 2 ? 1 : -1, upper ? 1 : -1};
    if (row == 0 || row == last) return (corner){{0, 0, 0.5 * sign[2] * size[2]}, {0, 0, sign[2]}};
    bool pole = row == 1 || row == last - 1;
    corner c = {.normal = {pole ? 0 : cos(up) * cos(around), pole ? 0 : cos(up) * sin(around), sin(up)}};
    for (int i = 0; i < 3; i++) c.position[i] = sign[i] * (0.5 * size[i] - rounding) + rounding * c.normal[i];
    return c;
}

/* ---- Surfaces with flat faces. ---- */

static bool add_face(triangles *t, const double (*corners)[3], unsigned count, const double pose[7])
{
    size_t first = t->vertex_count;
    corner c = {.normal = {0, 0, 0}};
    double one[3], other[3], part[3];
    if (!vertex_room(t, count)) return false;
    if (!grow((void **)&t->indices, &t->index_room, t->index_count + (size_t)3 * count, sizeof *t->indices))
        return false;
    for (unsigned k = 1; k + 1 < count; k++) {
        scene_subtract(corners[k], corners[0], one);
        scene_subtract(corners[k + 1], corners[0], other);
        scene_cross(one, other, part);
        scene_add_scaled(c.normal, 1, part);
    }
    if (!(scene_norm(c.normal) > 0)) return true;
    for (unsigned k = 0; k < count; k++) {
        scene_copy(corners[k], c.position);
        add_vertex(t, &c, pose);
    }
    for (unsigned k = 1; k + 1 < count; k++) add_triangle(t, first, first + k, first + k + 1);
    return true;
}

static bool add_hull(triangles *t, const scene_hull *hull, const double pose[7])
{
    const unsigned *polygon = hull->polygons;
    bool done = true;
    for (size_t f = 0; f < hull->face_count && done; f++) {
        double(*corners)[3] = calloc(*polygon, sizeof *corners);
        if (!corners) return false;
        for (unsigned k = 0; k < *polygon; k++) scene_copy(hull->vertices + (size_t)3 * polygon[1 + k], corners[k]);
        done = add_face(t, (const double(*)[3])corners, *polygon, pose);
        free(corners);
        polygon += *polygon + 1;
    }
    return done;
}

static bool add_sharp_box(triangles *t, const double size[3], const double pose[7])
{
    bool done = true;
    for (int face = 0; face < 6 && done; face++) {
        int i = face / 2, j = (i + 1) % 3, k = (i + 2) % 3;
        double side = face % 2 ? 0.5 : -0.5, corners[4][3];
        static const double turn[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
        for (int c = 0; c < 4; c++) {
            corners[c][i] = side * size[i];
            corners[c][j] = side * turn[c][0] * size[j];
            corners[c][k] = 0.5 * turn[c][1] * size[k];
        }
        done = add_face(t, (const double(*)[3])corners, 4, pose);
    }
    return done;
}

/* ---- All shapes. ---- */

static bool add_round(triangles *t, const scene_shape *shape, const double pose[7])
{
    double radius, rounding = 0, heights[2];
    profile p;
    switch (shape->type) {
    case SCENE_SPHERE:
        radius = shape->u.sphere.radius;
        p = cylinder_profile(radius, (double[2]){-radius, radius}, radius, radius);
        break;
    case SCENE_CAPSULE:
        radius = shape->u.capsule.radius;
        heights[1] = 0.5 * shape->u.capsule.length + radius;
        p = cylinder_profile(radius, (double[2]){-heights[1], heights[1]}, radius, radius);
        break;
    case SCENE_FLAT_CAPSULE:
        radius = shape->u.flat_capsule.radius;
        heights[0] = scene_flat_capsule_middle(shape) - 0.5 * shape->u.flat_capsule.length;
        heights[1] = heights[0] + shape->u.flat_capsule.length + radius;
        p = cylinder_profile(radius, heights, radius, 0);
        break;
    default: /* cylinder */
        radius = shape->u.cylinder.radius;
        rounding = shape->u.cylinder.rounding;
        heights[1] = 0.5 * shape->u.cylinder.length;
        p = cylinder_profile(radius, (double[2]){-heights[1], heights[1]}, rounding, rounding);
    }
    return add_turned(t, &p, pose);
}

bool triangles_add_shape(triangles *t, const scene_shape *shape, const double pose[7])
{
    bool done = true;
    switch (shape->type) {
    case SCENE_BOX:
        if (!(shape->u.box.rounding > 0)) return add_sharp_box(t, shape->u.box.size, pose);
        return add_grid(t, &(grid){2 * QUARTER + 4, 4 * (QUARTER + 1) + 1, on_rounded_box, shape}, pose);
    case SCENE_ELLIPSOID:
    case SCENE_SUPERELLIPSOID:
        return add_grid(t, &(grid){2 * QUARTER + 1, AROUND + 1, on_ellipsoid, shape}, pose);
    case SCENE_CONVEX:
    case SCENE_PRISM:
        return add_hull(t, &shape->hull, pose);
    case SCENE_MESH:
        for (size_t k = 0; k < shape->piece_count && done; k++) done = add_hull(t, &shape->pieces[k], pose);
        return done;
    default:
        return add_round(t, shape, pose);
    }
}

/* Turns +z to +y. */
static const double UPRIGHT[7] = {0, 0, 0, 0.70710678118654752, -0.70710678118654752, 0, 0};

bool triangles_add_arrow(triangles *t, double radius, double head, double head_radius)
{
    profile p = {.count = 0};
    double slope = hypot(head, head_radius);
    add_profile(&p, 0, 1, head / slope, head_radius / slope);
    add_profile(&p, head_radius, 1 - head, head / slope, head_radius / slope);
    add_profile(&p, head_radius, 1 - head, 0, -1);
    add_profile(&p, radius, 1 - head, 0, -1);
    add_profile(&p, radius, 1 - head, 1, 0);
    add_profile(&p, radius, 0, 1, 0);
    add_profile(&p, radius, 0, 0, -1);
    add_profile(&p, 0, 0, 0, -1);
    return add_turned(t, &p, UPRIGHT);
}

bool triangles_add_cone(triangles *t)
{
    profile p = {.count = 0};
    add_profile(&p, 1, 1, 1, -1);
    add_profile(&p, 0, 0, 1, -1);
    return add_turned(t, &p, UPRIGHT);
}

void triangles_free(triangles *t)
{
    free(t->positions);
    free(t->normals);
    free(t->indices);
    *t = (triangles){.positions = NULL};
}
