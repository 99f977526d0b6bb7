/*
 * The points are sorted into groups by their normals. The hull of each group grows by the point that is farthest
 * outside of all hulls, until there are as many corners as may stay. In such an order an n-gon is found exactly with n
 * points, and of a circle of many points eight cut off least.
 *
 * Distances are measured in each group's own plane, in units of the points' standard deviations along the axes of the
 * group: the two far corners of a long beam count as much as its width.
 */
#include "contacts/reduction.h"

#include "support/extremes.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { MOST_GROUPS = PINCH_SHARED_POINTS / 2, OUTSIDE_NONE = -1 };

/* Normals that differ by more than this (the chord, 0.26 rad) press on different faces. */
static const double OTHER_FACE = 0.26;
/* In standard deviations: a point that reaches less far out adds nothing, and two that differ by less are equal. */
static const double NOTHING = 0.02, EQUAL = 1e-6;
/* The part of its depth by which the deepest point has to exceed those that span the hull. */
static const double DEEPER = 1e-3;
/* A width below this part of the length is none, nor is one below this part of the merge distance: the points lie on a
 * line, or all in one place. */
static const double THIN = 1e-6, THIN_POINTS = 1e-3;

/* The points whose normals are alike, and the hull of those of them that are kept. */
typedef struct face_group {
    double normal[3];             /* of the point that it began with */
    double centre[3], axis[2][3]; /* the coordinates u = axis (position - centre) have unit variance */
    pinch_detected_point *from[PINCH_SHARED_POINTS], *to[PINCH_SHARED_POINTS]; /* edges, counter-clockwise */
    int kept;
} face_group;

typedef struct reduction {
    const pinch_manifold *known;
    double merge_distance;
    pinch_detected_point *points, **kept;
    int count, most, kept_count, group_count;
    face_group group[MOST_GROUPS];
} reduction;

static double squared_distance(const double *a, const double *b)
{
    double d[3];
    pinch_v3_sub(a, b, d);
    return pinch_v3_dot(d, d);
}

/* ---- rims ---- */

static const double NO_DEPTH = 1e-6; /* times the depth of a deep point */

/*
 * Where edges of one body go through the surface of the other, a collider returns a point of no depth. It bears nothing
 * beside one that is deep, and may hide it: at the corners of a mesh that is pressed in, edges come out right above
 * the deep corners, as far out as these. A far corner that only just touches is none such, however deep the others
 * are: from there to the deep ones the surface rises less than a rim does.
 */
static bool is_on_rim_around(const pinch_detected_point *deep, const pinch_detected_point *p)
{
    static const double FAR = 10; /* times the depth of the deep one */
    double reach = FAR * deep->depth;
    return p->depth <= NO_DEPTH * deep->depth && deep->depth > 0 &&
           squared_distance(p->normal, deep->normal) <= OTHER_FACE * OTHER_FACE &&
           squared_distance(p->position, deep->position) <= reach * reach;
}

int pinch_leave_out_rims(pinch_detected_point *points, int count)
{
    int others = 0;
    double deepest = 0;
    if (count > PINCH_MOST_COMPARED) return count;
    for (int i = 0; i < count; i++) deepest = pinch_larger(points[i].depth, deepest);
    for (int i = 0; i < count; i++) {
        pinch_detected_point *p = &points[i];
        if (p->depth > NO_DEPTH * deepest) continue;
        for (int k = 0; k < count && !p->redundant; k++) p->redundant = is_on_rim_around(&points[k], p);
    }
    for (int i = 0; i < count; i++) {
        if (points[i].redundant) continue;
        if (i > others) {
            pinch_detected_point p = points[i];
            points[i] = points[others];
            points[others] = p;
        }
        others++;
    }
    return others;
}

/* ---- groups ---- */

/* Sorts the points into groups: first around the deepest point's normal, then again and again around the normal that is
 * farthest from those that there are. */
