/*
 * Where the overlap p(n) = h_A(-n) + h_B(n) of a sharp box and a sharp cylinder is least, the surface of the Minkowski
 * difference is smooth, because no ball touches a sharp edge from inside. So one of these pairs of features meets
 * there: a face and anything (n is its normal); a side and an edge (n is their common perpendicular); a side and a
 * corner (n is at right angles to the axis, towards the corner); or a rim and an edge (n is at right angles to the
 * edge, which leaves one unknown).
 *
 * The tangent planes at smooth places alone bound a convex body. So the bodies overlap if p > 0 along all of these
 * normals.
 */
#include "methods.h"

#include "face_test.h"
#include "rim_line.h"
#include "support/vec3.h"

#include <float.h>

/* A face gives the steadier contact. Anything else counts only if it is better by this much of the size. */
static const double FACE_PREFERENCE = 1e-9;

/* If edge and axis are nearer to parallel than this (sine), their common perpendicular is rounding. */
static const double PARALLEL = 1e-8;

/* Components of less than this part of the size are rounding. */
static const double LEVEL = 1e-12;

/* The pair's numbers are computed once. */
typedef struct box_and_cylinder {
    const pinch_shape_pair *pair;
    double w[3];    /* the cylinder's axis */
    double W[3];    /* absolute values of w */
    double sine[3]; /* of the angles between the axis and the box's axes */
    double over[3]; /* 1/sine; 0 if parallel */
    double r, H, preference;
} box_and_cylinder;

/* Returns whose face it is: 0 for the box, 1 for the cylinder. */
static int faces(const box_and_cylinder *k, pinch_contact_normal *best)
{
    const double *h = k->pair->a->half;
    for (int i = 0; i < 3; i++) {
        double n[3] = {i == 0, i == 1, i == 2};
        pinch_offer_axis(k->pair, n, h[i] + k->r * k->sine[i] + k->H * k->W[i], 0, best);
    }
    double of_box = best->overlap;
    pinch_offer_axis(k->pair, k->w, h[0] * k->W[0] + h[1] * k->W[1] + h[2] * k->W[2] + k->H, 0, best);
    return best->overlap < of_box;
}

static void side_and_edges(const box_and_cylinder *k, pinch_contact_normal *best)
{
    const double *h = k->pair->a->half;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, l = (i + 2) % 3;
        double n[3] = {0, 0, 0}, scale = k->over[i];
        if (!(scale > 0)) continue;
        n[j] = -k->w[l] * scale;
        n[l] = k->w[j] * scale;
        pinch_offer_axis(k->pair, n, (h[j] * k->W[l] + h[l] * k->W[j]) * scale + k->r, k->preference, best);
    }
}

static void side_and_corners(const box_and_cylinder *k, pinch_contact_normal *best)
{
    const double *h = k->pair->a->half, *p = k->pair->p, *w = k->w;
    double along = pinch_v3_dot(w, p);
    const double middle[3] = {p[0] - along * w[0], p[1] - along * w[1], p[2] - along * w[2]};
    /* d = middle - v + (w.v) w, and d.v >= 0 below, so d.d = d.middle - d.v is at most |d| |middle| */
    double farthest2 = pinch_v3_dot(middle, middle), needed = k->r - best->overlap + k->preference;
    if (needed > 0 && farthest2 < needed * needed) return;
    for (int corner = 0; corner < 8; corner++) {
        const double v[3] = {corner & 1 ? h[0] : -h[0], corner & 2 ? h[1] : -h[1], corner & 4 ? h[2] : -h[2]};
        double at = pinch_v3_dot(w, v), d[3];
        bool supports =
            true; /* is the corner, or its edge at right angles to rounding, the box's farthest part along d? */
        for (int i = 0; i < 3 && supports; i++) {
            d[i] = middle[i] - v[i] + at * w[i];
            supports = d[i] * v[i] >= -LEVEL * h[i] * k->pair->a->bound;
        }
        if (!supports) continue;
        double least = k->r - best->overlap + k->preference, length2 = pinch_v3_dot(d, d);
        if (!(length2 > 0) || (least > 0 && length2 < least * least)) continue;
        double length = sqrt(length2);
        best->overlap = k->r - length;
        for (int i = 0; i < 3; i++) best->normal[i] = -d[i] / length;
    }
}

