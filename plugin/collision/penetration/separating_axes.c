/*
 * Where two polytopes overlap, the overlap as a function of the normal can be least only at a face's normal or at the
 * common perpendicular of two edges whose arcs on the Gauss sphere cross (Gregorius, The Separating Axis Test between
 * Convex Polyhedra, 2013).
 */
#include "methods.h"

#include "candidate_edges.h"
#include "face_test.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* A face gives the steadier contact. An edge counts only if it is better by this much of the size. */
static const double FACE_PREFERENCE = 1e-9;

/* Returns the support value of A along -n, which is known where a face gives the normal. */
static double support_value_of_a(const pinch_shape_pair *pair, const pinch_least_face faces[2],
                                 const pinch_contact_normal *best)
{
    const double *n = best->normal;
    double back[3];
    if (pair->a->kind == PINCH_SHAPE_HULL && pinch_face_gives_normal(&faces[0], n))
        return pair->a->hull->faces[faces[0].face].offset;
    if (pair->b->kind == PINCH_SHAPE_HULL && pinch_face_gives_normal(&faces[1], n))
        return best->overlap - pair->b->hull->faces[faces[1].face].offset - pinch_v3_dot(n, pair->p);
    for (int i = 0; i < 3; i++) back[i] = -n[i];
    return pinch_support_value(pair->a, back);
}

/* Keeps those edges of A (and of B below) that may meet the other shape with less overlap than is known. */
static uint64_t edges_of_a(const pinch_shape_pair *pair, const pinch_contact_normal *best, double extent,
                           uint64_t edges)
{
    const double out[3] = {-best->normal[0], -best->normal[1], -best->normal[2]};
    return pinch_edges_beyond(pair->a->hull, out, extent - 2 * best->overlap, edges);
}

static uint64_t edges_of_b(const pinch_shape_pair *pair, const pinch_contact_normal *best, double extent,
                           uint64_t edges)
{
    double n[3], level = -extent - pinch_v3_dot(best->normal, pair->p) - best->overlap;
    pinch_pair_rotate_back(pair, best->normal, n);
    return pinch_edges_beyond(pair->b->hull, n, level, edges);
}

/* Rotates an arc of B to A's axes, without the point on the edge. */
static void rotate_arc(const pinch_shape_pair *pair, const pinch_edge_arc *arc, pinch_edge_arc *rotated)
{
    pinch_pair_rotate(pair, arc->u, rotated->u);
    pinch_pair_rotate(pair, arc->n1, rotated->n1);
    pinch_pair_rotate(pair, arc->n2, rotated->n2);
}

/* Finds where the arc from n1 to n2 crosses the plane that they are s1 and s2 beyond. */
static bool crossing(const double *n1, const double *n2, double s1, double s2, double *n)
{
    double t1 = fabs(s2), t2 = fabs(s1);
    for (int i = 0; i < 3; i++) n[i] = t1 * n1[i] + t2 * n2[i];
    double length = pinch_v3_norm(n);
    if (!(length > 1e-8 * (t1 + t2))) return false;
    pinch_v3_scale(n, 1 / length);
    return true;
}

static void point_of_b(const pinch_shape_pair *pair, int edge, double *x)
{
    pinch_pair_point_to_a(pair, pair->b->hull->arcs[edge].v, x);
}

/* A box has an edge across every normal at right angles to one of its axes. A segment is its own edge. */
static void straight_edges(const pinch_shape_pair *pair, uint64_t edges, double preference, pinch_contact_normal *best)
{
    const double *half = pair->a->half;
    int first = pair->a->kind == PINCH_SHAPE_BOX ? 0 : 2;
    while (edges) {
        int edge = pinch_take_bit(&edges);
        double n1[3], n2[3];
        pinch_pair_rotate(pair, pair->b->hull->arcs[edge].n1, n1);
        pinch_pair_rotate(pair, pair->b->hull->arcs[edge].n2, n2);
        for (int i = first; i < 3; i++) {
            double n[3], v[3];
            if (!(n1[i] * n2[i] < 0) || !crossing(n1, n2, n1[i], n2[i], n)) continue;
            point_of_b(pair, edge, v);
            double overlap = pinch_v3_dot(v, n);
            for (int j = 0; j < 3; j++) overlap += j == i ? 0 : half[j] * fabs(n[j]);
            if (!(overlap < best->overlap - preference)) continue;
            best->overlap = overlap;
            pinch_v3_copy(best->normal, n);
            best->normal[i] = 0;
        }
    }
}

