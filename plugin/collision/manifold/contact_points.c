#include "contact_points.h"

#include "clip.h"
#include "pair_features.h"
#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* Straight edges that are as nearly parallel as PARALLEL (sine) touch along a line if the gap that opens between them
 * is less than OPENING of the overlap. */
static const double PARALLEL = 0.05, OPENING = 0.01;

/* How deep each of the points lies behind the face's plane, how many are deep, and the last of these. */
typedef struct levels {
    double depth[PINCH_MAX_CONTACT_POINTS];
    int deep, last;
} levels;

static void find_levels(double x[PINCH_MAX_CONTACT_POINTS][3], int count, const double *n, double sign, double offset,
                        levels *l)
{
    l->deep = l->last = 0;
    for (int k = 0; k < count; k++) {
        l->depth[k] = sign * pinch_v3_dot(n, x[k]) + offset;
        if (!(l->depth[k] > 0)) continue;
        l->deep++;
        l->last = k;
    }
}

/* If one corner alone of a tilted polygon is deep, and all that is deep around it lies over the face, it stands for the
 * polygon. */
static bool single_corner(const pinch_flat_face *face, double x[PINCH_MAX_CONTACT_POINTS][3], int count,
                          const levels *l)
{
    double tip[PINCH_MAX_CONTACT_POINTS][3];
    int k = l->last, beside[2] = {(k + 1) % count, (k + count - 1) % count};
    bool whole;
    if (l->deep != 1 || !pinch_is_round(face->shape))
        return false; /* a face with few sides is as soon clipped against */
    pinch_v3_copy(tip[0], x[k]);
    for (int i = 0; i < 2; i++) { /* to where the edge leaves the plane */
        double part = l->depth[k] / (l->depth[k] - l->depth[beside[i]]);
        for (int j = 0; j < 3; j++) tip[1 + i][j] = x[k][j] + part * (x[beside[i]][j] - x[k][j]);
    }
    (void)pinch_clip_to_face(face, tip, 3, NULL, &whole);
    return whole;
}

static bool is_point(const pinch_feature *part)
{
    return !part->face && part->count == 1;
}

/* A face that is level but for a tilt may count as parallel (see face_test.c). A point that overhangs may then be
 * deeper than those over the face, by no more than this part of the size. The deepest point over the face gets that
 * depth. */
static const double LEVEL = 1e-6;

/* A flat face of shape `which` meets whatever feature the other shape has there. */
static int on_face(const pinch_shape_pair *pair, int which, const pinch_feature parts[2],
                   const pinch_contact_normal *normal, pinch_contact_point *contacts)
{
    const double *n = normal->normal;
    const pinch_feature *part = &parts[which], *there = &parts[!which], *opposite = there;
    pinch_flat_face face = pinch_flat_face_of(pair, which, part, n);
    pinch_feature other, own;
    double margins = pair->a->margin + pair->b->margin, whole = normal->overlap + margins;
    if (pinch_is_face_without_corners(part) && !face.simple) {
        pinch_pair_face_corners(pair, which, n, part, &own);
        face.part = &own;
    }
    if (pinch_is_face_without_corners(opposite)) {
        pinch_pair_face_corners(pair, !which, n, opposite, &other);
        opposite = there = &other;
    } else if (!opposite->face) {
        pinch_pair_nearest_feature(pair, !which, n, opposite, &other);
        opposite = &other;
    }
    if (opposite->count == 1) { /* the point itself gives the normal, so it is over the face */
        pinch_contact_point_at(pair, !which, opposite->x[0], n, whole, &contacts[0]);
        return 1;
    }
    double x[PINCH_MAX_CONTACT_POINTS][3], sign = which ? -1 : 1, offset = margins - sign * pinch_v3_dot(n, part->x[0]),
                                           deepest = 0;
    double smaller = pair->a->bound < pair->b->bound ? pair->a->bound : pair->b->bound;
    int count = opposite->count, kept = 0, deepest_kept = 0;
    bool all;
    memcpy(x, opposite->x, (size_t)count * sizeof x[0]);
    levels l;
    find_levels(x, count, n, sign, offset, &l);
    if (l.deep > 0 && !single_corner(&face, x, count, &l)) {
        count = pinch_clip_to_face(&face, x, count, opposite, &all);
        if (!all) find_levels(x, count, n, sign, offset, &l);
    }
    for (int k = 0; k < count; k++) {
        if (!(l.depth[k] > 0)) continue;
        bool most = l.depth[k] > deepest;
        if (most) deepest = l.depth[k];
        deepest_kept = most ? kept : deepest_kept;
        pinch_contact_point_at(pair, !which, x[k], n, l.depth[k], &contacts[kept++]);
    }
    if (kept > 0 && deepest > whole - LEVEL * smaller) {
        contacts[deepest_kept].depth = whole;
        return kept;
    }
    if (kept == PINCH_MAX_CONTACT_POINTS) return kept;
    pinch_contact_point_at(pair, !which, there->x[0], n, whole,
                           &contacts[kept]); /* it is over the face, if only to rounding */
    return kept + 1;
}

/* Returns how far to the side of a straight edge the shape still has material. */
static double thickness(const pinch_shape *shape)
{
    return shape->margin + (pinch_is_round(shape) ? shape->radius : 0);
}

/* Two straight edges, both at right angles to n, meet along a line where they are parallel enough, otherwise where they
 * cross. */
