#include "joints/joint_rows.h"

#include "joints/row_builder.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* Compliance below this part of what the step itself gives a row (h J M^-1 J^T) is treated as none: that of the world,
 * which all joints get, and one that somebody has given to a motor, a stop or a suspension. The latter is a spring or a
 * dashpot. It may be soft for the mechanism behind a light body, and next to nothing for that body. */
static const double HARD_COMPLIANCE = 1e-3, HARD_OWN_COMPLIANCE = 1e-6;

/* ---- the types of joints ---- */

static void ball_rows(pinch_row_builder *b)
{
    dVector3 anchor1, anchor2;
    dJointGetBallAnchor(b->joint, anchor1);
    dJointGetBallAnchor2(b->joint, anchor2);
    pinch_anchor_rows(b, dJointGetBallParam(b->joint, dParamERP), anchor1, anchor2);
    for (int i = 0; i < 3; i++) b->rows->row[i].cfm = dJointGetBallParam(b->joint, dParamCFM);
    b->rows->exact = true;
}

static void hinge_rows(pinch_row_builder *b)
{
    pinch_axis_reading *reading = b->rows->reading;
    const double *axis = reading->axis;
    dVector3 anchor1, anchor2;
    double p[3], q[3];
    dJointGetHingeAnchor(b->joint, anchor1);
    dJointGetHingeAnchor2(b->joint, anchor2);
    b->own_axis = reading->own;
    pinch_anchor_rows(b, b->erp, anchor1, anchor2);
    pinch_plane_of(axis, p, q);
    b->rows->exact = pinch_axis_rows(b, b->erp, axis, p, q);
    pinch_limit_motor m = pinch_read_motor(b->joint, dJointGetHingeParam, 0);
    reading->placed = m.limited = pinch_stops_angle(&m);
    if (m.limited) {
        reading->position = dJointGetHingeAngle(b->joint);
        m.position = b->reversed ? -reading->position : reading->position;
    }
    pinch_limit_motor_row(b, &m, axis);
}

static void universal_rows(pinch_row_builder *b)
{
    dVector3 anchor1, anchor2, axis1, axis2;
    double normal[3];
    dJointGetUniversalAnchor(b->joint, anchor1);
    dJointGetUniversalAnchor2(b->joint, anchor2);
    dJointGetUniversalAxis1(b->joint, b->reversed ? axis2 : axis1);
    dJointGetUniversalAxis2(b->joint, b->reversed ? axis1 : axis2);
    pinch_anchor_rows(b, b->erp, anchor1, anchor2);
    b->rows->exact = true;
    pinch_v3_cross(axis1, axis2, normal);
    double sine = pinch_v3_norm(normal);
    if (sine > 0) {
        pinch_v3_scale(normal, 1 / sine);
        (void)pinch_angular_row(b, normal, pinch_closing_spin(b, b->erp, -pinch_v3_dot(axis1, axis2)));
    }
    pinch_limit_motor m1 = pinch_read_motor(b->joint, dJointGetUniversalParam, 0);
    pinch_limit_motor m2 = pinch_read_motor(b->joint, dJointGetUniversalParam, dParamGroup2);
    double angle1 = dJointGetUniversalAngle1(b->joint), angle2 = dJointGetUniversalAngle2(b->joint);
    m1.limited = pinch_stops_angle(&m1);
    m2.limited = pinch_stops_angle(&m2);
    m1.position = b->reversed ? -angle2 : angle1;
    m2.position = b->reversed ? angle1 : angle2; /* the getters turn one sign of two */
    pinch_limit_motor_row(b, &m1, axis1);
    pinch_limit_motor_row(b, &m2, axis2);
}

/*
 * The suspension is the position row along the first axis, with parameters of its own. The angle between the axes is
 * kept: about their common normal the bodies turn so as to take the part ERP of theta - theta0 away in a step, for
 * which ODE has its sine, sin(theta - theta0) = cos(theta0) sin(theta) - sin(theta0) cos(theta). A turn of the first
 * body about the normal takes its axis towards the second's.
 */
