/*
 * Polytopes that overlap: the overlap as a function of the normal can be least only at a face's normal or at the common
 * perpendicular of two edges whose arcs on the Gauss sphere cross (Gregorius, The Separating Axis Test between Convex
 * Polyhedra, 2013).
 */
#include "normal.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

enum { MAX_EDGES = 96 };

/* An edge must be better than the faces by this much of the size to count: a face gives the steadier contact. */
static const double FACE_BONUS = 1e-9;

/* A straight edge and one arc of its normals, less than a half turn. */
typedef struct edge_arc {
    double v[3], u[3], n1[3], n2[3];
} edge_arc;

static int box_arcs(const pinch_core *core, edge_arc *arcs)
{
    int count = 0;
    for (int i = 0; i < 3; i++)
        for (int corner = 0; corner < 4; corner++) {
            edge_arc *arc = &arcs[count++];
            int j = (i + 1) % 3, k = (i + 2) % 3;
            double sj = corner & 1 ? 1 : -1, sk = corner & 2 ? 1 : -1;
            memset(arc, 0, sizeof *arc);
            arc->v[i] = -core->half[i];
            arc->v[j] = sj * core->half[j];
            arc->v[k] = sk * core->half[k];
            arc->u[i] = 1;
            arc->n1[j] = sj;
            arc->n2[k] = sk;
        }
    return count;
}

static int hull_arcs(const pinch_core_hull *hull, edge_arc *arcs)
{
    for (int e = 0; e < hull->edge_count; e++) {
        const pinch_core_edge *edge = &hull->edges[e];
        pinch_v3_copy(arcs[e].v, hull->convex.points + 3 * edge->corner[0]);
        pinch_v3_sub(hull->convex.points + 3 * edge->corner[1], arcs[e].v, arcs[e].u);
        pinch_v3_scale(arcs[e].u, 1 / pinch_v3_norm(arcs[e].u));
        pinch_v3_copy(arcs[e].n1, hull->convex.planes + 4 * edge->face[0]);
        pinch_v3_copy(arcs[e].n2, hull->convex.planes + 4 * edge->face[1]);
    }
    return hull->edge_count;
}

/* A triangle's edge has the half circle from one side to the other, through the direction that leads outward. */
static int triangle_arcs(const pinch_core *core, edge_arc *arcs)
{
    double axes[3][3];
    int count = 0;
    if (!pinch_core_axes(core, axes)) return 0;
    for (int k = 0; k < 3; k++) {
        const double *from = core->corner + 3 * k, *to = core->corner + 3 * ((k + 1) % 3);
        double u[3], out[3];
        pinch_v3_sub(to, from, u);
        pinch_v3_scale(u, 1 / pinch_v3_norm(u));
        pinch_v3_cross(u, axes[0], out);
        for (int side = 0; side < 2; side++) {
            edge_arc *arc = &arcs[count++];
            pinch_v3_copy(arc->v, from);
            pinch_v3_copy(arc->u, u);
            pinch_v3_copy(arc->n1, out);
            for (int i = 0; i < 3; i++) arc->n2[i] = side ? -axes[0][i] : axes[0][i];
        }
    }
    return count;
}

/* A segment has the whole circle, in four quarters. */
static int segment_arcs(const pinch_core *core, edge_arc *arcs)
{
    for (int k = 0; k < 4; k++) {
        memset(&arcs[k], 0, sizeof arcs[k]);
        arcs[k].v[2] = -core->half[2];
        arcs[k].u[2] = 1;
        arcs[k].n1[k % 2] = k < 2 ? 1 : -1;
        arcs[k].n2[(k + 1) % 2] = k == 0 || k == 3 ? 1 : -1;
    }
    return 4;
}

/* -1: too many */
static int arcs_of(const pinch_core *core, edge_arc *arcs)
{
    switch (core->kind) {
    case PINCH_CORE_SEGMENT:
        return segment_arcs(core, arcs);
    case PINCH_CORE_TRIANGLE:
        return triangle_arcs(core, arcs);
    case PINCH_CORE_BOX:
        return box_arcs(core, arcs);
    case PINCH_CORE_HULL:
        return core->hull->edge_count <= MAX_EDGES ? hull_arcs(core->hull, arcs) : -1;
    default:
        return 0;
    }
}

static void faces(const pinch_core_pair *pair, pinch_contact_normal *best)
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

/* Does A's arc cross the mirrored arc of B? */
static bool arcs_cross(const edge_arc *a, const edge_arc *b)
{
    double c = pinch_v3_dot(b->n1, a->u), d = pinch_v3_dot(b->n2, a->u);
    if (!(c * d < 0)) return false;
    double e = pinch_v3_dot(a->n1, b->u), f = pinch_v3_dot(a->n2, b->u);
    return e * f < 0;
}

