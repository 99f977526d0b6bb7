/*
 * The transmission: two wheels on two bodies that mesh, as gears or over a chain.
 *
 * ODE computes where the wheels mesh from the bodies' poses in every step, and follows how far each has turned since
 * its axes or anchors were set last. Where it measures from is what Pinch notes; the angles themselves have getters,
 * which show those of the last step.
 */
#include "joints/row_builder.h"

#include "support/vec3.h"

#include <math.h>

/* The wheels in the world. */
typedef struct wheels {
    int mode;
    bool anew; /* ODE measures them anew in this step */
    dVector3 anchor[2], axis[2];
    double mesh[2][3];  /* where each wheel meshes */
    double along[2][3]; /* the direction in which it moves there */
    double radius[2];   /* of a chain's wheels */
    double angle[2];    /* rad */
} wheels;

/* ---- where the wheels mesh ---- */

static void mesh_parallel(wheels *w, double ratio)
{
    double line[3];
    pinch_v3_sub(w->anchor[1], w->anchor[0], line);
    for (int i = 0; i < 2; i++) {
        pinch_v3_copy(w->mesh[i], w->anchor[0]);
        pinch_v3_add_scaled(w->mesh[i], ratio / (1 + ratio), line);
    }
    pinch_v3_scale(line, 1 / pinch_v3_norm(line));
    for (int i = 0; i < 2; i++) pinch_v3_cross(line, w->axis[i], w->along[i]);
}

/* The wheels' planes meet in a line; each wheel meshes where its anchor is nearest to it. */
static void mesh_intersecting(wheels *w)
{
    double across = pinch_v3_dot(w->axis[0], w->axis[1]), off[2], origin[3], to[3];
    for (int i = 0; i < 2; i++) {
        off[i] = pinch_v3_dot(w->axis[i], w->anchor[i]);
        pinch_v3_cross(w->axis[0], w->axis[1], w->along[i]);
    }
    pinch_v3_set(origin, 0, 0, 0);
    pinch_v3_add_scaled(origin, (off[0] - off[1] * across) / (1 - across * across), w->axis[0]);
    pinch_v3_add_scaled(origin, (off[1] - off[0] * across) / (1 - across * across), w->axis[1]);
    for (int i = 0; i < 2; i++) {
        pinch_v3_sub(w->anchor[i], origin, to);
        pinch_v3_copy(w->mesh[i], origin);
        pinch_v3_add_scaled(w->mesh[i], pinch_v3_dot(to, w->along[i]), w->along[i]);
    }
}

/* A chain leaves its wheels at an angle to the line between them. ODE turns the radius from that line's frame with the
 * frame's directions as rows. */
static void mesh_chain(wheels *w)
{
    double line[3];
    pinch_v3_sub(w->anchor[0], w->anchor[1], line);
    double length = pinch_v3_norm(line);
    double cosine = fmin(fmax((w->radius[1] - w->radius[0]) / length, -1), 1), sine = sqrt(1 - cosine * cosine);
    pinch_v3_scale(line, 1 / length);
    for (int i = 0; i < 2; i++) {
        double side[3], r[3];
        const double radius[3] = {w->radius[i] * cosine, 0, w->radius[i] * sine};
        pinch_v3_cross(line, w->axis[i], side);
        pinch_v3_set(r, pinch_v3_dot(line, radius), pinch_v3_dot(w->axis[i], radius), pinch_v3_dot(side, radius));
        pinch_v3_copy(w->mesh[i], w->anchor[i]);
        pinch_v3_add_scaled(w->mesh[i], 1, r);
        pinch_v3_cross(r, w->axis[i], w->along[i]);
        pinch_v3_scale(w->along[i], 1 / pinch_v3_norm(w->along[i]));
    }
}

/* Where the other strand of a chain pulls, ODE reflects mesh and direction. */
static void change_strand(wheels *w)
{
    double line[3];
    pinch_v3_sub(w->anchor[0], w->anchor[1], line);
    for (int i = 0; i < 2; i++) {
        double normal[3];
        pinch_v3_cross(w->axis[i], line, normal);
        double size2 = pinch_v3_dot(normal, normal);
        pinch_v3_add_scaled(w->mesh[i], -2 * pinch_v3_dot(w->mesh[i], normal) / size2, normal);
        double part = 2 * pinch_v3_dot(w->along[i], normal) / size2;
        pinch_v3_scale(w->along[i], -1);
        pinch_v3_add_scaled(w->along[i], part, normal);
    }
}

