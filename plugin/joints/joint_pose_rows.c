/* Joints that keep a relative pose of their bodies: sliders but for one direction, fixed joints in whole. */
#include "joints/joint_motors.h"

#include "support/vec3.h"

#include <string.h>

static const double UNIT[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/* The rotation that takes the second body (the world) back to where the joint wants it, as seen from the first body:
 * twice the vector part of q1^-1 q2 turn^-1, in world coordinates. */
static void turn_error(const pinch_row_builder *b, double error[3])
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

static void same_turn_rows(pinch_row_builder *b)
{
    double error[3];
    turn_error(b, error);
    for (int i = 0; i < 3; i++) pinch_angular_row(b, UNIT[i], b->erp / b->h * error[i]);
}

/* From where the first body is to where the offset wants it, for a slider. */
static void slider_error(const pinch_row_builder *b, double error[3])
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

void pinch_slider_rows(pinch_row_builder *b)
{
    dVector3 axis, p, q;
    double middle[3], error[3], rate = b->erp / b->h;
    dJointGetSliderAxis(b->joint, axis);
    same_turn_rows(b);
    pinch_plane_of(axis, p, q);
    const double *x1 = dBodyGetPosition(b->body[0]), *x2 = b->body[1] ? dBodyGetPosition(b->body[1]) : x1;
    for (int i = 0; i < 3; i++) middle[i] = 0.5 * (x1[i] + x2[i]);
    slider_error(b, error);
    pinch_linear_row(b, p, middle, middle, rate * pinch_v3_dot(p, error));
    pinch_linear_row(b, q, middle, middle, rate * pinch_v3_dot(q, error));
    b->rows->exact = b->pose != NULL;
    pinch_limit_motor m = pinch_read_motor(b->joint, dJointGetSliderParam, 0);
    if (b->reversed) pinch_v3_scale(axis, -1);
    pinch_limit_motor_row(b, &m, axis, false, true, dJointGetSliderPosition(b->joint));
}

/* The first body carries the place where the second's centre is to be. */
void pinch_fixed_rows(pinch_row_builder *b)
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
    for (int i = 0; i < 3; i++)
        pinch_linear_row(b, UNIT[i], b->body[1] ? place : x1, x2, erp / b->h * (wanted[i] - is[i]));
    for (int i = 0; i < 3; i++) b->rows->row[i].cfm = dJointGetFixedParam(b->joint, dParamCFM);
    same_turn_rows(b);
    b->rows->exact = b->pose != NULL;
}
