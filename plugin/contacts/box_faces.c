/*
 * Where faces of two boxes lie on each other, as in stacks and rows, rounding decides two things in ODE's collider.
 *
 * Whose normal it returns: they differ by as much as the bodies are tilted against each other, and with the normal
 * turns the force. The direction half way between the two does not depend on that choice.
 *
 * Whether and where edges cross that lie along each other: the place may be anywhere along them, and is another one in
 * the next step. Each point carries a part of the load, which would wander with it. What rests on such a point rests on
 * the corners.
 */
#include "contacts/collider_points.h"

#include "support/vec3.h"

#include <math.h>

/* A normal within 0.14 rad of an axis of the box means a face. */
static const double OF_FACE = 0.99;
/* The sine of the angle up to which two faces lie on each other. */
static const double ON_EACH_OTHER = 1e-3;
/* A place nearer to an edge than this part of the box's width lies on it. */
static const double ON_EDGE = 1e-5;
/* The sine of the angle at which edges that cross do so in a place that is their own. */
static const double CROSSING = 1.5e-3;

typedef struct box {
    const double *centre;
    double axis[3][3], half[3];
    int face; /* the axis of the face that the normal belongs to; -1: none */
} box;

static box read_box(dGeomID geom, const pinch_pose *pose, const double *normal)
{
    box b = {.centre = pose->position, .face = -1};
    dVector3 sides;
    dGeomBoxGetLengths(geom, sides);
    for (int i = 0; i < 3; i++) {
        b.half[i] = 0.5 * sides[i];
        for (int k = 0; k < 3; k++) b.axis[i][k] = pose->rotation[4 * k + i];
        if (fabs(pinch_v3_dot(b.axis[i], normal)) > OF_FACE) b.face = i;
    }
    return b;
}

/* Returns the axis along which an edge of the face runs that the point lies on; -1: none, or it is a corner. */
static int edge_at(const box *b, const double *point)
{
    double from[3];
    int edge = -1;
    pinch_v3_sub(point, b->centre, from);
    for (int side = 1; side < 3; side++) {
        int i = (b->face + side) % 3, other = (b->face + 3 - side) % 3;
        if (fabs(fabs(pinch_v3_dot(b->axis[i], from)) - b->half[i]) > ON_EDGE * b->half[i]) continue;
        if (edge >= 0) return -1;
        edge = other;
    }
    return edge;
}

static bool run_along(const double *edge, const double *other)
{
    double sine[3];
    pinch_v3_cross(edge, other, sine);
    return pinch_v3_dot(sine, sine) < CROSSING * CROSSING;
}

/* Is the point, of the faces that lie on each other, one where edges cross that run along each other? */
static bool is_crossing(const box *a, const box *b, const pinch_detected_point *p)
{
    if (fabs(pinch_v3_dot(p->normal, a->axis[a->face])) < OF_FACE) return false;
    int first = edge_at(a, p->position), second = first < 0 ? -1 : edge_at(b, p->position);
    return second >= 0 && run_along(a->axis[first], b->axis[second]);
}

/* Gives all points the normal half way between those of the two faces, where these lie on each other, and those of the
 * points do not differ by more from it. One that does is a program's own. */
static void share_normal(const box *a, const box *b, pinch_detected_point *detected, int count)
{
    const box *of[2] = {a, b};
    double sine[3], between[3] = {0, 0, 0};
    pinch_v3_cross(a->axis[a->face], b->axis[b->face], sine);
    if (pinch_v3_dot(sine, sine) > ON_EACH_OTHER * ON_EACH_OTHER) return;
    for (int side = 0; side < 2; side++) {
        const double *axis = of[side]->axis[of[side]->face];
        pinch_v3_add_scaled(between, pinch_v3_dot(axis, detected->normal) > 0 ? 1 : -1, axis);
    }
    pinch_v3_scale(between, 1 / pinch_v3_norm(between));
    for (int k = 0; k < count; k++) {
        double *normal = detected[k].normal;
        pinch_v3_cross(normal, between, sine);
        if (pinch_v3_dot(normal, between) > 0 && pinch_v3_dot(sine, sine) <= ON_EACH_OTHER * ON_EACH_OTHER)
            pinch_v3_copy(normal, between);
    }
}

int pinch_settle_box_faces(const dGeomID geom[2], const int class[2], const pinch_pose pose[2],
                           pinch_detected_point *detected, int count)
{
    enum { FEWEST = 3 }; /* two are the ends of a line */
    int kept = 0;
    if (class[0] != dBoxClass || class[1] != dBoxClass) return count;
    const box a = read_box(geom[0], &pose[0], detected->normal), b = read_box(geom[1], &pose[1], detected->normal);
    if (a.face < 0 || b.face < 0) return count;
    share_normal(&a, &b, detected, count);
    if (count < FEWEST) return count;
    for (int k = 0; k < count; k++)
        if (!is_crossing(&a, &b, &detected[k])) detected[kept++] = detected[k];
    return kept > 0 ? kept : count;
}
