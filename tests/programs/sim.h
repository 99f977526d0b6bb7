#ifndef SIM_H
#define SIM_H

#include <ode/ode.h>

#include <stdbool.h>

/*
 * What the programs in this folder share: plain ODE programs that know nothing of Pinch. Each builds a scene, steps it
 * and prints one line of JSON.
 *
 * Options: --steps N, --h SECONDS, --stepper world|quick, --seed N, --threads N (a pool of ODE's own), --mu X (< 0:
 * infinite), and --KEY NUMBER for what a program asks for with sim_value. Exit status 2 for others.
 */
enum {
    SIM_MOST_BODIES = 16384,
    SIM_MOST_CONTACTS = 8192,
    SIM_LAST_STEPS = 500,
    SIM_POINTS = 8,
    SIM_MOST_POINTS = 2048
};

typedef struct sim sim;
struct sim {
    long steps, step;
    double h;
    bool quick;
    unsigned long seed;
    int argc;
    char **argv;

    dWorldID world;
    dSpaceID space;
    dJointGroupID contacts;
    dThreadingImplementationID threading; /* NULL: ODE's default */
    dThreadingThreadPoolID pool;
    dBodyID bodies[SIM_MOST_BODIES]; /* those that are measured */
    int body_count;

    dSurfaceParameters surface; /* of every contact: coefficients (dContactApprox1), mu 0.5, ODE's own stiffness */
    /* finds at most `room` contacts of two geoms; NULL: dCollide, and SIM_POINTS of them */
    int (*collide)(sim *s, dGeomID a, dGeomID b, dContact *found, int room);
    /* changes a contact before it becomes a joint; false: it does not; NULL */
    bool (*change)(sim *s, dContact *contact);
    void (*each_step)(sim *s); /* before every step; NULL */
    bool want_feedback;
    dJointFeedback feedback[SIM_MOST_CONTACTS]; /* of the contacts of the step just done */
    int contact_count;                          /* in the step just done */

    bool finite;
    double speed_max;                         /* m/s */
    double speed_last, spin_last, depth_last; /* largest of the last SIM_LAST_STEPS: m/s, rad/s, m */
    double depth_max;
    double energy_start, energy_max; /* kinetic and of height, J */
    bool timed;
    double step_time; /* s of the processor, in the calls that step the world; printed with --time 1 */
};

/* Gravity -9.81 along z. h and steps are the defaults. */
sim *sim_open(int argc, char **argv, double h, long steps);
double sim_value(sim *s, const char *key, double otherwise);

dGeomID sim_ground(sim *s);
/* four planes that face inwards at this distance from the z axis */
void sim_pit(sim *s, double half_width);
dBodyID sim_box(sim *s, double mass, double x, double y, double z, double px, double py, double pz);
dBodyID sim_sphere(sim *s, double mass, double radius, double px, double py, double pz);
dBodyID sim_capsule(sim *s, double mass, double radius, double length, double px, double py, double pz);

void sim_step(sim *s);
void sim_run(sim *s);
double sim_kinetic(const sim *s);
double sim_energy(const sim *s);

/* The end: what all programs print, with their own numbers between; sim_close ends the line and ODE. */
void sim_print(const sim *s, const char *name);
void sim_number(const char *key, double value);
int sim_close(sim *s);

#endif
