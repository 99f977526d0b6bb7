/* What every part of a step has to know: the world, the settings, the length of the step. */
#ifndef PINCH_PLUGIN_STEP_CONTEXT_H
#define PINCH_PLUGIN_STEP_CONTEXT_H

#include <pinch/ode.h>

/* What an ODE world has for all contacts, as it is at the solve. */
typedef struct pinch_world_values {
    double erp, cfm, correcting_velocity, surface_layer;
} pinch_world_values;

typedef struct pinch_step_context {
    dWorldID world;
    dJointGroupID joint_group;   /* joints that Pinch makes for this step alone */
    pinch_ode_settings settings; /* only the stepper and move_bodies change after creation */
    long number;                 /* of the step that contacts are being handed over for */
    double h, h_before;          /* s; of the last step, 0: there was none */
    double gravity[3];           /* m/s^2, of the solve */
    pinch_world_values values;
    dVector3 gravity_now;   /* m/s^2, when bodies are moved: a program may change it in between */
    double noise[2];        /* m/s, rad/s: by which ODE's steps have missed what was solved, the last ones most */
    bool same_world;        /* h and all values of the world are those of the last step */
    bool solve_and_advance; /* one call does both halves of the step: nobody can change a joint between them */
} pinch_step_context;

#endif
