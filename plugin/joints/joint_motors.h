/* The rows of joints while they are being written, and those of motors and stops, which most types have. */
#ifndef PINCH_PLUGIN_JOINT_MOTORS_H
#define PINCH_PLUGIN_JOINT_MOTORS_H

#include "joints/joint_rows.h"

typedef struct pinch_row_builder {
    dJointID joint;
    dBodyID body[2];
    bool reversed; /* attached as (0, body): ODE turns such a joint round */
    double h, erp, cfm;
    const double *axis2; /* see pinch_joint_rows_of, */
    const pinch_joint_pose *pose;
    pinch_joint_rows *rows;
} pinch_row_builder;

/* An empty row without limits. */
pinch_joint_row *pinch_new_row(pinch_row_builder *b, double rhs);

/* No relative velocity but rhs: of rotation about the unit vector `axis`; along it, of the two bodies' material points
 * at point1 and point2. */
void pinch_angular_row(pinch_row_builder *b, const double *axis, double rhs);
void pinch_linear_row(pinch_row_builder *b, const double *axis, const double *point1, const double *point2, double rhs);
/* The two directions perpendicular to a unit axis. */
void pinch_plane_of(const double *axis, double *p, double *q);

/* joint_pose_rows.c */
void pinch_slider_rows(pinch_row_builder *b);
void pinch_fixed_rows(pinch_row_builder *b);

/* One motor and its stops, in ODE's parameters. */
typedef struct pinch_limit_motor {
    double velocity, fmax, low_stop, high_stop, fudge, normal_cfm, stop_erp, stop_cfm, bounce;
} pinch_limit_motor;

typedef dReal (*pinch_parameter_getter)(dJointID joint, int parameter);

/* group: 0, dParamGroup2, ... */
pinch_limit_motor pinch_read_motor(dJointID joint, pinch_parameter_getter get, int group);

/*
 * The motor or stop row along `axis` at joint position `position`, as ODE's addLimot builds it. A linear one acts half
 * way between the two bodies' centres, so that it makes no couple.
 */
void pinch_limit_motor_row(pinch_row_builder *b, const pinch_limit_motor *m, const double *axis, bool rotational,
                           bool limited, double position);

#endif