static void hinge2_rows(pinch_row_builder *b)
{
    dVector3 anchor1, anchor2, axis1, axis2;
    double normal[3], p[3], q[3];
    dJointGetHinge2Anchor(b->joint, anchor1);
    dJointGetHinge2Anchor2(b->joint, anchor2);
    double sine = pinch_hinge2_axes(b->joint, axis1, axis2, normal);
    pinch_plane_of(axis1, p, q);
    const double *const across[2] = {p, q};
    double apart[3], rate = dJointGetHinge2Param(b->joint, dParamSuspensionERP) / b->h;
    pinch_v3_sub(anchor2, anchor1, apart);
    pinch_linear_row(b, axis1, anchor1, anchor2, rate * pinch_v3_dot(axis1, apart))->cfm =
        dJointGetHinge2Param(b->joint, dParamSuspensionCFM);
    for (int i = 0; i < 2; i++) {
        double speed = pinch_closing_speed(b, b->erp, pinch_v3_dot(across[i], apart));
        (void)pinch_linear_row(b, across[i], anchor1, anchor2, speed);
    }
    if (sine > 0) {
        double cosine = pinch_v3_dot(axis1, axis2);
        double turned = pinch_builder_knows(b, PINCH_KNOWS_TURN) ? b->pose->cosine * sine - b->pose->sine * cosine : 0;
        pinch_v3_scale(normal, 1 / sine);
        (void)pinch_angular_row(b, normal, pinch_closing_spin(b, b->erp, turned));
        b->rows->exact = pinch_builder_knows(b, PINCH_KNOWS_TURN);
    }
    pinch_limit_motor m1 = pinch_read_motor(b->joint, dJointGetHinge2Param, 0);
    pinch_limit_motor m2 = pinch_read_motor(b->joint, dJointGetHinge2Param, dParamGroup2);
    m1.limited = pinch_stops_angle(&m1);
    m1.position = dJointGetHinge2Angle1(b->joint);
    pinch_limit_motor_row(b, &m1, axis1);
    pinch_limit_motor_row(b, &m2, axis2);
}

/* Computes the rotation that takes the second body (the world) back to where the joint wants it, as seen from the first
 * body: twice the vector part of q1^-1 q2 turn^-1, in world coordinates. */
static void turn_error(const pinch_row_builder *b, double error[3])
{
    static const dQuaternion world = {1, 0, 0, 0};
    dQuaternion now, off;
    dVector3 turned;
    memset(error, 0, 3 * sizeof *error);
    if (!pinch_builder_knows(b, PINCH_KNOWS_TURN)) return;
    dQMultiply1(now, dBodyGetQuaternion(b->body[0]), b->body[1] ? dBodyGetQuaternion(b->body[1]) : world);
    dQMultiply2(off, now, b->pose->turn);
    double scale = off[0] < 0 ? -2 : 2;
    dBodyVectorToWorld(b->body[0], off[1], off[2], off[3], turned);
    for (int i = 0; i < 3; i++) error[i] = scale * turned[i];
}

static void same_turn_rows(pinch_row_builder *b)
{
    double error[3];
    turn_error(b, error);
    for (int i = 0; i < 3; i++) (void)pinch_angular_row(b, pinch_unit_axis[i], pinch_closing_spin(b, b->erp, error[i]));
}

/* Computes the way from where a slider's first body is to where the offset wants it. */
static void slider_error(const pinch_row_builder *b, double error[3])
{
    dVector3 offset;
    memset(error, 0, 3 * sizeof *error);
    if (!pinch_builder_knows(b, PINCH_KNOWS_OFFSET)) return;
    pinch_v3_copy(offset, b->pose->offset);
    if (b->body[1]) {
        dBodyVectorToWorld(b->body[1], b->pose->offset[0], b->pose->offset[1], b->pose->offset[2], offset);
        pinch_v3_add_scaled(offset, 1, dBodyGetPosition(b->body[1]));
    }
    pinch_v3_sub(offset, dBodyGetPosition(b->body[0]), error);
}

static void slider_rows(pinch_row_builder *b)
{
    pinch_axis_reading *reading = b->rows->reading;
    double *axis = reading->axis, middle[3], error[3];
    dVector3 p, q, along;
    dJointGetSliderAxis(b->joint, axis);
    same_turn_rows(b);
    pinch_plane_of(axis, p, q);
    const double *x1 = dBodyGetPosition(b->body[0]), *x2 = b->body[1] ? dBodyGetPosition(b->body[1]) : x1;
    for (int i = 0; i < 3; i++) middle[i] = 0.5 * (x1[i] + x2[i]);
    slider_error(b, error);
    (void)pinch_linear_row(b, p, middle, middle, pinch_closing_speed(b, b->erp, pinch_v3_dot(p, error)));
    (void)pinch_linear_row(b, q, middle, middle, pinch_closing_speed(b, b->erp, pinch_v3_dot(q, error)));
    b->rows->exact = pinch_builder_knows(b, PINCH_KNOWS_TURN | PINCH_KNOWS_OFFSET);
    pinch_limit_motor m = pinch_read_motor(b->joint, dJointGetSliderParam, 0);
    m.linear = m.limited = true;
    m.position = reading->position = dJointGetSliderPosition(b->joint);
    reading->known = reading->slides = reading->placed = true;
    reading->reversed = b->reversed;
    pinch_v3_copy(along, axis);
    if (b->reversed) pinch_v3_scale(along, -1);
    pinch_limit_motor_row(b, &m, along);
}