/* Tells whether two unit vectors are parallel to rounding. */
static bool parallel(const double *u, const double *v)
{
    double across[3];
    pinch_v3_cross(u, v, across);
    return !(pinch_v3_dot(across, across) > 1e-16);
}

/* Tries one edge of A with edges of B in A's axes. Returns the place of the best one, or -1 if none is better. */
static int edge_and_edges(const pinch_shape_pair *pair, const pinch_edge_arc *a, const int *edges,
                          const pinch_edge_arc *of_b, int count, double preference, pinch_contact_normal *best)
{
    const double *u = a->u;
    double n[3], v[3];
    int winner = -1;
    for (int k = 0; k < count; k++) {
        const pinch_edge_arc *b = &of_b[k];
        double s1 = pinch_v3_dot(b->n1, u), s2 = pinch_v3_dot(b->n2, u);
        if (!(s1 * s2 < 0) || !(pinch_v3_dot(a->n1, b->u) * pinch_v3_dot(a->n2, b->u) < 0)) continue;
        if (parallel(u, b->u) || !crossing(b->n1, b->n2, s1, s2, n)) continue;
        if (!(pinch_v3_dot(n, a->n1) + pinch_v3_dot(n, a->n2) < 0)) continue; /* this is the circles' other crossing */
        point_of_b(pair, edges[k], v);
        double overlap = pinch_v3_dot(v, n) - pinch_v3_dot(a->v, n);
        if (!(overlap < best->overlap - preference)) continue;
        best->overlap = overlap;
        pinch_v3_copy(best->normal, n);
        winner = k;
    }
    return winner;
}

/*
 * Two edges can give the least overlap only where their arcs on the Gauss sphere cross. That is on B's arc, between the
 * normals of its edge's two faces, and at right angles to A's edge. The edges' points there are apart by the overlap,
 * so neither edge can lie farther from the other body than that.
 */
static bool hull_edges(const pinch_shape_pair *pair, pinch_least_face faces[2], double preference,
                       pinch_contact_normal *best)
{
    pinch_edge_arc arcs[PINCH_MAX_CANDIDATES];
    int of_b[PINCH_MAX_CANDIDATES], b_count = 0;
    pinch_candidates candidates_a, candidates_b;
    const pinch_hull *a = pair->a->hull, *b = pair->b->hull;
    bool straight = pair->a->kind == PINCH_SHAPE_SEGMENT || pair->a->kind == PINCH_SHAPE_BOX;
    if (pair->b->kind != PINCH_SHAPE_HULL || (!straight && pair->a->kind != PINCH_SHAPE_HULL)) return false;
    if (!pinch_find_candidates(b, &faces[1], best->overlap - preference, &candidates_b)) return false;
    if (!straight && !pinch_find_candidates(a, &faces[0], best->overlap - preference, &candidates_a)) return false;
    double extent = support_value_of_a(pair, faces, best);
    uint64_t edges_b = edges_of_b(pair, best, extent, candidates_b.edges);
    if (edges_b == 0) return true;
    if (straight) {
        straight_edges(pair, edges_b, preference, best);
        return true;
    }
    uint64_t edges_a = edges_of_a(pair, best, extent, candidates_a.edges);
    if (edges_a == 0) return true;
    while (edges_b) {
        of_b[b_count] = pinch_take_bit(&edges_b);
        rotate_arc(pair, &b->arcs[of_b[b_count]], &arcs[b_count]);
        b_count++;
    }
    while (edges_a) {
        int e = pinch_take_bit(&edges_a),
            winner = edge_and_edges(pair, &a->arcs[e], of_b, arcs, b_count, preference, best);
        if (winner < 0) continue;
        faces[0].edge = e;
        faces[1].edge = of_b[winner];
    }
    return true;
}

static void every_face(const pinch_shape_pair *pair, const pinch_shallow_faces shallow[2], pinch_contact_normal *best)
{
    double f[3], n[3];
    for (int k = 0; k < pinch_face_count(pair->a); k++) {
        if (!pinch_is_shallow(&shallow[0], (unsigned)k)) continue;
        pinch_face_normal(pair->a, k, f);
        for (int i = 0; i < 3; i++) n[i] = -f[i];
        pinch_offer_normal(pair, n, best);
    }
    for (int k = 0; k < pinch_face_count(pair->b); k++) {
        if (!pinch_is_shallow(&shallow[1], (unsigned)k)) continue;
        pinch_face_normal(pair->b, k, f);
        pinch_pair_rotate(pair, f, n);
        pinch_offer_normal(pair, n, best);
    }
}

/* Tells whether A's arc crosses or touches the mirrored arc of B. Where an edge has several arcs, those of bodies with
 * aligned axes cross at the end of one. */
