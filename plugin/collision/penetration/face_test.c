#include "face_test.h"

#include "support/vec3.h"

#include <float.h>
#include <math.h>

/* Returns the axis of the face that has the normal d. */
static int axis_of(const pinch_shape *shape, const double *d)
{
    return shape->kind == PINCH_SHAPE_CYLINDER ? 2 : pinch_v3_main_axis(d);
}

double pinch_border_distance(const pinch_shape *shape, const double d[3], const double x[3])
{
    if (shape->kind == PINCH_SHAPE_CYLINDER) return shape->radius - sqrt(x[0] * x[0] + x[1] * x[1]);
    int axis = axis_of(shape, d), j = (axis + 1) % 3, k = (axis + 2) % 3;
    double u = shape->half[j] - fabs(x[j]), v = shape->half[k] - fabs(x[k]);
    return u < v ? u : v;
}

bool pinch_nearest_face_point(const pinch_shape_pair *pair, int which, const double n[3], double x[3])
{
    static const double PARALLEL = 1e-13, LEVEL = 1e-12; /* 1 less a cosine; a sine */
    const pinch_shape *shape = which ? pair->b : pair->a;
    double d[3] = {-n[0], -n[1], -n[2]}, centre[3] = {-pair->p[0], -pair->p[1], -pair->p[2]};
    if (which) {
        pinch_pair_rotate_back(pair, n, d);
        pinch_pair_rotate_back(pair, centre, x);
    } else {
        pinch_v3_copy(x, pair->p);
    }
    int axis = pinch_v3_main_axis(d);
    if (shape->kind == PINCH_SHAPE_CYLINDER && fabs(d[2]) < LEVEL) {
        x[0] = shape->radius * d[0];
        x[1] = shape->radius * d[1];
        if (fabs(x[2]) > shape->half[2]) x[2] = copysign(shape->half[2], x[2]);
        axis = -1;
    } else if (fabs(d[axis]) < 1 - PARALLEL || (axis < 2 && shape->kind != PINCH_SHAPE_BOX)) {
        return false;
    } else if (shape->kind == PINCH_SHAPE_CYLINDER) {
        double rho = sqrt(x[0] * x[0] + x[1] * x[1]), scale = rho > shape->radius ? shape->radius / rho : 1;
        x[0] *= scale;
        x[1] *= scale;
    } else if (shape->kind == PINCH_SHAPE_BOX) {
        for (int i = 0; i < 3; i++)
            if (fabs(x[i]) > shape->half[i]) x[i] = copysign(shape->half[i], x[i]);
    } else {
        return false;
    }
    if (axis >= 0) x[axis] = copysign(shape->half[axis], d[axis]);
    if (which) {
        pinch_pair_rotate(pair, x, d);
        for (int i = 0; i < 3; i++) x[i] = d[i] + pair->p[i];
    } else {
        pinch_pair_point_to_b(pair, x, x);
    }
    return true;
}

bool pinch_ball_fits(const pinch_shape *shape, const double d[3], double inside, double overlap)
{
    return overlap > 0 && inside >= overlap && shape->half[axis_of(shape, d)] >= overlap;
}

/*
 * Let p(n) be the overlap. If a ball of radius p(n) about a point of the other body fits into the body that has the
 * face, it bounds the overlap in every direction by p(n).
 *
 * Otherwise a facet of the difference may do. Points x of the difference B - A bound the overlap: p(m) >= m.x. Let the
 * other body's farthest point lie over the face, inside its border by d. Then the difference contains a flat disc of
 * radius d around that point at n.x = p(n), and at the angle t from n
 *
 *     p(m) >= p(n) cos t + d sin t >= p(n)  for tan(t/2) <= d/p(n).
 *
 * At larger angles a ball in both bodies bounds the overlap (pinch_is_deeper_beyond). Bodies that are apart along n are
 * nearest to each other at that point.
 */
