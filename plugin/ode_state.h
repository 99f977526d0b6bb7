/* The whole state of the plugin. Only ode.c, save.c and step.c see it: they hand each room the store it works on. */
#ifndef PINCH_PLUGIN_ODE_STATE_H
#define PINCH_PLUGIN_ODE_STATE_H

#include "contacts/detection.h"
#include "islands/island_graph.h"
#include "islands/solver_pool.h"

struct pinch_ode {
    pinch_step_context context;
    pinch_contact_store contacts;
    pinch_joint_store joints;
    pinch_island_graph graph;
    pinch_solver_pool pool;
    pinch_detection detection;
    pinch_ode_stats stats;
    bool recount_at_rest;   /* the statistics were reset: islands at rest have not been counted yet */
    bool unconverged;       /* an island of this step, see unconverged_steps */
    bool detecting;         /* pairs of geoms are being looked at */
    bool solved;            /* pinch_ode_solve is done, pinch_ode_advance not yet */
    bool stepped;           /* ODE's step was done, or left out; memory may have run out in it */
    int body_count;         /* of the world, as the program says; -1: not known */
    double world_values[7]; /* of the last step, see watch_world in step.c */
    double last_h;          /* of the last step, s */
};

/* step.c: wakes the threads up, which takes a while, when most contacts of a step have been handed over. */
void pinch_expect_step(pinch_ode *p);
/* step.c: drops what is kept of geoms and bodies that are forgotten, once for all of them. To be called before pairs,
 * islands and joints are used. */
void pinch_drop_forgotten(pinch_ode *p);

#endif
