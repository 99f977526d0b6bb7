#include "hull.h"

#include "support/vec3.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

typedef struct half_edge {
    unsigned from, to, face;
} half_edge;

static int by_corners(const void *a, const void *b)
{
    const half_edge *x = a, *y = b;
    unsigned xl = x->from < x->to ? x->from : x->to, yl = y->from < y->to ? y->from : y->to;
    unsigned xh = x->from + x->to - xl, yh = y->from + y->to - yl;
    return xl != yl             ? (xl < yl ? -1 : 1)
           : xh != yh           ? (xh < yh ? -1 : 1)
           : x->from != y->from ? (x->from < y->from ? -1 : 1)
                                : 0;
}

static size_t corner_count(const pinch_convex *convex)
{
    size_t count = 0;
    const unsigned *polygon = convex->polygons;
    for (unsigned f = 0; f < convex->plane_count; f++, polygon += 1 + polygon[0]) count += polygon[0];
    return count;
}

static bool find_edges(const pinch_convex *convex, size_t corners, half_edge *half, pinch_hull_edge *edges, int *found)
{
    size_t n = 0;
    const unsigned *polygon = convex->polygons;
    bool closed = corners % 2 == 0;
    for (unsigned f = 0; f < convex->plane_count; f++, polygon += 1 + polygon[0])
        for (unsigned k = 0; k < polygon[0]; k++)
            half[n++] = (half_edge){polygon[1 + k], polygon[1 + (k + 1) % polygon[0]], f};
    qsort(half, corners, sizeof *half, by_corners);
    for (size_t k = 0; k + 1 < corners && closed; k += 2) {
        closed = half[k].from == half[k + 1].to && half[k].to == half[k + 1].from;
        edges[(*found)++] = (pinch_hull_edge){{half[k].from, half[k].to}, {half[k].face, half[k + 1].face}};
    }
    return closed;
}

/* The sides lead away from the face's middle, whichever way round its corners come. */
static void find_sides(const pinch_convex *convex, const unsigned *polygon, const double *normal, double *sides)
{
    double middle[3] = {0, 0, 0};
    for (unsigned k = 0; k < polygon[0]; k++)
        pinch_v3_add_scaled(middle, 1.0 / polygon[0], convex->points + 3 * polygon[1 + k]);
    for (unsigned k = 0; k < polygon[0]; k++, sides += 4) {
        const double *from = convex->points + 3 * polygon[1 + k];
        double edge[3];
        pinch_v3_sub(convex->points + 3 * polygon[1 + (k + 1) % polygon[0]], from, edge);
        pinch_v3_cross(edge, normal, sides);
        double length = pinch_v3_norm(sides);
        if (length > 0) pinch_v3_scale(sides, 1 / length);
        sides[3] = pinch_v3_dot(sides, from);
        if (pinch_v3_dot(sides, middle) <= sides[3]) continue;
        for (int i = 0; i < 4; i++) sides[i] = -sides[i];
    }
}

static void find_extent(const pinch_convex *convex, pinch_hull_face *face)
{
    const unsigned *corner = face->polygon + 1, count = face->polygon[0];
    double d[3], far2 = 0;
    pinch_v3_set(face->centre, 0, 0, 0);
    for (unsigned k = 0; k < count; k++) pinch_v3_add_scaled(face->centre, 1.0 / count, convex->points + 3 * corner[k]);
    for (unsigned k = 0; k < count; k++) {
        pinch_v3_sub(convex->points + 3 * corner[k], face->centre, d);
        far2 = fmax(far2, pinch_v3_dot(d, d));
    }
    face->radius = sqrt(far2);
    pinch_v3_sub(convex->points + 3 * corner[count / 2], convex->points + 3 * corner[0], d);
    face->across2 = pinch_v3_dot(d, d);
}

