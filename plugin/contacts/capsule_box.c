/*
 * ODE's capsule-box collider returns one point of a capsule that lies flat on a box, at alternating ends. A contact
 * line has two ends; the second one is computed here.
 *
 * A program may change a contact before it hands it over: it allows a slop, adds a margin, or moves the point to one of
 * the surfaces. It would have done the same to the other end. So how much deeper the handed point is than the geoms
 * overlap there, and how far it lies from the middle of the overlap, holds for both ends. Where the point is none that
 * the collider returns, the program has made it by itself, and it stays as it is.
 */
#include "contacts/collider_points.h"

#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* A contact normal within 0.05 rad of a face's normal means the face, if both ends of the line penetrate it. Where the
 * line runs out over the face's border and is slightly tilted, the collider returns the border's normal. Otherwise an
 * edge or a corner touches, in one point. */
static const double FACE_ALIGNMENT = 0.99875;
/* A contact that is farther than this part of the radius from where the collider puts it, or has a normal that is
 * turned by more, is not the collider's. */
static const double NEAR = 1e-3;
/* Depths and places along the normal that differ by less than this part of the radius differ by rounding. */
static const double ROUNDING = 1e-9;

static void to_frame(const double *rotation, const double *v, double *local)
{
    for (int i = 0; i < 3; i++) local[i] = rotation[i] * v[0] + rotation[4 + i] * v[1] + rotation[8 + i] * v[2];
}

/* Finds the part of the segment centre +- reach that lies over the face, by its parameters in [-1, 1]. Returns false
 * when none does. */
static bool clip_to_face(const double *centre, const double *reach, const double *half, int axis, double range[2])
{
    range[0] = -1;
    range[1] = 1;
    for (int i = 0; i < 3; i++) {
        if (i == axis) continue;
        if (fabs(reach[i]) < DBL_MIN) {
            if (fabs(centre[i]) > half[i]) return false;
            continue;
        }
        double a = (-half[i] - centre[i]) / reach[i], b = (half[i] - centre[i]) / reach[i];
        range[0] = fmax(range[0], fmin(a, b));
        range[1] = fmin(range[1], fmax(a, b));
    }
    return range[0] < range[1];
}

/* The line of a capsule over a face of a box. */
typedef struct line {
    double radius, along[3], out[3];      /* half the line, out of the face; world */
    double centre[3], reach[3], half[3];  /* of the line, of the box; in the box's frame */
    double place[3], normal[3], range[2]; /* the contact, out of the box; the part over the face, in [-1, 1] */
    double sign;                          /* of the face */
    int axis;
} line;

/* Returns false where the contact's normal means no face, or no part of the line lies over it. */
static bool read_line(dGeomID capsule, dGeomID box, bool capsule_first, const pinch_detected_point *seen, line *l)
{
    dReal length;
    dVector3 sides;
    dGeomCapsuleGetParams(capsule, &l->radius, &length);
    dGeomBoxGetLengths(box, sides);
    const double *R = dGeomGetRotation(box), *turn = dGeomGetRotation(capsule);
    double from[3];
    for (int i = 0; i < 3; i++) l->out[i] = capsule_first ? seen->normal[i] : -seen->normal[i];
    to_frame(R, l->out, l->normal);
    l->axis = 0;
    for (int i = 1; i < 3; i++)
        if (fabs(l->normal[i]) > fabs(l->normal[l->axis])) l->axis = i;
    if (fabs(l->normal[l->axis]) < FACE_ALIGNMENT) return false;

    l->sign = l->normal[l->axis] > 0 ? 1 : -1;
    for (int i = 0; i < 3; i++) l->out[i] = l->sign * R[4 * i + l->axis];
    for (int i = 0; i < 3; i++) l->along[i] = 0.5 * length * turn[4 * i + 2];
    pinch_v3_sub(dGeomGetPosition(capsule), dGeomGetPosition(box), from);
    to_frame(R, from, l->centre);
    to_frame(R, l->along, l->reach);
    pinch_v3_sub(seen->position, dGeomGetPosition(box), from);
    to_frame(R, from, l->place);
    for (int i = 0; i < 3; i++) l->half[i] = 0.5 * sides[i];
    return clip_to_face(l->centre, l->reach, l->half, l->axis, l->range);
}

/* Returns how deep the capsule is in the face, below a place of its line. */
static double depth_below(const line *l, double at)
{
    double height = l->sign * (l->centre[l->axis] + at * l->reach[l->axis]) - l->half[l->axis];
    return l->radius - height;
}

