/*
 * ODE's capsule-box collider returns one point of a capsule that lies flat on a box, at alternating ends. A contact
 * line has two ends; the second one is computed here.
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

/* Finds the ends of the capsule's line over the touched face that penetrate it, and returns how many do. */
static int line_ends(dGeomID capsule, dGeomID box, bool capsule_first, const pinch_detected_point *seen,
                     pinch_detected_point ends[2])
{
    dReal radius, length;
    dVector3 sides;
    dGeomCapsuleGetParams(capsule, &radius, &length);
    dGeomBoxGetLengths(box, sides);
    const double *R = dGeomGetRotation(box), *turn = dGeomGetRotation(capsule);
    double out[3], normal[3], from[3], centre[3], reach[3], half[3], range[2];
    for (int i = 0; i < 3; i++) out[i] = capsule_first ? seen->normal[i] : -seen->normal[i]; /* out of the box */
    to_frame(R, out, normal);
    int axis = 0;
    for (int i = 1; i < 3; i++)
        if (fabs(normal[i]) > fabs(normal[axis])) axis = i;
    if (fabs(normal[axis]) < FACE_ALIGNMENT) return 0;

    double sign = normal[axis] > 0 ? 1 : -1;
    for (int i = 0; i < 3; i++) out[i] = sign * R[4 * i + axis];
    const double along[3] = {0.5 * length * turn[2], 0.5 * length * turn[6], 0.5 * length * turn[10]};
    pinch_v3_sub(dGeomGetPosition(capsule), dGeomGetPosition(box), from);
    to_frame(R, from, centre);
    to_frame(R, along, reach);
    for (int i = 0; i < 3; i++) half[i] = 0.5 * sides[i];
    if (!clip_to_face(centre, reach, half, axis, range)) return 0;

    int count = 0;
    for (int end = 0; end < 2; end++) {
        double height = sign * (centre[axis] + range[end] * reach[axis]) - half[axis], depth = radius - height;
        if (!(depth > 0)) continue;
        pinch_detected_point *p = &ends[count++];
        *p = *seen;
        p->depth = depth;
        for (int i = 0; i < 3; i++) { /* half way through the overlap, below the line's end */
            double on_line = dGeomGetPosition(capsule)[i] + range[end] * along[i];
            p->position[i] = on_line - (radius - 0.5 * depth) * out[i];
            p->normal[i] = capsule_first ? out[i] : -out[i];
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
