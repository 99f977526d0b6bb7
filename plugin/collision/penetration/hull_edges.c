/*
 * A minimum of the overlap between two edges is where their arcs on the Gauss sphere cross (separating_axes.c): on B's
 * arc, between the normals of its edge's two faces, at right angles to A's edge. Both edges' points there are apart by
 * the overlap, so that neither edge can lie farther from the other body.
 */
#include "hull_edges.h"

#include "support/vec3.h"

#include <math.h>

uint64_t pinch_edges_beyond(const pinch_core_hull *hull, const double n[3], double level, uint64_t edges)
{
    const double *x = hull->convex.points;
    uint64_t kept = 0;
    while (edges) {
        int e = pinch_take_bit(&edges);
        const unsigned *corner = hull->edges[e].corner;
        double one = pinch_v3_dot(n, x + 3 * corner[0]), two = pinch_v3_dot(n, x + 3 * corner[1]);
        kept |= (uint64_t)((one >= level) | (two >= level)) << e;
    }
    return kept;
}

/* How far A reaches along -n, where the face of one of both gives the normal. */
static double reach_of_a(const pinch_core_pair *pair, const pinch_least_face faces[2], const pinch_contact_normal *best)
{
    const double *n = best->normal;
    double back[3];
    if (pair->a->kind == PINCH_CORE_HULL && pinch_gives_normal(&faces[0], n))
        return pair->a->hull->faces[faces[0].face].offset;
    if (pair->b->kind == PINCH_CORE_HULL && pinch_gives_normal(&faces[1], n))
        return best->overlap - pair->b->hull->faces[faces[1].face].offset - pinch_v3_dot(n, pair->p);
    for (int i = 0; i < 3; i++) back[i] = -n[i];
    return pinch_core_reach(pair->a, back);
}

/* Of these edges the ones that may meet the other core with less overlap than is known: of A and of B. */
static uint64_t edges_of_a(const pinch_core_pair *pair, const pinch_contact_normal *best, double reach, uint64_t edges)
{
    const double out[3] = {-best->normal[0], -best->normal[1], -best->normal[2]};
    return pinch_edges_beyond(pair->a->hull, out, reach - 2 * best->overlap, edges);
}

static uint64_t edges_of_b(const pinch_core_pair *pair, const pinch_contact_normal *best, double reach, uint64_t edges)
{
    double n[3], level = -reach - pinch_v3_dot(best->normal, pair->p) - best->overlap;
    pinch_pair_turn_back(pair, best->normal, n);
    return pinch_edges_beyond(pair->b->hull, n, level, edges);
}

/* In A's axes; but for the point on the edge. */
static void turn_arc(const pinch_core_pair *pair, const pinch_edge_arc *arc, pinch_edge_arc *turned)
{
    pinch_pair_turn(pair, arc->u, turned->u);
    pinch_pair_turn(pair, arc->n1, turned->n1);
    pinch_pair_turn(pair, arc->n2, turned->n2);
}

/* Where the arc from n1 to n2 crosses the plane that they are s1 and s2 beyond. */
static bool crossing(const double *n1, const double *n2, double s1, double s2, double *n)
{
    double t1 = fabs(s2), t2 = fabs(s1);
    for (int i = 0; i < 3; i++) n[i] = t1 * n1[i] + t2 * n2[i];
    double length = pinch_v3_norm(n);
    if (!(length > 1e-8 * (t1 + t2))) return false;
    pinch_v3_scale(n, 1 / length);
    return true;
}

static void point_of_b(const pinch_core_pair *pair, int edge, double *x)
{
    pinch_pair_turn(pair, pair->b->hull->arcs[edge].v, x);
    pinch_v3_add_scaled(x, 1, pair->p);
}

