#ifndef PINCH_WORLD_H
#define PINCH_WORLD_H

#include "scenes/scene.h"

#include <ode/ode.h>
#include <pinch/ode.h>
#include <stdint.h>

/* A scene as an ODE world that can be stepped. It has a body for the object and one for every fingertip, and geoms for
 * the environment. Contacts are solved by Pinch or by ODE itself. dInitODE must have been called. A thread may step one
 * world at a time. */

/* The energy ledger of a run, in J since its start. Every line is the sum of its own forces and motions. `closure` is
 * what remains when all are added up, closure = kinetic + gravity + elastic - work_drives - work_external + friction +
 * damping + integrator. */
typedef struct energy_ledger {
    double kinetic;       /* change of the object and the tips on sliders since the start */
    double gravity;       /* minus the work of gravity on them */
    double elastic;       /* change of the energy stored in the contacts since the start */
    double work_drives;   /* of moving bases, slider forces, force control */
    double work_external; /* of the scene's force and torque and of base_acceleration */
    double friction;      /* lost to slip */
    double damping;       /* lost to contact dampers, drive dampers */
    double integrator;    /* lost to the time step (gained: < 0): implicit integration, moving contact points */
    double closure;
    double work_size; /* sum of |work| of all forces, which closure is compared with */
} energy_ledger;

/* A body with inertia, between the two ends of a step. */
typedef struct energy_body {
    dBodyID body;
    double kinetic_start;                    /* at the start of the run */
    double velocity[6], inertia[9], kinetic; /* at the start of the step */
} energy_body;

typedef enum world_solver { WORLD_PINCH = 0, WORLD_QUICKSTEP, WORLD_WORLDSTEP } world_solver;

typedef struct finger_sums finger_sums;

typedef struct world_settings {
    world_solver contact_solver;
    int quickstep_iterations;     /* default 20, ODE's own */
    pinch_solver_settings solver; /* WORLD_PINCH; from the scene */
    int faces;                    /* WORLD_PINCH: 0 for the exact cone, else of the linearized one; from the scene */
    bool manifolds;               /* ODE's own solvers get the points of Pinch's persistent manifolds; default false */
    int points; /* WORLD_PINCH, manifolds: the most points of a pair; default 8, see pinch_ode_settings */
    pinch_ode_recorder recorder; /* WORLD_PINCH: see pinch_ode_settings, these three; default none */
    void *recorder_context;
    bool record_all;
    bool cold_start; /* WORLD_PINCH: see pinch_ode_settings; default false */
} world_settings;

world_settings world_default_settings(const scene *s);

/* What a finger does at the end of a step, summed over its contact points. World frame; forces on the object. */
typedef struct world_finger_state {
    int points; /* contact points under load */
    pinch_contact_state state;
    double normal_force;        /* N */
    double force[3];            /* N */
    double tangential_force[3]; /* N */
    double torsional_moment;    /* N m about the finger's normal direction, of torsional friction */
    double moment[3];           /* N m about the object's centre of mass */
    double point[3];            /* m, force-weighted mean of the contact points; the last one while open */
    double elastic[3];          /* m, of the object against the tip */
    double slip[3];             /* m, sum of slip increments since touch-down */
    double slip_total;          /* m, path length of the slip over the run, see readout.c */
    double least_margin;        /* of its points, see world_least_margin */
    double stiffness;           /* N/m along the normal, of its points together; 0 where they do not tell */
    double peak_normal_force;   /* N */
} world_finger_state;

typedef struct world_finger {
    const scene_finger *finger;
    int hand;     /* 0: a finger of the scene; else its number, from 1, and the finger is a link against one object */
    int object;   /* that it touches */
    dBodyID body; /* the tip's body, kinematic, or dynamic on a slider; of a link the body that it is part of */
    dBodyID rail; /* kinematic body that carries a slider where the hand moves, else NULL */
    dGeomID tip;  /* NULL for a link, which may have several geoms */
    dJointID slider; /* NULL without one */
    dJointFeedback slider_feedback;
    energy_body energy; /* of a tip on a slider */
    double force;       /* force with which the drive pushes in this step, N */
    double push[3];     /* unit direction in which it pushes: the finger's normal now */
    world_finger_state state;
} world_finger;

/* A contact that collision detection has found, to be handed to the solver. */
typedef struct world_contact {
    dContact contact;
    dBodyID body[2];
    int owner;                              /* the finger that touches the object here, -1: any other pair */
    int sharing;                            /* points of the same pair in this step */
    const pinch_material *material, *other; /* of its geoms; `other` is NULL where one alone has any */
    dJointFeedback feedback;
} world_contact;

