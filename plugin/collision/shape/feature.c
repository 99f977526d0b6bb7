#include "feature.h"

#include "support/vec3.h"

#include <float.h>
#include <math.h>

enum { CORNERS = 32 };

#define S 0.70710678118654752
const double PINCH_RIM_CORNER[PINCH_RIM][2] = {{1, 0}, {S, S}, {0, 1}, {-S, S}, {-1, 0}, {-S, -S}, {0, -1}, {S, -S}};

/* A vertex this near to the farthest one (of the size) counts as equally far. */
static const double TIE = 1e-8;

/* of half the angle between two corners of the rim polygon */
static const double COSINE_OF_HALF = 0.92387953251128676;

static void add(pinch_feature *part, double x, double y, double z)
{
    if (part->count < CORNERS) pinch_v3_set(part->x[part->count++], x, y, z);
}

/*
 * A regular polygon that is fixed to the body stands for a rim: equal forces at its corners have the resultant of the
 * whole rim, whichever way the body is rotated. When the cap is tilted, the lowest point of the rim replaces the corner
 * next to it.
 */
void pinch_rim_polygon(const pinch_cap *cap, const double d[3], pinch_feature *part)
{
    const double *x = cap->x, *y = cap->y, *centre = cap->centre, r = cap->radius, q = S * r;
    double rho2 = d[0] * d[0] + d[1] * d[1];
    part->face = true;
    part->count = PINCH_RIM;
    pinch_v3_copy(part->centre, centre);
    part->radius = r;
    part->across2 = 4 * r * r;
    for (int i = 0; i < 3; i++) {
        double c = centre[i], along[4] = {r * x[i], q * (x[i] + y[i]), r * y[i], q * (y[i] - x[i])};
        for (int k = 0; k < 4; k++) {
            part->x[k][i] = c + along[k];
            part->x[k + 4][i] = c - along[k];
        }
    }
    if (!(rho2 > 1e-14)) return;
    double rho = sqrt(rho2), low[2] = {d[0] / rho, d[1] / rho};
    for (int k = 0; k < PINCH_RIM; k++)
        if (PINCH_RIM_CORNER[k][0] * low[0] + PINCH_RIM_CORNER[k][1] * low[1] > COSINE_OF_HALF)
            for (int i = 0; i < 3; i++) part->x[k][i] = centre[i] + r * (low[0] * x[i] + low[1] * y[i]);
}

static void rim(const pinch_shape *shape, const double *d, pinch_feature *part)
{
    const pinch_cap cap = {{1, 0, 0}, {0, 1, 0}, {0, 0, shape->middle + copysign(shape->half[2], d[2])}, shape->radius};
    pinch_rim_polygon(&cap, d, part);
}

/* A cylinder's cap is nearer than its side when the direction rises by more than this. */
static const double TO_CAP = 0.7;

static void side_line(const pinch_shape *shape, const double *d, pinch_feature *part)
{
    double rho = sqrt(d[0] * d[0] + d[1] * d[1]), x = shape->radius * d[0] / rho, y = shape->radius * d[1] / rho;
    add(part, x, y, shape->middle - shape->half[2]);
    if (shape->kind == PINCH_SHAPE_FLAT_CAPSULE && d[2] > 0) { /* the dome's lowest point continues the line */
        double top[3];
        pinch_support_point(shape, d, top);
        add(part, top[0], top[1], top[2]);
    } else {
        add(part, x, y, shape->middle + shape->half[2]);
    }
}

bool pinch_exact_cap(const pinch_shape *shape, const double d[3], double centre[3])
{
    if (!pinch_is_round(shape) || !pinch_has_rim(shape, d[2]) || !(d[0] * d[0] + d[1] * d[1] < TIE * TIE)) return false;
    pinch_v3_set(centre, 0, 0, shape->middle + copysign(shape->half[2], d[2]));
    return true;
}

static void round_part(const pinch_shape *shape, const double *d, bool exact, pinch_feature *part)
{
    double rho = sqrt(d[0] * d[0] + d[1] * d[1]);
    bool dome = shape->kind == PINCH_SHAPE_FLAT_CAPSULE && d[2] > 0;
    bool cap = exact ? rho < TIE : fabs(d[2]) > TO_CAP;
    bool line = exact ? fabs(d[2]) < TIE : !cap;
    if (cap && !dome)
        rim(shape, d, part);
    else if (line && rho > 0.1)
        side_line(shape, d, part);
}