/* A box has an edge across every normal at right angles to one of its axes; a segment is its own. */
static void straight_edges(const pinch_core_pair *pair, uint64_t edges, double bonus, pinch_contact_normal *best)
{
    const double *half = pair->a->half;
    int first = pair->a->kind == PINCH_CORE_BOX ? 0 : 2;
    while (edges) {
        int edge = pinch_take_bit(&edges);
        double n1[3], n2[3];
        pinch_pair_turn(pair, pair->b->hull->arcs[edge].n1, n1);
        pinch_pair_turn(pair, pair->b->hull->arcs[edge].n2, n2);
        for (int i = first; i < 3; i++) {
            double n[3], v[3];
            if (!(n1[i] * n2[i] < 0) || !crossing(n1, n2, n1[i], n2[i], n)) continue;
            point_of_b(pair, edge, v);
            double overlap = pinch_v3_dot(v, n);
            for (int j = 0; j < 3; j++) overlap += j == i ? 0 : half[j] * fabs(n[j]);
            if (!(overlap < best->overlap - bonus)) continue;
            best->overlap = overlap;
            pinch_v3_copy(best->normal, n);
            best->normal[i] = 0;
        }
    }
}

/* Are two unit vectors parallel to rounding? */
static bool parallel(const double *u, const double *v)
{
    double across[3];
    pinch_v3_cross(u, v, across);
    return !(pinch_v3_dot(across, across) > 1e-16);
}

/* One edge of A, and those of B in A's axes. The place of the one that is best; -1: none. */
static int edge_and_edges(const pinch_core_pair *pair, const pinch_edge_arc *a, const int *edges,
                          const pinch_edge_arc *of_b, int count, double bonus, pinch_contact_normal *best)
{
    const double *u = a->u;
    double n[3], v[3];
    int winner = -1;
    for (int k = 0; k < count; k++) {
        const pinch_edge_arc *b = &of_b[k];
        double s1 = pinch_v3_dot(b->n1, u), s2 = pinch_v3_dot(b->n2, u);
        if (!(s1 * s2 < 0) || !(pinch_v3_dot(a->n1, b->u) * pinch_v3_dot(a->n2, b->u) < 0)) continue;
        if (parallel(u, b->u) || !crossing(b->n1, b->n2, s1, s2, n)) continue;
        if (!(pinch_v3_dot(n, a->n1) + pinch_v3_dot(n, a->n2) < 0)) continue; /* the circles' other crossing */
        point_of_b(pair, edges[k], v);
        double overlap = pinch_v3_dot(v, n) - pinch_v3_dot(a->v, n);
        if (!(overlap < best->overlap - bonus)) continue;
        best->overlap = overlap;
        pinch_v3_copy(best->normal, n);
        winner = k;
    }
    return winner;
}

bool pinch_hull_edges(const pinch_core_pair *pair, pinch_least_face faces[2], double bonus, pinch_contact_normal *best)
{
    pinch_edge_arc arcs[PINCH_LEFT_EDGES];
    int of_b[PINCH_LEFT_EDGES], b_count = 0;
    pinch_left left_a, left_b;
    const pinch_core_hull *a = pair->a->hull, *b = pair->b->hull;
    bool straight = pair->a->kind == PINCH_CORE_SEGMENT || pair->a->kind == PINCH_CORE_BOX;
    if (pair->b->kind != PINCH_CORE_HULL || (!straight && pair->a->kind != PINCH_CORE_HULL)) return false;
    if (!pinch_find_left(b, &faces[1], best->overlap - bonus, &left_b)) return false;
    if (!straight && !pinch_find_left(a, &faces[0], best->overlap - bonus, &left_a)) return false;
    double reach = reach_of_a(pair, faces, best);
    uint64_t edges_b = edges_of_b(pair, best, reach, left_b.edges);
    if (edges_b == 0) return true;
    if (straight) {
        straight_edges(pair, edges_b, bonus, best);
        return true;
    }
    uint64_t edges_a = edges_of_a(pair, best, reach, left_a.edges);
    if (edges_a == 0) return true;
    while (edges_b) {
        of_b[b_count] = pinch_take_bit(&edges_b);
        turn_arc(pair, &b->arcs[of_b[b_count]], &arcs[b_count]);
        b_count++;
    }
    while (edges_a) {
        int e = pinch_take_bit(&edges_a), winner = edge_and_edges(pair, &a->arcs[e], of_b, arcs, b_count, bonus, best);
        if (winner < 0) continue;
        faces[0].edge = e;
        faces[1].edge = of_b[winner];
    }
    return true;
}
