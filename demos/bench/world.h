/*
 * A plain ODE program in a few lines, with the solver of its contacts to choose: what the benchmarks of steps run. It
 * collides first and keeps the contacts, so that what is timed is what a solver does: from the first contact handed
 * over to the end of the step and the emptying of the contacts.
 */
#ifndef PINCH_BENCH_WORLD_H
#define PINCH_BENCH_WORLD_H

#include <pinch/ode.h>
#include <stdbool.h>

typedef enum bench_solver { BENCH_PINCH = 0, BENCH_QUICKSTEP, BENCH_WORLDSTEP, BENCH_SOLVERS } bench_solver;

/* How a world is to be run. */
typedef struct bench_settings {
    bench_solver solver;
    bool cold;   /* Pinch: nothing of the last step's forces and factors */
    int threads; /* >= 1, of Pinch; ODE's own pool makes many small islands several times slower, and is left out */
} bench_settings;

typedef struct bench_contact {
    dContact contact;
    dBodyID body[2];
    dJointFeedback feedback;
} bench_contact;

typedef struct bench_world bench_world;

struct bench_world {
    bench_settings settings;
    dWorldID ode;
    dSpaceID space;
    dJointGroupID group;
    pinch_ode *pinch;
    pinch_material material; /* of all fingertips */
    double step;             /* s */
    double time;             /* s */
    int steps;
    bench_contact *contacts;
    int contact_count, contact_room;
    int body_count;
    dBodyID *bodies; /* that move by themselves */
    int finger_count;
    void (*drive)(bench_world *w); /* before each step: motions and forces; NULL for none */
    dBodyID *driven;               /* what `drive` moves */
    int driven_count;
    dJointID *hinges;
    double *torques; /* of the hinges at rest, N m */
    int hinge_count;
    bool failed; /* memory ran out */
};

/* Empty, with gravity -9.81 along z. */
void bench_world_make(bench_world *w, const bench_settings *settings, double step);
void bench_world_free(bench_world *w);

/* A moving body of this mass (kg, > 0) with this geom; takes the geom. */
dBodyID bench_add_body(bench_world *w, dGeomID geom, double mass, double x, double y, double z);
/* The geom touches bodies as a fingertip of w->material; where `body` is NULL it does not move. */
void bench_add_tip(bench_world *w, dGeomID geom, dBodyID body, double x, double y, double z);
/* A geom without a material that does not move. */
void bench_add_ground(bench_world *w, dGeomID geom);
/* A kinematic body that `drive` moves. */
dBodyID bench_add_driven(bench_world *w, double x, double y, double z);
/* A hinge between two bodies (0: the static world) that `drive` turns with this torque at rest. */
dJointID bench_add_hinge(bench_world *w, dBodyID body1, dBodyID body2, const double anchor[3], const double axis[3],
                         double torque);

/* Moves, loads and collides: everything before the contacts are handed over. */
void bench_prepare(bench_world *w);
/* The rest; returns the seconds it took, negative where the step failed. */
double bench_step(bench_world *w);

/*
 * How far the forces of the step just done are from the contact law, N. Of a normal force that is not what its spring
 * and damper give at the velocities the step ended with, the change that would mend this, the velocity that it brings
 * about included (a stiff spring's force alone is rounding magnified); of friction what exceeds mu times the normal
 * force (an ODE friction box counts by its corners). The largest of all contacts.
 */
double bench_residual(const bench_world *w);

#endif
