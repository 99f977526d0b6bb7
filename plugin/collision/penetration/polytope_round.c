/*
 * A polytope and a body with a round side. As for a box and a cylinder (box_cylinder.c), the overlap is least at the
 * normal of a face or cap, at the common perpendicular of an edge and the side, at right angles to the axis towards a
 * corner, or where a rim meets an edge. A flat capsule's dome is smooth and also meets whatever is nearest to its
 * centre. The overlap along every direction on offer is that of the whole bodies.
 */
#include "methods.h"

#include "candidate_edges.h"
#include "collision/distance/distance.h"
#include "rim_line.h"
#include "support/vec3.h"

#include <float.h>

static void offer_along(const pinch_shape_pair *pair, const double *direction, double sign, pinch_contact_normal *best)
{
    double length = pinch_v3_norm(direction), n[3];
    if (!(length > 1e-9 * pair->b->bound)) return;
    for (int i = 0; i < 3; i++) n[i] = sign / length * direction[i];
    pinch_offer_normal(pair, n, best);
}

static void faces_and_caps(const pinch_shape_pair *pair, const double *w, const pinch_shallow_faces *shallow,
                           pinch_contact_normal *best)
{
    double f[3], n[3];
    for (int k = 0; k < pinch_face_count(pair->a); k++) {
        if (shallow && !pinch_is_shallow(shallow, (unsigned)k)) continue;
        pinch_face_normal(pair->a, k, f);
        for (int i = 0; i < 3; i++) n[i] = -f[i];
        pinch_offer_normal(pair, n, best);
    }
    for (int i = 0; i < 3; i++) n[i] = -w[i];
    pinch_offer_normal(pair, n, best);
    if (pair->b->kind == PINCH_SHAPE_CYLINDER) pinch_offer_normal(pair, w, best);
}

/* Tells whether the vertex is farthest against d to rounding, so that none of its neighbours is farther. */
static bool is_farthest(const pinch_hull *hull, unsigned corner, const double *d)
{
    static const double LEVEL = 1e-9;
    const double *points = hull->convex.points;
    double least = pinch_v3_dot(points + 3 * corner, d) - LEVEL * hull->outer * hull->outer;
    for (unsigned k = hull->neighbours_at[corner]; k < hull->neighbours_at[corner + 1]; k++)
        if (pinch_v3_dot(points + 3 * hull->neighbours[k], d) < least) return false;
    return true;
}

/* The normal is the one at which only this corner and the side meet. */
static void offer_corner(const pinch_shape_pair *pair, const double *w, int corner, const pinch_hull *hull,
                         pinch_contact_normal *best)
{
    double v[3], d[3], needed = pair->b->radius - best->overlap;
    pinch_vertex(pair->a, corner, v);
    pinch_v3_sub(v, pair->p, d);
    pinch_v3_make_perpendicular(d, w);
    if (needed > 0 && pinch_v3_dot(d, d) <= needed * needed) return;
    if (hull && !is_farthest(hull, (unsigned)corner, d)) return;
    offer_along(pair, d, 1, best);
}

static void side_and_corners(const pinch_shape_pair *pair, const double *w, pinch_contact_normal *best)
{
    for (int k = 0, count = pinch_vertex_count(pair->a); k < count; k++) offer_corner(pair, w, k, NULL, best);
}

/* Tells whether -n, which is at right angles to the edge, lies between its faces' normals to rounding. */
static bool is_on_arc(const pinch_edge_arc *edge, const double *n)
{
    static const double ROUNDING = 1e-9;
    double c = pinch_v3_dot(edge->n1, edge->n2), to_1 = -pinch_v3_dot(n, edge->n1), to_2 = -pinch_v3_dot(n, edge->n2);
    return to_1 >= c - ROUNDING && to_2 >= c - ROUNDING && to_1 + to_2 >= -ROUNDING;
}

