/* The plugin's own state: who lives where, and the stations a step goes through. */
#ifndef PINCH_PLUGIN_PLUGIN_H
#define PINCH_PLUGIN_PLUGIN_H

#include "util/block_pool.h"
#include "util/hash_index.h"
#include "joints/joint_pose.h"
#include "joints/hinge_reference.h"
#include "joints/joint_rows.h"
#include "util/key_map.h"
#include "contacts/manifold.h"
#include "util/workers.h"

#include <pinch/ode.h>

#include <string.h>
#include <threads.h>

/* A geom that has been in a contact or was given a material. Its index orders the geoms of a pair. */
typedef struct pinch_geom_record {
    dGeomID geom; /* NULL: forgotten */
    double size;  /* diagonal of its bounding box when first seen, m; infinite for a plane; < 0: not measured yet */
    int material; /* index, -1: none */
} pinch_geom_record;

/* Fingertips of one kind share it. */
typedef struct pinch_kept_material {
    pinch_material material;
    int users; /* geoms; 0: its place is free */
} pinch_kept_material;

/* Where a geom was, for those laws that its pose counts in. */
typedef struct pinch_seen_pose {
    double pose[12]; /* position and rotation (rows) in the last step it had a contact */
    long step;       /* that step */
    bool stays;      /* it had the same pose, to the bit, in the step before */
} pinch_seen_pose;

/* A pair of geoms in contact: geom[0] has the smaller record index. */
typedef struct pinch_pair {
    dGeomID id[2];
    dBodyID body[2];
    long handed_over;                   /* the step it was last handed over for */
    int first_taken, last_taken;        /* its contacts */
    uint16_t taken_count, taken_before; /* how many, in this step and in the last; dCollide finds no more */
    int step_body[2];                   /* its bodies in this step, -1: does not move by itself */
    bool same;         /* its contacts are those of the last step, to the bit, and nothing moves them */
    bool has_material; /* or its points have surface parameters of their own */
    bool updated;      /* false: no memory */
    int geom[2];       /* records */
    pinch_manifold manifold;
    int room;          /* points there is room for in the manifold's block */
    int island;        /* of this step */
    int laid_out;      /* points that the layout of islands has room for */
    int first_contact; /* of its points, among the contacts read out for this step */
    int first_core;    /* likewise among its island's */
} pinch_pair;

/* A contact as it was handed over. What comes in the same place in the next step mostly is the same one again. */
typedef struct pinch_taken_contact {
    double found[7]; /* position, normal, depth */
    int pair;
    int next;      /* of the same pair, -1: the last */
    int surface;   /* index of its surface parameters, -1: the pair has a material */
    int direction; /* index of the first friction direction that the program gave, -1: none */
    int joint;     /* index of the contact joint it came with, -1: none */
    int8_t point;  /* its place in the manifold, -1: none */
    bool swapped;  /* the pair's first geom is the contact's second */
} pinch_taken_contact;

/* A first friction direction as it was handed over. */
typedef struct pinch_direction {
    double tangent[3]; /* unit, world */
} pinch_direction;

/* A contact joint that the program made itself. */
typedef struct pinch_handed_joint {
    dJointID joint;
    dBodyID body[2]; /* as the program attached it */
    bool disabled;   /* while ODE steps */
} pinch_handed_joint;

/* A body under force control. */
typedef struct pinch_drive {
    dBodyID body;
    double axis[3], force;
    double speed; /* solved for in the last step, m/s */
} pinch_drive;

/* A body that takes part in this step as an unknown. */
typedef struct pinch_step_body {
    dBodyID body;
    int drive;                          /* index, -1: a dynamic body */
    int parent;                         /* union-find, then the island */
    int local;                          /* index among its island's bodies */
    int first_attached, attached_count; /* its joints, among `attached` */
    int handed; /* contact joints handed over that it has in this step, where it has many joints; otherwise 0 */
    /* of a solved island */
    double position[3]; /* at the start of the step */
    double wrench[6];   /* force and torque of its contacts; once it has been given them, those it came with */
    double velocity[6]; /* solved for; after ODE's step the mismatch: what ODE arrived at, less that */
    uint64_t rest_bits; /* of an island at rest: a checksum of its orientation and its weight */
} pinch_step_body;

typedef struct pinch_step_joint {
    dJointID joint;
    int body[2];              /* step bodies, -1: does not move by itself */
    int reference;            /* of a hinge, among the references; -1: of no hinge */
    bool exact;               /* see pinch_joint_rows */
    bool met;                 /* still there when its forces are handed over */
    int first_row, row_count; /* among its island's */
    bool applies;             /* its motors add forces of their own to those of its rows */
    double wrench[2][6];      /* of its rows, on the two bodies */
} pinch_step_joint;

