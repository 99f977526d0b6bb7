/*
 * Servos: springs and dampers that a program puts on the coordinates of joints, with a target and a bound.
 *
 * Over a step, implicitly, the force is clamp(kp (target - q - h q'+) + kd (rate - q'+), -max_force, max_force), which
 * is a compliant row with the bounds of a motor,
 *
 *     J v+ + C lambda = C (kp (target - q) + kd rate),     C = 1 / (h kp + kd),     q' = J v.
 *
 * The row is added to those of its joint, and its force is part of the joint's. Where ODE solves the joint, a motor of
 * ODE's with the same row is made for the step.
 */
#ifndef PINCH_JOINTS_SERVO_H
#define PINCH_JOINTS_SERVO_H

#include "joints/coordinate.h"
#include "util/list.h"

typedef struct pinch_servo_axis {
    bool used;
    pinch_servo law;
    pinch_followed coordinate; /* since the servo was set */
    double force;              /* of the last step, N or N m */
    dJointFeedback feedback;   /* of the motor that ODE has solved in its place */
    dJointID motor;            /* NULL: Pinch has solved it */
    double direction[3];       /* of the motor's axis */
} pinch_servo_axis;

typedef struct pinch_joint_servos {
    dJointID joint;
    bool by_pinch; /* in the step at hand */
    pinch_servo_axis axis[PINCH_JOINT_AXES];
} pinch_joint_servos;

typedef struct pinch_servos {
    pinch_joint_servos *items;
    int count, room;
    pinch_item_index index;
} pinch_servos;

/* Is the law within the ranges of pinch_servo? */
bool pinch_servo_law_is_legal(const pinch_servo *law);
/* Sets the servo of a coordinate, or ends it where `law` is NULL. PINCH_INVALID_ARGUMENT for a law out of range and for
 * a coordinate that the joint does not have. */
pinch_status pinch_servo_set(pinch_servos *servos, dJointID joint, int axis, const pinch_servo *law);
/* Returns NULL for a joint without servos. *hint: as for pinch_item_index_find. */
pinch_joint_servos *pinch_servos_of(const pinch_servos *servos, dJointID joint, int *hint);

/* Writes the rows of a joint's servos, and returns how many there are. reading: as for pinch_coordinate_follow; body:
 * those of pinch_joint_bodies. */
int pinch_servo_rows(pinch_joint_servos *servos, const pinch_axis_reading *reading, const dBodyID body[2], double h,
                     pinch_joint_row *rows);
/* Reads the forces of these rows. */
void pinch_read_servo_rows(pinch_joint_servos *servos, const pinch_joint_row *rows);

/* Has ODE solve the servos of all joints that it solves. To be called just before it steps. */
void pinch_leave_servos_to_ode(pinch_servos *servos, const pinch_step_context *context);
/* Reads their forces, and forgets who has solved what. To be called just after. */
void pinch_read_servos_of_ode(pinch_servos *servos);

void pinch_servos_free(pinch_servos *servos);

#endif