static void find_mesh(const pinch_row_builder *b, wheels *w)
{
    dJointID j = b->joint;
    w->mode = dJointGetTransmissionMode(j);
    dJointGetTransmissionAnchor1(j, w->anchor[0]);
    dJointGetTransmissionAnchor2(j, w->anchor[1]);
    dJointGetTransmissionAxis1(j, w->axis[0]);
    dJointGetTransmissionAxis2(j, w->axis[1]);
    w->radius[0] = dJointGetTransmissionRadius1(j);
    w->radius[1] = dJointGetTransmissionRadius2(j);
    if (w->anew && pinch_v3_dot(w->axis[0], w->axis[1]) < 0) pinch_v3_scale(w->axis[0], -1);
    if (w->mode == dTransmissionParallelAxes)
        mesh_parallel(w, dJointGetTransmissionRatio(j));
    else if (w->mode == dTransmissionIntersectingAxes)
        mesh_intersecting(w);
    else
        mesh_chain(w);
}

/* ---- how far they have turned ---- */

/* Returns the angle that is `theta` up to whole turns and lies near `guess`, by ODE's rules. */
static double unwind(double theta, double guess)
{
    if (guess > M_PI / 2) {
        if (theta < 0) theta += 2 * M_PI;
        theta += floor(guess / (2 * M_PI)) * (2 * M_PI);
    } else if (guess < -M_PI / 2) {
        if (theta > 0) theta -= 2 * M_PI;
        theta += ceil(guess / (2 * M_PI)) * (2 * M_PI);
    }
    return guess - theta > M_PI ? theta + 2 * M_PI : guess - theta < -M_PI ? theta - 2 * M_PI : theta;
}

static void find_angles(const pinch_row_builder *b, wheels *w)
{
    const double last[2] = {dJointGetTransmissionAngle1(b->joint), dJointGetTransmissionAngle2(b->joint)};
    for (int i = 0; i < 2; i++) {
        double radius[3], side[3];
        const double *from = b->pose->mesh.reference[i];
        pinch_v3_sub(w->mesh[i], w->anchor[i], radius);
        pinch_turn_back(b->body[i], radius, radius);
        double axis[3];
        pinch_turn_back(b->body[i], w->axis[i], axis);
        pinch_v3_cross(axis, from, side);
        double turns = pinch_v3_dot(dBodyGetAngularVel(b->body[i]), w->axis[i]) * b->h;
        w->angle[i] =
            unwind(atan2(pinch_v3_dot(side, radius), pinch_v3_dot(from, radius)), (w->anew ? 0 : last[i]) + turns);
    }
}

/* Takes up where the wheels are measured from, as ODE does in this step. */
static void measure_anew(pinch_row_builder *b, const wheels *w)
{
    b->pose->mesh.meshed = b->step;
    for (int i = 0; i < 2; i++) {
        double *from = b->pose->mesh.reference[i];
        pinch_v3_sub(w->mesh[i], w->anchor[i], from);
        pinch_v3_scale(from, 1 / pinch_v3_norm(from));
        pinch_turn_back(b->body[i], from, from);
    }
}

static double distance(const double *a, const double *b)
{
    double d[3];
    pinch_v3_sub(a, b, d);
    return pinch_v3_norm(d);
}

void pinch_transmission_rows(pinch_row_builder *b)
{
    bool known = pinch_builder_knows(b, PINCH_KNOWS_MESH);
    wheels w = {.anew = known && (b->pose->mesh.meshed < 0 || b->pose->mesh.meshed == b->step)};
    find_mesh(b, &w);
    double late = 0, backlash = dJointGetTransmissionBacklash(b->joint);
    if (w.anew) measure_anew(b, &w);
    if (known) {
        double sign = w.mode == dTransmissionChainDrive ? -1 : 1;
        find_angles(b, &w);
        late = distance(w.mesh[0], w.anchor[0]) * w.angle[0] + sign * distance(w.mesh[1], w.anchor[1]) * w.angle[1];
    }
    b->rows->exact = known;
    if (w.mode == dTransmissionChainDrive) { /* which strand pulls hangs on rounding where the wheels are in step */
        b->rows->exact = false;
        if (late < 0) change_strand(&w);
    }
    if (backlash != 0 && !(fabs(late) > backlash)) return;
    double rate = -dJointGetTransmissionParam(b->joint, dParamERP) / b->h;
    pinch_joint_row *row = pinch_new_row(b, rate * (late > 0 ? late - backlash : late + backlash));
    row->cfm = dJointGetTransmissionParam(b->joint, dParamCFM);
    if (backlash > 0) *(late > 0 ? &row->high : &row->low) = 0;
    double arm[3], pull[3];
    pinch_v3_copy(row->j1, w.along[0]);
    pinch_v3_sub(w.mesh[0], dBodyGetPosition(b->body[0]), arm);
    pinch_v3_cross(arm, row->j1, row->j1 + 3);
    pinch_v3_copy(pull, w.along[1]);
    pinch_v3_scale(pull, -1);
    pinch_v3_copy(row->j2, pull);
    pinch_v3_sub(w.mesh[1], dBodyGetPosition(b->body[1]), arm);
    pinch_v3_cross(arm, pull, row->j2 + 3);
}