/* An object of the scene, and what touches it besides fingers, at the end of a step. */
typedef struct world_object {
    dBodyID body;
    dGeomID geom;
    pinch_material material; /* where the object has one, and where objects meet */
    energy_body energy;
    bool touched;               /* by the environment or another object */
    double force[3], moment[3]; /* of those, N; N m about its centre of mass */
} world_object;

/* A geom of a hand's link: which hand, from 1, and what it is in the hand's file. */
typedef struct world_hand_geom {
    int hand;
    const struct hand_geom *geom;
} world_hand_geom;

typedef struct world_pose {
    double position[3], orientation[4];
} world_pose;

typedef struct world world;
typedef struct world_hand world_hand; /* world_hand.h */

struct world {
    const scene *scene;
    world_settings settings;
    dWorldID ode;
    int body_count;
    dBodyID *bodies; /* all of them, in the order in which they were made */
    int object_count;
    world_object *objects;
    dBodyID object; /* the first */
    dGeomID object_geom;
    dJointID plane; /* dimension 2 */
    dJointGroupID contact_group;
    pinch_ode *plugin;    /* WORLD_PINCH */
    pinch_ode *manifolds; /* ODE's own solvers with settings.manifolds: keeps the points that ODE then solves */
    int finger_count;     /* the scene's fingers, then each hand's links, each against each object */
    world_finger *fingers;
    finger_sums *sums; /* of the read-out, per finger */
    int hand_count;
    world_hand *hands;
    int geom_count; /* the geoms that an object can touch: the tips, the environment's, the hands' */
    dGeomID *geoms;
    pinch_material *materials;   /* per geom */
    int *categories;             /* per geom: index of the finger, of a link against the first object; -1 environment */
    world_hand_geom *hand_geoms; /* per geom: of a hand, or hand = 0 */
    world_contact *contacts;
    int contact_count, contact_room;
    bool contacts_given; /* the next step takes the contacts of world_give_contacts */
    /* WORLD_PINCH: called in every step after the contacts are solved and before anything has moved; NULL: not called.
     */
    void (*observe)(void *context, const world *w);
    void *observe_context;

    bool diverged;         /* the last step was not taken, see WORLD_DIVERGED */
    bool no_memory;        /* the plugin had none for something that it was told: the world is not what it should be */
    world *next_abandoned; /* used by ode_guard.c */
    long steps;
    double time;            /* s */
    scene_loads loads;      /* of the step just done */
    double elastic_initial; /* J, stored in the contacts as the run begins */
    double elastic_before;  /* J, at the end of the last step */
    energy_ledger ledger;   /* WORLD_PINCH only */
    double depth_max;       /* m, over the run */
    double collide_s, solve_s,
        step_s;       /* wall time of the run in s: collision detection; the contact solve; handing over to emptying */
    long timed_steps; /* these are the times of so many steps: not of those before a run was resumed */
};

typedef enum world_status {
    WORLD_OK = 0,
    WORLD_NO_MEMORY,
    WORLD_DIVERGED /* a number was not finite, or soon would not be: the step was not taken */
} world_status;

/* `s` must outlive the world. On failure *w is NULL and `error` (256 bytes) says why. */
world_status world_create(const scene *s, const world_settings *settings, world **w, char *error);
void world_free(world *w);

/* Makes one step of the scene's length. WORLD_NO_MEMORY, WORLD_DIVERGED or WORLD_OK. */
world_status world_advance(world *w);

/* The next step takes these contacts (of geoms and bodies of this world) instead of detecting its own. Their feedback
 * holds the forces afterwards. Not for WORLD_PINCH. Returns false when memory runs out. */
bool world_give_contacts(world *w, const world_contact *contacts, int count);

/* The external force (N) and moment (N m about the centre of mass) on an object: gravity, base acceleration and load.
 */
void world_external_wrench(const world *w, int object, double force[3], double moment[3]);
/* The same of all that touches the object. */
void world_contact_wrench(const world *w, int object, double force[3], double moment[3]);

/* Returns a time of the run per step, in us; NaN where no step was timed. */
double world_us_a_step(const world *w, double seconds);

/* How the run was solved: converged when every step was solved and verified. */
pinch_solve_status world_solve_status(const world *w);

/* A link that has not touched its object in this run is not shown. */
bool world_finger_is_shown(const world_finger *finger);

