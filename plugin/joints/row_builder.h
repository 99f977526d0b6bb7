/*
 * What the rows of all types of joints are made of: rows along an axis, rows that hold anchors together, and the row of
 * a motor with its stops.
 */
#ifndef PINCH_JOINTS_ROW_BUILDER_H
#define PINCH_JOINTS_ROW_BUILDER_H

#include "joints/coordinate.h"
#include "joints/joint_rows.h"

#include "support/extremes.h"

#include <math.h>

/* The rows of a joint while they are being written. */
typedef struct pinch_row_builder {
    dJointID joint;
    dBodyID body[2];
    bool reversed; /* the joint is attached as (0, body), which ODE turns round */
    bool as_ode;   /* ODE solves all joints: their rows are to be its own where these are wrong, too */
    double h, erp, cfm;
    const double *noise; /* of pinch_step_context */
    long step;
    const double *axis2;    /* see pinch_joint_rows_of */
    const double *own_axis; /* the joint's axis in the first body's frame, where it has been read, otherwise NULL */
    pinch_joint_pose *pose;
    pinch_joint_rows *rows;
} pinch_row_builder;

static inline bool pinch_builder_knows(const pinch_row_builder *b, unsigned things)
{
    return b->pose && (b->pose->known & things) == things;
}

extern const double pinch_unit_axis[3][3];

/* The velocity at which a row takes an error of position (m) back. The largest is noted. */
static inline double pinch_closing_speed(pinch_row_builder *b, double erp, double error)
{
    b->rows->error = pinch_larger(b->rows->error, fabs(error));
    return erp / b->h * error;
}

/* The same of an angle (rad). */
static inline double pinch_closing_spin(pinch_row_builder *b, double erp, double error)
{
    b->rows->error_angle = pinch_larger(b->rows->error_angle, fabs(error));
    return erp / b->h * error;
}

/* Adds an empty row without limits. */
pinch_joint_row *pinch_new_row(pinch_row_builder *b, double rhs);
/* Adds a row that asks for the relative angular velocity rhs about the unit vector `axis`. */
pinch_joint_row *pinch_angular_row(pinch_row_builder *b, const double *axis, double rhs);
/* Adds a row that asks for the relative velocity rhs along `axis` of the two bodies' material points at point1 and
 * point2. */
pinch_joint_row *pinch_linear_row(pinch_row_builder *b, const double *axis, const double *point1, const double *point2,
                                  double rhs);
/* Adds three position rows. ODE's getters name the anchors by the order in which the joint was attached, the error by
 * the bodies. */
void pinch_anchor_rows(pinch_row_builder *b, double erp, const double *anchor_a, const double *anchor_b);
/* Computes where the second body has the axis that the first has along `axis`: as noted, that one in the orientation of
 * then. Returns false where it is not known; it then is the first's. */
bool pinch_second_axis(const pinch_row_builder *b, const double *axis, double axis2[3]);
/* Adds rows about p and q, perpendicular to `axis`, which is fixed in the first body: they turn it to where the second
 * body has it. Returns whether that is known. */
bool pinch_axis_rows(pinch_row_builder *b, double erp, const double *axis, const double *p, const double *q);

/* Finds two directions perpendicular to a unit axis. */
void pinch_plane_of(const double *axis, double *p, double *q);
/* Turns a vector of a body's frame (of the world without one) into world axes, and back. */
void pinch_turn_with(dBodyID body, const double *local, double *world);
void pinch_turn_back(dBodyID body, const double *world, double *local);
/* The place of a point of a body's frame. */
void pinch_place_of(dBodyID body, const double *local, double *place);

typedef dReal (*pinch_parameter_getter)(dJointID joint, int parameter);

/* What of a motor's parameters counts at a stop alone. */
typedef struct pinch_stop {
    double fudge, erp, cfm, bounce;
} pinch_stop;

/* One motor and its stops, in ODE's parameters, with what is known of its axis. */
typedef struct pinch_limit_motor {
    double velocity, fmax, low_stop, high_stop, normal_cfm;
    dJointID joint;             /* those of `stop` are read from it where they count, */
    pinch_parameter_getter get; /* by this; NULL: they are set */
    int group;
    pinch_stop stop;
    bool linear;
    bool limited;           /* its stops count at this position */
    bool crossed;           /* they do so also where the low one is above the high one */
    double position;        /* m or rad */
    const double *point[2]; /* of a linear one: where its force acts on the bodies; NULL: half way between their
                             * centres, so that it makes no couple */
} pinch_limit_motor;

/* Reads the motor of a parameter group: 0, dParamGroup2, ... It has no stops yet. */
pinch_limit_motor pinch_read_motor(dJointID joint, pinch_parameter_getter get, int group);
/* Reads what of it counts at a stop. */
pinch_stop pinch_read_stop(const pinch_limit_motor *m);
/* Tells whether an angle, which ODE knows up to whole turns, may be at a stop. */
bool pinch_stops_angle(const pinch_limit_motor *m);
/* Adds the motor's or stop's row along `axis`, if there is one, as ODE builds it. */
void pinch_limit_motor_row(pinch_row_builder *b, const pinch_limit_motor *m, const double *axis);

/* The rows of types that have files of their own. */
void pinch_prismatic_rotoide_rows(pinch_row_builder *b);
void pinch_prismatic_universal_rows(pinch_row_builder *b);
void pinch_piston_rows(pinch_row_builder *b);
void pinch_double_ball_rows(pinch_row_builder *b);
void pinch_double_hinge_rows(pinch_row_builder *b);
void pinch_transmission_rows(pinch_row_builder *b);
void pinch_plane_rows(pinch_row_builder *b);
void pinch_angular_motor_rows(pinch_row_builder *b);
void pinch_linear_motor_rows(pinch_row_builder *b);

#endif