static void edge_and_side(const pinch_shape_pair *pair, const double *w, const pinch_edge_arc *edge,
                          pinch_contact_normal *best)
{
    double n[3], from[3];
    pinch_v3_cross(edge->u, w, n);
    double length = pinch_v3_norm(n);
    if (!(length > 1e-8)) { /* the edge is parallel to the axis, and a corner on the axis has no direction: any
                               direction across will do */
        pinch_v3_any_perpendicular(w, n);
        offer_along(pair, n, 1, best);
        offer_along(pair, n, -1, best);
        return;
    }
    pinch_v3_sub(pair->p, edge->v, from);
    for (int sign = -1; sign <= 1; sign += 2) {
        const double m[3] = {sign / length * n[0], sign / length * n[1], sign / length * n[2]};
        if (is_on_arc(edge, m) && pinch_v3_dot(from, m) + pair->b->radius < best->overlap)
            pinch_offer_normal(pair, m, best);
    }
}

static void rim_and_edge(const pinch_shape_pair *pair, const pinch_rim_line *across, const pinch_edge_arc *edge,
                         int rim, pinch_contact_normal *best)
{
    const pinch_shape *b = pair->b;
    const double *x = across->x, *y = across->y;
    double X = rim * across->X + b->half[2] * across->sine, Q2 = across->sine * across->sine, n[3], overlap;
    const double ends[2][2] = {{-rim * pinch_v3_dot(edge->n1, x), -rim * pinch_v3_dot(edge->n1, y)},
                               {-rim * pinch_v3_dot(edge->n2, x), -rim * pinch_v3_dot(edge->n2, y)}};
    if (pinch_rim_least_is_off(X, rim * across->Y, b->radius, across->m, Q2, ends)) return;
    if (!pinch_rim_line_normal(across, b, rim, n, &overlap)) return;
    if (overlap < best->overlap && is_on_arc(edge, n))
        offer_along(pair, n, 1, best); /* this overlap is at most that of the whole bodies */
}

/* Tries the rims on the sides where the edge's normals are. s1 and s2 are the components of its faces' normals along
 * the axis. */
static void rims_and_edge(const pinch_shape_pair *pair, const double *w, const pinch_edge_arc *edge, double s1,
                          double s2, pinch_contact_normal *best)
{
    pinch_rim_line across;
    double P[3];
    for (int i = 0; i < 3; i++) P[i] = pair->p[i] + pair->b->middle * w[i] - edge->v[i];
    if (!pinch_rim_line_of(edge->u, w, P, &across)) return;
    if (s1 > 0 || s2 > 0) rim_and_edge(pair, &across, edge, -1, best);
    if ((s1 < 0 || s2 < 0) && pair->b->kind == PINCH_SHAPE_CYLINDER) rim_and_edge(pair, &across, edge, 1, best);
}

static void dome(const pinch_shape_pair *pair, const double *w, pinch_contact_normal *best)
{
    pinch_shape centre = {.kind = PINCH_SHAPE_POINT, .bound = pair->b->bound};
    pinch_shape_pair with = *pair;
    pinch_gjk_result result;
    double guess[3];
    with.b = &centre;
    pinch_v3_add_scaled(with.p, pair->b->middle + pair->b->half[2], w);
    for (int i = 0; i < 3; i++) guess[i] = -with.p[i];
    if (pinch_gjk(&with, NULL, false, guess, DBL_MAX, 1e-15, &result) == PINCH_GJK_APART)
        pinch_offer_normal(pair, result.normal, best);
}

static void along_edge(const pinch_shape_pair *pair, const double *w, const pinch_edge_arc *arc,
                       pinch_contact_normal *best)
{
    static const double LEVEL = 1e-8;
    double s1 = pinch_v3_dot(w, arc->n1),
           s2 = pinch_v3_dot(w, arc->n2); /* the contact normals are opposite: from -s1 to -s2 */
    if ((s1 <= LEVEL || s2 <= LEVEL) && (s1 >= -LEVEL || s2 >= -LEVEL)) edge_and_side(pair, w, arc, best);
    rims_and_edge(pair, w, arc, s1, s2, best);
}