/* A contact of an island that was left to ODE for this step: what force ODE found. */
typedef struct pinch_left_contact {
    dJointFeedback feedback;
    int contact; /* among the contacts read out */
    double sign; /* of the feedback's first force as a force on body 1 */
} pinch_left_contact;

typedef struct pinch_island {
    int first_body, body_count;
    int first_pair, pair_count; /* among pair_of */
    int first_contact, contact_count;
    int first_joint, joint_count; /* among joint_of */
    bool awake;                   /* has a body that is enabled, or touches one; otherwise it is left as it is */
    bool may_sleep;               /* ODE has to know what touches: a body is disabled, or may disable itself */
    /* how its solve ended */
    bool solved, first_try; /* at all; by the first solver asked */
    bool rests;             /* see rest.c */
    bool again;             /* nothing has changed: the answer of the last step is this one's */
    bool left_out;          /* its bodies are disabled while ODE steps: there is nothing to do for it */
    bool rows_hold;         /* the laws of all rows of its joints, for what was solved */
    bool takes_joints;      /* the forces of its joints are Pinch's, too */
    int row_count;          /* of its joints */
    uint64_t applied_bits;  /* a checksum of what its joints apply beside their rows, for what was filled in last */
    uint64_t joint_bits;    /* at rest: that, and their rows */
    pinch_status status;
    double mismatch[2]; /* largest, m/s and rad/s */
    double depth_max;
    pinch_step_result result;
} pinch_island;

/* A growing array: items, number in use, number there is room for. */
#define PINCH_LIST(type)                                                                                               \
    struct {                                                                                                           \
        type *items;                                                                                                   \
        int count, room;                                                                                               \
    }

/* Where a problem is written out: that of the island a thread is at, or those of all islands one behind the other. A
 * thread's lists count the most that was needed since pinch_scratch_review last looked. */
typedef struct pinch_desk {
    PINCH_LIST(pinch_body) bodies;
    PINCH_LIST(pinch_contact) contacts;
    PINCH_LIST(pinch_joint_row) rows; /* PINCH_JOINT_MAX_ROWS for each joint before the next island's begin */
} pinch_desk;

struct pinch_ode {
    dWorldID world;
    pinch_ode_settings settings;
    int threads;                          /* >= 1 */
    pinch_step_solver **solver;           /* one per thread */
    pinch_desk *desk;                     /* one per thread */
    pinch_desk kept;                      /* with settings.keep_islands, instead of the threads' */
    pinch_workers *workers;               /* NULL: one thread */
    dJointGroupID left;                   /* contacts left to ODE for this step */
    long step;                            /* the step that contacts are being handed over for */
    bool recount;                         /* the statistics were reset: islands at rest have not been counted yet */
    bool solved;                          /* pinch_ode_solve done, pinch_ode_advance not yet */
    bool at_once;                         /* the two follow each other: nobody can change a joint between them */
    long scratch_looked_at, scratch_span; /* see scratch.c: the step that was at, steps until the next */
    size_t scratch_missed;                /* bytes above which what was last given back is missed; 0: nothing was */
    long distrusted_until;                /* see distrust.c */
    long distrust_span;                   /* steps; 0: never yet */
    double last_h;                        /* of the step just done, s */
    double solved_h;                      /* of the step that is solved, s */
    bool places;                          /* pairs are where they were in the last step */
    bool layout;                          /* bodies and islands are those of the last step, as far as contacts tell */
    bool unchanged;         /* all contacts so far are those of the last step, to the bit, and nothing moves them */
    bool sleepers;          /* a body may sleep, or does */
    double world_values[7]; /* gravity, ERP, CFM, largest push-out velocity, surface layer */
    bool same_world;        /* they, and h, are as in the last step */
    bool poses_count;       /* a contact's law may depend on more of the geoms' poses than its own place */

