/* Joints that are motors alone, and the plane joint, which has motors without getters. */
#include "joints/row_builder.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* ODE holds the plane joint's first body alone, whatever else it was attached to. */
void pinch_plane_rows(pinch_row_builder *b)
{
    const double *x = dBodyGetPosition(b->body[0]);
    (void)pinch_linear_row(b, pinch_unit_axis[2], x, x, pinch_closing_speed(b, b->erp, -x[2]));
    (void)pinch_angular_row(b, pinch_unit_axis[0], 0);
    (void)pinch_angular_row(b, pinch_unit_axis[1], 0);
    for (int k = 0; k < 3; k++) memset(b->rows->row[k].j2, 0, sizeof b->rows->row[k].j2);
    b->rows->exact = pinch_builder_knows(b, PINCH_KNOWS_MOTORS);
    for (int i = 0; i < 3 && b->rows->exact; i++) {
        const pinch_plane_motor *own = &b->pose->motor[i];
        const pinch_limit_motor m = {
            .velocity = own->velocity, .fmax = own->fmax, .normal_cfm = own->cfm, .linear = i < 2};
        pinch_limit_motor_row(b, &m, pinch_unit_axis[i]);
    }
}

/* ---- angular motors ---- */

/*
 * The Euler angles, as ODE measures them when it steps the joint. The outer axes X and Z are fixed in the two bodies; Y
 * is their common normal. ODE shows Y, and the directions Y x Z and X x Y about which it turns the bodies. Angles of
 * the outer axes are measured from where each body had the other's axis when the axes were set.
 */
static void euler_angles(const pinch_row_builder *b, dVector3 shown[3], double angle[3])
{
    double x[3], z[3], x_then[3], z_then[3], q[3];
    const double *y = shown[1];
    const double *R = b->pose->rotation;
    int of_x = b->reversed ? 1 : 0; /* the body in which X is fixed */
    pinch_v3_cross(y, shown[2], x);
    pinch_v3_cross(shown[0], y, z);
    for (int k = 0; k < 2; k++) { /* each body's own axis, as the other body had it */
        double own[3], *then = k == of_x ? x_then : z_then;
        pinch_turn_back(b->body[k], k == of_x ? x : z, own);
        for (int i = 0; i < 3; i++)
            then[i] = k == 0 ? R[i] * own[0] + R[4 + i] * own[1] + R[8 + i] * own[2] : pinch_v3_dot(R + 4 * i, own);
        pinch_turn_with(b->body[!k], then, then);
    }
    pinch_v3_cross(x, z_then, q);
    angle[0] = -atan2(pinch_v3_dot(z, q), pinch_v3_dot(z, z_then));
    pinch_v3_cross(x, y, q);
    angle[1] = -atan2(pinch_v3_dot(z, x), pinch_v3_dot(z, q));
    pinch_v3_cross(y, z, q);
    angle[2] = -atan2(pinch_v3_dot(x_then, y), pinch_v3_dot(x_then, q));
}

/*
 * ODE measures the angles of a motor that is attached as (0, body) to the static world from the world's side: they fall
 * where the body turns on about the axis, d(angle)/dt = -axis . w. Its rows count on a rise, so that a stop drives the
 * body further beyond itself. Here a stop is that of the angle that rises, -angle, between -high and -low.
 */
static void turn_stops_round(pinch_limit_motor *m)
{
    double low = m->low_stop;
    m->position = -m->position;
    m->low_stop = -m->high_stop;
    m->high_stop = -low;
}

void pinch_angular_motor_rows(pinch_row_builder *b)
{
    int axes = dJointGetAMotorNumAxes(b->joint);
    bool euler = dJointGetAMotorMode(b->joint) == dAMotorEuler;
    bool known = !euler || pinch_builder_knows(b, PINCH_KNOWS_TURN);
    dVector3 axis[3];
    double angle[3] = {0, 0, 0};
    for (int i = 0; i < axes; i++) dJointGetAMotorAxis(b->joint, i, axis[i]);
    if (euler && known) euler_angles(b, axis, angle);
    for (int i = 0; i < axes; i++) {
        pinch_limit_motor m = pinch_read_motor(b->joint, dJointGetAMotorParam, i * dParamGroup2);
        m.limited = m.crossed = known;
        m.position = euler ? angle[i] : dJointGetAMotorAngle(b->joint, i);
        if (euler && b->reversed && !b->as_ode) turn_stops_round(&m);
        pinch_limit_motor_row(b, &m, axis[i]);
    }
    b->rows->exact = known;
}

/* ---- linear motors ---- */

void pinch_linear_motor_rows(pinch_row_builder *b)
{
    int axes = dJointGetLMotorNumAxes(b->joint);
    b->rows->exact = true;
    for (int i = 0; i < axes; i++) {
        dVector3 axis;
        dJointGetLMotorAxis(b->joint, i, axis);
        pinch_limit_motor m = pinch_read_motor(b->joint, dJointGetLMotorParam, i * dParamGroup2);
        m.linear = true;
        bool known = pinch_builder_knows(b, (unsigned)PINCH_KNOWS_FRAME << i);
        int frame = known ? b->pose->frame[i] : 0;
        if (frame > 0) pinch_turn_with(b->body[frame - 1], axis, axis);
        pinch_limit_motor_row(b, &m, axis);
        if (m.fmax > 0) b->rows->exact = b->rows->exact && known && (frame < 2 || b->body[1]);
    }
}
