#include "joints/joint_rows.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* Compliance below this part of what the step itself gives a row (h J M^-1 J^T) is treated as none. */
static const double HARD_COMPLIANCE = 1e-3;

static const double UNIT[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/* The rows of a joint while they are being written. */
typedef struct row_builder {
    dJointID joint;
    dBodyID body[2];
    bool reversed; /* the joint is attached as (0, body), which ODE turns round */
    double h, erp, cfm;
    const double *axis2; /* see pinch_joint_rows_of */
    const pinch_joint_pose *pose;
    pinch_joint_rows *rows;
} row_builder;

/* Adds an empty row without limits. */
static pinch_joint_row *new_row(row_builder *b, double rhs)
{
    pinch_joint_row *row = &b->rows->row[b->rows->count++];
    memset(row, 0, sizeof *row);
    row->rhs = rhs;
    row->cfm = b->cfm;
    row->low = -INFINITY;
    row->high = INFINITY;
    return row;
}

/* Adds a row that asks for the relative angular velocity rhs about the unit vector `axis`. */
static void angular_row(row_builder *b, const double *axis, double rhs)
{
    pinch_joint_row *row = new_row(b, rhs);
    pinch_v3_copy(row->j1 + 3, axis);
    for (int i = 0; i < 3; i++) row->j2[3 + i] = b->body[1] ? -axis[i] : 0;
}

/* Adds a row that asks for the relative velocity rhs along `axis` of the two bodies' material points at point1 and
 * point2. */
static void linear_row(row_builder *b, const double *axis, const double *point1, const double *point2, double rhs)
{
    pinch_joint_row *row = new_row(b, rhs);
    double arm[3];
    pinch_v3_copy(row->j1, axis);
    pinch_v3_sub(point1, dBodyGetPosition(b->body[0]), arm);
    pinch_v3_cross(arm, axis, row->j1 + 3);
    if (!b->body[1]) return;
    for (int i = 0; i < 3; i++) row->j2[i] = -axis[i];
    pinch_v3_sub(point2, dBodyGetPosition(b->body[1]), arm);
    pinch_v3_cross(arm, row->j2, row->j2 + 3);
}

/* Finds two directions perpendicular to a unit axis. */
static void plane_of(const double *axis, double *p, double *q)
{
    pinch_v3_any_perpendicular(axis, p);
    pinch_v3_cross(axis, p, q);
}

/* ---- motors and stops ---- */

/* One motor and its stops, in ODE's parameters. */
typedef struct limit_motor {
    double velocity, fmax, low_stop, high_stop, fudge, normal_cfm, stop_erp, stop_cfm, bounce;
} limit_motor;

/* Tells whether an angle, which ODE knows up to whole turns, may be at a stop. */
static bool stops_angle(const limit_motor *m)
{
    return m->low_stop >= -M_PI || m->high_stop <= M_PI;
}

typedef dReal (*parameter_getter)(dJointID joint, int parameter);

/* group: 0, dParamGroup2, ... */
static limit_motor read_motor(dJointID joint, parameter_getter get, int group)
{
    limit_motor m = {
        .velocity = get(joint, dParamVel + group),
        .fmax = get(joint, dParamFMax + group),
        .low_stop = get(joint, dParamLoStop + group),
        .high_stop = get(joint, dParamHiStop + group),
        .fudge = get(joint, dParamFudgeFactor + group),
        .normal_cfm = get(joint, dParamCFM + group),
        .stop_erp = get(joint, dParamStopERP + group),
        .stop_cfm = get(joint, dParamStopCFM + group),
        .bounce = get(joint, dParamBounce + group),
    };
    return m;
}

static double velocity_along(const row_builder *b, const pinch_joint_row *row)
{
    double v = 0;
    for (int side = 0; side < 2 && b->body[side]; side++) {
        const double *j = side ? row->j2 : row->j1;
        v += pinch_v3_dot(j, dBodyGetLinearVel(b->body[side])) + pinch_v3_dot(j + 3, dBodyGetAngularVel(b->body[side]));
    }
    return v;
}

/* Where a motor runs into its stop, ODE drops the motor's row and applies its force itself. */
static void apply_motor(row_builder *b, const pinch_joint_row *row, const limit_motor *m, bool at_low)
{
    double force = m->velocity > 0 || (m->velocity == 0 && !at_low) ? m->fmax : -m->fmax;
    bool away = at_low ? m->velocity > 0 : m->velocity < 0;
    if (away) force *= m->fudge;
    for (int i = 0; i < 6; i++) {
        b->rows->applied[0][i] += force * row->j1[i];
        b->rows->applied[1][i] += force * row->j2[i];
    }
}

/*
 * Adds the motor or stop row along `axis` at joint position `position`, as ODE's addLimot builds it. A linear one acts
 * half way between the two bodies' centres, so that it makes no couple.
 */
static void limit_motor_row(row_builder *b, const limit_motor *m, const double *axis, bool rotational, bool limited,
                            double position)
{
    bool stops = limited && m->low_stop <= m->high_stop;
    bool at_low = stops && position <= m->low_stop, at_high = stops && !at_low && position >= m->high_stop;
    bool powered = m->fmax > 0;
    if (!powered && !at_low && !at_high) return;

    pinch_joint_row *row = new_row(b, m->velocity);
    pinch_v3_copy(row->j1 + (rotational ? 3 : 0), axis);
    if (b->body[1]) {
        for (int i = 0; i < 3; i++) row->j2[(rotational ? 3 : 0) + i] = -axis[i];
        if (!rotational) {
            double half[3];
            pinch_v3_sub(dBodyGetPosition(b->body[1]), dBodyGetPosition(b->body[0]), half);
            pinch_v3_scale(half, 0.5);
            pinch_v3_cross(half, axis, row->j1 + 3);
            pinch_v3_copy(row->j2 + 3, row->j1 + 3);
        }
    }
    row->cfm = m->normal_cfm;
    row->low = -m->fmax;
    row->high = m->fmax;
    if (!at_low && !at_high) return;

    bool fixed = m->low_stop == m->high_stop;
    if (powered && !fixed) apply_motor(b, row, m, at_low);
    row->rhs = -m->stop_erp / b->h * (position - (at_low ? m->low_stop : m->high_stop));
    row->cfm = m->stop_cfm;
    row->low = fixed || at_high ? -INFINITY : 0;
    row->high = fixed || at_low ? INFINITY : 0;
    if (fixed || !(m->bounce > 0)) return;
    double rebound = -m->bounce * velocity_along(b, row);
    if (at_low ? rebound > fmax(row->rhs, 0) : rebound < fmin(row->rhs, 0)) row->rhs = rebound;
}

/* ---- the types of joints ---- */

/* Adds three position rows. ODE's getters name the anchors by the order in which the joint was attached, the error by
 * the bodies. */
static void anchor_rows(row_builder *b, double erp, const double *anchor_a, const double *anchor_b)
{
    const double *anchor1 = b->reversed ? anchor_b : anchor_a, *anchor2 = b->reversed ? anchor_a : anchor_b;
    for (int i = 0; i < 3; i++) linear_row(b, UNIT[i], anchor1, anchor2, erp / b->h * (anchor2[i] - anchor1[i]));
}

static void ball_rows(row_builder *b)
{
    dVector3 anchor1, anchor2;
    dJointGetBallAnchor(b->joint, anchor1);
    dJointGetBallAnchor2(b->joint, anchor2);
    anchor_rows(b, dJointGetBallParam(b->joint, dParamERP), anchor1, anchor2);
    for (int i = 0; i < 3; i++) b->rows->row[i].cfm = dJointGetBallParam(b->joint, dParamCFM);
    b->rows->exact = true;
}

static void hinge_rows(row_builder *b)
{
    dVector3 anchor1, anchor2, axis, p, q;
    dJointGetHingeAnchor(b->joint, anchor1);
    dJointGetHingeAnchor2(b->joint, anchor2);
    dJointGetHingeAxis(b->joint, axis);
    anchor_rows(b, b->erp, anchor1, anchor2);
    plane_of(axis, p, q);
    double error[3] = {0, 0, 0};
    if (b->axis2) { /* the rotation that takes the first body's axis to the second's */
        double other[3];
        pinch_v3_copy(other, b->axis2);
        for (int i = 0; i < 3 && b->body[1]; i++)
            other[i] = pinch_v3_dot(dBodyGetRotation(b->body[1]) + 4 * i, b->axis2);
        pinch_v3_cross(axis, other, error);
        b->rows->exact = true;
    }
    angular_row(b, p, b->erp / b->h * pinch_v3_dot(error, p));
    angular_row(b, q, b->erp / b->h * pinch_v3_dot(error, q));
    limit_motor m = read_motor(b->joint, dJointGetHingeParam, 0);
    bool limited = stops_angle(&m);
    double angle = limited ? dJointGetHingeAngle(b->joint) : 0;
    limit_motor_row(b, &m, axis, true, limited, b->reversed ? -angle : angle);
}

static void universal_rows(row_builder *b)
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
        angular_row(b, normal, -b->erp / b->h * pinch_v3_dot(axis1, axis2));
    }
    limit_motor m1 = read_motor(b->joint, dJointGetUniversalParam, 0);
    limit_motor m2 = read_motor(b->joint, dJointGetUniversalParam, dParamGroup2);
    double angle1 = dJointGetUniversalAngle1(b->joint), angle2 = dJointGetUniversalAngle2(b->joint);
    limit_motor_row(b, &m1, axis1, true, stops_angle(&m1), b->reversed ? -angle2 : angle1);
    limit_motor_row(b, &m2, axis2, true, stops_angle(&m2), b->reversed ? -angle1 : angle2);
}

