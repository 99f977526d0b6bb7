/*
 * The joint store: the joints that take part in a step, and what is known of joints beyond ODE's getters.
 */
#ifndef PINCH_JOINTS_JOINT_STORE_H
#define PINCH_JOINTS_JOINT_STORE_H

#include "bodies/step_bodies.h"
#include "contacts/contact_store.h"
#include "joints/coupling.h"
#include "joints/hinge_reference.h"
#include "joints/joint_aside.h"
#include "joints/joint_pose.h"
#include "joints/joint_rows.h"
#include "joints/servo.h"

/* The forces of a joint's rows with compliance or bounds in the last step that found them; 0 for others. */
typedef struct pinch_row_forces {
    dJointID joint;
    int count; /* of its rows; 0: nothing is known */
    double force[PINCH_JOINT_MAX_ROWS];
} pinch_row_forces;

/* An enabled joint on a step body. */
typedef struct pinch_attached_joint {
    dJointID joint;
    int hint; /* where it was found among the step joints last */
} pinch_attached_joint;

/* A joint with rows that ties bodies of an island. What a step at rest looks at comes first. */
typedef struct pinch_step_joint {
    dJointID joint;
    int body[2];                          /* step bodies, -1: does not move by itself */
    int pose, servos;                     /* hints: where its pose and its servos were found last */
    int reference;                        /* index of a hinge's reference, -1 for other joints */
    bool exact;                           /* see pinch_joint_rows */
    bool found;                           /* on a body of its island, when its forces are handed over */
    pinch_range rows;                     /* among its island's */
    double closing[PINCH_JOINT_MAX_ROWS]; /* the part of each row's rhs that takes an error of position back */
    int servo_rows;                       /* the last of its rows are those of its servos */
    pinch_row_forces forces;              /* which the next solve begins with */
    pinch_axis_reading reading;           /* what its rows have read of it in this step */
    unsigned drives;                      /* bit k: pinch_row_may_drive row k */
    bool may_give_energy;   /* rows besides those of `drives` may ask for more than to take errors of position back */
    bool motors_add_wrench; /* its motors add forces of their own to those of its rows */
    double wrench[2][6];    /* of its rows, on the two bodies: its feedback */
    double given[2][6];     /* what the bodies get for them */
    pinch_joint_aside aside;
    double erp[3]; /* its own and those of its stops, while ODE solves it more slowly: see joint_pace.c */
} pinch_step_joint;

enum { PINCH_STEP_JOINT_AT_REST = offsetof(pinch_step_joint, exact) };

/* The joints of one island. */
typedef struct pinch_island_joints {
    pinch_range range;     /* of the list by_island */
    pinch_range couplings; /* of the list couplings.by_island */
    pinch_range room;      /* for its rows, where the problems of all islands stay */
    int row_count;         /* those of joints, and behind them those of couplings */
    int joint_rows;
    bool loops_known;        /* since the islands were built: */
    bool loops;              /* they close loops */
    double error;            /* m: the largest of the joints, see pinch_joint_rows */
    double error_angle;      /* rad */
    bool includes_couplings; /* what the joints give to the bodies includes the forces of couplings */
    bool rows_hold;          /* what was solved for satisfies the laws of all rows */
    bool put_energy_in;      /* what was solved for gets more energy from joints than they may put in */
    double energy, work;     /* J: what they may put in in this step, and what they have put in */
    double saved;            /* J: what they have taken out less what they have put in; see energy_account.c */
    double closing_work;     /* J: what it takes to close them in a step as ODE asks for */
    double lifting;          /* J: what they may put in besides, as what comes back has to be lifted; 0: not needed */
    double overdraft;        /* J: part of `energy` that they have not taken out yet */
    double pace;             /* at which errors of position are taken back, as a multiple of what ODE asks for */
    bool slowed;             /* ODE solves them in this step, and takes errors back at that pace */
    double kinetic;          /* J: in that case, what the bodies have before the step */
    bool torn;     /* since bodies turned far in a step, or contacts gave way to joints, errors may be large */
    bool by_pinch; /* the joints' forces are those of Pinch's solve, and ODE does not see the joints */
    bool alone;    /* then: ODE sees no joints on the bodies at all, as nobody can have added one since */
    bool ties_no_kinematic_body; /* they are known to tie no kinematic body */
    bool skipped_by_ode;         /* ODE does not come to them in this step, although they are enabled */
    uint64_t applied_bits; /* a checksum of what the joints applied beside their rows when these were last computed */
    uint64_t rest_bits;    /* at rest: a checksum of that, and of the rows */
    uint64_t rest_inputs;  /* at rest: a checksum of what the rows are computed from, in poses that stay */
    bool inputs_known;     /* rest_inputs tells whether the rows are the same; otherwise only the rows do */
} pinch_island_joints;