static int edges(const pinch_shape_pair *pair, const pinch_feature *a, const pinch_feature *b,
                 const pinch_contact_normal *normal, double depth, pinch_contact_point *contacts)
{
    const double *n = normal->normal;
    double u[3], v[3], across[3], from[3], gap[3];
    pinch_v3_sub(a->x[1], a->x[0], u);
    pinch_v3_sub(b->x[1], b->x[0], v);
    double lu = pinch_v3_norm(u), lv = pinch_v3_norm(v);
    if (!(lu > 0) || !(lv > 0)) return 0;
    pinch_v3_scale(u, 1 / lu);
    pinch_v3_scale(v, 1 / lv);
    pinch_v3_cross(u, v, across);
    double sine = pinch_v3_dot(across, n), cosine = pinch_v3_dot(u, v);
    pinch_v3_sub(b->x[0], a->x[0], from);
    if (fabs(sine) < PARALLEL) {
        double s0 = pinch_v3_dot(from, u), s1 = s0 + lv * cosine;
        double low = fmax(0, fmin(s0, s1)), high = fmin(lu, fmax(s0, s1)), most = 0;
        double ends[2] = {low, high}, thick = thickness(pair->a) + thickness(pair->b);
        for (int k = 0; k < 2; k++) { /* sideways from A's line to B's */
            double side[3], t = (ends[k] - s0) / cosine;
            pinch_v3_copy(gap, from);
            pinch_v3_add_scaled(gap, t, v);
            pinch_v3_cross(n, u, side);
            most = fmax(most, fabs(pinch_v3_dot(gap, side)));
        }
        if (high - low > 1e-3 * fmin(lu, lv) && most * most <= 2 * thick * OPENING * depth) {
            for (int k = 0; k < 2; k++) {
                double x[3];
                pinch_v3_copy(x, a->x[0]);
                pinch_v3_add_scaled(x, ends[k], u);
                pinch_contact_point_at(pair, 0, x, n, depth, &contacts[k]);
            }
            return 2;
        }
    }
    if (!(fabs(sine) > 1e-12)) return 0;
    /* the lines cross, seen along n, where from + t v - s u has no component across n */
    pinch_v3_cross(from, v, gap);
    double s = pinch_v3_dot(gap, n) / sine, x[3];
    s = fmax(0, fmin(lu, s));
    pinch_v3_copy(x, a->x[0]);
    pinch_v3_add_scaled(x, s, u);
    pinch_contact_point_at(pair, 0, x, n, depth, &contacts[0]);
    return 1;
}

/* Takes the single point of the shape that has only one there. */
static int single(const pinch_shape_pair *pair, const pinch_feature part[2], const double *n, double depth,
                  pinch_contact_point *contacts)
{
    int which = is_point(&part[0]) || !is_point(&part[1]) ? 0 : 1;
    double x[3] = {0, 0, 0};
    for (int k = 0; k < part[which].count; k++) pinch_v3_add_scaled(x, 1.0 / part[which].count, part[which].x[k]);
    pinch_contact_point_at(pair, which, x, n, depth, contacts);
    return 1;
}

/* Returns which of two flat faces is larger from corner to corner, because the other's corners may all be over it. Of a
 * polygon and a cap it returns the polygon: what is clipped to a cap may lie outside by the gap between the polygon's
 * sides and the circle. */
static int larger_face(const pinch_shape_pair *pair, const pinch_feature part[2])
{
    if (!part[0].face || !part[1].face || pinch_is_round(pair->a) != pinch_is_round(pair->b)) return 0;
    return part[1].across2 > part[0].across2;
}

int pinch_contact_points(const pinch_shape_pair *pair, const pinch_contact_normal *normal,
                         const pinch_least_face faces[2], pinch_contact_point *contacts)
{
    pinch_feature part[2];
    double depth = normal->overlap + pair->a->margin + pair->b->margin;
    if (pair->a->kind == PINCH_SHAPE_POINT) {
        pinch_contact_point_at(pair, 0, (const double[3]){0, 0, 0}, normal->normal, depth, contacts);
        return 1;
    }
    int count = pinch_pressure_patch_points(pair, normal, contacts);
    if (count > 0) return count;
    count = pinch_interior_face_points(pair, normal, faces, depth, contacts);
    if (count > 0) return count;
    for (int which = 0; which < 2; which++) pinch_pair_exact_feature(pair, which, normal->normal, faces, &part[which]);
    int first = larger_face(pair, part);
    for (int k = 0; k < 2; k++) {
        int which = k ? !first : first;
        count = part[which].face ? on_face(pair, which, part, normal, contacts) : 0;
        if (count > 0) return count;
    }
    if (part[0].count == 2 && part[1].count == 2) count = edges(pair, &part[0], &part[1], normal, depth, contacts);
    if (count == 0) count = single(pair, part, normal->normal, depth, contacts);
    bool face = part[0].face || part[1].face;
    return count == 1 && !face ? pinch_near_face_points(pair, normal, part, contacts) : count;
}

int pinch_plane_contact_points(const pinch_shape *shape, const double n[3], double offset,
                               pinch_contact_point *contacts)
{
    pinch_feature part;
    const double d[3] = {-n[0], -n[1], -n[2]};
    int kept = 0;
    pinch_feature_at(shape, d, false, &part);
    if (pinch_pressure_patch_on_plane(shape, d, offset - pinch_v3_dot(n, part.x[0]), part.x)) part.count = 4;
    for (int k = 0; k < part.count; k++) {
        double depth = offset + shape->margin - pinch_v3_dot(n, part.x[k]);
        if (!(depth > 0)) continue;
        for (int i = 0; i < 3; i++) contacts[kept].position[i] = part.x[k][i] + (0.5 * depth - shape->margin) * n[i];
        contacts[kept++].depth = depth;
    }
    return kept;
}