/* Keeps those edges of A that may meet B with less overlap than is known. */
static uint64_t edges_in_reach(const pinch_shape_pair *pair, const pinch_contact_normal *best, uint64_t edges)
{
    double b[3], out[3];
    if (edges == 0) return 0;
    pinch_pair_support_b(pair, best->normal, b);
    for (int i = 0; i < 3; i++) out[i] = -best->normal[i];
    return pinch_edges_beyond(pair->a->hull, out, pinch_v3_dot(out, b) - best->overlap, edges);
}

/* Tries only what the face test leaves. */
static bool round_hull(const pinch_shape_pair *pair, const double *w, const pinch_least_face *faces,
                       pinch_contact_normal *best)
{
    const pinch_hull *hull = pair->a->hull;
    pinch_candidates candidates;
    if (!pinch_find_candidates(hull, faces, best->overlap, &candidates)) return false;
    if (pair->b->kind != PINCH_SHAPE_CYLINDER)
        faces_and_caps(pair, w, NULL, best); /* the face test has tried a cylinder's caps already */
    while (candidates.corners) offer_corner(pair, w, pinch_take_bit(&candidates.corners), hull, best);
    if (pair->b->kind == PINCH_SHAPE_FLAT_CAPSULE) dome(pair, w, best);
    candidates.edges = edges_in_reach(pair, best, candidates.edges);
    while (candidates.edges) along_edge(pair, w, &hull->arcs[pinch_take_bit(&candidates.edges)], best);
    return true;
}

/* Across an edge the contact normals are -(a n1 + b n2) with a + b >= 1. If a point of B, seen from the edge, has
 * `limit` or more along both, none of these normals has less. The point tried is the one farthest along their
 * middle. */
static bool edge_is_deep(const pinch_shape_pair *pair, const pinch_edge_arc *edge, double limit)
{
    double n[3], x[3];
    for (int i = 0; i < 3; i++) n[i] = -edge->n1[i] - edge->n2[i];
    pinch_pair_support_b(pair, n, x);
    pinch_v3_sub(x, edge->v, x);
    return pinch_v3_dot(edge->n1, x) <= -limit && pinch_v3_dot(edge->n2, x) <= -limit;
}

/* Tells whether a direction across the axis, which an edge parallel to the axis offers, has less overlap. That is no
 * normal of the edge, so that nothing is known of it from the faces. */
static bool is_less_across(const pinch_shape_pair *pair, const double *w, const pinch_contact_normal *best)
{
    pinch_contact_normal found = *best;
    double n[3];
    pinch_v3_any_perpendicular(w, n);
    offer_along(pair, n, 1, &found);
    offer_along(pair, n, -1, &found);
    return found.overlap < best->overlap;
}

void pinch_polytope_round(const pinch_shape_pair *pair, const pinch_least_face *faces, pinch_contact_normal *best)
{
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]};
    pinch_edge_arc own[PINCH_BOX_EDGES];
    pinch_shallow_faces shallow;
    int count;
    if (faces && pair->a->kind == PINCH_SHAPE_HULL && round_hull(pair, w, faces, best)) return;
    const pinch_edge_arc *arcs = pinch_edge_arcs(pair->a, own, &count);
    pinch_find_shallow_faces(pair, 0, best, &shallow);
    faces_and_caps(pair, w, &shallow, best);
    side_and_corners(pair, w, best);
    if (pair->b->kind == PINCH_SHAPE_FLAT_CAPSULE) dome(pair, w, best);
    if (is_less_across(pair, w, best)) shallow.hull = NULL;
    for (int k = 0; k < count; k++)
        if (pinch_is_shallow_edge(&shallow, k) && !edge_is_deep(pair, &arcs[k], best->overlap))
            along_edge(pair, w, &arcs[k], best);
}
