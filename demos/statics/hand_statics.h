#ifndef PINCH_HAND_STATICS_H
#define PINCH_HAND_STATICS_H

#include "scenes/scene.h"

#include <pinch/problem.h>

/*
 * The statics of hands: what contacts, motors, ties and loops bear when a scene stands still. The contacts are those
 * that the scene's run has come to, with their springs and what has slipped by then; from there displacements are
 * small, so that the answer of a scene at rest is its rest, and of one that still moves where it would stand. Motors
 * under position control give kp (target - q), within their bounds; motors under torque control, what they are told.
 */

typedef enum hand_statics_status {
    HAND_STATICS_SOLVED = 0, /* and verified */
    HAND_STATICS_UNVERIFIED,
    HAND_STATICS_NOT_FOUND,   /* Newton's method came to no answer: there may be none */
    HAND_STATICS_INFEASIBLE,  /* nothing touches an object that has a load; `why` says which one */
    HAND_STATICS_UNSUPPORTED, /* `why` says what of the scene the statics do not know */
    HAND_STATICS_FAILED       /* the run itself; `why` says in what way */
} hand_statics_status;

typedef struct hand_static_finger {
    const char *name;
    int points; /* that press */
    pinch_contact_state state;
    double normal_force, force[3], tangential_force[3], torsional_moment; /* N, N m: on the object */
    double slip_margin; /* the least of its points: 1 - hypot(|r_t|/mu, r_tau/mu_tau)/r_n; NaN without */
} hand_static_finger;

typedef struct hand_static_joint {
    const char *name, *hand;
    double position;       /* rad or m, where it stands */
    double target;         /* of its position control; NaN without */
    double torque;         /* N m or N: of its motor, and of tendons that drive it */
    double contact_torque; /* J^T f: what the contacts exert on it */
    double weight_torque;  /* of the links that it carries */
    double passive_torque; /* of springs, dry friction, stops, ties and loops; the four add up to nothing */
    bool at_limit;         /* a stop bears something */
    bool saturated;        /* its motor, or a tendon's, gives all it has */
} hand_static_joint;

typedef struct hand_statics {
    hand_statics_status status;
    char why[256];
    int unknowns, steps;                /* of Newton's method */
    double residual;                    /* N */
    double time;                        /* s, of the solve */
    double translation[3], rotation[3]; /* m, rad: of the first object from where the run has it */
    double force_error, torque_error, joint_error, motor_error, cone, normal_law, slip_direction, force_scale;
    int finger_count, joint_count;
    hand_static_finger *fingers; /* the links and fingers that touch */
    hand_static_joint *joints;
} hand_statics;

/* Runs the scene for `time` seconds (>= 0) and solves. The texts in the answer are the scene's. The caller gives it to
 * hand_statics_free in any case. Returns false when memory runs out. */
bool hand_statics_solve(const scene *s, double time, hand_statics *answer);
void hand_statics_free(hand_statics *answer);

#endif
