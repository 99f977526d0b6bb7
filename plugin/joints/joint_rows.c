#include "joints/joint_rows.h"

#include "joints/joint_motors.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* Compliance below this part of what the step itself gives a row (h J M^-1 J^T) is treated as none. */
static const double HARD_COMPLIANCE = 1e-3;

static const double UNIT[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/* Three position rows; ODE's getters name the anchors by the order the joint was attached in, the error by the bodies.
 */
static void anchor_rows(pinch_row_builder *b, double erp, const double *anchor_a, const double *anchor_b)
{
    const double *anchor1 = b->reversed ? anchor_b : anchor_a, *anchor2 = b->reversed ? anchor_a : anchor_b;
    for (int i = 0; i < 3; i++) pinch_linear_row(b, UNIT[i], anchor1, anchor2, erp / b->h * (anchor2[i] - anchor1[i]));
}

static void ball_rows(pinch_row_builder *b)
{
    dVector3 anchor1, anchor2;
    dJointGetBallAnchor(b->joint, anchor1);
    dJointGetBallAnchor2(b->joint, anchor2);
    anchor_rows(b, dJointGetBallParam(b->joint, dParamERP), anchor1, anchor2);
    for (int i = 0; i < 3; i++) b->rows->row[i].cfm = dJointGetBallParam(b->joint, dParamCFM);
    b->rows->exact = true;
}

static void hinge_rows(pinch_row_builder *b)
{
    dVector3 anchor1, anchor2, axis, p, q;
    dJointGetHingeAnchor(b->joint, anchor1);
    dJointGetHingeAnchor2(b->joint, anchor2);
    dJointGetHingeAxis(b->joint, axis);
    anchor_rows(b, b->erp, anchor1, anchor2);
    pinch_plane_of(axis, p, q);
    double error[3] = {0, 0, 0};
    if (b->axis2) { /* the rotation that takes the first body's axis to the second's */
        double other[3];
        pinch_v3_copy(other, b->axis2);
        for (int i = 0; i < 3 && b->body[1]; i++)
            other[i] = pinch_v3_dot(dBodyGetRotation(b->body[1]) + 4 * i, b->axis2);
        pinch_v3_cross(axis, other, error);
        b->rows->exact = true;
    }
    pinch_angular_row(b, p, b->erp / b->h * pinch_v3_dot(error, p));
    pinch_angular_row(b, q, b->erp / b->h * pinch_v3_dot(error, q));
    pinch_limit_motor m = pinch_read_motor(b->joint, dJointGetHingeParam, 0);
    bool limited = m.low_stop >= -M_PI || m.high_stop <= M_PI;
    double angle = limited ? dJointGetHingeAngle(b->joint) : 0;
    pinch_limit_motor_row(b, &m, axis, true, limited, b->reversed ? -angle : angle);
}

static void universal_rows(pinch_row_builder *b)
{
    dVector3 anchor1, anchor2, axis1, axis2;
    double normal[3];
    dJointGetUniversalAnchor(b->joint, anchor1);
    dJointGetUniversalAnchor2(b->joint, anchor2);
    dJointGetUniversalAxis1(b->joint, b->reversed ? axis2 : axis1);
    dJointGetUniversalAxis2(b->joint, b->reversed ? axis1 : axis2);
    anchor_rows(b, b->erp, anchor1, anchor2);
    b->rows->exact = true;
    pinch_v3_cross(axis1, axis2, normal);
    double sine = pinch_v3_norm(normal);
    if (sine > 0) {
        pinch_v3_scale(normal, 1 / sine);
        pinch_angular_row(b, normal, -b->erp / b->h * pinch_v3_dot(axis1, axis2));
    }
    pinch_limit_motor m1 = pinch_read_motor(b->joint, dJointGetUniversalParam, 0);
    pinch_limit_motor m2 = pinch_read_motor(b->joint, dJointGetUniversalParam, dParamGroup2);
    double angle1 = dJointGetUniversalAngle1(b->joint), angle2 = dJointGetUniversalAngle2(b->joint);
    pinch_limit_motor_row(b, &m1, axis1, true, m1.low_stop >= -M_PI || m1.high_stop <= M_PI,
                          b->reversed ? -angle2 : angle1);
    pinch_limit_motor_row(b, &m2, axis2, true, m2.low_stop >= -M_PI || m2.high_stop <= M_PI,
                          b->reversed ? -angle1 : angle2);
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
    const double *direction[3] = {axis1, p, q};
    double erp[3] = {dJointGetHinge2Param(b->joint, dParamSuspensionERP), b->erp, b->erp}, error[3];
    pinch_v3_sub(anchor2, anchor1, error);
    for (int i = 0; i < 3; i++)
        pinch_linear_row(b, direction[i], anchor1, anchor2, erp[i] / b->h * pinch_v3_dot(direction[i], error));
    b->rows->row[b->rows->count - 3].cfm = dJointGetHinge2Param(b->joint, dParamSuspensionCFM);
    if (sine > 0) {
        double cosine = pinch_v3_dot(axis1, axis2);
        double apart = b->pose ? b->pose->cosine * sine - b->pose->sine * cosine : 0;
        pinch_v3_scale(normal, 1 / sine);
        pinch_angular_row(b, normal, b->erp / b->h * apart);
        b->rows->exact = b->pose != NULL;
    }
    pinch_limit_motor m1 = pinch_read_motor(b->joint, dJointGetHinge2Param, 0);
    pinch_limit_motor m2 = pinch_read_motor(b->joint, dJointGetHinge2Param, dParamGroup2);
    pinch_limit_motor_row(b, &m1, axis1, true, m1.low_stop >= -M_PI || m1.high_stop <= M_PI,
                          dJointGetHinge2Angle1(b->joint));
    pinch_limit_motor_row(b, &m2, axis2, true, false, 0);
}

/* ODE has setters for this joint's motors and no getters: they stay unknown here. */
static void plane_rows(pinch_row_builder *b)
{
    const double *x = dBodyGetPosition(b->body[0]);
    pinch_linear_row(b, UNIT[2], x, x, -b->erp / b->h * x[2]);
    pinch_angular_row(b, UNIT[0], 0);
    pinch_angular_row(b, UNIT[1], 0);
}

static void angular_motor_rows(pinch_row_builder *b)
{
    int axes = dJointGetAMotorNumAxes(b->joint);
    bool euler = dJointGetAMotorMode(b->joint) == dAMotorEuler;
    dVector3 axis[3];
    for (int i = 0; i < axes; i++) dJointGetAMotorAxis(b->joint, i, axis[i]);
    if (euler) { /* what is held are the perpendiculars of the outer axes to the middle one */
        double first[3], last[3];
        pinch_v3_cross(axis[1], axis[2], first);
        pinch_v3_cross(axis[0], axis[1], last);
        pinch_v3_copy(axis[0], first);
        pinch_v3_copy(axis[2], last);
    }
    for (int i = 0; i < axes; i++) {
        pinch_limit_motor m = pinch_read_motor(b->joint, dJointGetAMotorParam, i * dParamGroup2);
        pinch_limit_motor_row(b, &m, axis[i], true, true, dJointGetAMotorAngle(b->joint, i));
    }
    b->rows->exact = !euler; /* ODE measures Euler angles only as it steps the joint */
}

static void linear_motor_rows(pinch_row_builder *b)
{
    int axes = dJointGetLMotorNumAxes(b->joint);
    for (int i = 0; i < axes; i++) {
        dVector3 axis;
        dJointGetLMotorAxis(b->joint, i, axis);
        pinch_limit_motor m = pinch_read_motor(b->joint, dJointGetLMotorParam, i * dParamGroup2);
        pinch_limit_motor_row(b, &m, axis, false, false, 0);
    }
}

typedef void (*row_filler)(pinch_row_builder *b);

/* NULL: no rows here. */
static row_filler filler_of(dJointID joint)
{
    switch (dJointGetType(joint)) {
    case dJointTypeBall:
        return ball_rows;
    case dJointTypeHinge:
        return hinge_rows;
    case dJointTypeSlider:
        return pinch_slider_rows;
    case dJointTypeUniversal:
        return universal_rows;
    case dJointTypeHinge2:
        return hinge2_rows;
    case dJointTypeFixed:
        return pinch_fixed_rows;
    case dJointTypePlane2D:
        return plane_rows;
    case dJointTypeAMotor:
        return angular_motor_rows;
    case dJointTypeLMotor:
        return linear_motor_rows;
    default:
        return NULL;
    }
}

/* How easily each body of the joint moves: 1/kg, and 1/(kg m^2) as the mean over its axes; 0: not by forces. */
static void body_mobilities(const pinch_row_builder *b, double linear[2], double angular[2])
{
    for (int side = 0; side < 2; side++) {
        linear[side] = angular[side] = 0;
        if (!b->body[side] || dBodyIsKinematic(b->body[side])) continue;
        dMass mass;
        dBodyGetMass(b->body[side], &mass);
        linear[side] = 1 / mass.mass;
        angular[side] = 3 / (mass.I[0] + mass.I[5] + mass.I[10]);
    }
}

/* Compliances that hardly count beside trace(J M^-1 J^T), what a unit force along the row moves, are none. */
static void harden(const pinch_row_builder *b)
{
    double linear[2], angular[2];
    body_mobilities(b, linear, angular);
    for (int k = 0; k < b->rows->count; k++) {
        pinch_joint_row *row = &b->rows->row[k];
        double moves = 0;
        if (row->cfm == 0) continue;
        for (int side = 0; side < 2 && b->body[side]; side++) {
            const double *j = side ? row->j2 : row->j1;
            moves += linear[side] * pinch_v3_dot(j, j) + angular[side] * pinch_v3_dot(j + 3, j + 3);
        }
        if (row->cfm <= HARD_COMPLIANCE * b->h * moves) row->cfm = 0;
    }
}

bool pinch_joint_bodies(dJointID joint, dBodyID body[2])
{
    body[0] = dJointGetBody(joint, 0);
    body[1] = dJointGetBody(joint, 1);
    if (!body[0]) {
        body[0] = body[1];
        body[1] = NULL;
    }
    return body[0] && filler_of(joint);
}

void pinch_joint_rows_of(dJointID joint, const dBodyID body[2], dWorldID world, double h, const double *axis2,
                         const pinch_joint_pose *pose, pinch_joint_rows *rows)
{
    pinch_row_builder b = {.joint = joint,
                           .h = h,
                           .erp = dWorldGetERP(world),
                           .cfm = dWorldGetCFM(world),
                           .axis2 = axis2,
                           .pose = pose,
                           .rows = rows};
    rows->count = 0;
    rows->exact = false;
    memset(rows->applied, 0, sizeof rows->applied);
    b.body[0] = body[0];
    b.body[1] = body[1];
    b.reversed = !dJointGetBody(joint, 0);
    filler_of(joint)(&b);
    harden(&b);
}
