#include "hull_first.h"

#include "face_first.h"
#include "support/vec3.h"

#include <float.h>

/* Overlaps that differ by no more than this part of the size are as good as the same. */
static const double TIE = 1e-13;

/* A core's faces with what is known of the other core, in the axes of the one that has the faces. */
typedef struct faces_and_body {
    const pinch_core_pair *pair;
    int which, count;
    const pinch_core *core, *other;
    double centre[3], radius; /* a ball in the other core */
} faces_and_body;

/* Of a cylinder the caps. */
static int count_faces(const pinch_core *core)
{
    return core->kind == PINCH_CORE_HULL       ? (int)core->hull->convex.plane_count
           : core->kind == PINCH_CORE_BOX      ? 6
           : core->kind == PINCH_CORE_CYLINDER ? 2
                                               : 0;
}

static faces_and_body faces_of(const pinch_core_pair *pair, int which)
{
    faces_and_body k = {.pair = pair, .which = which, .core = pair->a, .other = pair->b};
    double centre[3];
    if (which) {
        k.core = pair->b;
        k.other = pair->a;
    }
    k.count = count_faces(k.core);
    k.radius = pinch_core_inner_ball(k.other, centre);
    if (which) {
        pinch_v3_sub(centre, pair->p, centre);
        pinch_pair_turn_back(pair, centre, k.centre);
    } else {
        pinch_pair_turn(pair, centre, k.centre);
        pinch_v3_add_scaled(k.centre, 1, pair->p);
    }
    return k;
}

/* Its normal, and how far the core reaches along it. */
static inline double face_at(const pinch_core *core, int face, double *d)
{
    if (core->kind == PINCH_CORE_HULL) {
        pinch_v3_copy(d, core->hull->convex.planes + 4 * face);
        return core->hull->faces[face].offset;
    }
    int axis = core->kind == PINCH_CORE_BOX ? face / 2 : 2;
    pinch_v3_set(d, 0, 0, 0);
    d[axis] = face % 2 ? -1 : 1;
    return core->half[axis];
}

static double overlap_at(const faces_and_body *k, int face, double *normal, double *point)
{
    double d[3], n[3], local[3], x[3], offset = face_at(k->core, face, d);
    if (k->which) {
        pinch_pair_turn(k->pair, d, normal);
        for (int i = 0; i < 3; i++) n[i] = -normal[i];
        pinch_core_support(k->other, n, x);
        pinch_v3_sub(x, k->pair->p, local);
        pinch_pair_turn_back(k->pair, local, point);
    } else {
        for (int i = 0; i < 3; i++) normal[i] = -d[i];
        pinch_pair_turn_back(k->pair, normal, n);
        pinch_core_support(k->other, n, local);
        pinch_pair_turn(k->pair, local, point);
        pinch_v3_add_scaled(point, 1, k->pair->p);
    }
    return offset - pinch_v3_dot(d, point);
}

/* The face that the other core's middle is least deep behind comes first: its overlap is small, and the point found
 * there is deep behind most other faces, which then need no look. So is the ball inside the other core. */
static void least_face(const pinch_core_pair *pair, int which, double limit, pinch_least_face *least)
{
    const faces_and_body k = faces_of(pair, which);
    double d[3], nearest = DBL_MAX, normal[3], point[3];
    int first = 0;
    least->face = -1;
    least->at.overlap = DBL_MAX;
    for (int f = 0; f < k.count; f++) {
        double clear = face_at(k.core, f, d) - pinch_v3_dot(d, k.centre);
        if (clear >= nearest) continue;
        nearest = clear;
        first = f;
    }
    if (nearest + k.radius >= limit) return;
    for (int turn = -1; turn < k.count; turn++) {
        int f = turn < 0 ? first : turn;
        if (turn == first) continue;
        if (turn >= 0) {
            double offset = face_at(k.core, f, d);
            if (offset - pinch_v3_dot(d, k.centre) + k.radius >= limit) continue;
            if (least->face >= 0 && offset - pinch_v3_dot(d, least->point) >= limit) continue;
        }
        double overlap = overlap_at(&k, f, normal, point);
        if (!(overlap < limit)) continue;
        limit = least->at.overlap = overlap;
        least->face = f;
        pinch_v3_copy(least->at.normal, normal);
        pinch_v3_copy(least->point, point);
    }
}

/* As pinch_face_is_least. */
static bool is_least(const pinch_core_pair *pair, int which, const pinch_least_face *least)
{
    const pinch_core *core = which ? pair->b : pair->a, *other = which ? pair->a : pair->b;
    double inside = DBL_MAX, d[3];
    if (least->face < 0) return false;
    if (core->kind == PINCH_CORE_HULL) {
        if (other->kind == PINCH_CORE_POINT && least->at.overlap >= 0) return true; /* faces alone bound the hull */
        const pinch_core_face *face = &core->hull->faces[least->face];
        const double *side = face->sides;
        for (unsigned k = 0; k < face->polygon[0]; k++, side += 4) {
            double to = side[3] - pinch_v3_dot(side, least->point);
            if (to < inside) inside = to;
        }
    } else {
        (void)face_at(core, least->face, d);
        inside = pinch_inside_face(core, d, least->point);
    }
    return pinch_flat_is_least(pair, inside, least->at.normal, least->at.overlap);
}

bool pinch_hull_first(const pinch_core_pair *pair, pinch_least_face faces[2], pinch_contact_normal *best)
{
    double size = pair->a->bound < pair->b->bound ? pair->a->bound : pair->b->bound;
    least_face(pair, 0, DBL_MAX, &faces[0]);
    least_face(pair, 1, faces[0].at.overlap < DBL_MAX ? faces[0].at.overlap + TIE * size : DBL_MAX, &faces[1]);
    int which = faces[1].at.overlap < faces[0].at.overlap;
    *best = faces[which].at;
    if (best->overlap <= -(pair->a->skin + pair->b->skin) || is_least(pair, which, &faces[which])) return true;
    return faces[!which].at.overlap <= best->overlap + TIE * size && is_least(pair, !which, &faces[!which]);
}
