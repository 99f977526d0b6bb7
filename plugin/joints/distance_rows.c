/* Joints that keep two anchors at a distance: double ball and double hinge. */
#include "joints/row_builder.h"

#include "support/vec3.h"

#include <math.h>

/* Where the anchors coincide, ODE holds them along their relative velocity, or along x. */
static void direction_of(const pinch_row_builder *b, const double *anchor1, const double *anchor2, double direction[3])
{
    static const double LEAST = 1e-12;
    pinch_v3_sub(anchor1, anchor2, direction);
    if (pinch_v3_norm(direction) < LEAST) {
        dVector3 v[2] = {{0}};
        const double *anchor[2] = {anchor1, anchor2};
        for (int i = 0; i < 2 && b->body[i]; i++)
            dBodyGetPointVel(b->body[i], anchor[i][0], anchor[i][1], anchor[i][2], v[i]);
        pinch_v3_sub(v[0], v[1], direction);
        if (pinch_v3_norm(direction) < LEAST) pinch_v3_set(direction, 1, 0, 0);
    }
    pinch_v3_scale(direction, 1 / pinch_v3_norm(direction));
}

/* Adds the row of the distance, and writes the anchors of the joint's bodies. ODE's getters name them by the order in
 * which the joint was attached. */
static void distance_row(pinch_row_builder *b, double erp, double anchor1[4], double anchor2[4])
{
    double direction[3], apart[3];
    dJointGetDBallAnchor1(b->joint, b->reversed ? anchor2 : anchor1);
    dJointGetDBallAnchor2(b->joint, b->reversed ? anchor1 : anchor2);
    direction_of(b, anchor1, anchor2, direction);
    pinch_v3_sub(anchor1, anchor2, apart);
    double missing = dJointGetDBallDistance(b->joint) - pinch_v3_norm(apart);
    pinch_linear_row(b, direction, anchor1, anchor2, pinch_closing_speed(b, erp, missing))->cfm =
        dJointGetDBallParam(b->joint, dParamCFM);
    b->rows->exact = true;
}

void pinch_double_ball_rows(pinch_row_builder *b)
{
    dVector3 anchor1, anchor2;
    distance_row(b, dJointGetDBallParam(b->joint, dParamERP), anchor1, anchor2);
}

/* Along the axis the bodies are held half way between their centres, as a linear motor would. */
void pinch_double_hinge_rows(pinch_row_builder *b)
{
    dVector3 anchor1, anchor2, axis;
    double apart[3], p[3], q[3], erp = dJointGetDHingeParam(b->joint, dParamERP);
    distance_row(b, erp, anchor1, anchor2);
    dJointGetDHingeAxis(b->joint, axis);
    pinch_plane_of(axis, p, q);
    b->rows->exact = pinch_axis_rows(b, erp, axis, p, q);
    pinch_v3_sub(anchor1, anchor2, apart);
    double speed = pinch_closing_speed(b, erp, -pinch_v3_dot(axis, apart));
    pinch_limit_motor along = {.velocity = speed, .fmax = INFINITY, .normal_cfm = b->cfm, .linear = true};
    pinch_limit_motor_row(b, &along, axis);
    b->rows->driven = 0; /* it takes an error back, and drives nothing */
}