static void sort_into_groups(reduction *r)
{
    int most = r->most / 2 < MOST_GROUPS ? r->most / 2 : MOST_GROUPS;
    pinch_detected_point *next = r->points;
    for (int i = 0; i < r->count; i++) {
        r->points[i].ahead = DBL_MAX;
        if (r->points[i].depth > next->depth) next = &r->points[i];
    }
    do {
        int g = r->group_count++;
        memset(&r->group[g], 0, sizeof r->group[g]);
        pinch_v3_copy(r->group[g].normal, next->normal);
        for (int i = 0; i < r->count; i++) {
            pinch_detected_point *p = &r->points[i];
            double apart = squared_distance(p->normal, r->group[g].normal);
            if (apart < p->ahead) {
                p->ahead = apart;
                p->group = g;
            }
            if (i == 0 || p->ahead > next->ahead) next = p;
        }
    } while (r->group_count < most && next->ahead > OTHER_FACE * OTHER_FACE);
}

/*
 * Finds the plane of a group, and the axes that make the points' coordinates in it have unit variance: with the
 * covariance C of their coordinates along two perpendicular tangents, the rows of C^-1/2. The square root of a
 * symmetric 2 x 2 matrix is (C + s 1)/t with s = sqrt(det C) and t = sqrt(trace C + 2 s).
 */
static void measure_group(const reduction *r, int g, face_group *group)
{
    double t[2][3], xx = 0, xy = 0, yy = 0;
    int count = 0;
    for (int i = 0; i < r->count; i++) {
        if (r->points[i].group != g) continue;
        count++;
        pinch_v3_add_scaled(group->centre, 1, r->points[i].position);
    }
    pinch_v3_scale(group->centre, 1.0 / count);
    pinch_v3_any_perpendicular(group->normal, t[0]);
    pinch_v3_cross(group->normal, t[0], t[1]);
    for (int i = 0; i < r->count; i++) {
        double arm[3];
        if (r->points[i].group != g) continue;
        pinch_v3_sub(r->points[i].position, group->centre, arm);
        double x = pinch_v3_dot(t[0], arm), y = pinch_v3_dot(t[1], arm);
        xx += x * x / count, xy += x * y / count, yy += y * y / count;
    }
    double width = THIN_POINTS * r->merge_distance, least = THIN * THIN * (xx + yy) + width * width + DBL_MIN;
    xx += least, yy += least;
    double s = sqrt(fmax(xx * yy - xy * xy, least * least)), scale = sqrt(xx + yy + 2 * s);
    double a = (xx + s) / scale, b = xy / scale, d = (yy + s) / scale, det = fmax(a * d - b * b, DBL_MIN);
    for (int i = 0; i < 3; i++) {
        group->axis[0][i] = (d * t[0][i] - b * t[1][i]) / det;
        group->axis[1][i] = (a * t[1][i] - b * t[0][i]) / det;
    }
}

/* ---- growing the hulls ---- */

/* Returns how far a point lies outside of an edge, and how far from its middle along it. */
static double outside_of(const pinch_detected_point *p, const pinch_detected_point *from,
                         const pinch_detected_point *to, double *along)
{
    double ex = to->u[0] - from->u[0], ey = to->u[1] - from->u[1], length = hypot(ex, ey);
    double x = p->u[0] - 0.5 * (from->u[0] + to->u[0]), y = p->u[1] - 0.5 * (from->u[1] + to->u[1]);
    *along = fabs(ex * x + ey * y) / length;
    return (ey * x - ex * y) / length;
}

/* Notes which edge of its group's hull a point is outside of, of those two that it may be. */
static void see_edges(const face_group *group, const int edge[2], pinch_detected_point *p)
{
    p->ahead = 0;
    p->edge = OUTSIDE_NONE;
    for (int k = 0; k < 2; k++) {
        double along, ahead = outside_of(p, group->from[edge[k]], group->to[edge[k]], &along);
        if (!(ahead > p->ahead)) continue;
        p->ahead = ahead;
        p->aside = along;
        p->edge = edge[k];
    }
}

/* Puts a point's hull, of one point so far, before every point of its group. */
static void see_point(const pinch_detected_point *first, pinch_detected_point *p)
{
    p->ahead = hypot(p->u[0] - first->u[0], p->u[1] - first->u[1]);
    p->aside = 0;
    p->edge = 0;
}

