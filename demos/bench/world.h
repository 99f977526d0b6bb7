/*
 * A plain ODE program whose contact solver can be chosen, as the benchmarks of steps run it. It detects collisions
 * first and keeps the contacts. The contact part of a step is the solver's: from the first contact handed over to the
 * end of the step and the emptying of the contact group. The whole step has the collision detection, too.
 */
#ifndef PINCH_BENCH_WORLD_H
#define PINCH_BENCH_WORLD_H

#include <pinch/ode.h>
#include <stdbool.h>

typedef enum bench_solver { BENCH_PINCH = 0, BENCH_QUICKSTEP, BENCH_WORLDSTEP, BENCH_SOLVERS } bench_solver;

/* How a world is to be run. */
typedef struct bench_settings {
    bench_solver solver;
    bool cold;      /* Pinch starts without the last step's forces and factors */
    bool watched;   /* Pinch keeps its islands, and the world's `watch` is called between solve and ODE's step */
    int iterations; /* of quickstep; 0: 20, ODE's own */
    int threads;    /* >= 1, of Pinch; ODE's own thread pool makes many small islands several times slower, so it is not
                       used */
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
    pinch_material material; /* the material of all fingertips */
    double step;             /* s */
    double time;             /* s */
    int steps;
    bench_contact *contacts;
    int contact_count, contact_room;
    int body_count;
    dBodyID *bodies; /* bodies that are not kinematic */
    int finger_count;
    dGeomID *geoms; /* in the order in which they were added */
    int geom_count;
    void (*watch)(void *context, bench_world *w); /* NULL: nobody looks */
    void *watch_context;
    void (*drive)(bench_world *w); /* called before each step for motions and forces; NULL: nothing is driven */
    dBodyID *driven;               /* the bodies that `drive` moves */
    int driven_count;
    dJointID *hinges;
    double *torques; /* of the hinges at rest, N m */
    int hinge_count;
    bool failed; /* memory ran out */
};

/* Makes an empty world with gravity -9.81 along z. */
void bench_world_make(bench_world *w, const bench_settings *settings, double step);
void bench_world_free(bench_world *w);

/* Adds a moving body of this mass (kg, > 0) with this geom, which the world then owns. */
dBodyID bench_add_body(bench_world *w, dGeomID geom, double mass, double x, double y, double z);
/* Makes the geom a fingertip of w->material. Where `body` is NULL it does not move. */
void bench_add_tip(bench_world *w, dGeomID geom, dBodyID body, double x, double y, double z);
/* Adds a geom without a material that does not move. */
void bench_add_ground(bench_world *w, dGeomID geom);
/* Adds a kinematic body that `drive` moves. */
dBodyID bench_add_driven(bench_world *w, double x, double y, double z);
/* Adds a hinge between two bodies (0: the static world), which `drive` turns with this torque at rest. */
dJointID bench_add_hinge(bench_world *w, dBodyID body1, dBodyID body2, const double anchor[3], const double axis[3],
                         double torque);

/* Moves the driven bodies, applies loads and detects collisions: everything before the contacts are handed over.
 * Returns the seconds of collision detection, whose pairs ODE's solvers have from dSpaceCollide, and Pinch from
 * pinch_ode_each_pair. */
double bench_prepare(bench_world *w);
/* Makes the rest of the step. Returns the seconds it took, or a negative number when the step failed. */
double bench_step(bench_world *w);
/* Makes a step by Pinch in which its threads share the collision detection, too: does what bench_prepare and bench_step
 * do. The time includes it. */
double bench_whole_step(bench_world *w);

/*
 * residual.c: how far the forces of the step just done are from the contact law, in N; the largest error of a contact.
 * The error of a normal force is the change of it that would make it equal to what its spring and damper give. The
 * velocity that this change brings about is included, because a stiff spring's force alone is rounding magnified. The
 * error of friction is what exceeds mu times the normal force, so ODE's friction box errs at its corners.
 */
double bench_residual(const bench_world *w);

/* side_by_side.c: gives one world the state of another that was built alike. Contact histories are not copied. */
void bench_copy_state(const bench_world *from, bench_world *to);

/* worlds.c: the worlds of the benchmarks, by size. */

/* One object held by n >= 2 fingertips that do not move: 2 pinch a capsule, 3 to 9 hold a cube, more hold a ball. */
void bench_build_object(bench_world *w, int n);
/* n cubes of 50 mm, held by five fingertips each. */
void bench_build_hands(bench_world *w, int n);
/* The same, carried up and down, so that nothing is ever at rest. */
void bench_build_carried(bench_world *w, int n);
/* n balls in hands of five fingers with three hinges each, and torques at the hinges. */
void bench_build_articulated(bench_world *w, int n);
/* n cubes between four fingertips each, which rub to and fro faster than they can stick. */
void bench_build_slip(bench_world *w, int n);
/* n bricks in a wall, n boxes or n spheres on a heap in a pit. The contacts are as stiff as ODE's defaults. */
void bench_build_wall(bench_world *w, int n);
void bench_build_boxes(bench_world *w, int n);
void bench_build_spheres(bench_world *w, int n);
/* n boxes in a pyramid, each on two below it, 4 mm beside its neighbours or touching them without load. */
void bench_build_pyramid(bench_world *w, int n);
void bench_build_touching(bench_world *w, int n);

#endif