/* Computes each face's offset along its normal, its sides and its extent. */
static void find_faces(const pinch_hull *hull, pinch_hull_face *faces, double *sides, double *columns)
{
    const pinch_convex *convex = &hull->convex;
    const unsigned *polygon = convex->polygons;
    for (unsigned f = 0; f < convex->plane_count; f++, sides += 4 * polygon[0], polygon += 1 + polygon[0]) {
        const double *normal = convex->planes + 4 * f;
        double offset = pinch_v3_dot(normal, convex->points + 3 * (size_t)pinch_hull_support_vertex(hull, normal));
        find_sides(convex, polygon, normal, sides);
        faces[f] = (pinch_hull_face){.polygon = polygon, .sides = sides, .offset = offset};
        find_extent(convex, &faces[f]);
        for (int i = 0; i < 3; i++) columns[i * (size_t)convex->plane_count + f] = normal[i];
        columns[3 * (size_t)convex->plane_count + f] = offset;
    }
}

/* Sorts the faces by vertex: first how many each vertex has, then where they start, then the faces themselves. */
static void find_corners(const pinch_convex *convex, const pinch_hull_face *faces, unsigned *faces_at,
                         unsigned *corner_faces)
{
    const unsigned *polygon = convex->polygons, count = convex->point_count;
    for (unsigned k = 0; k <= count; k++) faces_at[k] = 0;
    for (unsigned f = 0; f < convex->plane_count; f++, polygon += 1 + polygon[0])
        for (unsigned k = 1; k <= polygon[0]; k++) faces_at[polygon[k]]++;
    for (unsigned k = 1; k <= count; k++) faces_at[k] += faces_at[k - 1];
    for (unsigned f = convex->plane_count; f-- > 0;) { /* filling from behind moves the starts to their places */
        polygon = faces[f].polygon;
        for (unsigned k = 1; k <= polygon[0]; k++) corner_faces[--faces_at[polygon[k]]] = f;
    }
}

/* Sorts the other ends of all edges by vertex. */
static void find_neighbours(const pinch_hull *hull, unsigned *neighbours_at, unsigned *neighbours)
{
    const unsigned count = hull->convex.point_count;
    for (unsigned k = 0; k <= count; k++) neighbours_at[k] = 0;
    for (int e = 0; e < hull->edge_count; e++)
        for (int end = 0; end < 2; end++) neighbours_at[hull->edges[e].corner[end]]++;
    for (unsigned k = 1; k <= count; k++) neighbours_at[k] += neighbours_at[k - 1];
    for (int e = 0; e < hull->edge_count; e++)
        for (int end = 0; end < 2; end++) {
            const unsigned *corner = hull->edges[e].corner;
            neighbours[--neighbours_at[corner[end]]] = corner[!end];
        }
}

static void find_arcs(const pinch_hull *hull, pinch_edge_arc *arcs)
{
    const pinch_convex *convex = &hull->convex;
    for (int e = 0; e < hull->edge_count; e++) {
        const pinch_hull_edge *edge = &hull->edges[e];
        pinch_edge_arc *arc = &arcs[e];
        pinch_v3_copy(arc->v, convex->points + 3 * edge->corner[0]);
        pinch_v3_sub(convex->points + 3 * edge->corner[1], arc->v, arc->u);
        pinch_v3_scale(arc->u, 1 / pinch_v3_norm(arc->u));
        pinch_v3_copy(arc->n1, convex->planes + 4 * edge->face[0]);
        pinch_v3_copy(arc->n2, convex->planes + 4 * edge->face[1]);
    }
}

static void find_balls(pinch_hull *hull)
{
    const pinch_convex *convex = &hull->convex;
    for (unsigned k = 0; k < convex->point_count; k++) {
        const double *x = convex->points + 3 * k;
        hull->outer = fmax(hull->outer, pinch_v3_norm(x));
        pinch_v3_add_scaled(hull->centre, 1.0 / convex->point_count, x);
    }
    hull->inner = hull->outer;
    for (unsigned f = 0; f < convex->plane_count; f++)
        hull->inner = fmin(hull->inner, hull->faces[f].offset - pinch_v3_dot(convex->planes + 4 * f, hull->centre));
    hull->inner = fmax(hull->inner, 0);
}