/* Keeps a point, which becomes a corner of its group's hull where it lies outside of it. */
static void keep(reduction *r, pinch_detected_point *corner)
{
    face_group *group = &r->group[corner->group];
    int split = corner->edge, edge[2] = {split, group->kept};
    r->kept[r->kept_count++] = corner;
    corner->kept = true;
    if (split == OUTSIDE_NONE) return;
    if (group->kept == 0) {
        group->from[0] = group->to[0] = corner;
    } else {
        group->from[edge[1]] = corner;
        group->to[edge[1]] = group->to[split];
        group->to[split] = corner;
    }
    for (int i = 0; i < r->count; i++) {
        pinch_detected_point *p = &r->points[i];
        if (p->group != corner->group || p->edge != split || p->kept) continue;
        if (group->kept == 0)
            see_point(corner, p);
        else
            see_edges(group, edge, p);
    }
    group->kept++;
}

/* Tells whether the manifold has a point within a part of the merge distance. */
static bool is_known(const reduction *r, const pinch_detected_point *p, double part)
{
    double within = part * r->merge_distance;
    for (int k = 0; k < r->known->count; k++)
        if (pinch_point_distance2(&r->known->point[k], p) < within * within) return true;
    return false;
}

/* Tells which of two points goes first that are as far outside: the one farther out along its edge, one that the
 * manifold has, or one in a direction that no two points of a regular pattern share. */
static bool goes_first(const reduction *r, const pinch_detected_point *a, const pinch_detected_point *b)
{
    static const double DIRECTION[3] = {0.5403, 0.6729, 0.5052};
    if (fabs(a->aside - b->aside) > EQUAL) return a->aside > b->aside;
    bool known = is_known(r, a, 1);
    if (known != is_known(r, b, 1)) return known;
    return pinch_v3_dot(DIRECTION, a->position) > pinch_v3_dot(DIRECTION, b->position);
}

/* Grows the hulls up to `most` points. */
static void grow(reduction *r, int most)
{
    while (r->kept_count < most) {
        double farthest = NOTHING;
        pinch_detected_point *next = NULL;
        for (int i = 0; i < r->count; i++)
            if (!r->points[i].kept && r->points[i].ahead > farthest) farthest = r->points[i].ahead;
        for (int i = 0; i < r->count; i++) {
            pinch_detected_point *p = &r->points[i];
            if (p->kept || !(p->ahead > NOTHING && p->ahead >= farthest - EQUAL)) continue;
            if (!next || goes_first(r, p, next)) next = p;
        }
        if (!next) return;
        keep(r, next);
    }
}

/* Begins the hull of a group with the point that is farthest from its middle. */
static void begin(reduction *r, int g)
{
    face_group *group = &r->group[g];
    pinch_detected_point *first = NULL;
    double farthest = 0;
    measure_group(r, g, group);
    for (int i = 0; i < r->count; i++) {
        pinch_detected_point *p = &r->points[i];
        double arm[3];
        if (p->group != g) continue;
        pinch_v3_sub(p->position, group->centre, arm);
        for (int k = 0; k < 2; k++) p->u[k] = pinch_v3_dot(group->axis[k], arm);
        p->ahead = hypot(p->u[0], p->u[1]);
        p->aside = 0;
        p->edge = 0;
        p->kept = false;
        farthest = fmax(farthest, p->ahead);
    }
    for (int i = 0; i < r->count; i++) {
        pinch_detected_point *p = &r->points[i];
        if (p->group == g && p->ahead >= farthest - EQUAL && (!first || goes_first(r, p, first))) first = p;
    }
    keep(r, first);
}

/* Keeps the deepest point of a group where none is as deep that is kept. */
static void keep_deepest(reduction *r, int g)
{
    const pinch_detected_point *kept = NULL;
    pinch_detected_point *deepest = NULL;
    for (int i = 0; i < r->count; i++) {
        pinch_detected_point *p = &r->points[i];
        if (p->group != g) continue;
        if (!deepest || p->depth > deepest->depth) deepest = p;
        if (p->kept && (!kept || p->depth > kept->depth)) kept = p;
    }
    if (deepest->depth - kept->depth > DEEPER * deepest->depth) keep(r, deepest);
}

