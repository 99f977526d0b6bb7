/*
 * Two sharp cylinders, or a segment and a cylinder. As for a box (box_cylinder.c), the overlap is least at a cap's
 * normal, at the common perpendicular of both sides, at right angles to one axis where the other's rim meets that side
 * (one unknown), or where two rims meet (two unknowns). A segment is a cylinder of radius 0: its side is the segment
 * itself, its rims are its ends, and these meet no rim where the surface of the difference is smooth.
 */
#include "methods.h"

#include "face_test.h"
#include "rim_line.h"
#include "rim_pair.h"
#include "support/vec3.h"

#include <float.h>

/* A cap gives the steadier contact. Anything else counts only if it is better by this much of the size. */
static const double FACE_PREFERENCE = 1e-9;

static const double PARALLEL = 1e-8; /* sine of the angle between the axes */

/* Tries the side of the cylinder along `axis` against the rims of the other one, which has the axis w. */
static void side_and_rims(const pinch_shape_pair *pair, const pinch_shape *straight, const double *axis,
                          const pinch_shape *other, const double *w, double preference, pinch_contact_normal *best)
{
    pinch_rim_line across;
    if (!pinch_rim_line_of(axis, w, pair->p, &across)) return;
    for (int rim = -1; rim <= 1; rim += 2) {
        double n[3], overlap, limit = best->overlap - preference - straight->radius;
        if (!pinch_rim_may_beat(&across, other, rim, limit)) continue;
        if (!pinch_rim_line_normal(&across, other, rim, n, &overlap) || !(overlap < limit)) continue;
        best->overlap = overlap + straight->radius;
        pinch_v3_copy(best->normal, n);
    }
}

/* Two sides meet across both axes, along the line of centres if they are parallel, and anywhere around if they are in
 * one line. */
static void sides(const pinch_shape_pair *pair, const double *w, double sine, double preference,
                  pinch_contact_normal *best)
{
    double n[3] = {-w[1], w[0], 0}; /* the cross product of z and w */
    if (!(sine > PARALLEL)) pinch_v3_set(n, pair->p[0], pair->p[1], 0);
    double length = pinch_v3_norm(n);
    if (length > 0)
        pinch_v3_scale(n, 1 / length);
    else
        n[0] = 1;
    pinch_offer_axis(pair, n, pair->a->radius + pair->b->radius, preference, best);
}

/* Tries the ends of the segment (A's axis) against the cylinder's side. */
static void side_and_ends(const pinch_shape_pair *pair, const double *w, pinch_contact_normal *best)
{
    for (int end = -1; end <= 1; end += 2) {
        double d[3] = {pair->p[0], pair->p[1], pair->p[2] - end * pair->a->half[2]}, n[3];
        pinch_v3_make_perpendicular(d, w);
        double length = pinch_v3_norm(d);
        if (!(length > 0)) continue;
        for (int i = 0; i < 3; i++) n[i] = -d[i] / length;
        pinch_offer_normal(pair, n, best);
    }
}

void pinch_segment_cylinder(const pinch_shape_pair *pair, pinch_contact_normal *best)
{
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]}, z[3] = {0, 0, 1};
    const pinch_shape *A = pair->a, *B = pair->b;
    double preference = FACE_PREFERENCE * fmin(A->bound, B->bound);
    best->overlap = DBL_MAX;
    pinch_offer_axis(pair, w, B->half[2] + A->half[2] * fabs(w[2]), 0, best);
    sides(pair, w, sqrt(w[0] * w[0] + w[1] * w[1]), preference, best);
    side_and_rims(pair, A, z, B, w, preference, best);
    side_and_ends(pair, w, best);
}

/* Where both sides meet, the difference has a parallelogram with sides along both axes. Returns how far the lines'
 * common perpendicular lies inside it. */
static double inside_sides(const pinch_rim_frame *frame, const pinch_shape *A, const pinch_shape *B)
{
    double along_b = frame->m[0] / frame->sine, along_a = frame->m[2] - along_b * frame->cosine;
    double a = A->half[2] - fabs(along_a), b = B->half[2] - fabs(along_b);
    return frame->sine * (a < b ? a : b);
}

void pinch_cylinder_cylinder(const pinch_shape_pair *pair, double apart, pinch_contact_normal *best)
{
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]}, z[3] = {0, 0, 1};
    const pinch_shape *A = pair->a, *B = pair->b;
    double preference = FACE_PREFERENCE * fmin(A->bound, B->bound), of_a;
    double sine = sqrt(w[0] * w[0] + w[1] * w[1]), cosine = fabs(w[2]);
    pinch_rim_frame frame;
    best->overlap = DBL_MAX;
    pinch_offer_axis(pair, z, A->half[2] + B->radius * sine + B->half[2] * cosine, 0, best);
    of_a = best->overlap;
    pinch_offer_axis(pair, w, B->half[2] + A->radius * sine + A->half[2] * cosine, 0, best);
    if (best->overlap <= apart || pinch_face_is_least(pair, best->overlap < of_a, best->normal, best->overlap)) return;
    const double of_caps = best->overlap;
    sides(pair, w, sine, preference, best);
    if (best->overlap <= apart || !pinch_rim_frame_of(pair, &frame)) return;
    if (best->overlap < of_caps && pinch_facet_is_least(pair, inside_sides(&frame, A, B), best->normal, best->overlap))
        return;
    const double of_sides = best->overlap;
    side_and_rims(pair, A, z, B, w, preference, best);
    const double of_rims = best->overlap;
    side_and_rims(pair, B, w, A, z, preference, best);
    if (best->overlap <= apart) return;
    if (best->overlap < of_sides && pinch_side_and_rim_certificate(pair, best->overlap < of_rims, best)) return;
    const pinch_contact_normal from = *best;
    bool settled = pinch_descend_into_rims(&frame, &from, best);
    if (best->overlap <= apart) return;
    if (settled && best->overlap < from.overlap && pinch_rim_pair_certificate(pair, best)) return;
    pinch_search_rim_pairs(&frame, &from, best);
}