static bool arcs_cross(const pinch_edge_arc *a, const pinch_edge_arc *b)
{
    static const double TOUCHING = 1e-12;
    double c = pinch_v3_dot(b->n1, a->u), d = pinch_v3_dot(b->n2, a->u);
    if (!(c * d < TOUCHING)) return false;
    double e = pinch_v3_dot(a->n1, b->u), f = pinch_v3_dot(a->n2, b->u);
    return e * f < TOUCHING;
}

/* The common normal, outward from A at -n and from B at n, is plus or minus the cross product of the edges. */
static void edge_pair(const pinch_shape_pair *pair, const pinch_edge_arc *a, const pinch_edge_arc *b, double preference,
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
    if (!(pinch_v3_dot(n, mid) < 0))
        return; /* the circles of the arcs meet at two opposite points, and this is the wrong one */
    if (!pinch_pair_overlaps_less(pair, n, best->overlap - preference, &best->overlap)) return;
    pinch_v3_copy(best->normal, n);
}

/* For two boxes half the axes are the opposites of the other half, and no arcs need be looked at. */
static void box_box(const pinch_shape_pair *pair, double apart, double preference, pinch_contact_normal *best)
{
    const double *R = pair->R, *a = pair->a->half, *b = pair->b->half;
    double Q[9];
    for (int i = 0; i < 9; i++) Q[i] = fabs(R[i]);
    int first = pair->a->kind == PINCH_SHAPE_BOX ? 0 : 2; /* a segment has one edge and no faces */
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
        for (int j = 0; j < 3; j++) { /* the axis is e_i x R e_j */
            int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            double length = sqrt(R[3 * i1 + j] * R[3 * i1 + j] + R[3 * i2 + j] * R[3 * i2 + j]);
            if (!(length > 1e-8)) continue;
            double scale = 1 / length, axis[3] = {0, 0, 0};
            axis[i1] = -R[3 * i2 + j] * scale;
            axis[i2] = R[3 * i1 + j] * scale;
            double extent =
                a[i1] * Q[3 * i2 + j] + a[i2] * Q[3 * i1 + j] + b[j1] * Q[3 * i + j2] + b[j2] * Q[3 * i + j1];
            pinch_offer_axis(pair, axis, extent * scale, preference, best);
        }
    }
}

/* Tries all faces and edges of both, but of hulls only where a face is shallow. */
static void all_axes(const pinch_shape_pair *pair, double preference, pinch_contact_normal *best)
{
    enum { KEPT = 1024 };
    pinch_edge_arc own_a[PINCH_BOX_EDGES], own_b[PINCH_BOX_EDGES], rotated;
    pinch_shallow_faces shallow[2];
    int a_count, b_count, kept[KEPT], kept_count = 0;
    const pinch_edge_arc *a = pinch_edge_arcs(pair->a, own_a, &a_count), *b = pinch_edge_arcs(pair->b, own_b, &b_count);
    for (int which = 0; which < 2; which++) pinch_find_shallow_faces(pair, which, best, &shallow[which]);
    every_face(pair, shallow, best);
    for (int i = 0; i < a_count; i++) {
        if (!pinch_is_shallow_edge(&shallow[0], i)) continue;
        if (kept_count < KEPT) kept[kept_count] = i;
        kept_count++;
    }
    for (int j = 0; j < b_count; j++) {
        if (!pinch_is_shallow_edge(&shallow[1], j)) continue;
        pinch_pair_point_to_a(pair, b[j].v, rotated.v);
        rotate_arc(pair, &b[j], &rotated);
        if (kept_count <= KEPT) {
            for (int i = 0; i < kept_count; i++) edge_pair(pair, &a[kept[i]], &rotated, preference, best);
            continue;
        }
        for (int i = 0; i < a_count; i++)
            if (pinch_is_shallow_edge(&shallow[0], i)) edge_pair(pair, &a[i], &rotated, preference, best);
    }
}

void pinch_separating_axes(const pinch_shape_pair *pair, pinch_least_face *faces, pinch_contact_normal *best)
{
    double preference = FACE_PREFERENCE * fmin(pair->a->bound, pair->b->bound);
    bool straight = pair->a->kind == PINCH_SHAPE_BOX || pair->a->kind == PINCH_SHAPE_SEGMENT;
    if (straight && pair->b->kind == PINCH_SHAPE_BOX) {
        double margins = pair->a->margin + pair->b->margin;
        box_box(pair, margins > 0 ? -DBL_MAX : 0, preference, best);
        return;
    }
    if (faces && hull_edges(pair, faces, preference, best)) return;
    all_axes(pair, preference, best);
}
