/*
 * Joints with a prismatic axis and others beside it: PR, PU and piston.
 *
 * A PR or piston that is attached as (0, body) to the static world has the arm from the body to its anchor the wrong
 * way round in ODE, in rows and errors alike. With d the arm and o the anchor in the body's axes, ODE corrects by
 * k (-d - o), where the body's motion x' changes d by -x': the error grows by the factor 1 + ERP in every step, from
 * rounding where the anchor is at the body's centre, and from twice the arm elsewhere. Here the arm is the right way
 * round wherever Pinch solves the joint. Where all joints are left to ODE, the rows are those that ODE solves.
 */
#include "joints/row_builder.h"

#include "support/vec3.h"

/* The bodies' anchors as ODE's rows have them. */
typedef struct prismatic_anchors {
    double arm[2][3]; /* from the bodies' centres */
    double error[3];  /* that is to be taken back, along directions across the axis */
} prismatic_anchors;

/* anchor1: of the first body, in the world; anchor2: of the second. Both arms reach to the latter. */
static prismatic_anchors anchors_of(const pinch_row_builder *b, const double *anchor1, const double *anchor2)
{
    prismatic_anchors a = {{{0, 0, 0}, {0, 0, 0}}, {0, 0, 0}};
    const double *x1 = dBodyGetPosition(b->body[0]);
    double own[3];
    pinch_v3_sub(anchor2, x1, a.arm[0]);
    if (b->body[1])
        pinch_v3_sub(anchor2, dBodyGetPosition(b->body[1]), a.arm[1]);
    else if (b->reversed && b->as_ode)
        pinch_v3_scale(a.arm[0], -1);
    pinch_v3_sub(anchor1, x1, own);
    pinch_v3_sub(a.arm[0], own, a.error);
    return a;
}

/* direction2: what ODE takes for the lever of the second body */
static void sideways_row(pinch_row_builder *b, const prismatic_anchors *a, const double *direction,
                         const double *direction2)
{
    pinch_joint_row *row = pinch_new_row(b, pinch_closing_speed(b, b->erp, pinch_v3_dot(direction, a->error)));
    pinch_v3_copy(row->j1, direction);
    pinch_v3_cross(a->arm[0], direction, row->j1 + 3);
    if (!b->body[1]) return;
    for (int i = 0; i < 3; i++) row->j2[i] = -direction[i];
    pinch_v3_cross(direction2, a->arm[1], row->j2 + 3);
}

static bool has_stop(const pinch_limit_motor *m)
{
    return m->low_stop > -dInfinity || m->high_stop < dInfinity;
}

/* The motor along the axis; that of a joint attached as (0, body) to the world drives the other way. */
static void prismatic_motor(pinch_row_builder *b, pinch_limit_motor *m, const double *axis, double position)
{
    double along[3];
    pinch_v3_copy(along, axis);
    if (b->reversed) pinch_v3_scale(along, -1);
    m->linear = true;
    m->limited = has_stop(m);
    m->position = position;
    pinch_limit_motor_row(b, m, along);
}

void pinch_prismatic_rotoide_rows(pinch_row_builder *b)
{
    dVector3 anchor2, slide, axis;
    double anchor1[3], across[3], axis2[3];
    dJointGetPRAnchor(b->joint, anchor2);
    dJointGetPRAxis1(b->joint, slide);
    dJointGetPRAxis2(b->joint, axis);
    bool offset = pinch_builder_knows(b, PINCH_KNOWS_OFFSET);
    if (offset) pinch_place_of(b->body[0], b->pose->offset, anchor1);
    prismatic_anchors a = anchors_of(b, offset ? anchor1 : anchor2, anchor2);
    pinch_v3_cross(axis, slide, across);
    (void)pinch_second_axis(b, axis, axis2);
    b->rows->exact = pinch_axis_rows(b, b->erp, axis, slide, across) && offset;
    sideways_row(b, &a, axis, axis2);
    sideways_row(b, &a, across, across);
    pinch_limit_motor p = pinch_read_motor(b->joint, dJointGetPRParam, 0);
    pinch_limit_motor r = pinch_read_motor(b->joint, dJointGetPRParam, dParamGroup2);
    prismatic_motor(b, &p, slide, dJointGetPRPosition(b->joint));
    r.limited = pinch_stops_angle(&r);
    r.position = b->reversed ? -dJointGetPRAngle(b->joint) : dJointGetPRAngle(b->joint);
    pinch_limit_motor_row(b, &r, axis);
}