/* What the scene says that the object is of; NULL where it says nothing. */
const pinch_material *world_object_material(const world *w, int object);

/* The part of its friction that a finger has left: 1 - |r_t| / (mu r_n), with the torsional part, of its forces added
 * up and the static coefficient. NAN where undefined. */
double world_slip_margin(const world *w, const world_finger *finger);

/* The same of the point that is nearest to slipping, whose limit is that of kinetic friction while it slips. A pad
 * whose points slip round about its middle has none left, though their forces add up to nothing. NAN where undefined.
 */
double world_least_margin(const world *w, const world_finger *finger);

/* How far the normal force (>= 0) has pressed the finger in, m: r_n / k_n with the finger's own stiffness, which
 * follows the depth under Hertz' law. */
double world_normal_displacement(const world *w, const world_finger *finger);

/* "pinch", "quickstep", "worldstep" */
const char *world_solver_name(world_solver solver);

/* FNV-1a over the bits of the final state: pose, velocities, fingertip poses and forces. */
uint64_t world_hash(const world *w);

/* Reports what the contact solver in use cannot express of the scene, one text at a time. */
void world_not_expressed(const world *w, void (*report)(void *context, const char *text), void *context);

/* Keeps in mind that a call of the plugin's found no memory. */
static inline void world_keep_status(world *w, pinch_status status)
{
    if (status == PINCH_OUT_OF_MEMORY) w->no_memory = true;
}

/* parts.c: NULL, or WORLD_NO_MEMORY, when memory runs out. */
dBodyID world_make_body(world *w, const double position[3], const double orientation[4]);
dGeomID world_make_geom(const scene_shape *shape);
pinch_material world_finger_material(const scene_finger *finger);
world_status world_add_geom(world *w, dGeomID geom, const pinch_material *material, int category);

/* kinematic.c: the angular velocity that turns orientation a into b in h seconds. */
void world_turning_velocity(const double a[4], const double b[4], double h, double w[3]);
/* A kinematic body gets the velocity that takes it there in h seconds, and is put exactly there at the end. */
void world_move_body(dBodyID body, const world_pose *from, const world_pose *to, double h);
void world_put_body(dBodyID body, const world_pose *pose);

/* collide.c: fills in the contacts of the step. */
world_status world_collide(world *w);

/* Two things of a scene, fingers left out, and how deep they were in each other when the last step began, m. */
typedef struct world_overlap {
    const char *first, *second; /* names; the scene's */
    double depth;
    bool fingers; /* both are tips of the scene's fingers */
} world_overlap;

/* The deepest of all but those of a finger's tip with something else than a tip. False where nothing touches. */
bool world_deepest_overlap(const world *w, world_overlap *deepest);

/* energy.c: called before and after the step that world_advance makes. */
void world_begin_ledger(world *w);
void world_update_ledger(world *w);
/* energy_body.c: the start of a step of a body with inertia, and what its motion over h seconds loses to the step. */
void energy_body_begin(energy_body *b, bool first);
double energy_body_integrator(const energy_body *b, double h);
/* Adds work to a line of the ledger. */
void ledger_add(energy_ledger *l, double *line, double work);
/* A body's inertia about its centre of mass in the world frame, kg m^2, row-major. */
void body_world_inertia(dBodyID body, double inertia[9]);
/* J */
double body_kinetic_energy(dBodyID body);

/* step_by_ode.c: stiffness, damping and friction of a contact as surface parameters of ODE's. */
void world_set_surface(const world *w, world_contact *c);
/* step_by_ode.c: solves and advances with ODE's own solvers. world_contact_room makes room for `count` contacts in all,
 * and returns false when memory runs out. */
world_status world_step_with_ode(world *w);

/* ode_guard.c: runs a step of the world. Where ODE gives up in it, the step ends with WORLD_DIVERGED and the world is
 * abandoned: it may be read, but not stepped any more, and world_free leaves it as it is. */
world_status world_guarded_step(world *w, world_status (*step)(world *w));
bool world_is_abandoned(const world *w);
/* dCloseODE, unless a world was abandoned. */
void world_close_ode(void);
bool world_contact_room(world *w, int count);

/* readout.c: fills the fingers' states at the end of a step. */
world_status world_read_fingers(world *w);
/* The object that a geom is, -1: none. */
int world_object_of(const world *w, dGeomID geom);
/* The finger that touches an object in this pair of geoms, -1 for any other pair. */
int world_finger_of_pair(const world *w, dGeomID geom1, dGeomID geom2);

#endif