typedef struct pinch_joint_store {
    pinch_step_joint *items;
    int count, room;
    pinch_item_index index;
    struct {
        pinch_row_forces *items;
        int count, room;
        pinch_item_index index;
    } forces;                  /* scratch: those of the step joints before, while joints are collected anew */
    PINCH_LIST(int) by_island; /* indices of step joints, island by island */
    PINCH_LIST(pinch_attached_joint) attached; /* the enabled joints of all step bodies, body by body */
    bool all_modelled;                         /* each of those has rows */
    bool no_kinematic_hinges;                  /* since joints were collected, it is known that there are none */
    int row_room;                              /* for the rows of all islands */

    pinch_hinge_references references;
    pinch_joint_poses own_poses;
    pinch_joint_poses *poses; /* own_poses, or those that the drop-in layer notes */

    pinch_servos servos;
    pinch_couplings couplings;
} pinch_joint_store;

void pinch_joint_store_free(pinch_joint_store *store);
size_t pinch_joint_store_bytes(const pinch_joint_store *store);

/* Of the memory that ODE has a joint in: what ODE's list goes through; what tells the joint's bodies and whether it is
 * enabled; all that a step reads. */
enum { PINCH_JOINT_IN_LIST = 36, PINCH_JOINT_TIES = 104, PINCH_JOINT_BYTES = 400 };

/* Asks ahead for what a step reads of a joint. What all joints have comes first, and then what a hinge has besides. */
static inline void pinch_prefetch_joint(dJointID joint)
{
    pinch_prefetch(joint, PINCH_JOINT_BYTES);
}

/* Returns the k-th joint of an island. */
static inline pinch_step_joint *pinch_island_joint(const pinch_joint_store *store, const pinch_island_joints *joints,
                                                   int k)
{
    return &store->items[store->by_island.items[joints->range.first + k]];
}

/* Returns the k-th coupling of an island. */
static inline pinch_coupling *pinch_island_coupling(const pinch_joint_store *store, const pinch_island_joints *joints,
                                                    int k)
{
    return &store->couplings.items[store->couplings.by_island.items[joints->couplings.first + k]];
}

/* Returns the index of a joint in the step, -1 where it takes no part. *hint: as for pinch_item_index_find. */
int pinch_step_joint_of(const pinch_joint_store *store, dJointID joint, int *hint);

/*
 * Adds the bodies of couplings, finds the joints of all step bodies, and adds the bodies at their other ends, until no
 * more come. Contact joints that
 * Pinch solves must be disabled by then. Counts the joints that have no rows. Returns false when memory runs out.
 */
bool pinch_collect_joints(pinch_joint_store *store, pinch_step_bodies *bodies, const pinch_contact_store *contacts,
                          long step, long *unmodelled);

/* Tells whether the enabled joints of all bodies are those that the last step found, between the same bodies, and each
 * of them has rows, and whether all bodies take part in the step as they did in the last. */
bool pinch_same_joints_and_bodies(const pinch_joint_store *store, pinch_step_bodies *bodies,
                                  const pinch_contact_store *contacts);
/* Follows hinges on kinematic bodies through a step that does not collect joints. */
void pinch_update_kinematic_hinges(pinch_joint_store *store, long step);

/* Forgets a joint: what ODE puts in the same place of memory is another one. The caller has joints collected
 * anew. */
void pinch_joint_store_forget_joint(pinch_joint_store *store, dJointID joint);

/* Returns the index of the first of a body's joints in ODE's list that may be no contact joint of Pinch's. */
int pinch_first_joint(const pinch_step_body *body);

#endif