/* Fills in the first `count` corners of the face nearest to facing d. */
static void box_face(const pinch_shape *shape, const double *d, int count, pinch_feature *part)
{
    static const double TURN[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
    int i = pinch_v3_main_axis(d), j = (i + 1) % 3, k = (i + 2) % 3;
    double hj = shape->half[j], hk = shape->half[k];
    part->face = true;
    part->count = count;
    for (int c = 0; c < count; c++) {
        part->x[c][i] = copysign(shape->half[i], d[i]);
        part->x[c][j] = TURN[c][0] * hj;
        part->x[c][k] = TURN[c][1] * hk;
    }
    pinch_v3_set(part->centre, 0, 0, 0);
    part->centre[i] = copysign(shape->half[i], d[i]);
    part->radius = sqrt(hj * hj + hk * hk);
    part->across2 = 4 * (hj * hj + hk * hk);
}

void pinch_nearest_feature_ball(const pinch_shape *shape, const double d[3], double centre[3], double *radius)
{
    pinch_v3_set(centre, 0, 0, 0);
    if (shape->kind == PINCH_SHAPE_BOX) {
        int i = pinch_v3_main_axis(d), j = (i + 1) % 3, k = (i + 2) % 3;
        double hj = shape->half[j], hk = shape->half[k];
        centre[i] = copysign(shape->half[i], d[i]);
        *radius = sqrt(hj * hj + hk * hk);
    } else if (fabs(d[2]) > TO_CAP) {
        centre[2] = copysign(shape->half[2], d[2]);
        *radius = shape->radius;
    } else {
        double scale = shape->radius / sqrt(d[0] * d[0] + d[1] * d[1]);
        centre[0] = scale * d[0];
        centre[1] = scale * d[1];
        *radius = shape->half[2];
    }
}

/* Collects the vertices that are as far along d as any, at most CORNERS of them, walking along edges from one of them.
 * A pair comes in ascending order. */
static void farthest_corners(const pinch_shape *shape, const double *d, unsigned farthest, pinch_feature *part)
{
    const pinch_hull *hull = shape->hull;
    const double *points = hull->convex.points;
    double level = pinch_v3_dot(points + 3 * farthest, d) - TIE * shape->bound;
    unsigned *corner = part->corner;
    int found = 1;
    corner[0] = farthest;
    for (int i = 0; i < found; i++)
        for (unsigned k = hull->neighbours_at[corner[i]]; k < hull->neighbours_at[corner[i] + 1]; k++) {
            unsigned next = hull->neighbours[k];
            int j = 0;
            if (pinch_v3_dot(points + 3 * next, d) < level || found == CORNERS) continue;
            while (j < found && corner[j] != next) j++;
            if (j == found) corner[found++] = next;
        }
    if (found == 2 && corner[0] > corner[1]) {
        unsigned swap = corner[0];
        corner[0] = corner[1];
        corner[1] = swap;
    }
    part->corner_count = found;
}

/* Takes all corners of the face, or only the first. */
static void face_part(const pinch_hull *hull, int index, bool corners, pinch_feature *part)
{
    const pinch_hull_face *face = &hull->faces[index];
    const unsigned *polygon = face->polygon;
    unsigned all = corners ? polygon[0] : 1, every = all > CORNERS ? 1 + (all - 1) / CORNERS : 1;
    int count = 0;
    for (unsigned k = 1; k <= all; k += every) /* of very many corners it takes some */
        pinch_v3_copy(part->x[count++], hull->convex.points + 3 * polygon[k]);
    part->face = true;
    part->index = index;
    part->count = count;
    pinch_v3_copy(part->centre, face->centre);
    part->radius = face->radius;
    part->across2 = face->across2;
}

void pinch_hull_face_feature(const pinch_hull *hull, int face, pinch_feature *part)
{
    face_part(hull, face, false, part);
}

/* Of the faces at the farthest vertices, returns the one that faces d most. Three vertices have that face in common. */
static int hull_face(const pinch_hull *hull, const double *d, const pinch_feature *part)
{
    double most = -2;
    unsigned best = 0;
    for (int i = 0, count = part->corner_count < 3 ? part->corner_count : 1; i < count; i++) {
        unsigned k = hull->faces_at[part->corner[i]], end = hull->faces_at[part->corner[i] + 1];
        for (; k < end; k++) {
            unsigned f = hull->corner_faces[k];
            double along = pinch_v3_dot(hull->convex.planes + 4 * f, d);
            if (along < most || (along == most && f >= best)) continue;
            most = along;
            best = f;
        }
    }
    return (int)best;
}

/* Of the faces at the vertex, returns the one whose normal is d to rounding, or -1. */
static int square_face(const pinch_hull *hull, unsigned corner, const double *d)
{
    static const double SQUARE = 0.1; /* so small a part of a tie that all corners of the face are as far along d */
    for (unsigned k = hull->faces_at[corner]; k < hull->faces_at[corner + 1]; k++) {
        double off[3];
        pinch_v3_sub(hull->convex.planes + 4 * hull->corner_faces[k], d, off);
        if (pinch_v3_dot(off, off) < SQUARE * TIE * SQUARE * TIE) return (int)hull->corner_faces[k];
    }
    return -1;
}

/* Finds all vertices that are as far along d as any: one, the two of an edge, or those of a face, of which the first is
 * enough. */
static void exact_hull(const pinch_shape *shape, const double *d, unsigned farthest, pinch_feature *part)
{
    int face = square_face(shape->hull, farthest, d);
    if (face < 0) {
        farthest_corners(shape, d, farthest, part);
        if (part->corner_count > 2) face = hull_face(shape->hull, d, part);
    }
    if (face >= 0) {
        face_part(shape->hull, face, false, part);
        return;
    }
    part->count = part->corner_count;
    for (int k = 0; k < part->count; k++) pinch_v3_copy(part->x[k], shape->hull->convex.points + 3 * part->corner[k]);
}

static void nearest_hull(const pinch_shape *shape, const double *d, pinch_feature *part)
{
    farthest_corners(shape, d, pinch_hull_support_vertex(shape->hull, d), part);
    face_part(shape->hull, hull_face(shape->hull, d, part), true, part);
}

/* Finds the corners of a box that are as far along d as any, axis by axis. */
static void exact_box(const pinch_shape *shape, const double *d, pinch_feature *part)
{
    int flat = 0, along = 0;
    for (int i = 0; i < 3; i++) {
        if (2 * shape->half[i] * fabs(d[i]) > TIE * shape->bound) continue;
        flat++;
        along = i;
    }
    if (flat >= 2) {
        box_face(shape, d, 1, part);
        return;
    }
    part->count = 1 + flat;
    for (int k = 0; k < part->count; k++) {
        for (int i = 0; i < 3; i++) part->x[k][i] = copysign(shape->half[i], d[i]);
        if (flat) part->x[k][along] = k ? shape->half[along] : -shape->half[along];
    }
}

static void triangle_part(const pinch_shape *shape, const double *d, bool exact, pinch_feature *part)
{
    double most = pinch_support_value(shape, d) - TIE * shape->bound;
    for (int k = 0; k < 3; k++) {
        const double *x = shape->corner + 3 * k;
        if (!exact || pinch_v3_dot(x, d) >= most) add(part, x[0], x[1], x[2]);
    }
    double edge[3];
    part->face = part->count == 3;
    pinch_v3_sub(shape->corner + 3, shape->corner, edge);
    part->across2 = pinch_v3_dot(edge, edge);
    pinch_v3_set(part->centre, 0, 0, 0);
    part->radius = -1; /* triangles have no ball, because nobody asks for it */
}

void pinch_feature_at(const pinch_shape *shape, const double d[3], bool exact, pinch_feature *part)
{
    part->count = 0;
    part->face = false;
    switch (shape->kind) {
    case PINCH_SHAPE_SEGMENT:
        if (exact && fabs(d[2]) * shape->half[2] > TIE * shape->bound) break;
        add(part, 0, 0, -shape->half[2]);
        add(part, 0, 0, shape->half[2]);
        break;
    case PINCH_SHAPE_TRIANGLE:
        triangle_part(shape, d, exact, part);
        break;
    case PINCH_SHAPE_BOX:
        if (exact)
            exact_box(shape, d, part);
        else
            box_face(shape, d, 4, part);
        break;
    case PINCH_SHAPE_HULL:
        if (exact)
            exact_hull(shape, d, pinch_hull_support_vertex(shape->hull, d), part);
        else
            nearest_hull(shape, d, part);
        break;
    case PINCH_SHAPE_CYLINDER:
    case PINCH_SHAPE_FLAT_CAPSULE:
        round_part(shape, d, exact, part);
        break;
    default:
        break;
    }
    if (part->count > 0) return;
    part->count = 1;
    pinch_support_point(shape, d, part->x[0]);
}

void pinch_exact_feature_at_vertex(const pinch_shape *shape, const double d[3], unsigned farthest, pinch_feature *part)
{
    part->count = 0;
    part->face = false;
    exact_hull(shape, d, farthest, part);
}

int pinch_nearest_hull_face(const pinch_shape *shape, const double d[3], const pinch_feature *exact)
{
    return hull_face(shape->hull, d, exact);
}

void pinch_nearest_feature(const pinch_shape *shape, const double d[3], const pinch_feature *exact, pinch_feature *part)
{
    if (shape->kind == PINCH_SHAPE_HULL)
        face_part(shape->hull, hull_face(shape->hull, d, exact), true, part);
    else
        pinch_feature_at(shape, d, false, part);
}

void pinch_face_corners(const pinch_shape *shape, const double d[3], const pinch_feature *exact, pinch_feature *part)
{
    if (shape->kind == PINCH_SHAPE_HULL)
        face_part(shape->hull, exact->index, true, part);
    else
        pinch_feature_at(shape, d, false, part);
}
