/*
 * If a box lies over another one's border and is nearly level, the least overlap is where two edges cross, although
 * much of the two faces is nearly as deep. That single point would let the box rock about it. Along n, the point x of
 * B's face is inside A's face, which has the outward normal m and the support value o, by
 *
 *     (o - m.x)/(-m.n).
 *
 * That is the whole overlap where the edges cross, and less elsewhere.
 */
#include "pair_features.h"

#include "clip.h"
#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* Faces are looked at up to this tilt against the normal (cosine). Points this near to the first one (of the smaller
 * size) add nothing to it. */
static const double LEVEL = 0.98, NEAR = 0.05;

/* Finds the outward normal of the face that is nearest to facing d, in the shape's own axes, and which face it is of a
 * hull. Returns false if no face does. */
static bool facing(const pinch_shape *shape, const double *d, const pinch_feature *exact, double *m, int *face)
{
    double axes[3][3], most = 0;
    int axis = 0;
    if (shape->kind == PINCH_SHAPE_HULL) {
        *face = pinch_nearest_hull_face(shape, d, exact);
        pinch_v3_copy(m, shape->hull->convex.planes + 4 * *face);
        return pinch_v3_dot(m, d) >= LEVEL;
    }
    if (pinch_is_round(shape) && !pinch_has_rim(shape, d[2])) return false;
    if (shape->kind != PINCH_SHAPE_BOX && shape->kind != PINCH_SHAPE_TRIANGLE && !pinch_is_round(shape)) return false;
    int count = pinch_shape_axes(shape, axes);
    for (int i = 0; i < count; i++) {
        double along = pinch_v3_dot(axes[i], d);
        axis = fabs(along) > fabs(most) ? i : axis;
        most = fabs(along) > fabs(most) ? along : most;
    }
    for (int i = 0; i < 3; i++) m[i] = copysign(1, most) * axes[axis][i];
    return fabs(most) >= LEVEL;
}

/* Tells whether anything that is not next to the point is deep. */
static bool worth_it(const double *m, const double *d, double depth, double size)
{
    double c = pinch_v3_dot(m, d), sine = sqrt(c < 1 ? 1 - c * c : 0);
    return sine * NEAR * size < depth;
}

static bool is_near(const pinch_contact_point *first, const double *position, double distance)
{
    double apart[3];
    pinch_v3_sub(position, first->position, apart);
    return pinch_v3_dot(apart, apart) < distance * distance;
}

int pinch_near_face_points(const pinch_shape_pair *pair, const pinch_contact_normal *normal,
                           const pinch_feature exact[2], pinch_contact_point *contacts)
{
    const pinch_shape *A = pair->a, *B = pair->b;
    const double *n = normal->normal;
    double size = A->bound < B->bound ? A->bound : B->bound, whole = normal->overlap + A->margin + B->margin;
    double d[3], m[3], other[3], x[PINCH_MAX_CONTACT_POINTS][3];
    pinch_feature a, all_of_a, b;
    int index = 0;
    bool all;
    pinch_outward_direction(pair, 1, n, d);
    if (!facing(B, d, &exact[1], other, &index) || !worth_it(other, d, whole, size)) return 1;
    pinch_outward_direction(pair, 0, n, d);
    if (!facing(A, d, &exact[0], m, &index) || !worth_it(m, d, whole, size)) return 1;
    pinch_pair_nearest_feature(pair, 1, n, &exact[1], &b);
    const double into[3] = {-m[0], -m[1], -m[2]};
    if (A->kind == PINCH_SHAPE_HULL)
        pinch_hull_face_feature(A->hull, index, &a);
    else
        pinch_feature_at(A, m, true, &a);
    if (!a.face || !b.face) return 1;
    pinch_flat_face face =
        pinch_flat_face_of(pair, 0, &a, into); /* what lies over the face; at so little tilt n makes no difference */
    if (pinch_is_face_without_corners(&a) && !face.simple) {
        pinch_pair_face_corners(pair, 0, into, &a, &all_of_a);
        face.part = &all_of_a;
    }
    memcpy(x, b.x, (size_t)b.count * sizeof x[0]);
    int count = pinch_clip_to_face(&face, x, b.count, &b, &all), kept = 1;
    double extent = pinch_v3_dot(m, a.x[0]), scale = -1 / pinch_v3_dot(m, n);
    for (int k = 0; k < count && kept < PINCH_MAX_CONTACT_POINTS; k++) {
        double overlap = scale * (extent - pinch_v3_dot(m, x[k])), depth = overlap + A->margin + B->margin;
        if (!(depth > 0)) continue;
        depth = depth < whole ? depth : whole;
        pinch_contact_point *to = &contacts[kept];
        for (int i = 0; i < 3; i++) to->position[i] = x[k][i] + (B->margin - 0.5 * depth) * n[i];
        to->depth = depth;
        if (!is_near(&contacts[0], to->position, NEAR * size)) kept++;
    }
    return kept;
}