bool pinch_face_is_least(const pinch_shape_pair *pair, int which, const double n[3], double overlap)
{
    const pinch_shape *shape = which ? pair->b : pair->a;
    double x[3], d[3];
    if (which) {
        pinch_pair_support_a(pair, n, x);
        pinch_pair_point_to_b(pair, x, x);
        pinch_pair_rotate_back(pair, n, d);
    } else {
        pinch_pair_support_b(pair, n, x);
        pinch_v3_copy(d, n);
    }
    double inside = pinch_border_distance(shape, d, x);
    if (pinch_ball_fits(shape, d, inside, overlap) || pinch_facet_is_least(pair, inside, n, overlap)) return true;
    if (!pinch_nearest_face_point(pair, !which, n, x)) return false;
    inside = pinch_border_distance(shape, d, x);
    return pinch_ball_fits(shape, d, inside, overlap) || pinch_facet_is_least(pair, inside, n, overlap);
}

bool pinch_facet_is_least(const pinch_shape_pair *pair, double inside, const double n[3], double overlap)
{
    if (overlap <= 0) return inside >= 0;
    if (!(inside > 0)) return false;
    double p2 = overlap * overlap, d2 = inside * inside, scale = 1 / (d2 + p2);
    return pinch_is_deeper_beyond(pair, n, overlap, (p2 - d2) * scale, 2 * overlap * inside * scale);
}

/* Returns whose face has the least overlap: 0 for A's, 1 for B's, -1 if there are no faces. */
static int least_face(const pinch_shape_pair *pair, pinch_contact_normal *best)
{
    int which = -1;
    for (int k = 0; k < 6; k++) {
        const pinch_shape *shape = k < 3 ? pair->a : pair->b;
        int axis = k % 3;
        if (shape->kind != PINCH_SHAPE_BOX && (shape->kind != PINCH_SHAPE_CYLINDER || axis < 2)) continue;
        double n[3] = {axis == 0, axis == 1, axis == 2}, before = best->overlap;
        if (k >= 3)
            for (int i = 0; i < 3; i++) n[i] = pair->R[3 * i + axis];
        if (pinch_v3_dot(n, pair->p) > 0) pinch_v3_scale(n, -1);
        pinch_offer_normal(pair, n, best);
        if (best->overlap < before) which = k / 3;
    }
    return which;
}

bool pinch_face_test(const pinch_shape_pair *pair, pinch_contact_normal *best)
{
    best->overlap = DBL_MAX;
    int which = least_face(pair, best);
    if (which < 0) return false;
    return best->overlap <= -(pair->a->margin + pair->b->margin) ||
           pinch_face_is_least(pair, which, best->normal, best->overlap);
}

/* Overlaps that differ by no more than this part of the size count as equal. */
static const double TIE = 1e-13;

/* A shape's faces with what is known of the other shape, in the axes of the one that has the faces. */
typedef struct faces_and_body {
    const pinch_shape_pair *pair;
    int which, count;
    const pinch_shape *shape, *other;
    double centre[3], radius; /* a ball in the other shape */
    double rounding;          /* of overlaps */
} faces_and_body;

/* The faces of a cylinder are its caps. */
static int count_faces(const pinch_shape *shape)
{
    return shape->kind == PINCH_SHAPE_HULL       ? (int)shape->hull->convex.plane_count
           : shape->kind == PINCH_SHAPE_BOX      ? 6
           : shape->kind == PINCH_SHAPE_CYLINDER ? 2
                                                 : 0;
}

static faces_and_body faces_of(const pinch_shape_pair *pair, int which)
{
    faces_and_body k = {.pair = pair, .which = which, .shape = pair->a, .other = pair->b};
    double centre[3];
    if (which) {
        k.shape = pair->b;
        k.other = pair->a;
    }
    k.count = count_faces(k.shape);
    k.radius = pinch_inner_ball(k.other, centre);
    if (pinch_is_large_hull(k.other)) k.rounding = TIE * (pair->a->bound + pair->b->bound + pinch_v3_norm(pair->p));
    if (which)
        pinch_pair_point_to_b(pair, centre, k.centre);
    else
        pinch_pair_point_to_a(pair, centre, k.centre);
    return k;
}

