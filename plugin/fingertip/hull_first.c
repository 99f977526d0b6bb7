#include "hull_first.h"

#include "face_first.h"
#include "support/vec3.h"

#include <float.h>

/* Overlaps that differ by no more than this part of the size are as good as the same. */
static const double TIE = 1e-13;

/* The face of one core with the least overlap. */
typedef struct least_face {
    pinch_contact_normal at;
    int face; /* of a hull */
} least_face;

/* Its other core reaches at least as far as the ball inside it does: few faces need be looked at. */
static void hull_faces(const pinch_core_pair *pair, int which, double limit, least_face *least)
{
    const pinch_core_hull *hull = (which ? pair->b : pair->a)->hull;
    const pinch_core *other = which ? pair->a : pair->b;
    double p[3] = {pair->p[0], pair->p[1], pair->p[2]}, around = pinch_inner_radius(other);
    if (which) pinch_pair_turn_back(pair, pair->p, p);
    for (unsigned f = 0; f < hull->convex.plane_count; f++) {
        const double *d = hull->convex.planes + 4 * f; /* B's: the contact normal; A's: its opposite */
        double along = pinch_v3_dot(d, p), n[3], local[3];
        double clear = hull->offsets[f] + (which ? along : -along);
        if (clear + around >= limit) continue;
        if (which) {
            pinch_pair_turn(pair, d, n);
            for (int i = 0; i < 3; i++) local[i] = -n[i];
        } else {
            for (int i = 0; i < 3; i++) n[i] = -d[i];
            pinch_pair_turn_back(pair, n, local);
        }
        double overlap = clear + pinch_core_reach(other, local);
        if (!(overlap < limit)) continue;
        limit = least->at.overlap = overlap;
        least->face = (int)f;
        pinch_v3_copy(least->at.normal, n);
    }
}

/* A box' or cylinder's, from their middles. */
static void plain_faces(const pinch_core_pair *pair, int which, double limit, least_face *least)
{
    const pinch_core *core = which ? pair->b : pair->a, *hull = which ? pair->a : pair->b;
    double around = pinch_inner_radius(hull);
    int first = core->kind == PINCH_CORE_BOX ? 0 : core->kind == PINCH_CORE_CYLINDER ? 2 : 3;
    for (int k = 2 * first; k < 6; k++) {
        int axis = k / 2;
        double n[3] = {axis == 0, axis == 1, axis == 2};
        for (int i = 0; i < 3 && which; i++) n[i] = pair->R[3 * i + axis];
        if (k % 2) pinch_v3_scale(n, -1);
        if (core->half[axis] + pinch_v3_dot(n, pair->p) + around >= limit) continue;
        double overlap = pinch_pair_overlap(pair, n);
        if (!(overlap < limit)) continue;
        limit = least->at.overlap = overlap;
        pinch_v3_copy(least->at.normal, n);
    }
}

/* As pinch_face_is_least. */
static bool is_least(const pinch_core_pair *pair, int which, const least_face *least)
{
    const pinch_core *core = which ? pair->b : pair->a, *other = which ? pair->a : pair->b;
    const double *n = least->at.normal;
    if (core->kind != PINCH_CORE_HULL) return pinch_face_is_least(pair, which, n, least->at.overlap);
    if (other->kind == PINCH_CORE_POINT && least->at.overlap >= 0) return true; /* inside faces alone bound the hull */
    double x[3], from[3];
    if (which) {
        pinch_pair_support_a(pair, n, x);
        pinch_v3_sub(x, pair->p, from);
        pinch_pair_turn_back(pair, from, x);
    } else {
        pinch_pair_support_b(pair, n, x);
    }
    const unsigned *polygon = core->hull->convex.polygons;
    const double *side = core->hull->sides;
    for (int f = 0; f < least->face; f++, polygon += 1 + polygon[0]) side += 4 * polygon[0];
    double inside = DBL_MAX;
    for (unsigned k = 0; k < polygon[0]; k++, side += 4) {
        double to = side[3] - pinch_v3_dot(side, x);
        if (to < inside) inside = to;
    }
    return pinch_flat_is_least(pair, inside, n, least->at.overlap);
}

bool pinch_hull_first(const pinch_core_pair *pair, pinch_contact_normal *best)
{
    double size = pair->a->bound < pair->b->bound ? pair->a->bound : pair->b->bound, limit = DBL_MAX;
    least_face least[2] = {{.at = {.overlap = DBL_MAX}}, {.at = {.overlap = DBL_MAX}}};
    for (int which = 0; which < 2; which++) {
        if ((which ? pair->b : pair->a)->kind == PINCH_CORE_HULL)
            hull_faces(pair, which, limit, &least[which]);
        else
            plain_faces(pair, which, limit, &least[which]);
        if (least[which].at.overlap < limit) limit = least[which].at.overlap + TIE * size; /* as good counts, too */
    }
    int which = least[1].at.overlap < least[0].at.overlap;
    *best = least[which].at;
    if (best->overlap <= -(pair->a->skin + pair->b->skin) || is_least(pair, which, &least[which])) return true;
    return least[!which].at.overlap <= best->overlap + TIE * size && is_least(pair, !which, &least[!which]);
}
