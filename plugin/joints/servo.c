#include "joints/servo.h"

#include "joints/joint_pose.h"

#include "support/vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool pinch_servo_law_is_legal(const pinch_servo *law)
{
    return isfinite(law->target) && isfinite(law->rate) && law->kp >= 0 && law->kd >= 0 && isfinite(law->kp) &&
           isfinite(law->kd) && law->max_force > 0;
}

static pinch_item_keys keys_of(const pinch_servos *servos)
{
    return PINCH_ITEM_KEYS(*servos, pinch_joint_servos, joint);
}

pinch_joint_servos *pinch_servos_of(const pinch_servos *servos, dJointID joint, int *hint)
{
    if (servos->count == 0) return NULL;
    int index = pinch_item_index_find(&servos->index, keys_of(servos), &joint, hint);
    return index < 0 ? NULL : &servos->items[index];
}

/* Takes a joint out where none of its coordinates has a servo any more. */
static void drop_unused(pinch_servos *servos, pinch_joint_servos *joint)
{
    for (int i = 0; i < PINCH_JOINT_AXES; i++)
        if (joint->axis[i].used) return;
    pinch_item_index_remove(&servos->index, keys_of(servos), (int)(joint - servos->items), servos->count - 1);
    *joint = servos->items[--servos->count];
}

pinch_status pinch_servo_set(pinch_servos *servos, dJointID joint, int axis, const pinch_servo *law)
{
    int hint = 0;
    pinch_joint_servos *known = pinch_servos_of(servos, joint, &hint);
    if (axis < 0 || axis >= PINCH_JOINT_AXES) return PINCH_INVALID_ARGUMENT;
    if (!law) { /* the joint need not be alive any more */
        if (!known) return PINCH_OK;
        known->axis[axis].used = false;
        drop_unused(servos, known);
        return PINCH_OK;
    }
    if (!pinch_servo_law_is_legal(law) || !pinch_coordinate_of(joint, axis)) return PINCH_INVALID_ARGUMENT;
    if (!known) {
        if (!PINCH_RESERVE(*servos, servos->count + 1) ||
            !pinch_item_index_add(&servos->index, keys_of(servos), &joint, servos->count))
            return PINCH_OUT_OF_MEMORY;
        known = &servos->items[servos->count++];
        memset(known, 0, sizeof *known);
        known->joint = joint;
    }
    pinch_servo_axis *of = &known->axis[axis];
    if (!of->used) memset(of, 0, sizeof *of);
    of->used = true;
    of->law = *law;
    return PINCH_OK;
}

/* Begins the row of a servo, and writes the direction whose row is the coordinate's rate. Returns the coordinate, NULL
 * for a servo without stiffness and damping. */
static const pinch_coordinate *begin_row(pinch_joint_servos *servos, int axis, const pinch_axis_reading *reading,
                                         double h, pinch_joint_row *row)
{
    pinch_servo_axis *of = &servos->axis[axis];
    const pinch_coordinate *c = of->used ? pinch_coordinate_of(servos->joint, axis) : NULL;
    if (!c) return NULL;
    pinch_coordinate_follow(servos->joint, axis, reading, &of->coordinate);
    double gain = h * of->law.kp + of->law.kd;
    if (!(gain > 0)) return NULL;
    *row = pinch_free_row;
    pinch_coordinate_direction(servos->joint, axis, reading, of->direction);
    row->cfm = 1 / gain;
    row->rhs = (of->law.kp * (of->law.target - of->coordinate.position) + of->law.kd * of->law.rate) / gain;
    row->low = -of->law.max_force;
    row->high = of->law.max_force;
    return c;
}

int pinch_servo_rows(pinch_joint_servos *servos, const pinch_axis_reading *reading, const dBodyID body[2], double h,
                     pinch_joint_row *rows)
{
    int count = 0;
    for (int axis = 0; axis < PINCH_JOINT_AXES; axis++) {
        pinch_joint_row *row = &rows[count];
        const pinch_coordinate *c = begin_row(servos, axis, reading, h, row);
        if (!c) continue;
        pinch_coordinate_row(c->linear, servos->axis[axis].direction, body, row);
        count++;
    }
    return count;
}

void pinch_read_servo_rows(pinch_joint_servos *servos, const pinch_joint_row *rows)
{
    for (int axis = 0; axis < PINCH_JOINT_AXES; axis++) {
        pinch_servo_axis *of = &servos->axis[axis];
        if (of->used) of->force = of->law.kp > 0 || of->law.kd > 0 ? (rows++)->force : 0;
    }
}

/* Makes the motor of ODE's that has the servo's row. */
static void make_motor(pinch_joint_servos *servos, int axis, const pinch_step_context *context)
{
    pinch_joint_row row;
    pinch_servo_axis *of = &servos->axis[axis];
    const pinch_coordinate *c = begin_row(servos, axis, NULL, context->h, &row);
    if (!c) return;
    const double *d = of->direction;
    of->motor = c->linear ? dJointCreateLMotor(context->world, context->joint_group)
                          : dJointCreateAMotor(context->world, context->joint_group);
    dJointAttach(of->motor, dJointGetBody(servos->joint, 0), dJointGetBody(servos->joint, 1));
    if (c->linear) {
        dJointSetLMotorNumAxes(of->motor, 1);
        dJointSetLMotorAxis(of->motor, 0, 0, d[0], d[1], d[2]);
    } else {
        dJointSetAMotorNumAxes(of->motor, 1);
        dJointSetAMotorAxis(of->motor, 0, 0, d[0], d[1], d[2]);
    }
    void (*set)(dJointID, int, dReal) = c->linear ? dJointSetLMotorParam : dJointSetAMotorParam;
    set(of->motor, dParamVel, row.rhs);
    set(of->motor, dParamFMax, row.high);
    set(of->motor, dParamCFM, row.cfm);
    dJointSetFeedback(of->motor, &of->feedback);
}

void pinch_leave_servos_to_ode(pinch_servos *servos, const pinch_step_context *context)
{
    for (int k = 0; k < servos->count; k++) {
        pinch_joint_servos *joint = &servos->items[k];
        dBodyID body[2];
        bool acts = !joint->by_pinch && dJointIsEnabled(joint->joint) && pinch_joint_bodies(joint->joint, body);
        for (int axis = 0; axis < PINCH_JOINT_AXES; axis++) {
            joint->axis[axis].motor = NULL;
            if (joint->by_pinch || !joint->axis[axis].used) continue;
            joint->axis[axis].force = 0;
            memset(&joint->axis[axis].feedback, 0, sizeof joint->axis[axis].feedback);
            if (acts) make_motor(joint, axis, context);
        }
    }
}

void pinch_read_servos_of_ode(pinch_servos *servos)
{
    for (int k = 0; k < servos->count; k++) {
        pinch_joint_servos *joint = &servos->items[k];
        joint->by_pinch = false;
        for (int axis = 0; axis < PINCH_JOINT_AXES; axis++) {
            pinch_servo_axis *of = &joint->axis[axis];
            if (!of->motor) continue;
            bool linear = dJointGetType(of->motor) == dJointTypeLMotor;
            of->force = pinch_v3_dot(of->direction, linear ? of->feedback.f1 : of->feedback.t1);
            of->motor = NULL;
        }
    }
}

void pinch_servos_free(pinch_servos *servos)
{
    pinch_item_index_free(&servos->index);
    free(servos->items);
    memset(servos, 0, sizeof *servos);
}