static inline const double *normal_of(const pinch_shape *shape, int face)
{
    static const double AXIS[6][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    if (shape->kind == PINCH_SHAPE_HULL) return shape->hull->convex.planes + 4 * face;
    return AXIS[shape->kind == PINCH_SHAPE_BOX ? face : 4 + face];
}

/* Returns how far the shape extends along the face's normal. */
static inline double offset_of(const pinch_shape *shape, int face)
{
    if (shape->kind == PINCH_SHAPE_HULL) return shape->hull->faces[face].offset;
    return shape->half[shape->kind == PINCH_SHAPE_BOX ? face / 2 : 2];
}

/* Finds how deep the ball's centre lies behind the faces from `first` on. Returns the place of the least. */
static int depths_of_centre(const faces_and_body *k, int first, int count, double *depth)
{
    double nearest = DBL_MAX;
    int least = 0, axis = k->shape->kind == PINCH_SHAPE_BOX ? 0 : 2;
    if (k->shape->kind == PINCH_SHAPE_HULL)
        pinch_hull_depths(k->shape->hull, k->centre, first, count, depth);
    else
        for (int f = 0; f < count; f++) {
            double along = k->centre[axis + f / 2];
            depth[f] = k->shape->half[axis + f / 2] + (f % 2 ? along : -along);
        }
    for (int f = 0; f < count; f++) {
        least = depth[f] < nearest ? f : least;
        nearest = depth[f] < nearest ? depth[f] : nearest;
    }
    return least;
}

/* Returns the overlap along a face's normal d if no point of the other shape were farther in than x. Finds x in the
 * axes of the shape that has the face. */
static double overlap_at(const faces_and_body *k, int face, const double *d, const double *x, double *point)
{
    if (k->which)
        pinch_pair_point_to_b(k->pair, x, point);
    else
        pinch_pair_point_to_a(k->pair, x, point);
    return offset_of(k->shape, face) - pinch_v3_dot(d, point);
}

/* Takes the face if its overlap is less than the limit. Of a large hull, a vertex that is nearly the farthest in often
 * tells that it is not. */
static void offer_face(const faces_and_body *k, int face, double *limit, pinch_least_face *least)
{
    const double *d = normal_of(k->shape, face);
    double normal[3], n[3], x[3], point[3];
    unsigned corner = 0;
    if (k->which) {
        pinch_pair_rotate(k->pair, d, normal);
        for (int i = 0; i < 3; i++) n[i] = -normal[i];
    } else {
        for (int i = 0; i < 3; i++) normal[i] = -d[i];
        pinch_pair_rotate_back(k->pair, normal, n);
    }
    if (k->other->kind == PINCH_SHAPE_HULL) {
        if (pinch_is_large_hull(k->other)) {
            const double *near = k->other->hull->convex.points + 3 * (size_t)pinch_hull_near_vertex(k->other->hull, n);
            if (overlap_at(k, face, d, near, point) >= *limit + k->rounding) return;
        }
        corner = pinch_hull_support_vertex(k->other->hull, n);
        pinch_v3_copy(x, k->other->hull->convex.points + 3 * corner);
    } else {
        pinch_support_point(k->other, n, x);
    }
    double overlap = overlap_at(k, face, d, x, point);
    if (!(overlap < *limit)) return;
    *limit = least->at.overlap = overlap;
    least->face = face;
    least->corner = corner;
    pinch_v3_copy(least->at.normal, normal);
    pinch_v3_copy(least->point, point);
}

/* The face behind which the other shape's middle is least deep comes first. Its overlap is small, and the point
 * found there lies deep behind most other faces, which then need no look. The same holds of the ball inside the
 * other shape. */
static void least_hull_face(const pinch_shape_pair *pair, int which, double limit, pinch_least_face *least)
{
    enum { BLOCK = PINCH_FACE_DEPTHS };
    const faces_and_body k = faces_of(pair, which);
    double *depth = least->centre;
    least->face = least->edge = -1;
    least->radius = k.radius;
    least->at.overlap = DBL_MAX;
    for (int first = 0; first < k.count; first += BLOCK) {
        int count = k.count - first < BLOCK ? k.count - first : BLOCK,
            start = depths_of_centre(&k, first, count, depth);
        if (!(depth[start] + k.radius < limit)) continue;
        offer_face(&k, first + start, &limit, least);
        for (int f = 0; f < count; f++) {
            if (!(depth[f] + k.radius < limit) || f == start) continue;
            const double *d = normal_of(k.shape, first + f);
            bool deep = least->face >= 0 && offset_of(k.shape, first + f) - pinch_v3_dot(d, least->point) >= limit;
            if (!deep) offer_face(&k, first + f, &limit, least);
        }
    }
}

/* Does what pinch_ball_fits does for a hull, and finds how deep the point lies behind the first faces. */
static bool fits(const pinch_hull *hull, const double *point, double overlap, double *depth)
{
    int faces = (int)hull->convex.plane_count, first = faces < PINCH_FACE_DEPTHS ? faces : PINCH_FACE_DEPTHS;
    double least = overlap - TIE * hull->outer; /* the face itself is as deep to rounding */
    pinch_hull_depths(hull, point, 0, first, depth);
    if (!(overlap > 0)) return false;
    for (int f = 0; f < first; f++)
        if (depth[f] < least) return false;
    for (int f = first; f < faces; f++)
        if (hull->faces[f].offset - pinch_v3_dot(hull->convex.planes + 4 * f, point) < least) return false;
    return true;
}

/* The point is the farthest in, or as far as that. */
static bool settles(const pinch_shape_pair *pair, const pinch_hull *hull, const pinch_least_face *least,
                    const double *point, double *depth)
{
    if (fits(hull, point, least->at.overlap, depth)) return true;
    double inside = pinch_hull_border_distance(hull, least->face, point);
    return pinch_facet_is_least(pair, inside, least->at.normal, least->at.overlap);
}

/* Does what pinch_face_is_least does for a pair with a hull. */
static bool is_least(const pinch_shape_pair *pair, int which, pinch_least_face *least)
{
    const pinch_shape *shape = which ? pair->b : pair->a, *other = which ? pair->a : pair->b;
    double point[3], depths[PINCH_FACE_DEPTHS];
    if (least->face < 0) return false;
    if (shape->kind != PINCH_SHAPE_HULL) {
        const double *d = normal_of(shape, least->face);
        double inside = pinch_border_distance(shape, d, least->point);
        return pinch_ball_fits(shape, d, inside, least->at.overlap) ||
               pinch_facet_is_least(pair, inside, least->at.normal, least->at.overlap);
    }
    if (other->kind == PINCH_SHAPE_POINT && least->at.overlap >= 0) return true; /* a point meets only faces */
    if (settles(pair, shape->hull, least, least->point, least->far)) return true;
    bool has_faces = other->kind == PINCH_SHAPE_BOX || other->kind == PINCH_SHAPE_CYLINDER;
    if (!has_faces || !pinch_nearest_face_point(pair, !which, least->at.normal, point)) return false;
    const double *d = normal_of(shape, least->face);
    double depth = offset_of(shape, least->face) - pinch_v3_dot(d, point);
    bool as_far = depth >= least->at.overlap - TIE * shape->bound; /* parallel to rounding, not only nearly */
    return as_far && settles(pair, shape->hull, least, point, depths);
}

/*
 * The shape with the larger ball inside it comes first. A small body's corner on a large body's face is the most
 * frequent contact, and once that is certain the other's faces need no look.
 */
bool pinch_hull_face_test(const pinch_shape_pair *pair, pinch_least_face faces[2], pinch_contact_normal *best)
{
    double size = pair->a->bound < pair->b->bound ? pair->a->bound : pair->b->bound, centre[3];
    double apart = -(pair->a->margin + pair->b->margin);
    int first = pinch_inner_ball(pair->b, centre) > pinch_inner_ball(pair->a, centre), second = !first;
    faces[second].face = faces[second].edge = -1;
    least_hull_face(pair, first, DBL_MAX, &faces[first]);
    *best = faces[first].at;
    if (best->overlap <= apart || is_least(pair, first, &faces[first])) return true;
    double limit = faces[first].face < 0 ? DBL_MAX : best->overlap + TIE * size; /* equally good counts as well */
    least_hull_face(pair, second, limit, &faces[second]);
    if (faces[second].at.overlap < best->overlap) *best = faces[second].at;
    return best->overlap <= apart || is_least(pair, second, &faces[second]);
}
