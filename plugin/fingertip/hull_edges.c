/*
 * A minimum of the overlap between two edges is where their arcs on the Gauss sphere cross (separating_axes.c): on B's
 * arc, between the normals of its edge's two faces, at right angles to A's edge. Both edges' points there are apart by
 * the overlap, so that neither edge can lie farther from the other body.
 */
#include "hull_edges.h"

#include "support/vec3.h"

#include <math.h>

enum { MOST = PINCH_LEFT_EDGES };

/* The hull's edges in the list that have a point x with n.x >= level; all in its own axes. */
static int edges_beyond(const pinch_core_hull *hull, const double *n, double level, int count, int *edges)
{
    const double *x = hull->convex.points;
    int kept = 0;
    for (int k = 0; k < count; k++) {
        const unsigned *corner = hull->edges[edges[k]].corner;
        if (pinch_v3_dot(n, x + 3 * corner[0]) >= level || pinch_v3_dot(n, x + 3 * corner[1]) >= level)
            edges[kept++] = edges[k];
    }
    return kept;
}

int pinch_edges_in_reach(const pinch_core_pair *pair, const pinch_contact_normal *best, int count, int *edges)
{
    double b[3], back[3];
    if (count == 0) return 0;
    pinch_pair_support_b(pair, best->normal, b);
    for (int i = 0; i < 3; i++) back[i] = -best->normal[i];
    return edges_beyond(pair->a->hull, back, pinch_v3_dot(back, b) - best->overlap, count, edges);
}

/* B's; in its own axes. */
static int edges_of_b(const pinch_core_pair *pair, const pinch_contact_normal *best, int count, int *edges)
{
    double a[3], d[3], n[3];
    if (count == 0) return 0;
    pinch_pair_support_a(pair, best->normal, a);
    pinch_v3_sub(a, pair->p, d);
    double level = pinch_v3_dot(best->normal, d) - best->overlap;
    pinch_pair_turn_back(pair, best->normal, n);
    return edges_beyond(pair->b->hull, n, level, count, edges);
}

static void normals_of_b(const pinch_core_pair *pair, double normals[MOST][3])
{
    const pinch_convex *convex = &pair->b->hull->convex;
    for (unsigned f = 0; f < convex->plane_count; f++) pinch_pair_turn(pair, convex->planes + 4 * f, normals[f]);
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
    const pinch_core_hull *hull = pair->b->hull;
    pinch_pair_turn(pair, hull->convex.points + 3 * hull->edges[edge].corner[0], x);
    pinch_v3_add_scaled(x, 1, pair->p);
}

/* A box has an edge across every normal at right angles to one of its axes; a segment is its own. */
static void straight_edges(const pinch_core_pair *pair, const int *edges, int count, double bonus,
                           pinch_contact_normal *best)
{
    const double *half = pair->a->half;
    double normals[MOST][3];
    int first = pair->a->kind == PINCH_CORE_BOX ? 0 : 2;
    normals_of_b(pair, normals);
    for (int k = 0; k < count; k++) {
        const unsigned *face = pair->b->hull->edges[edges[k]].face;
        const double *n1 = normals[face[0]], *n2 = normals[face[1]];
        for (int i = first; i < 3; i++) {
            double n[3], v[3];
            if (!(n1[i] * n2[i] < 0) || !crossing(n1, n2, n1[i], n2[i], n)) continue;
            point_of_b(pair, edges[k], v);
            double overlap = pinch_v3_dot(v, n);
            for (int j = 0; j < 3; j++) overlap += j == i ? 0 : half[j] * fabs(n[j]);
            if (!(overlap < best->overlap - bonus)) continue;
            best->overlap = overlap;
            pinch_v3_copy(best->normal, n);
            best->normal[i] = 0;
        }
    }
}

static void edge_of(const pinch_core_hull *hull, int edge, double *u)
{
    const unsigned *corner = hull->edges[edge].corner;
    pinch_v3_sub(hull->convex.points + 3 * corner[1], hull->convex.points + 3 * corner[0], u);
}

/* Are two directions parallel to rounding? */
static bool parallel(const double *u, const double *v)
{
    double across[3];
    pinch_v3_cross(u, v, across);
    return !(pinch_v3_dot(across, across) > 1e-16 * pinch_v3_dot(u, u) * pinch_v3_dot(v, v));
}

/* One edge of A, and those of B: `ub` their directions, in A's axes. */
static void edge_and_edges(const pinch_core_pair *pair, int edge, const double normals[MOST][3], const int *edges,
                           const double ub[MOST][3], int count, double bonus, pinch_contact_normal *best)
{
    const pinch_core_hull *A = pair->a->hull, *B = pair->b->hull;
    const double *a1 = A->convex.planes + 4 * A->edges[edge].face[0], *va;
    const double *a2 = A->convex.planes + 4 * A->edges[edge].face[1];
    double u[3], beyond[MOST], n[3], v[3];
    edge_of(A, edge, u);
    va = A->convex.points + 3 * A->edges[edge].corner[0];
    for (unsigned f = 0; f < B->convex.plane_count; f++) beyond[f] = pinch_v3_dot(normals[f], u);
    for (int k = 0; k < count; k++) {
        const unsigned *face = B->edges[edges[k]].face;
        double s1 = beyond[face[0]], s2 = beyond[face[1]];
        if (!(s1 * s2 < 0) || !(pinch_v3_dot(a1, ub[k]) * pinch_v3_dot(a2, ub[k]) < 0)) continue;
        if (parallel(u, ub[k]) || !crossing(normals[face[0]], normals[face[1]], s1, s2, n)) continue;
        if (!(pinch_v3_dot(n, a1) + pinch_v3_dot(n, a2) < 0)) continue; /* the circles' other crossing */
        point_of_b(pair, edges[k], v);
        double overlap = pinch_v3_dot(v, n) - pinch_v3_dot(va, n);
        if (!(overlap < best->overlap - bonus)) continue;
        best->overlap = overlap;
        pinch_v3_copy(best->normal, n);
    }
}

bool pinch_hull_edges(const pinch_core_pair *pair, const pinch_least_face faces[2], double bonus,
                      pinch_contact_normal *best)
{
    double normals[MOST][3], ub[MOST][3], u[3];
    int of_a[MOST], of_b[MOST];
    pinch_deep_faces deep_a, deep_b;
    bool straight = pair->a->kind == PINCH_CORE_SEGMENT || pair->a->kind == PINCH_CORE_BOX;
    if (pair->b->kind != PINCH_CORE_HULL || (!straight && pair->a->kind != PINCH_CORE_HULL)) return false;
    if (!pinch_find_deep_faces(pair, 1, &faces[1], best->overlap - bonus, &deep_b)) return false;
    if (!straight && !pinch_find_deep_faces(pair, 0, &faces[0], best->overlap - bonus, &deep_a)) return false;
    int b_count = edges_of_b(pair, best, pinch_edges_left(&deep_b, of_b), of_b);
    if (b_count == 0) return true;
    if (straight) {
        straight_edges(pair, of_b, b_count, bonus, best);
        return true;
    }
    int a_count = pinch_edges_in_reach(pair, best, pinch_edges_left(&deep_a, of_a), of_a);
    if (a_count == 0) return true;
    normals_of_b(pair, normals);
    for (int k = 0; k < b_count; k++) {
        edge_of(pair->b->hull, of_b[k], u);
        pinch_pair_turn(pair, u, ub[k]);
    }
    for (int k = 0; k < a_count; k++) edge_and_edges(pair, of_a[k], normals, of_b, ub, b_count, bonus, best);
    return true;
}