/*
 * The suspension is the position row along the first axis, with parameters of its own. The angle between the axes is
 * kept: about their common normal the bodies turn so as to take the part ERP of theta - theta0 away in a step, for
 * which ODE has its sine, sin(theta - theta0) = cos(theta0) sin(theta) - sin(theta0) cos(theta). A turn of the first
 * body about the normal takes its axis towards the second's.
 */
static void hinge2_rows(row_builder *b)
{
    dVector3 anchor1, anchor2, axis1, axis2;
    double normal[3], p[3], q[3];
    dJointGetHinge2Anchor(b->joint, anchor1);
    dJointGetHinge2Anchor2(b->joint, anchor2);
    double sine = pinch_hinge2_axes(b->joint, axis1, axis2, normal);
    plane_of(axis1, p, q);
    const double *direction[3] = {axis1, p, q};
    double erp[3] = {dJointGetHinge2Param(b->joint, dParamSuspensionERP), b->erp, b->erp}, error[3];
    pinch_v3_sub(anchor2, anchor1, error);
    for (int i = 0; i < 3; i++)
        linear_row(b, direction[i], anchor1, anchor2, erp[i] / b->h * pinch_v3_dot(direction[i], error));
    b->rows->row[b->rows->count - 3].cfm = dJointGetHinge2Param(b->joint, dParamSuspensionCFM);
    if (sine > 0) {
        double cosine = pinch_v3_dot(axis1, axis2);
        double apart = b->pose ? b->pose->cosine * sine - b->pose->sine * cosine : 0;
        pinch_v3_scale(normal, 1 / sine);
        angular_row(b, normal, b->erp / b->h * apart);
        b->rows->exact = b->pose != NULL;
    }
    limit_motor m1 = read_motor(b->joint, dJointGetHinge2Param, 0);
    limit_motor m2 = read_motor(b->joint, dJointGetHinge2Param, dParamGroup2);
    limit_motor_row(b, &m1, axis1, true, stops_angle(&m1), dJointGetHinge2Angle1(b->joint));
    limit_motor_row(b, &m2, axis2, true, false, 0);
}