static void find_bits(const pinch_hull *hull, uint64_t *edges_of_face, uint64_t *corners_of_face)
{
    for (unsigned f = 0; f < hull->convex.plane_count; f++) {
        const unsigned *polygon = hull->faces[f].polygon;
        edges_of_face[f] = corners_of_face[f] = 0;
        for (unsigned k = 1; k <= polygon[0]; k++) corners_of_face[f] |= UINT64_C(1) << polygon[k];
    }
    for (int e = 0; e < hull->edge_count; e++)
        for (int side = 0; side < 2; side++) edges_of_face[hull->edges[e].face[side]] |= UINT64_C(1) << e;
}

/*
 * Where an edge is not quite at right angles to its faces' normals, or a corner is not quite in its face's plane, the
 * normals of the faces tell nothing of the edge. Such faces are loose. Tiny edges of meshes have them.
 */
static void find_loose_faces(const pinch_hull *hull, uint64_t *loose)
{
    static const double SQUARE = 1e-5;
    const pinch_convex *convex = &hull->convex;
    for (unsigned f = 0; f < convex->plane_count; f++) {
        const unsigned *polygon = hull->faces[f].polygon;
        double least = hull->faces[f].offset - SQUARE * hull->outer;
        bool flat = true;
        for (unsigned k = 1; k <= polygon[0] && flat; k++)
            flat = pinch_v3_dot(convex->planes + 4 * (size_t)f, convex->points + 3 * (size_t)polygon[k]) >= least;
        if (f % 64 == 0) loose[f / 64] = 0;
        loose[f / 64] |= (uint64_t)!flat << f % 64;
    }
    for (int e = 0; e < hull->edge_count; e++) {
        const pinch_edge_arc *arc = &hull->arcs[e];
        unsigned f = hull->edges[e].face[0];
        bool square = fabs(pinch_v3_dot(arc->u, arc->n1)) <= SQUARE && fabs(pinch_v3_dot(arc->u, arc->n2)) <= SQUARE;
        if (!square) loose[f / 64] |= UINT64_C(1) << f % 64;
    }
}

/* All arrays share one piece of memory. With `base` NULL, lay_out only measures it. It returns the size. */
typedef struct found {
    pinch_hull_face *faces;
    pinch_hull_edge *edges;
    pinch_edge_arc *arcs;
    double *sides, *columns, *corners;
    uint64_t *edges_of_face, *corners_of_face, *loose_faces;
    unsigned *faces_at, *corner_faces, *neighbours_at, *neighbours;
} found;

static void *take(char *base, size_t *at, size_t bytes)
{
    void *place = base ? base + *at : NULL;
    *at += (bytes + 7) / 8 * 8;
    return place;
}

static size_t lay_out(const pinch_convex *convex, size_t corners, char *base, found *f)
{
    size_t faces = convex->plane_count, points = convex->point_count, edges = corners / 2 + 1, at = 0;
    f->faces = take(base, &at, faces * sizeof *f->faces);
    f->arcs = take(base, &at, edges * sizeof *f->arcs);
    f->sides = take(base, &at, 4 * corners * sizeof *f->sides);
    f->columns = take(base, &at, 4 * faces * sizeof *f->columns);
    f->corners = take(base, &at, 3 * points * sizeof *f->corners);
    f->edges_of_face = take(base, &at, faces * sizeof *f->edges_of_face);
    f->corners_of_face = take(base, &at, faces * sizeof *f->corners_of_face);
    f->loose_faces = take(base, &at, (faces + 63) / 64 * sizeof *f->loose_faces);
    f->edges = take(base, &at, edges * sizeof *f->edges);
    f->faces_at = take(base, &at, (points + 1) * sizeof *f->faces_at);
    f->corner_faces = take(base, &at, corners * sizeof *f->corner_faces);
    f->neighbours_at = take(base, &at, (points + 1) * sizeof *f->neighbours_at);
    f->neighbours = take(base, &at, corners * sizeof *f->neighbours);
    return at;
}