/* ---- filling up ---- */

/* Tells whether two points press on the same face and have the same law. Directions of friction turn little by little
 * over a turntable. */
static bool is_of_kind(const pinch_detected_point *a, const pinch_detected_point *b)
{
    static const double SAME_WAY = 0.966; /* the cosine of 0.26 rad */
    if (a->group != b->group || a->surface != b->surface || !a->tangent1 != !b->tangent1) return false;
    return !a->tangent1 || pinch_v3_dot(a->tangent1, b->tangent1) > SAME_WAY;
}

/* Sorts the points into kinds. Where there are too many for each to have some points that stay, faces alone count. */
static void sort_into_kinds(reduction *r)
{
    const pinch_detected_point *first[PINCH_MOST_KINDS];
    int kinds = 0;
    bool few = true;
    for (int i = 0; i < r->count && few; i++) {
        pinch_detected_point *p = &r->points[i];
        p->kind = 0;
        while (p->kind < kinds && !is_of_kind(p, first[p->kind])) p->kind++;
        if (p->kind < kinds) continue;
        few = kinds < PINCH_MOST_KINDS;
        if (few) first[kinds++] = p;
    }
    for (int i = 0; i < r->count && !few; i++) r->points[i].kind = r->points[i].group;
}

/* Notes how far (m^2) a point is at most from those of its kind that are kept. */
static void see_kept(const pinch_detected_point *kept, pinch_detected_point *p)
{
    if (p->kind == kept->kind) p->ahead = fmin(p->ahead, squared_distance(p->position, kept->position));
}

/*
 * Keeps further points until there are as many as may stay: always the one that is farthest from all of its kind, so
 * that they spread evenly, each for those around it. One that the manifold has goes before others up to twice as far.
 */
static void fill_up(reduction *r)
{
    static const double BEFORE = 4;  /* in square distance */
    static const double SAME = 0.02; /* merge distances: neighbours may be closer than one */
    for (int i = 0; i < r->count; i++) {
        pinch_detected_point *p = &r->points[i];
        p->ahead = DBL_MAX / BEFORE;
        p->aside = is_known(r, p, SAME) ? BEFORE : 1;
        for (int k = 0; k < r->kept_count; k++) see_kept(r->kept[k], p);
    }
    while (r->kept_count < r->most) {
        pinch_detected_point *next = NULL;
        for (int i = 0; i < r->count; i++) {
            pinch_detected_point *p = &r->points[i];
            if (!p->kept && p->ahead > 0 && (!next || p->ahead * p->aside > next->ahead * next->aside)) next = p;
        }
        if (!next) return;
        next->kept = true;
        r->kept[r->kept_count++] = next;
        for (int i = 0; i < r->count; i++) see_kept(next, &r->points[i]);
    }
}

int pinch_reduce_points(const pinch_manifold *known, double merge_distance, int most, pinch_detected_point *points,
                        int count, pinch_detected_point **kept)
{
    reduction r = {known, merge_distance, points, kept, count, most, 0, 0, {{{0}, {0}, {{0}}, {0}, {0}, 0}}};
    if (most == 1) { /* no room for more than the deepest */
        kept[0] = points;
        for (int i = 1; i < count; i++)
            if (points[i].depth > kept[0]->depth) kept[0] = &points[i];
        return 1;
    }
    r.count = pinch_leave_out_rims(points, count);
    if (r.count <= most) {
        for (int i = 0; i < r.count; i++) kept[i] = &points[i];
        return r.count;
    }
    sort_into_groups(&r);
    sort_into_kinds(&r);
    for (int g = 0; g < r.group_count; g++) begin(&r, g);
    int corners = most < PINCH_SHARED_POINTS ? most : PINCH_SHARED_POINTS;
    grow(&r, corners - r.group_count);
    for (int g = 0; g < r.group_count; g++) keep_deepest(&r, g);
    grow(&r, corners);
    if (most > PINCH_SHARED_POINTS) fill_up(&r);
    return r.kept_count;
}
