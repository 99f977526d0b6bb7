#ifndef PINCH_WORLD_HAND_H
#define PINCH_WORLD_HAND_H

#include "hands/hand.h"
#include "world.h"

#include <jansson.h>

/* A hand in a world: a kinematic base, and a body and a joint of ODE's for every joint of the hand. */

/* A joint of the hand with the body that it moves. Where a link hangs on several joints, and where a body of the file
 * has no mass, the bodies between them get a hundredth of the mass that moves with them. */
typedef struct world_joint {
    const hand_joint *of;
    char *name;                   /* its own; with several hands HAND/JOINT, as links are called */
    const scene_control *control; /* its own */
    dJointID joint;               /* a hinge or a slider; body 1 is the outer one */
    dBodyID body, parent;
    double centre[3];                         /* of mass, in the frame of the link as this joint has moved it */
    double relieved;                          /* kg of its body whose weight is taken off, */
    double relief[3];                         /* and their centre from that of the body, in the body's axes; */
    double relief_force[3], relief_torque[3]; /* what takes it off in this step, N and N m about the body's centre */
    double zero;                              /* the hand's position where ODE's is 0 */
    int damper;                               /* coupling that is its spring, damper and armature; -1: none */
    dJointID motor;                           /* the same by ODE; NULL: none */
    bool moved;                               /* has it been away from its limits? */
    dJointFeedback feedback;
    energy_body energy;
    double row[2][6]; /* rate of the joint = row[0] . twist of body + row[1] . twist of parent; in this step */
    double storage,
        storage_start; /* J in spring and armature, at the end of the last step and at the start of the run */

    /* at the end of the step */
    double position, velocity; /* rad or m */
    double start_position;     /* at the start of the step */
    double target;             /* of its control */
    double pushed;             /* N m or N: the part of its own control that is no servo's, in this step */
    double own_torque, torque; /* N m or N: of its own control, and with what tendons add that drive it */
    bool at_limit, saturated;
} world_joint;

/* A tendon with what drives it, a tie between joints (mimic), a tendon's own spring and friction, or what drives a
 * joint or a tendon besides its first drive. */
typedef struct world_tie {
    int coupling;
    int tendon; /* -1: a rigid tie, or a further drive of a joint */
    int terms;
    int joint[SCENE_TENDON_JOINTS];
    double factor[SCENE_TENDON_JOINTS];
    double offset; /* of the hand's x against that of the coupling */
    pinch_servo law;
    const scene_control *control; /* NULL: none */
    bool is_further;              /* a drive of what has another one */
    double pushed;                /* the part of its control's force that is no servo's, in this step */
    double position, force;       /* x at the start of the step, and the force in it */
    bool dissipates, is_friction; /* a damper; dry friction, which holds x where it is */
} world_tie;

typedef struct world_loop {
    dJointID ball;
    dJointFeedback feedback;
} world_loop;

struct world_hand {
    const scene_hand *hand;
    dBodyID base;
    int joint_count;
    world_joint *joints; /* as the model has them */
    int tie_count;
    world_tie *ties;
    int loop_count;
    world_loop *loops;     /* those between two bodies */
    int first_finger;      /* its links' places in the world's fingers; as many for each link as there are objects */
    dBodyID *body;         /* of each body of the model */
    const double **centre; /* of mass of that body, in its frame */
};

/* hand_build.c: the shape of a geom that collides, of which vertices stay the model's. */
scene_shape world_hand_shape(const hand *model, const hand_geom *g);
/* hand_build.c: adds hand `index` of the scene, its geoms and its links as fingers. */
world_status world_add_hand(world *w, int index);
void world_free_hands(world *w);
/* m: the largest distance of two anchors that should be one; 0 without loops. */
double world_loop_gap(const world_hand *hand);
/* hand_rows.c: writes one text for each thing that the solver in use does not express. */
void world_hand_not_expressed(const world *w, void (*report)(void *context, const char *text), void *context);

/* hand_rows.c: springs, dampers, friction, mimics and tendons of a hand that has its joints. */
world_status world_add_hand_rows(world *w, world_hand *hand);

/* hand_drive.c: is the control a servo, a row of Pinch's? Else its force is known without one. */
bool world_control_is_servo(const scene_control *control);
/* Is the force of a control at one of its bounds? */
bool world_control_is_saturated(const scene_control *control, double force);
/* hand_drive.c: what damps a joint where ODE solves it, N m s/rad or N s/m. */
double world_ode_damping(const world_joint *joint);
/* hand_drive.c: the bases at the start of a step that ends at t1, the drives of the step; the bases at its end. */
void world_move_hand_bases(world *w, double t0, double t1);
void world_drive_hands(world *w, double t1);
void world_put_hand_bases(world *w, double t1);
/* The force (N) that takes weight off a joint's body in this gravity, and the point (world, m) that it acts at. */
void world_relief(const world_joint *joint, const double gravity[3], double force[3], double point[3]);
/* The rate of a joint (rad/s or m/s) by its rows, which are those of the start of the step. */
double world_joint_rate(const world_joint *joint);
/* Reads what the joints do at the end of a step. */
void world_read_joints(world *w);

/* hand_document.c: the name in the scene of what a hand calls so, see world_joint; NULL when memory runs out. */
char *world_name_of_hand(const world *w, const world_hand *hand, const char *name);
/* What joints and ties do. */
json_t *world_joint_documents(const world *w);
json_t *world_tie_documents(const world *w);

/* hand_energy.c: the part of hands in the ledger. */
void world_begin_hand_ledger(world *w, bool first);
void world_update_hand_ledger(world *w);

#endif
