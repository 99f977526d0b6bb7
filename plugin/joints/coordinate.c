#include "joints/coordinate.h"

#include "support/vec3.h"

#include <math.h>

const pinch_joint_row pinch_free_row = {.low = -INFINITY, .high = INFINITY};

const pinch_coordinate *pinch_coordinate_of(dJointID joint, int axis)
{
    static const struct {
        dJointType type;
        int axis;
        pinch_coordinate coordinate;
    } known[] = {
        {dJointTypeHinge, 0, {dJointGetHingeAngle, dJointGetHingeAxis, false, {1, -1}}},
        {dJointTypeSlider, 0, {dJointGetSliderPosition, dJointGetSliderAxis, true, {1, -1}}},
        {dJointTypeUniversal, 0, {dJointGetUniversalAngle1, dJointGetUniversalAxis1, false, {1, 1}}},
        {dJointTypeUniversal, 1, {dJointGetUniversalAngle2, dJointGetUniversalAxis2, false, {1, -1}}},
        {dJointTypeHinge2, 0, {dJointGetHinge2Angle1, dJointGetHinge2Axis1, false, {1, 1}}},
        {dJointTypeHinge2, 1, {dJointGetHinge2Angle2, dJointGetHinge2Axis2, false, {-1, -1}}},
        {dJointTypePR, 1, {dJointGetPRAngle, dJointGetPRAxis2, false, {1, -1}}},
        {dJointTypePU, 0, {dJointGetPUAngle1, dJointGetPUAxis1, false, {1, 1}}},
        {dJointTypePU, 1, {dJointGetPUAngle2, dJointGetPUAxis2, false, {1, 1}}},
        {dJointTypePiston, 0, {dJointGetPistonPosition, dJointGetPistonAxis, true, {1, -1}}},
        {dJointTypePiston, 1, {dJointGetPistonAngle, dJointGetPistonAxis, false, {1, -1}}},
    };
    dJointType type = dJointGetType(joint);
    for (size_t k = 0; k < sizeof known / sizeof *known; k++)
        if (known[k].type == type && known[k].axis == axis) return &known[k].coordinate;
    return NULL;
}

void pinch_coordinate_follow(dJointID joint, int axis, const pinch_axis_reading *reading, pinch_followed *followed)
{
    bool read = reading && reading->placed;
    const pinch_coordinate *c = read ? NULL : pinch_coordinate_of(joint, axis);
    double now = read ? reading->position : c->position(joint);
    if (followed->placed && !(read ? reading->slides : c->linear)) {
        double change = now - followed->position;
        if (!(fabs(change) < M_PI)) change = remainder(change, 2 * M_PI); /* slow, and otherwise it changes nothing */
        now = followed->position + change;
    }
    followed->position = now;
    followed->placed = true;
}

void pinch_coordinate_direction(dJointID joint, int axis, const pinch_axis_reading *reading, double direction[3])
{
    if (reading) {
        for (int i = 0; i < 3; i++) direction[i] = reading->reversed ? -reading->axis[i] : reading->axis[i];
        return;
    }
    dVector3 own;
    const pinch_coordinate *c = pinch_coordinate_of(joint, axis);
    c->axis(joint, own);
    pinch_v3_copy(direction, own);
    pinch_v3_scale(direction, c->sign[dJointGetBody(joint, 0) ? 0 : 1]);
}

void pinch_coordinate_row(bool linear, const double direction[3], const dBodyID body[2], pinch_joint_row *row)
{
    pinch_v3_copy(row->j1 + (linear ? 0 : 3), direction);
    if (!body[1]) return;
    for (int i = 0; i < 3; i++) row->j2[(linear ? 0 : 3) + i] = -direction[i];
    if (!linear) return;
    double half[3]; /* the force acts half way between the centres, so that it makes no couple */
    pinch_v3_sub(dBodyGetPosition(body[1]), dBodyGetPosition(body[0]), half);
    pinch_v3_scale(half, 0.5);
    pinch_v3_cross(half, direction, row->j1 + 3);
    pinch_v3_copy(row->j2 + 3, row->j1 + 3);
}
