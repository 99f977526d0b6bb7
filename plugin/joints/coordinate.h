/* The coordinates of joints that servos and couplings act on: angles and positions, as the joints' getters show them.
 */
#ifndef PINCH_JOINTS_COORDINATE_H
#define PINCH_JOINTS_COORDINATE_H

#include "joints/joint_pose.h"
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

/* A row without limits that acts on nothing yet. To copy it takes less time than to set memory to zero. */
extern const pinch_joint_row pinch_free_row;

/* Returns NULL for a coordinate that the joint does not have. */
const pinch_coordinate *pinch_coordinate_of(dJointID joint, int axis);
/* Reads the position of a coordinate that the joint has. An angle changes by less than half a turn from one call to the
 * next. reading: what has been read of the joint in this step and need not be read again; NULL: nothing. */
void pinch_coordinate_follow(dJointID joint, int axis, const pinch_axis_reading *reading, pinch_followed *followed);
/* Writes the direction along which, or about which, the first body moves when the coordinate grows. reading: as above.
 */
void pinch_coordinate_direction(dJointID joint, int axis, const pinch_axis_reading *reading, double direction[3]);
/* Writes j1 and j2 of a pinch_free_row whose velocity is the rate of a coordinate, linear or an angle. body: those of
 * pinch_joint_bodies. */
void pinch_coordinate_row(bool linear, const double direction[3], const dBodyID body[2], pinch_joint_row *row);

#endif