/* Tries one edge of the box, along axis i, with one rim. `to` leads along the cylinder to the rim. */
static void edge_and_rim(const box_and_cylinder *k, int i, const double P[2], const double to[2], const double sign[2],
                         pinch_contact_normal *best)
{
    double x[2] = {to[0] / k->sine[i], to[1] / k->sine[i]}, X = P[0] * x[0] + P[1] * x[1];
    double Y = P[1] * x[0] - P[0] * x[1], m = k->W[i] * k->W[i], Q2 = k->sine[i] * k->sine[i], c, s;
    const double ends[2][2] = {{x[0], -x[1]}, {x[1], x[0]}};
    if (pinch_rim_least_is_off(X, Y, k->r, m, Q2, ends)) return;
    if (!pinch_rim_least(X, Y, k->r, m, Q2, &c, &s)) return;
    const double n[2] = {c * x[0] - s * x[1], c * x[1] + s * x[0]};
    double overlap = X * c + Y * s + k->r * sqrt(m + Q2 * s * s);
    if (n[0] < 0 || n[1] < 0 || !(overlap < best->overlap - k->preference)) return;
    best->overlap = overlap;
    best->normal[i] = 0;
    best->normal[(i + 1) % 3] = sign[0] * n[0];
    best->normal[(i + 2) % 3] = sign[1] * n[1];
}

/*
 * The normals across an edge of the box are (c, s) with c and s >= 0. A rim with its centre at P from the edge extends
 * along n by at least n.P' for each of its points P'. Two of these points bound it well: those farthest along (1, 0)
 * and (0, 1), whose other coordinates are past_l and past_j.
 */
static void rims_and_edges(const box_and_cylinder *k, pinch_contact_normal *best)
{
    const double *h = k->pair->a->half, *p = k->pair->p;
    double to[3][4], P[3][4]; /* per axis of the box: bit 0 is the side of the box, bit 1 the rim */
    for (int i = 0; i < 3; i++)
        for (int which = 0; which < 4; which++) {
            double side = which & 1 ? 1 : -1;
            to[i][which] = (which & 2 ? side : -side) * k->w[i];
            P[i][which] = h[i] + side * p[i] + k->H * to[i][which];
        }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, l = (i + 2) % 3;
        if (!(k->over[i] > 0)) continue;
        double both = k->r * k->w[j] * k->w[l], past_j = both * k->over[j], past_l = both * k->over[l];
        for (int which = 0; which < 8; which++) {
            int a = (which & 1) | (which & 4) >> 1, b = which >> 1;
            double limit = best->overlap - k->preference, sign = (which + 1) & 2 ? -1 : 1;
            if (to[j][a] <= 0 && to[l][b] <= 0) continue;
            if (P[j][a] + k->r * k->sine[j] >= limit && P[l][b] - sign * past_j >= limit) continue;
            if (P[l][b] + k->r * k->sine[l] >= limit && P[j][a] - sign * past_l >= limit) continue;
            edge_and_rim(k, i, (const double[2]){P[j][a], P[l][b]}, (const double[2]){to[j][a], to[l][b]},
                         (const double[2]){a & 1 ? 1 : -1, b & 1 ? 1 : -1}, best);
        }
    }
}

void pinch_box_cylinder(const pinch_shape_pair *pair, double apart, pinch_contact_normal *best)
{
    box_and_cylinder k = {.pair = pair,
                          .w = {pair->R[2], pair->R[5], pair->R[8]},
                          .r = pair->b->radius,
                          .H = pair->b->half[2],
                          .preference = FACE_PREFERENCE * fmin(pair->a->bound, pair->b->bound)};
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, l = (i + 2) % 3;
        k.W[i] = fabs(k.w[i]);
        k.sine[i] = sqrt(k.w[j] * k.w[j] + k.w[l] * k.w[l]);
        k.over[i] = k.sine[i] > PARALLEL ? 1 / k.sine[i] : 0;
    }
    best->overlap = DBL_MAX;
    int which = faces(&k, best);
    if (best->overlap <= apart || pinch_face_is_least(pair, which, best->normal, best->overlap)) return;
    side_and_edges(&k, best);
    if (best->overlap <= apart) return;
    side_and_corners(&k, best);
    if (best->overlap <= apart) return;
    rims_and_edges(&k, best);
}