/* Returns false when the faces do not close or memory runs out. */
static bool edges_of(const pinch_convex *convex, size_t corners, pinch_hull_edge *edges, int *count)
{
    half_edge *half = malloc(corners * sizeof *half);
    bool closed = half && find_edges(convex, corners, half, edges, count);
    free(half);
    return closed;
}

enum { BITS = 64, SCANNED = 128 }; /* a tree of no more vertices would be no faster than a look at all of them */

bool pinch_hull_of_convex(const pinch_convex *convex, pinch_hull *hull)
{
    size_t corners = corner_count(convex), points = convex->point_count;
    found f;
    memset(hull, 0, sizeof *hull);
    char *memory = malloc(lay_out(convex, corners, NULL, &f));
    if (!memory) return false;
    (void)lay_out(convex, corners, memory, &f);
    *hull = (pinch_hull){.convex = *convex,
                         .memory = memory,
                         .edges = f.edges,
                         .arcs = f.arcs,
                         .faces = f.faces,
                         .neighbours_at = f.neighbours_at,
                         .neighbours = f.neighbours,
                         .faces_at = f.faces_at,
                         .corner_faces = f.corner_faces,
                         .loose_faces = f.loose_faces,
                         .columns = f.columns,
                         .corners = f.corners};
    if (!edges_of(convex, corners, f.edges, &hull->edge_count)) {
        pinch_hull_free(hull);
        return false;
    }
    for (size_t k = 0; k < 3 * points; k++) f.corners[k % 3 * points + k / 3] = convex->points[k];
    if (points > SCANNED && !pinch_hull_build_tree(hull)) {
        pinch_hull_free(hull);
        return false;
    }
    find_faces(hull, f.faces, f.sides, f.columns);
    find_corners(convex, f.faces, f.faces_at, f.corner_faces);
    find_neighbours(hull, f.neighbours_at, f.neighbours);
    find_arcs(hull, f.arcs);
    if (convex->plane_count <= BITS && points <= BITS && hull->edge_count <= BITS) {
        find_bits(hull, f.edges_of_face, f.corners_of_face);
        hull->edges_of_face = f.edges_of_face;
        hull->corners_of_face = f.corners_of_face;
    }
    find_balls(hull);
    find_loose_faces(hull, f.loose_faces);
    return true;
}

void pinch_hull_free(pinch_hull *hull)
{
    pinch_hull_free_tree(hull);
    free(hull->memory);
    memset(hull, 0, sizeof *hull);
}

unsigned pinch_hull_scan_vertices(const pinch_hull *hull, const double d[3])
{
    enum { BLOCK = 32 };
    const size_t points = hull->convex.point_count;
    const double *x = hull->corners, *y = x + points, *z = y + points, dx = d[0], dy = d[1], dz = d[2];
    double most = -DBL_MAX, along[BLOCK];
    size_t best = 0;
    for (size_t first = 0; first < points; first += BLOCK, x += BLOCK, y += BLOCK, z += BLOCK) {
        size_t count = points - first < BLOCK ? points - first : BLOCK;
        for (size_t k = 0; k < count; k++) along[k] = x[k] * dx + y[k] * dy + z[k] * dz;
        for (size_t k = 0; k < count; k++) {
            best = along[k] > most ? first + k : best;
            most = along[k] > most ? along[k] : most;
        }
    }
    return (unsigned)best;
}

double pinch_hull_border_distance(const pinch_hull *hull, int face, const double x[3])
{
    const double *side = hull->faces[face].sides;
    double room = DBL_MAX;
    for (unsigned k = 0; k < hull->faces[face].polygon[0]; k++, side += 4) {
        double to = side[3] - pinch_v3_dot(side, x);
        room = to < room ? to : room;
    }
    return room;
}