    PINCH_LIST(pinch_geom_record) geoms;
    PINCH_LIST(pinch_kept_material) materials;
    int free_material;                 /* where the next free place is looked for first */
    PINCH_LIST(pinch_seen_pose) poses; /* of the geoms, where poses_count */
    pinch_item_index geom_index;
    PINCH_LIST(pinch_pair) pairs;
    pinch_item_index pair_index;
    pinch_block_pool points, own_laws;     /* of the pairs' manifolds */
    mtx_t blocks;                          /* held while a worker takes or gives back blocks */
    PINCH_LIST(pinch_taken_contact) taken; /* for this step so far */
    PINCH_LIST(pinch_direction) directions;
    PINCH_LIST(pinch_surface) surfaces; /* see surfaces.c */
    pinch_key_map surface_index;
    int surfaces_swept; /* how many there were when those that nobody has were last dropped */
    int last_surface;   /* asked for, -1: none */
    int taken_before,
        directions_before; /* the last step's, which are there as far as this step has not replaced them; -1: unknown */
    PINCH_LIST(pinch_handed_joint) handed;
    PINCH_LIST(pinch_drive) drives;
    pinch_item_index drive_index;
    pinch_joint_poses own_poses;
    pinch_joint_poses *joint_poses; /* those, or what somebody else notes */
    PINCH_LIST(pinch_joint_reference) references;
    pinch_item_index reference_index;

    /* of the step at hand */
    PINCH_LIST(pinch_step_body) bodies;
    pinch_item_index body_index;
    PINCH_LIST(pinch_step_joint) joints;
    pinch_item_index joint_index;
    PINCH_LIST(dJointID) attached; /* the enabled joints of all step bodies, body by body */
    bool all_modelled;             /* they have rows, or are disabled */
    PINCH_LIST(pinch_island) islands;
    PINCH_LIST(int) pair_of; /* the pairs that touch, island by island */
    PINCH_LIST(int) body_of; /* the step bodies likewise */
    PINCH_LIST(int) joint_of;
    PINCH_LIST(pinch_ode_contact) contacts;
    PINCH_LIST(pinch_left_contact) left_contacts;
    PINCH_LIST(int) order;                    /* scratch for sorting by island */
    PINCH_LIST(pinch_step_memory *) memories; /* island k of this step goes on with memory k of the last */

    pinch_ode_stats stats;
};

/* The k-th of an island's bodies and joints. */
static inline pinch_step_body *pinch_island_body(const pinch_ode *p, const pinch_island *island, int k)
{
    return &p->bodies.items[p->body_of.items[island->first_body + k]];
}

static inline pinch_step_joint *pinch_island_joint(const pinch_ode *p, const pinch_island *island, int k)
{
    return &p->joints.items[p->joint_of.items[island->first_joint + k]];
}

/* Is its velocity zero, to the bit? */
static inline bool pinch_body_stands(dBodyID body)
{
    static const double ZERO[3] = {0, 0, 0};
    return memcmp(dBodyGetLinearVel(body), ZERO, sizeof ZERO) == 0 &&
           memcmp(dBodyGetAngularVel(body), ZERO, sizeof ZERO) == 0;
}

/* Where the lists that have an index have their keys. */
static inline pinch_item_keys pinch_geom_keys(const pinch_ode *p)
{
    return PINCH_ITEM_KEYS(p->geoms, pinch_geom_record, geom);
}

static inline pinch_item_keys pinch_body_keys(const pinch_ode *p)
{
    return PINCH_ITEM_KEYS(p->bodies, pinch_step_body, body);
}

static inline pinch_item_keys pinch_joint_keys(const pinch_ode *p)
{
    return PINCH_ITEM_KEYS(p->joints, pinch_step_joint, joint);
}

/* The step body of an ODE body, -1: none. */
static inline int pinch_step_body_of(const pinch_ode *p, dBodyID body)
{
    return pinch_item_index_get(&p->body_index, pinch_body_keys(p), pinch_key_of_pointer(body));
}

/* Makes room for `count` items in all; false when memory ran out. */
bool pinch_list_reserve(void **items, int *room, int count, size_t item_size);
#define PINCH_RESERVE(list, n) pinch_list_reserve((void **)&(list).items, &(list).room, (n), sizeof *(list).items)

/* scratch.c */
bool pinch_desk_reserve(pinch_desk *desk, int bodies, int contacts, int rows); /* false: no memory */
void pinch_scratch_review(pinch_ode *p); /* after each step: gives back what has not been needed for a while */
size_t pinch_desk_bytes(const pinch_desk *desk);

/* settings.c: PINCH_INVALID_ARGUMENT for a NULL pointer or values out of range, PINCH_UNSUPPORTED for a solver that
 * cannot step */
pinch_status pinch_check_settings(const pinch_ode_settings *settings);