/* Finds the place of the line, by its parameter, that the contact lies below. Returns false where it lies beside the
 * line, or not at an end of the part over the face, and where the line is upright. The collider returns the deepest
 * point, which is at an end. */
static bool find_on_line(const line *l, double *at)
{
    double aside[3], across[3], within = NEAR * l->radius;
    pinch_v3_sub(l->place, l->centre, aside);
    pinch_v3_make_perpendicular(aside, l->normal);
    pinch_v3_copy(across, l->reach);
    pinch_v3_make_perpendicular(across, l->normal);
    double length2 = pinch_v3_dot(across, across);
    if (!(length2 > NEAR * NEAR * pinch_v3_dot(l->reach, l->reach))) return false;
    *at = fmin(fmax(pinch_v3_dot(aside, across) / length2, -1), 1);
    pinch_v3_add_scaled(aside, -*at, across);
    double from_end = fmin(*at - l->range[0], l->range[1] - *at) * sqrt(length2);
    return pinch_v3_norm(aside) <= within && from_end <= within;
}

/* What the program has made of the collider's contact, in m. */
typedef struct change {
    double deeper, lower; /* than the collider had it, along the normal */
} change;

/*
 * Finds out what the program has changed. Differences by rounding are none. Where the line goes into the box itself,
 * the collider takes the capsule for a box, and its points tell nothing. Returns false where the collider returns no
 * such contact.
 */
static bool find_change(const line *l, double depth, change *c)
{
    double at, on[3], gap[3], down[3];
    *c = (change){0, 0};
    if (depth_below(l, l->range[0]) >= l->radius || depth_below(l, l->range[1]) >= l->radius) return true;
    if (!find_on_line(l, &at)) return false;
    for (int i = 0; i < 3; i++) {
        on[i] = l->centre[i] + at * l->reach[i];
        gap[i] = on[i] - fmin(fmax(on[i], -l->half[i]), l->half[i]);
    }
    double distance = pinch_v3_norm(gap);
    pinch_v3_add_scaled(gap, -distance, l->normal);
    if (pinch_v3_norm(gap) > NEAR * distance) return false;
    pinch_v3_sub(on, l->place, down);
    double deeper = depth - (l->radius - distance);
    double lower = pinch_v3_dot(down, l->normal) - 0.5 * (l->radius + distance);
    if (fabs(deeper) > ROUNDING * l->radius) c->deeper = deeper;
    if (fabs(lower) > ROUNDING * l->radius) c->lower = lower;
    return fabs(lower) <= l->radius;
}

/*
 * Finds the ends of the capsule's line over the touched face that penetrate it, and returns how many do. A program that
 * hands over a gap hands over all that the collider returns: there an end counts where the geoms touch.
 */
static int line_ends(dGeomID capsule, dGeomID box, bool capsule_first, const pinch_detected_point *seen,
                     pinch_detected_point ends[2])
{
    line l;
    change by_program;
    if (!read_line(capsule, box, capsule_first, seen, &l) || !find_change(&l, seen->depth, &by_program)) return 0;

    int count = 0;
    for (int end = 0; end < 2; end++) {
        double overlap = depth_below(&l, l.range[end]), depth = overlap + by_program.deeper;
        if (!(depth > 0 || (overlap > 0 && seen->depth <= 0))) continue;
        pinch_detected_point *p = &ends[count++];
        *p = *seen;
        p->depth = depth;
        for (int i = 0; i < 3; i++) { /* half way through the overlap, below the line's end */
            double on_line = dGeomGetPosition(capsule)[i] + l.range[end] * l.along[i];
            p->position[i] = on_line - (l.radius - 0.5 * overlap + by_program.lower) * l.out[i];
            p->normal[i] = capsule_first ? l.out[i] : -l.out[i];
        }
    }
    return count;
}

int pinch_add_capsule_end(const dGeomID geom[2], const int class[2], pinch_detected_point *detected, int count)
{
    bool capsule_first = class[0] == dCapsuleClass && class[1] == dBoxClass;
    if (!capsule_first && !(class[0] == dBoxClass && class[1] == dCapsuleClass)) return count;
    if (count != 1) return count;

    pinch_detected_point ends[2];
    if (line_ends(geom[!capsule_first], geom[capsule_first], capsule_first, detected, ends) < 2) return count;
    memcpy(detected, ends, sizeof ends);
    return 2;
}