/* The outward normal of both, A's at -n and B's at n, is +- the cross product of the edges. */
static void edge_pair(const edge_arc *a, const edge_arc *b, double bonus, pinch_contact_normal *best)
{
    double n[3], mid[3], gap[3];
    if (!arcs_cross(a, b)) return;
    pinch_v3_cross(a->u, b->u, n);
    double length = pinch_v3_norm(n);
    if (!(length > 1e-8)) return;
    for (int i = 0; i < 3; i++) mid[i] = b->n1[i] + b->n2[i];
    pinch_v3_scale(n, (pinch_v3_dot(n, mid) < 0 ? -1 : 1) / length);
    for (int i = 0; i < 3; i++) mid[i] = a->n1[i] + a->n2[i];
    if (!(pinch_v3_dot(n, mid) < 0)) return; /* the two arcs' circles meet at opposite points */
    pinch_v3_sub(b->v, a->v, gap);
    double overlap = pinch_v3_dot(gap, n);
    if (!(overlap < best->overlap - bonus)) return;
    best->overlap = overlap;
    pinch_v3_copy(best->normal, n);
}

/* Two boxes: half the axes are the other half's opposites, and no arcs need be looked at. */
static void box_axis(const pinch_core_pair *pair, const double *axis, double reach, double bonus,
                     pinch_contact_normal *best)
{
    double along = pinch_v3_dot(axis, pair->p), overlap = reach - fabs(along);
    if (!(overlap < best->overlap - bonus)) return;
    best->overlap = overlap;
    for (int i = 0; i < 3; i++) best->normal[i] = along > 0 ? -axis[i] : axis[i];
}

static void box_box(const pinch_core_pair *pair, double bonus, pinch_contact_normal *best)
{
    const double *R = pair->R, *a = pair->a->half, *b = pair->b->half;
    double Q[9];
    for (int i = 0; i < 9; i++) Q[i] = fabs(R[i]);
    for (int i = 0; i < 3; i++) {
        double axis[3] = {0, 0, 0};
        axis[i] = 1;
        box_axis(pair, axis, a[i] + b[0] * Q[3 * i] + b[1] * Q[3 * i + 1] + b[2] * Q[3 * i + 2], 0, best);
    }
    for (int j = 0; j < 3; j++) {
        const double axis[3] = {R[j], R[3 + j], R[6 + j]};
        box_axis(pair, axis, b[j] + a[0] * Q[j] + a[1] * Q[3 + j] + a[2] * Q[6 + j], 0, best);
    }
    for (int i = 0; i < 3; i++) {
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
            box_axis(pair, axis, reach * scale, bonus, best);
        }
    }
}

/* Nothing flat and no two edges: a point on a point, a point on a line, lines in line. */
static void any_normal(const pinch_core_pair *pair, pinch_contact_normal *best)
{
    double n[3] = {-pair->p[0], -pair->p[1], -pair->p[2]}, u[3] = {0, 0, 1};
    if (pair->b->kind == PINCH_CORE_SEGMENT) pinch_pair_turn(pair, (const double[3]){0, 0, 1}, u);
    if (pair->a->kind == PINCH_CORE_SEGMENT) pinch_v3_set(u, 0, 0, 1);
    pinch_v3_make_perpendicular(n, u);
    double length = pinch_v3_norm(n);
    if (length > 1e-12 * pair->a->bound)
        pinch_v3_scale(n, 1 / length);
    else
        pinch_v3_any_perpendicular(u, n);
    pinch_offer_normal(pair, n, best);
}

bool pinch_separating_axes(const pinch_core_pair *pair, pinch_contact_normal *best)
{
    double bonus = FACE_BONUS * fmin(pair->a->bound, pair->b->bound);
    if (pair->a->kind == PINCH_CORE_BOX && pair->b->kind == PINCH_CORE_BOX) {
        box_box(pair, bonus, best);
        return true;
    }
    edge_arc a[MAX_EDGES], b[MAX_EDGES];
    int a_count = arcs_of(pair->a, a), b_count = arcs_of(pair->b, b);
    if (a_count < 0 || b_count < 0) return false;
    faces(pair, best);
    for (int j = 0; j < b_count; j++) {
        edge_arc turned;
        pinch_pair_turn(pair, b[j].v, turned.v);
        pinch_v3_add_scaled(turned.v, 1, pair->p);
        pinch_pair_turn(pair, b[j].u, turned.u);
        pinch_pair_turn(pair, b[j].n1, turned.n1);
        pinch_pair_turn(pair, b[j].n2, turned.n2);
        for (int i = 0; i < a_count; i++) edge_pair(&a[i], &turned, bonus, best);
    }
    if (best->overlap > 1e300) any_normal(pair, best);
    return true;
}