/* geoms.c */
int pinch_geom_record_of(pinch_ode *p, dGeomID geom); /* index, -1: no memory */
pinch_pose pinch_geom_pose(dGeomID geom);
/* NULL: it has none */
static inline const pinch_material *pinch_geom_material(const pinch_ode *p, const pinch_geom_record *record)
{
    return record->material < 0 ? NULL : &p->materials.items[record->material].material;
}
/* Has the geom of a record the pose, to the bit, that it had when last asked for, in the step before? One thread at a
 * time. */
bool pinch_geom_stays(pinch_ode *p, int record);
/* The material of a pair, and how much of the overlap lies between geom[0]'s surface and the contact: the part that
 * geom[0] gives, its part of the compliance, 0 where it has no material and is rigid; half between flat faces, see
 * placing.c. False when neither geom has a material. */
bool pinch_pair_material(const pinch_ode *p, const pinch_pair *pair, pinch_material *material, double *share);

/* hertz.c: secant stiffness of a pair at its depth, N/m; 0 where Hertz' law does not apply */
double pinch_hertz_stiffness(const pinch_ode *p, const pinch_pair *pair, double modulus);

/* taking.c */
/* joint: index of the contact's own joint, -1: none. *taken_over: Pinch will solve it. */
pinch_status pinch_take_contact(pinch_ode *p, const dContact *contact, dBodyID body1, dBodyID body2, int joint,
                                bool *taken_over);

/* surfaces.c: the index of a surface in the list, one that it may be tried first; -1: no memory. Indices that are kept
 * elsewhere than in taken contacts and own laws do not outlive it. */
int pinch_surface_index(pinch_ode *p, const pinch_surface *surface, int guess);

/* pairs.c */
int pinch_pair_between(pinch_ode *p, int geom0, int geom1); /* index, new pairs included; -1: no memory */
void pinch_pair_clear(pinch_ode *p, pinch_pair *pair);      /* ends its contact history */
bool pinch_pairs_update(pinch_ode *p);                      /* false: no memory */
/* Forgets the pairs that were not handed over for this step, or all of one geom (geom >= 0). */
void pinch_pairs_prune(pinch_ode *p, int geom);

/* complete.c: adds to a pair's fresh points what its collider is known to leave out, one at most; returns how many
 * there are */
int pinch_complete_points(const pinch_pair *pair, pinch_fresh_point *fresh, int count);

/* placing.c */
/* Two bodies with flat faces: their points stay where the collider puts them. */
bool pinch_place_as_found(const pinch_geom_record *a, const pinch_geom_record *b);
/* Moves a fresh point of a pair along its normal to half way through the overlap, wherever its collider put it; where
 * that cannot be told, it stays. */
void pinch_place_half_way(const pinch_geom_record *a, const pinch_geom_record *b, pinch_fresh_point *fresh);

/* handed.c: contact joints that the program made itself */
void pinch_handed_disable(pinch_ode *p); /* all of them */
void pinch_handed_settle(pinch_ode *p);  /* those of solved islands get their feedback, the others are ODE's again */
void pinch_handed_enable(pinch_ode *p);  /* all of them; none is handed over any more */

/*
 * joint_reference.c: *reference: index of what is known of a hinge, -1 for other joints; false: no memory. Then its
 * axis as pinch_joint_rows_of wants it, in axis2, NULL where that cannot be relied on. body: the joint's first; to read
 * the axis it is turned for a moment, and a kinematic one may belong to several islands: it is read at once, one of a
 * dynamic body by the thread that has its island.
 */
bool pinch_joint_reference_of(pinch_ode *p, dJointID joint, dBodyID body, int *reference);
const double *pinch_joint_reference_axis(pinch_ode *p, int reference, dBodyID body, double axis2[3]);
void pinch_joint_reference_keep_up(pinch_ode *p, const pinch_step_joint *joint); /* where it is not asked for */
bool pinch_joint_references_sweep(pinch_ode *p); /* forgets joints that nobody has asked for in a long time */

/* joint_forces.c: joints whose forces Pinch has found are given them, and disabled for ODE's step */
void pinch_give_joint_forces(pinch_ode *p, pinch_island *island, double h);
void pinch_take_joints_again(pinch_ode *p, const pinch_island *island); /* the same of the last step, without forces */
void pinch_enable_joints(pinch_ode *p, const pinch_island *island);

/* distrust.c */
/* Would it be left to ODE, whatever its solve came to? To be asked when its joints' rows have been filled in. */
bool pinch_joints_left_anyway(const pinch_ode *p, const pinch_island *island);
/* Is the island to be left to ODE, as its joints are? To be asked when it has been given its forces. */
bool pinch_joints_distrusted(const pinch_ode *p, const pinch_island *island, double h);
void pinch_judge_joints(pinch_ode *p, const pinch_island *island, double h); /* after ODE's step */