/* ODE has setters for this joint's motors and no getters: they stay unknown here. */
static void plane_rows(row_builder *b)
{
    const double *x = dBodyGetPosition(b->body[0]);
    linear_row(b, UNIT[2], x, x, -b->erp / b->h * x[2]);
    angular_row(b, UNIT[0], 0);
    angular_row(b, UNIT[1], 0);
}

static void angular_motor_rows(row_builder *b)
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
        limit_motor m = read_motor(b->joint, dJointGetAMotorParam, i * dParamGroup2);
        limit_motor_row(b, &m, axis[i], true, true, dJointGetAMotorAngle(b->joint, i));
    }
    b->rows->exact = !euler; /* ODE measures Euler angles only as it steps the joint */
}

static void linear_motor_rows(row_builder *b)
{
    int axes = dJointGetLMotorNumAxes(b->joint);
    for (int i = 0; i < axes; i++) {
        dVector3 axis;
        dJointGetLMotorAxis(b->joint, i, axis);
        limit_motor m = read_motor(b->joint, dJointGetLMotorParam, i * dParamGroup2);
        limit_motor_row(b, &m, axis, false, false, 0);
    }
}

/* Computes the rotation that takes the second body (the world) back to where the joint wants it, as seen from the first
 * body: twice the vector part of q1^-1 q2 turn^-1, in world coordinates. */
static void turn_error(const row_builder *b, double error[3])
{
    static const dQuaternion world = {1, 0, 0, 0};
    dQuaternion now, off;
    dVector3 turned;
    memset(error, 0, 3 * sizeof *error);
    if (!b->pose) return;
    dQMultiply1(now, dBodyGetQuaternion(b->body[0]), b->body[1] ? dBodyGetQuaternion(b->body[1]) : world);
    dQMultiply2(off, now, b->pose->turn);
    double scale = off[0] < 0 ? -2 : 2;
    dBodyVectorToWorld(b->body[0], off[1], off[2], off[3], turned);
    for (int i = 0; i < 3; i++) error[i] = scale * turned[i];
}

