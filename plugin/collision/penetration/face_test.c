#include "face_test.h"

#include "support/vec3.h"

#include <float.h>
#include <math.h>

/* A face's axis: the one of the normal d. */
static int axis_of(const pinch_core *core, const double *d)
{
    return core->kind == PINCH_CORE_CYLINDER ? 2 : pinch_v3_main_axis(d);
}

double pinch_inside_face(const pinch_core *core, const double d[3], const double x[3])
{
    if (core->kind == PINCH_CORE_CYLINDER) return core->radius - sqrt(x[0] * x[0] + x[1] * x[1]);
    int axis = axis_of(core, d), j = (axis + 1) % 3, k = (axis + 2) % 3;
    double u = core->half[j] - fabs(x[j]), v = core->half[k] - fabs(x[k]);
    return u < v ? u : v;
}

bool pinch_face_point(const pinch_core_pair *pair, int which, const double n[3], double x[3])
{
    static const double PARALLEL = 1e-13, LEVEL = 1e-12; /* 1 less the cosine, sine */
    const pinch_core *core = which ? pair->b : pair->a;
    double d[3] = {-n[0], -n[1], -n[2]}, centre[3] = {-pair->p[0], -pair->p[1], -pair->p[2]};
    if (which) {
        pinch_pair_turn_back(pair, n, d);
        pinch_pair_turn_back(pair, centre, x);
    } else {
        pinch_v3_copy(x, pair->p);
    }
    int axis = pinch_v3_main_axis(d);
    if (core->kind == PINCH_CORE_CYLINDER && fabs(d[2]) < LEVEL) {
        x[0] = core->radius * d[0];
        x[1] = core->radius * d[1];
        if (fabs(x[2]) > core->half[2]) x[2] = copysign(core->half[2], x[2]);
        axis = -1;
    } else if (fabs(d[axis]) < 1 - PARALLEL || (axis < 2 && core->kind != PINCH_CORE_BOX)) {
        return false;
    } else if (core->kind == PINCH_CORE_CYLINDER) {
        double rho = sqrt(x[0] * x[0] + x[1] * x[1]), scale = rho > core->radius ? core->radius / rho : 1;
        x[0] *= scale;
        x[1] *= scale;
    } else if (core->kind == PINCH_CORE_BOX) {
        for (int i = 0; i < 3; i++)
            if (fabs(x[i]) > core->half[i]) x[i] = copysign(core->half[i], x[i]);
    } else {
        return false;
    }
    if (axis >= 0) x[axis] = copysign(core->half[axis], d[axis]);
    if (which) {
        pinch_pair_turn(pair, x, d);
        for (int i = 0; i < 3; i++) x[i] = d[i] + pair->p[i];
    } else {
        pinch_v3_sub(x, pair->p, d);
        pinch_pair_turn_back(pair, d, x);
    }
    return true;
}

bool pinch_ball_fits(const pinch_core *core, const double d[3], double inside, double overlap)
{
    return overlap > 0 && inside >= overlap && core->half[axis_of(core, d)] >= overlap;
}

/*
 * A point of the other body around which a ball of radius p(n) fits into the one that has the face bounds the overlap
 * in every direction by p(n). Where none does:
 *
 * Points x of the difference B - A bound the overlap: p(m) >= m.x. Let the other body's farthest point lie over the
 * face, inside its border by d. Then the difference has around it a flat disc of radius d at n.x = p(n), and at the
 * angle t from n,
 *
 *     p(m) >= p(n) cos t + d sin t >= p(n)  for tan(t/2) <= d/p(n).
 *
 * What is left is at larger angles, where a ball in both bodies bounds the overlap (pinch_rest_is_deeper). Bodies that
 * are apart along n are nearest to each other at that point.
 */
bool pinch_face_is_least(const pinch_core_pair *pair, int which, const double n[3], double overlap)
{
    const pinch_core *core = which ? pair->b : pair->a;
    double x[3], d[3], from[3];
    if (which) {
        pinch_pair_support_a(pair, n, x);
        pinch_v3_sub(x, pair->p, from);
        pinch_pair_turn_back(pair, from, x);
        pinch_pair_turn_back(pair, n, d);
    } else {
        pinch_pair_support_b(pair, n, x);
        pinch_v3_copy(d, n);
    }
    double inside = pinch_inside_face(core, d, x);
    if (pinch_ball_fits(core, d, inside, overlap) || pinch_flat_is_least(pair, inside, n, overlap)) return true;
    if (!pinch_face_point(pair, !which, n, x)) return false;
    inside = pinch_inside_face(core, d, x);
    return pinch_ball_fits(core, d, inside, overlap) || pinch_flat_is_least(pair, inside, n, overlap);
}

bool pinch_flat_is_least(const pinch_core_pair *pair, double inside, const double n[3], double overlap)
{
    if (overlap <= 0) return inside >= 0;
    if (!(inside > 0)) return false;
    double p2 = overlap * overlap, d2 = inside * inside, scale = 1 / (d2 + p2);
    return pinch_rest_is_deeper(pair, n, overlap, (p2 - d2) * scale, 2 * overlap * inside * scale);
}

/* The face of least overlap; -1: no faces, 0: A's, 1: B's. */
static int least_face(const pinch_core_pair *pair, pinch_contact_normal *best)
{
    int which = -1;
    for (int k = 0; k < 6; k++) {
        const pinch_core *core = k < 3 ? pair->a : pair->b;
        int axis = k % 3;
        if (core->kind != PINCH_CORE_BOX && (core->kind != PINCH_CORE_CYLINDER || axis < 2)) continue;
        double n[3] = {axis == 0, axis == 1, axis == 2}, before = best->overlap;
        if (k >= 3)
            for (int i = 0; i < 3; i++) n[i] = pair->R[3 * i + axis];
        if (pinch_v3_dot(n, pair->p) > 0) pinch_v3_scale(n, -1);
        pinch_offer_normal(pair, n, best);
        if (best->overlap < before) which = k / 3;
    }
    return which;
}

bool pinch_face_first(const pinch_core_pair *pair, pinch_contact_normal *best)
{
    best->overlap = DBL_MAX;
    int which = least_face(pair, best);
    if (which < 0) return false;
    return best->overlap <= -(pair->a->skin + pair->b->skin) ||
           pinch_face_is_least(pair, which, best->normal, best->overlap);
}