/* step.c: pinch_ode_solve for one who lets nobody at the world before pinch_ode_advance */
pinch_status pinch_solve_at_once(pinch_ode *p, double h);

/* rest.c */
/* Has nothing moved in the step, but for rounding? To be asked before the answer is read out. */
bool pinch_island_rests(const pinch_ode *p, const pinch_island *island, double h, const pinch_problem *problem);
void pinch_bring_to_rest(pinch_problem *problem);                /* the answer of an island at rest */
void pinch_hold_still(pinch_ode *p, const pinch_island *island); /* instead of the forces it was given */
void pinch_brake(pinch_ode *p, const pinch_island *island);      /* its velocities are zero */
/* Is it as in the last step, and at rest there? */
bool pinch_island_same(pinch_ode *p, int worker, pinch_island *island, double h);
void pinch_settle_poses(const pinch_ode *p, const pinch_island *island); /* after ODE's step; one thread at a time */
void pinch_rest_on(pinch_ode *p, pinch_island *island);                  /* gives the answer of the last step again */
void pinch_take_in(const pinch_ode *p, pinch_island *island);            /* after ODE's step, or where there is none */
bool pinch_stayed(const pinch_ode *p, const pinch_island *island);       /* at rest after ODE's step, too? */

/* history.c: after ODE's step */
void pinch_carry_history(pinch_ode *p, pinch_island *island, double h);

/* gather.c: who takes part in the step, the islands they form, and where their data go */
bool pinch_gather(pinch_ode *p); /* false: no memory */

/* body_joints.c: tells a body how many of its joints are contacts that were handed over; counted: false at first, the
 * same for all bodies. Then the first of its joints to look at for those that are not. Contact joints that were handed
 * over are disabled by then. */
void pinch_count_handed(pinch_ode *p, pinch_step_body *body, bool *counted);
int pinch_first_joint(const pinch_step_body *body);

/* drives.c */
int pinch_drive_of(const pinch_ode *p, dBodyID body); /* index, -1: none */
/*
 * Does a solved answer have a driven finger go farther in the step than it, or what it touches, is large? Where a
 * normal turns away from a finger's axis, what presses along the axis grows without bound, and the finger, which has no
 * inertia, flies after it: the contact of the start of the step says nothing about that.
 */
bool pinch_drives_run_away(const pinch_ode *p, const pinch_island *island, double h);

/* layout.c: is the layout that of the last step? Then there is nothing to gather. */
bool pinch_layout_holds(pinch_ode *p);
/* Something was changed by hand: whatever comes is new. */
void pinch_expect_nothing(pinch_ode *p);

/* Island by island, each by one thread: bodies.c its bodies, contacts.c its contacts, island_joints.c the rows of its
 * joints and what they came to, island.c all of it, solved and read out on one of the desks. */
void pinch_fill_bodies(pinch_ode *p, const pinch_island *island, double h, pinch_body *bodies);
void pinch_give_forces(pinch_ode *p, const pinch_island *island); /* of a solved one; drives their speeds */
void pinch_restore_forces(const pinch_step_body *body);           /* those it came with */
void pinch_take_back_forces(pinch_ode *p, const pinch_island *island);
void pinch_stop_drives(pinch_ode *p, const pinch_island *island);   /* back to the motion that their owner prescribed */
void pinch_apply_external(pinch_body *bodies, int count, double h); /* the forces on them into their velocities */
void pinch_fill_contacts(const pinch_ode *p, const pinch_island *island, double h, pinch_contact *contacts);
/* What motors add by themselves goes to the bodies' external forces. */
void pinch_fill_joints(pinch_ode *p, pinch_island *island, double h, pinch_problem *problem);
void pinch_joint_applied(const pinch_ode *p, const pinch_step_joint *joint, double h, double applied[2][6]);
void pinch_read_joints(pinch_ode *p, pinch_island *island, const pinch_problem *problem);
uint64_t pinch_joint_bits(const pinch_island *island, const pinch_joint_row *rows, int count);
void pinch_solve_island(pinch_ode *p, int worker, pinch_island *island, double h);

/* left.c: the last resort for an island and one step, its points as ODE contact joints; false: no memory */
bool pinch_leave_island(pinch_ode *p, const pinch_island *island, double h);
void pinch_read_left_contacts(pinch_ode *p); /* the forces that ODE found for them */

#endif
