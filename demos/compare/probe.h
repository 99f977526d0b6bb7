#ifndef PINCH_COMPARE_PROBE_H
#define PINCH_COMPARE_PROBE_H

#include "scenes/world/world.h"

/*
 * What one of ODE's own solvers makes of a step of Pinch's: a world of its own with the bodies' state of that step and
 * its contact points, with their stiffness, damping and friction, makes the one step. What ODE's contacts cannot say
 * (tangential stiffness, torsion, force limits) is lost, and a slider stands in for force control.
 */

/* The contact points of a step, as ODE contacts of `w`'s geoms and bodies. */
typedef struct probe_contacts {
    int count;
    world_contact *contacts;
    pinch_material *materials; /* one per contact */
} probe_contacts;

/* settings: the solver and its iterations. w: in the step, before anything has moved (world.observe). force: 3 per
 * contact, on its body 1, N; NaN where the step could not be made. false: no memory. */
bool probe_step(const world *w, const world_settings *settings, const probe_contacts *contacts, double *force);

#endif
