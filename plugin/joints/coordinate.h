/* The coordinates of joints that servos and couplings act on: angles and positions, as the joints' getters show them.
 */
#ifndef PINCH_JOINTS_COORDINATE_H
#define PINCH_JOINTS_COORDINATE_H

#include "step_context.h"

#include <pinch/problem.h>

enum { PINCH_JOINT_AXES = 2 };

typedef struct pinch_coordinate {
    dReal (*position)(dJointID joint);
    void (*axis)(dJointID joint, dVector3 axis);
    bool linear;
    double sign[2]; /* of its rate about or along the axis: as a rule, and of a joint attached as (0, body) */
} pinch_coordinate;

/* A coordinate followed from step to step; all zero at first. */
typedef struct pinch_followed {
    bool placed;     /* `position` has been read */
    double position; /* an angle is followed over whole turns */
} pinch_followed;

/* Returns false for a coordinate that the joint does not have. */
bool pinch_coordinate_of(dJointID joint, int axis, pinch_coordinate *coordinate);
/* Reads the position, or takes it from `position`, as it was read before, where that is not NULL. An angle changes by
 * less than half a turn from one call to the next. */
void pinch_coordinate_follow(const pinch_coordinate *coordinate, dJointID joint, const double *position,
                             pinch_followed *followed);
/* Writes the direction along which, or about which, the first body moves when the coordinate grows. */
void pinch_coordinate_direction(const pinch_coordinate *coordinate, dJointID joint, double direction[3]);
/* Writes j1 and j2 of a row, all zero before, whose velocity is the coordinate's rate. body: those of
 * pinch_joint_bodies. */
void pinch_coordinate_row(const pinch_coordinate *coordinate, const double direction[3], const dBodyID body[2],
                          pinch_joint_row *row);

#endif
