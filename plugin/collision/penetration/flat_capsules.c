#include "methods.h"

#include "rim_line.h"
#include "rim_pair.h"
#include "support/vec3.h"

#include <math.h>

/*
 * Searches two rims from the best normal so far and from each cap. Where a rim lies a little beyond a cap's border, the
 * way down is too narrow to be met from other directions, which lead to the cap itself.
 */
static void rims(const pinch_shape_pair *pair, pinch_contact_normal *best)
{
    const pinch_contact_normal from = *best;
    pinch_rim_frame frame;
    if (!pinch_rim_frame_of(pair, &frame)) return;
    (void)pinch_descend_into_rims(&frame, &from, best);
    for (int which = 0; which < 4; which++) {
        double end = which & 2 ? 1 : -1;
        if (!pinch_has_rim(which & 1 ? pair->b : pair->a, end)) continue;
        pinch_contact_normal cap = {.normal = {0, 0, -end}};
        for (int i = 0; i < 3 && which & 1; i++) cap.normal[i] = end * pair->R[3 * i + 2];
        (void)pinch_descend_into_rims(&frame, &cap, best);
    }
    const pinch_contact_normal start = *best;
    pinch_search_rim_pairs(&frame, &start, best);
}

static void offer_along(const pinch_shape_pair *pair, const double *d, double sign, pinch_contact_normal *best)
{
    double n[3], length = pinch_v3_norm(d);
    if (!(length > 1e-9 * fmin(pair->a->bound, pair->b->bound))) return;
    for (int i = 0; i < 3; i++) n[i] = sign / length * d[i];
    pinch_offer_normal(pair, n, best);
}

/* A dome is part of a ball whose middle lies at d from that of `shape`, which has the axis v. The shape's side, rims
 * and dome come nearest to it along lines through that middle. `sign` is 1 for A's dome, to which the normal leads, and
 * -1 for B's. */
static void dome(const pinch_shape_pair *pair, const double *d, const pinch_shape *shape, const double *v, double sign,
                 pinch_contact_normal *best)
{
    double radial[3], from[3];
    pinch_v3_copy(radial, d);
    pinch_v3_make_perpendicular(radial, v);
    double rho = pinch_v3_norm(radial);
    offer_along(pair, radial, sign, best);
    for (int end = -1; end <= 1; end += 2) {
        pinch_v3_copy(from, d);
        pinch_v3_add_scaled(from, -end * shape->half[2], v);
        if (pinch_has_rim(shape, end) && rho > 0) pinch_v3_add_scaled(from, -shape->radius / rho, radial);
        offer_along(pair, from, sign, best);
    }
}

static void domes(const pinch_shape_pair *pair, const double *w, pinch_contact_normal *best)
{
    const double z[3] = {0, 0, 1};
    const pinch_shape *A = pair->a, *B = pair->b;
    double d[3];
    pinch_pair_between_middles(pair, w, d);
    pinch_v3_add_scaled(d, B->half[2], w);
    if (B->kind == PINCH_SHAPE_FLAT_CAPSULE) dome(pair, d, A, z, -1, best);
    pinch_pair_between_middles(pair, w, d);
    pinch_v3_scale(d, -1);
    pinch_v3_add_scaled(d, A->half[2], z);
    if (A->kind == PINCH_SHAPE_FLAT_CAPSULE) dome(pair, d, B, w, 1, best);
}

void pinch_flat_capsules(const pinch_shape_pair *pair, pinch_contact_normal *best)
{
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]}, z[3] = {0, 0, 1}, back[3] = {-w[0], -w[1], -w[2]};
    const pinch_shape *A = pair->a, *B = pair->b;
    double to_b[3], from_a[3], n[3], overlap;
    pinch_rim_line of_a, of_b;
    pinch_v3_copy(to_b, pair->p); /* from A's axis to B's middle */
    pinch_v3_add_scaled(to_b, B->middle, w);
    pinch_v3_copy(from_a, pair->p); /* from A's middle to B's axis */
    pinch_v3_add_scaled(from_a, -A->middle, z);
    bool crossed = pinch_rim_line_of(z, w, to_b, &of_b) && pinch_rim_line_of(w, z, from_a, &of_a);
    for (int end = -1; end <= 1; end += 2) {
        const double cap[3] = {0, 0, -end};
        if (pinch_has_rim(A, end)) pinch_offer_normal(pair, cap, best);
        if (pinch_has_rim(B, end)) pinch_offer_normal(pair, end > 0 ? w : back, best);
        if (!crossed) continue;
        if (pinch_has_rim(B, end) && pinch_rim_line_normal(&of_b, B, end, n, &overlap))
            pinch_offer_normal(pair, n, best);
        /* A's feature is the one along -n */
        if (pinch_has_rim(A, end) && pinch_rim_line_normal(&of_a, A, -end, n, &overlap))
            pinch_offer_normal(pair, n, best);
        for (int i = 0; i < 3; i++) n[i] = end * of_b.y[i];
        pinch_offer_normal(pair, n, best);
    }
    domes(pair, w, best);
    rims(pair, best);
}
