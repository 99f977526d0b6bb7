#ifndef PINCH_ENERGY_H
#define PINCH_ENERGY_H

#include <ode/ode.h>
#include <pinch/ode.h>

/*
 * The energy ledger of a run, in J since its start. Every line is summed from its own forces and motions; closure is
 * what is left over when all are added up,
 *
 *     closure = kinetic + gravity + elastic - work_drives - work_external + friction + damping + integrator.
 */
typedef struct energy_ledger {
    double kinetic;       /* of the object and the tips on sliders, change since the start */
    double gravity;       /* minus the work of gravity on them */
    double elastic;       /* stored in the contacts, change since the start */
    double work_drives;   /* of moving bases, slider forces, force control */
    double work_external; /* of the scene's force and torque and of base_acceleration */
    double friction;      /* lost to slip */
    double damping;       /* lost to contact dampers, drive dampers */
    double integrator;    /* lost to the time step (gained where negative): implicit steps, geometry's second order */
    double closure;
    double work_size; /* sum of |work| of all forces, what closure is held against */
} energy_ledger;

/* One body that moves by its own inertia, between the two ends of a step. */
typedef struct energy_body {
    dBodyID body;
    double kinetic_start;                    /* at the start of the run */
    double velocity[6], inertia[9], kinetic; /* at the start of the step */
} energy_body;

/* The kinetic energy now, J. */
double energy_kinetic(dBodyID body);
/* Before the step. */
void energy_begin(energy_body *b);
/* After it: the energy that the step itself cost the body, J. */
double energy_integrator(const energy_body *b, double h);

#endif