/* The first body carries the place where the second's centre has to be. */
static void fixed_rows(pinch_row_builder *b)
{
    const double *x1 = dBodyGetPosition(b->body[0]), *x2 = b->body[1] ? dBodyGetPosition(b->body[1]) : x1;
    double erp = dJointGetFixedParam(b->joint, dParamERP), place[3];
    pinch_v3_copy(place, x2);
    bool known = pinch_builder_knows(b, PINCH_KNOWS_OFFSET);
    if (known && b->body[1]) {
        dVector3 offset;
        dBodyVectorToWorld(b->body[0], b->pose->offset[0], b->pose->offset[1], b->pose->offset[2], offset);
        pinch_v3_sub(x1, offset, place);
    }
    const double *wanted = known && !b->body[1] ? b->pose->offset : x2, *is = b->body[1] ? place : x1;
    for (int i = 0; i < 3; i++) {
        double speed = pinch_closing_speed(b, erp, wanted[i] - is[i]);
        (void)pinch_linear_row(b, pinch_unit_axis[i], b->body[1] ? place : x1, x2, speed);
    }
    for (int i = 0; i < 3; i++) b->rows->row[i].cfm = dJointGetFixedParam(b->joint, dParamCFM);
    same_turn_rows(b);
    b->rows->exact = pinch_builder_knows(b, PINCH_KNOWS_TURN | PINCH_KNOWS_OFFSET);
}

typedef void (*row_filler)(pinch_row_builder *b);

/* Returns NULL for a type that has no rows here. */
static row_filler filler_of(dJointID joint)
{
    switch (dJointGetType(joint)) {
    case dJointTypeBall:
        return ball_rows;
    case dJointTypeHinge:
        return hinge_rows;
    case dJointTypeSlider:
        return slider_rows;
    case dJointTypeUniversal:
        return universal_rows;
    case dJointTypeHinge2:
        return hinge2_rows;
    case dJointTypeFixed:
        return fixed_rows;
    case dJointTypePR:
        return pinch_prismatic_rotoide_rows;
    case dJointTypePU:
        return pinch_prismatic_universal_rows;
    case dJointTypePiston:
        return pinch_piston_rows;
    case dJointTypeDBall:
        return pinch_double_ball_rows;
    case dJointTypeDHinge:
        return pinch_double_hinge_rows;
    case dJointTypeTransmission:
        return pinch_transmission_rows;
    case dJointTypePlane2D:
        return pinch_plane_rows;
    case dJointTypeAMotor:
        return pinch_angular_motor_rows;
    case dJointTypeLMotor:
        return pinch_linear_motor_rows;
    default:
        return NULL;
    }
}

/* How easily a body moves: 1/kg, and 1/(kg m^2) as the mean over its axes; 0 for a body that forces do not move. */
typedef struct body_mobility {
    double linear, angular;
} body_mobility;

static body_mobility mobility_of(dBodyID body)
{
    dMass mass;
    if (dBodyIsKinematic(body)) return (body_mobility){0, 0};
    dBodyGetMass(body, &mass);
    return (body_mobility){1 / mass.mass, 3 / (mass.I[0] + mass.I[5] + mass.I[10])};
}

/* Returns how far a unit force along a row moves one of its bodies. */
static double moves(body_mobility of, const double j[6])
{
    return of.linear * pinch_v3_dot(j, j) + of.angular * pinch_v3_dot(j + 3, j + 3);
}

/* Sets compliances to zero that hardly count beside trace(J M^-1 J^T), what a unit force along the row moves. */
static void harden(const pinch_row_builder *b)
{
    body_mobility first = mobility_of(b->body[0]);
    pinch_joint_row *end = b->rows->row + b->rows->count;
    for (pinch_joint_row *row = b->rows->row; row < end; row++) {
        if (row->cfm == 0) continue;
        double trace = moves(first, row->j1),
               little = b->h * (row->cfm == b->cfm ? HARD_COMPLIANCE : HARD_OWN_COMPLIANCE);
        bool hard = row->cfm <= little * trace;
        if (!hard && b->body[1]) /* few rows need to know it of their second body */
            hard = row->cfm <= little * (trace + moves(mobility_of(b->body[1]), row->j2));
        if (!hard) continue;
        row->yield = row->cfm;
        row->cfm = 0;
    }
}

bool pinch_modelled_joint_bodies(dJointID joint, dBodyID body[2])
{
    return filler_of(joint) && pinch_joint_bodies(joint, body);
}

void pinch_joint_rows_of(const pinch_step_context *context, dJointID joint, const dBodyID body[2], const double *axis2,
                         pinch_joint_pose *pose, pinch_joint_rows *rows)
{
    pinch_row_builder b = {.joint = joint,
                           .body = {body[0], body[1]},
                           .reversed = pinch_joint_reversed(joint, body),
                           .as_ode = context->settings.joints_by_ode || context->settings.ode_solves,
                           .h = context->h,
                           .noise = context->noise,
                           .step = context->number,
                           .erp = dWorldGetERP(context->world),
                           .cfm = dWorldGetCFM(context->world),
                           .axis2 = axis2,
                           .pose = pose,
                           .rows = rows};
    rows->count = 0;
    rows->exact = false;
    rows->applies = false;
    rows->driven = 0;
    rows->error = rows->error_angle = 0;
    filler_of(joint)(&b);
    harden(&b);
}