void pinch_piston_rows(pinch_row_builder *b)
{
    dVector3 anchor_a, anchor_b, axis;
    double p[3], q[3];
    dJointGetPistonAnchor(b->joint, anchor_a);
    dJointGetPistonAnchor2(b->joint, anchor_b);
    dJointGetPistonAxis(b->joint, axis);
    prismatic_anchors a = anchors_of(b, b->reversed ? anchor_b : anchor_a, b->reversed ? anchor_a : anchor_b);
    pinch_plane_of(axis, p, q);
    b->rows->exact = pinch_axis_rows(b, b->erp, axis, p, q);
    sideways_row(b, &a, p, p);
    sideways_row(b, &a, q, q);
    pinch_limit_motor along = pinch_read_motor(b->joint, dJointGetPistonParam, 0);
    pinch_limit_motor about = pinch_read_motor(b->joint, dJointGetPistonParam, dParamGroup2);
    prismatic_motor(b, &along, axis, dJointGetPistonPosition(b->joint));
    about.limited = has_stop(&about);
    about.position = b->reversed ? -dJointGetPistonAngle(b->joint) : dJointGetPistonAngle(b->joint);
    pinch_limit_motor_row(b, &about, axis);
}

/* ODE takes the prismatic axis of a joint that is attached as (0, body) as fixed in the second body, the world, though
 * its coordinates are those of the first. */
static void prismatic_axis(const pinch_row_builder *b, double axis[3])
{
    dVector3 shown;
    dJointGetPUAxisP(b->joint, shown);
    if (b->reversed)
        pinch_turn_back(b->body[0], shown, axis);
    else
        pinch_v3_copy(axis, shown);
}

void pinch_prismatic_universal_rows(pinch_row_builder *b)
{
    dVector3 anchor2, axis1, axis2;
    double anchor1[3], slide[3], normal[3], p[3], q[3], error[3];
    dJointGetPUAnchor(b->joint, anchor2);
    dJointGetPUAxis1(b->joint, b->reversed ? axis2 : axis1);
    dJointGetPUAxis2(b->joint, b->reversed ? axis1 : axis2);
    prismatic_axis(b, slide);
    bool offset = b->rows->exact = pinch_builder_knows(b, PINCH_KNOWS_OFFSET);
    pinch_v3_copy(anchor1, anchor2);
    if (offset) pinch_place_of(b->body[0], b->pose->offset, anchor1);
    pinch_v3_cross(axis1, axis2, normal);
    double sine = pinch_v3_norm(normal);
    if (sine > 0) {
        pinch_v3_scale(normal, 1 / sine);
        (void)pinch_angular_row(b, normal, pinch_closing_spin(b, b->erp, -pinch_v3_dot(axis1, axis2)));
    }
    pinch_plane_of(slide, p, q);
    pinch_v3_sub(anchor2, anchor1, error);
    (void)pinch_linear_row(b, p, anchor1, anchor2, pinch_closing_speed(b, b->erp, pinch_v3_dot(p, error)));
    (void)pinch_linear_row(b, q, anchor1, anchor2, pinch_closing_speed(b, b->erp, pinch_v3_dot(q, error)));

    pinch_limit_motor m1 = pinch_read_motor(b->joint, dJointGetPUParam, dParamGroup1);
    pinch_limit_motor m2 = pinch_read_motor(b->joint, dJointGetPUParam, dParamGroup2);
    pinch_limit_motor m3 = pinch_read_motor(b->joint, dJointGetPUParam, dParamGroup3);
    double angle1 = dJointGetPUAngle1(b->joint), angle2 = dJointGetPUAngle2(b->joint);
    m1.limited = pinch_stops_angle(&m1);
    m2.limited = pinch_stops_angle(&m2);
    m1.position = b->reversed ? angle2 : angle1;
    m2.position = b->reversed ? angle1 : angle2;
    pinch_limit_motor_row(b, &m1, axis1);
    pinch_limit_motor_row(b, &m2, axis2);
    m3.point[0] = anchor1;
    m3.point[1] = anchor2;
    prismatic_motor(b, &m3, slide, dJointGetPUPosition(b->joint));
}