static void same_turn_rows(row_builder *b)
{
    double error[3];
    turn_error(b, error);
    for (int i = 0; i < 3; i++) angular_row(b, UNIT[i], b->erp / b->h * error[i]);
}

/* Computes the way from where a slider's first body is to where the offset wants it. */
static void slider_error(const row_builder *b, double error[3])
{
    dVector3 offset;
    memset(error, 0, 3 * sizeof *error);
    if (!b->pose) return;
    pinch_v3_copy(offset, b->pose->offset);
    if (b->body[1]) {
        dBodyVectorToWorld(b->body[1], b->pose->offset[0], b->pose->offset[1], b->pose->offset[2], offset);
        pinch_v3_add_scaled(offset, 1, dBodyGetPosition(b->body[1]));
    }
    pinch_v3_sub(offset, dBodyGetPosition(b->body[0]), error);
}

static void slider_rows(row_builder *b)
{
    dVector3 axis, p, q;
    double middle[3], error[3], rate = b->erp / b->h;
    dJointGetSliderAxis(b->joint, axis);
    same_turn_rows(b);
    plane_of(axis, p, q);
    const double *x1 = dBodyGetPosition(b->body[0]), *x2 = b->body[1] ? dBodyGetPosition(b->body[1]) : x1;
    for (int i = 0; i < 3; i++) middle[i] = 0.5 * (x1[i] + x2[i]);
    slider_error(b, error);
    linear_row(b, p, middle, middle, rate * pinch_v3_dot(p, error));
    linear_row(b, q, middle, middle, rate * pinch_v3_dot(q, error));
    b->rows->exact = b->pose != NULL;
    limit_motor m = read_motor(b->joint, dJointGetSliderParam, 0);
    if (b->reversed) pinch_v3_scale(axis, -1);
    limit_motor_row(b, &m, axis, false, true, dJointGetSliderPosition(b->joint));
}

/* The first body carries the place where the second's centre has to be. */
static void fixed_rows(row_builder *b)
{
    const double *x1 = dBodyGetPosition(b->body[0]), *x2 = b->body[1] ? dBodyGetPosition(b->body[1]) : x1;
    double erp = dJointGetFixedParam(b->joint, dParamERP), place[3];
    pinch_v3_copy(place, x2);
    if (b->pose && b->body[1]) {
        dVector3 offset;
        dBodyVectorToWorld(b->body[0], b->pose->offset[0], b->pose->offset[1], b->pose->offset[2], offset);
        pinch_v3_sub(x1, offset, place);
    }
    const double *wanted = b->pose && !b->body[1] ? b->pose->offset : x2, *is = b->body[1] ? place : x1;
    for (int i = 0; i < 3; i++) linear_row(b, UNIT[i], b->body[1] ? place : x1, x2, erp / b->h * (wanted[i] - is[i]));
    for (int i = 0; i < 3; i++) b->rows->row[i].cfm = dJointGetFixedParam(b->joint, dParamCFM);
    same_turn_rows(b);
    b->rows->exact = b->pose != NULL;
}

typedef void (*row_filler)(row_builder *b);

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

/* Computes how easily each body of the joint moves: 1/kg, and 1/(kg m^2) as the mean over its axes; 0 for a body that
 * forces do not move. */
static void body_mobilities(const row_builder *b, double linear[2], double angular[2])
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

/* Sets compliances to zero that hardly count beside trace(J M^-1 J^T), what a unit force along the row moves. */
static void harden(const row_builder *b)
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

bool pinch_modelled_joint_bodies(dJointID joint, dBodyID body[2])
{
    return filler_of(joint) && pinch_joint_bodies(joint, body);
}

void pinch_joint_rows_of(const pinch_step_context *context, dJointID joint, const dBodyID body[2], const double *axis2,
                         const pinch_joint_pose *pose, pinch_joint_rows *rows)
{
    row_builder b = {.joint = joint,
                     .body = {body[0], body[1]},
                     .reversed = !dJointGetBody(joint, 0),
                     .h = context->h,
                     .erp = dWorldGetERP(context->world),
                     .cfm = dWorldGetCFM(context->world),
                     .axis2 = axis2,
                     .pose = pose,
                     .rows = rows};
    rows->count = 0;
    rows->exact = false;
    memset(rows->applied, 0, sizeof rows->applied);
    filler_of(joint)(&b);
    harden(&b);
}
