/*
 * What two segments have of the other's points is a parallelogram, and the overlap is least along its normal or where
 * one of its edges, a segment and an end of the other, is nearest. Segments that cross, to the bit as bodies with
 * aligned axes do, have no overlap along the normal; lines in line have none along any way out of both.
 */
#include "two_segments.h"

#include "support/vec3.h"

#include <float.h>
#include <math.h>

/* The direction from an end of A to the nearest point of B, which is p + t w; in A's axes. */
static void from_end_of_a(const pinch_core_pair *pair, double end, const double *w, double touching,
                          pinch_contact_normal *best)
{
    double e[3] = {pair->p[0], pair->p[1], pair->p[2] - end};
    double half = pair->b->half[2], t = -pinch_v3_dot(e, w);
    bool inside = fabs(t) < half;
    pinch_v3_add_scaled(e, inside ? t : copysign(half, t), w);
    if (inside) pinch_v3_make_perpendicular(e, w); /* so short a vector is not so already */
    double distance = pinch_v3_norm(e);
    if (!(distance > touching)) return;
    pinch_v3_scale(e, -1 / distance);
    pinch_offer_normal(pair, e, best);
}

/* The direction from the nearest point of A to an end of B. */
static void from_end_of_b(const pinch_core_pair *pair, double end, const double *w, double touching,
                          pinch_contact_normal *best)
{
    double e[3] = {pair->p[0] + end * w[0], pair->p[1] + end * w[1], pair->p[2] + end * w[2]};
    double half = pair->a->half[2];
    e[2] = fabs(e[2]) < half ? 0 : e[2] - copysign(half, e[2]);
    double distance = pinch_v3_norm(e);
    if (!(distance > touching)) return;
    pinch_v3_scale(e, -1 / distance);
    pinch_offer_normal(pair, e, best);
}

/* In line: at right angles to the line, and as far as there is a way, from B towards A. */
static void out_of_line(const pinch_core_pair *pair, const double *w, pinch_contact_normal *best)
{
    double n[3] = {-pair->p[0], -pair->p[1], -pair->p[2]};
    pinch_v3_make_perpendicular(n, w);
    double length = pinch_v3_norm(n);
    if (length > 1e-12 * pair->b->bound)
        pinch_v3_scale(n, 1 / length);
    else
        pinch_v3_any_perpendicular(w, n);
    pinch_offer_normal(pair, n, best);
}

void pinch_two_segments(const pinch_core_pair *pair, pinch_contact_normal *found)
{
    /* Nearer than this part of the size counts as touching: the direction of so short a distance is rounding. Lines
     * at less than this angle, in radians, count as parallel: their common perpendicular is. */
    static const double TOUCHING = 1e-10, PARALLEL = 1e-8;
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]};
    double touching = TOUCHING * fmin(pair->a->bound, pair->b->bound), sine = sqrt(w[0] * w[0] + w[1] * w[1]);
    double half_a = pair->a->half[2], half_b = pair->b->half[2];
    found->overlap = DBL_MAX;
    for (int side = -1; side <= 1; side += 2) {
        if (half_a > 0 || side > 0) from_end_of_a(pair, side * half_a, w, touching, found);
        from_end_of_b(pair, side * half_b, w, touching, found);
    }
    if (sine > PARALLEL) {
        const double common[3] = {-w[1] / sine, w[0] / sine, 0};
        pinch_offer_axis(pair, common, 0, 0, found);
    }
    if (!(found->overlap < -touching)) out_of_line(pair, w, found);
}
