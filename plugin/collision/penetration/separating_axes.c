/*
 * Polytopes that overlap: the overlap as a function of the normal can be least only at a face's normal or at the common
 * perpendicular of two edges whose arcs on the Gauss sphere cross (Gregorius, The Separating Axis Test between Convex
 * Polyhedra, 2013).
 */
#include "separating_axes.h"

#include "edge_arcs.h"
#include "face_test.h"
#include "hull_edges.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* An edge must be better than the faces by this much of the size to count: a face gives the steadier contact. */
static const double FACE_BONUS = 1e-9;

static void every_face(const pinch_core_pair *pair, pinch_contact_normal *best)
{
    double f[3], n[3];
    for (int k = 0; k < pinch_core_face_count(pair->a); k++) {
        pinch_core_face_normal(pair->a, k, f);
        for (int i = 0; i < 3; i++) n[i] = -f[i];
        pinch_offer_normal(pair, n, best);
    }
    for (int k = 0; k < pinch_core_face_count(pair->b); k++) {
        pinch_core_face_normal(pair->b, k, f);
        pinch_pair_turn(pair, f, n);
        pinch_offer_normal(pair, n, best);
    }
}

/* Does A's arc cross the mirrored arc of B, or touch it? Where an arc is one of several that its edge has, those of
 * bodies with aligned axes cross at its end. */
static bool arcs_cross(const pinch_edge_arc *a, const pinch_edge_arc *b)
{
    static const double TOUCHING = 1e-12;
    double c = pinch_v3_dot(b->n1, a->u), d = pinch_v3_dot(b->n2, a->u);
    if (!(c * d < TOUCHING)) return false;
    double e = pinch_v3_dot(a->n1, b->u), f = pinch_v3_dot(a->n2, b->u);
    return e * f < TOUCHING;
}

/* The outward normal of both, A's at -n and B's at n, is +- the cross product of the edges. */
static void edge_pair(const pinch_core_pair *pair, const pinch_edge_arc *a, const pinch_edge_arc *b, double bonus,
                      pinch_contact_normal *best)
{
    double n[3], mid[3];
    if (!arcs_cross(a, b)) return;
    pinch_v3_cross(a->u, b->u, n);
    double length = pinch_v3_norm(n);
    if (!(length > 1e-8)) return;
    for (int i = 0; i < 3; i++) mid[i] = b->n1[i] + b->n2[i];
    pinch_v3_scale(n, (pinch_v3_dot(n, mid) < 0 ? -1 : 1) / length);
    for (int i = 0; i < 3; i++) mid[i] = a->n1[i] + a->n2[i];
    if (!(pinch_v3_dot(n, mid) < 0)) return; /* the two arcs' circles meet at opposite points */
    double overlap = pinch_pair_overlap(pair, n);
    if (!(overlap < best->overlap - bonus)) return;
    best->overlap = overlap;
    pinch_v3_copy(best->normal, n);
}

/* Two boxes: half the axes are the other half's opposites, and no arcs need be looked at. */
static void box_box(const pinch_core_pair *pair, double apart, double bonus, pinch_contact_normal *best)
{
    const double *R = pair->R, *a = pair->a->half, *b = pair->b->half;
    double Q[9];
    for (int i = 0; i < 9; i++) Q[i] = fabs(R[i]);
    int first = pair->a->kind == PINCH_CORE_BOX ? 0 : 2; /* a segment has one edge, and no faces */
    for (int i = 0; i < 3 && first == 0; i++) {
        double axis[3] = {0, 0, 0};
        axis[i] = 1;
        pinch_offer_axis(pair, axis, a[i] + b[0] * Q[3 * i] + b[1] * Q[3 * i + 1] + b[2] * Q[3 * i + 2], 0, best);
    }
    double of_a = best->overlap;
    for (int j = 0; j < 3; j++) {
        const double axis[3] = {R[j], R[3 + j], R[6 + j]};
        pinch_offer_axis(pair, axis, b[j] + a[0] * Q[j] + a[1] * Q[3 + j] + a[2] * Q[6 + j], 0, best);
    }
    if (best->overlap <= apart || pinch_face_is_least(pair, best->overlap < of_a, best->normal, best->overlap)) return;
    for (int i = first; i < 3; i++) {
        int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
        for (int j = 0; j < 3; j++) { /* e_i x R e_j */
            int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            double length = sqrt(R[3 * i1 + j] * R[3 * i1 + j] + R[3 * i2 + j] * R[3 * i2 + j]);
            if (!(length > 1e-8)) continue;
            double scale = 1 / length, axis[3] = {0, 0, 0};
            axis[i1] = -R[3 * i2 + j] * scale;
            axis[i2] = R[3 * i1 + j] * scale;
            double reach =
                a[i1] * Q[3 * i2 + j] + a[i2] * Q[3 * i1 + j] + b[j1] * Q[3 * i + j2] + b[j2] * Q[3 * i + j1];
            pinch_offer_axis(pair, axis, reach * scale, bonus, best);
        }
    }
}

bool pinch_separating_axes(const pinch_core_pair *pair, pinch_least_face *faces, pinch_contact_normal *best)
{
    double bonus = FACE_BONUS * fmin(pair->a->bound, pair->b->bound);
    bool straight = pair->a->kind == PINCH_CORE_BOX || pair->a->kind == PINCH_CORE_SEGMENT;
    if (straight && pair->b->kind == PINCH_CORE_BOX) {
        double skins = pair->a->skin + pair->b->skin;
        box_box(pair, skins > 0 ? -DBL_MAX : 0, bonus, best);
        return true;
    }
    if (faces && pinch_hull_edges(pair, faces, bonus, best)) return true;
    pinch_edge_arc a[PINCH_MAX_EDGES], b[PINCH_MAX_EDGES];
    int a_count = pinch_edge_arcs(pair->a, a), b_count = pinch_edge_arcs(pair->b, b);
    if (a_count < 0 || b_count < 0) return false;
    every_face(pair, best);
    for (int j = 0; j < b_count; j++) {
        pinch_edge_arc turned;
        pinch_pair_turn(pair, b[j].v, turned.v);
        pinch_v3_add_scaled(turned.v, 1, pair->p);
        pinch_pair_turn(pair, b[j].u, turned.u);
        pinch_pair_turn(pair, b[j].n1, turned.n1);
        pinch_pair_turn(pair, b[j].n2, turned.n2);
        for (int i = 0; i < a_count; i++) edge_pair(pair, &a[i], &turned, bonus, best);
    }
    return true;
}
