/*
 * The island graph: the bodies of a step, and the islands that contacts and joints tie them into. Each island is solved
 * by itself.
 */
#ifndef PINCH_ISLANDS_ISLAND_GRAPH_H
#define PINCH_ISLANDS_ISLAND_GRAPH_H

#include "bodies/step_bodies.h"
#include "contacts/contact_store.h"
#include "joints/joint_rows.h"
#include "joints/joint_store.h"

/* What becomes of an island in a step. README.md of this room has a picture. The order counts: from SOLVED on it has an
 * answer of Pinch's, from RESTING on it does not move. */
typedef enum pinch_island_phase {
    PINCH_ISLAND_ASLEEP,   /* all of its bodies are disabled, and nothing that moves touches them: left as it is */
    PINCH_ISLAND_AWAKE,    /* to be solved */
    PINCH_ISLAND_LEFT,     /* it has no contacts, and ODE solves its joints just as exactly: left as it is */
    PINCH_ISLAND_FALLBACK, /* it has no answer that could be given to ODE: ODE's own contacts solve it */
    PINCH_ISLAND_SOLVED,   /* it has a verified answer, or one of sweeps, and moves */
    PINCH_ISLAND_RESTING,  /* it has a verified answer whose motions are rounding: its velocities become zero */
    PINCH_ISLAND_REUSED    /* it rested in the last step and nothing has changed: that step's answer is this one's */
} pinch_island_phase;

typedef struct pinch_island {
    pinch_range bodies;    /* of bodies.by_island */
    pinch_range pairs;     /* of the contact store's pairs_by_island */
    pinch_range contacts;  /* among all contacts, island by island */
    pinch_range kinematic; /* of the list kinematic.by_island: those that are its own */
    pinch_island_joints joints;
    pinch_island_phase phase;
    pinch_status status;     /* of its solve: whether that was legal */
    bool shared;             /* it is so large that all threads share its loops */
    bool may_sleep;          /* a body is disabled or may disable itself: ODE has to know what touches */
    bool kept_awake;         /* something in it moves or may move that does not go to sleep */
    bool falls_asleep;       /* in this step, if that comes to an end */
    bool sweeps_alone;       /* in this step it is swept without a try */
    bool tried;              /* a solver has worked on it in this step: `result` says how its last one ended */
    bool first_solve_failed; /* the solver asked for did not solve it, whatever solved it later */
    bool skipped_by_ode;     /* reused, and its bodies are disabled while ODE steps, as there is nothing to do */
    bool moved_by_pinch;     /* bodies of it may be: only then each tells whether it is */
    int aside;               /* bodies of it, kinematic ones included, that are disabled while ODE steps */
    int drive_rows;          /* of its problem, behind those of joints: see drive_limits.c */
    int drives_at_limit;     /* driven fingers that went as fast as such a row lets them */
    bool pushes;             /* it has hard contacts, which push_out.c judges */
    double push_balance;     /* J: what these have taken out and not put in again, before and after its solve */
    double push_limit;       /* J: what they may put in */
    double push_pace;     /* the part of what overlaps ask for that they got in the last step, or with joints may get */
    double push_work;     /* J: what they have put in in the last solve; negative: taken out */
    double push_change;   /* J: by how much that lowers their balance */
    double push_spare;    /* J: what lifting bodies out of each other allows besides, and they have not put in */
    double surface_limit; /* J: what surfaces that move may put in */
    double mismatch[2];   /* largest, m/s and rad/s */
    double depth_max;
    pinch_step_result result;
} pinch_island;

/* A contact of an island in fallback, which ODE solves as a contact joint. */
typedef struct pinch_fallback_contact {
    dJointFeedback feedback; /* the force that ODE finds */
    int result;              /* index among the contact store's results */
    double sign;             /* of the feedback's first force as a force on body 1 */
} pinch_fallback_contact;

/* A body whose island went wrong. Until the step `until`, islands with it are swept or go to ODE: those with at least
 * `size` contacts and joints, or at least `size` joints where joints were the cause. Where the island was swept, others
 * with the body are swept as well, but do not go to ODE for that. */
typedef struct pinch_backed_off {
    dBodyID body;
    long until, span;
    int size;
    bool joints, swept;
} pinch_backed_off;

/* See backoff.c. */
typedef struct pinch_backoff {
    pinch_backed_off *items;
    int count, room;
    pinch_item_index index; /* by body */
    long dropped_step;      /* the step in which bodies were dropped last */
} pinch_backoff;

/* What joints and hard contacts may put into a body, and the pace at which joints close. */
typedef struct pinch_joint_account {
    dBodyID body;
    double energy, pace;   /* J, at the end of the last step with joints; to begin the next with */
    double saved;          /* J: see energy_account.c; negative: a debt */
    double push;           /* J, of hard contacts; see push_out.c */
    double push_pace;      /* at which they begin the next step, if they were slowed in the step before */
    long push_slowed_step; /* the number of that step, if they ever were */
    bool torn;             /* see pinch_island_joints */
    long seen;             /* the number of the last step with joints or a push */
} pinch_joint_account;

/* See energy_account.c. */
typedef struct pinch_joint_accounts {
    pinch_joint_account *items;
    int count, room;
    pinch_item_index index; /* by body */
} pinch_joint_accounts;

/* How long a body that may go to sleep has been slow. */
typedef struct pinch_idle_body {
    dBodyID body;
    int steps;             /* in a row, since there has been a mean */
    double time;           /* s, of these steps */
    double linear[3];      /* m/s, rad/s: sums of velocities since the last mean of them was taken */
    double angular[3];     /* likewise */
    int samples;           /* that have been summed up */
    double push[6];        /* N, N m: what acted on it in the last step */
    bool has_mean;         /* since it was fast, a mean has been taken */
    int patience;          /* >= 1; it waits that many times as long as asked for */
    bool was_put_to_sleep; /* in the last step */
    long seen;             /* the number of the last step with it */
} pinch_idle_body;

/* The thresholds of a body (m/s, rad/s) below which ODE disables it. */
typedef struct pinch_sleep_thresholds {
    dBodyID body;
    double linear, angular;
} pinch_sleep_thresholds;

enum { PINCH_MOST_PATIENCE = 1 << 20, PINCH_MOST_IDLE_STEPS = 1 << 30 };

/* See sleep.c. */
typedef struct pinch_sleep {
    pinch_idle_body *items;
    int count, room;
    pinch_item_index index;                  /* by body */
    bool by_ode;                             /* ODE decides in this step */
    PINCH_LIST(pinch_sleep_thresholds) held; /* while ODE steps: what it will have again after that */
} pinch_sleep;

/* A kinematic body that islands touch, or that joints tie to them, and no drive moves. It belongs to the first of
 * them. */
typedef struct pinch_kinematic_body {
    dBodyID body;
    int island;
    bool shared;   /* others touch it as well, or are tied to it */
    dJointID tie;  /* where nothing touches it: the first joint that ties it to its island; NULL: it is touched */
    int side;      /* of that joint */
    bool by_pinch; /* Pinch moves it in this step, and it is disabled while ODE steps */
} pinch_kinematic_body;

typedef struct pinch_kinematic_bodies {
    pinch_kinematic_body *items;
    int count, room;
    pinch_item_index index;
    PINCH_LIST(int) by_island;
    bool laid_out; /* for the islands that there are */
} pinch_kinematic_bodies;

/* What a pair was in the last step. */
typedef struct pinch_pair_before {
    int island;       /* -1: it was of none */
    int points;       /* of its manifold */
    int first_result; /* as pinch_pair */
    int step_body[2]; /* likewise */
    bool carried;     /* its island goes on as it was */
} pinch_pair_before;

/* Scratch while islands are built: those of the last step, where one of them rested. See carried_rest.c. */
typedef struct pinch_islands_before {
    PINCH_LIST(pinch_pair_before) pairs; /* in the order in which the contact store has them now */
    PINCH_LIST(pinch_island) islands;
    PINCH_LIST(pinch_step_body) bodies;
} pinch_islands_before;

typedef struct pinch_island_graph {
    pinch_island *items;
    int count, room;
    pinch_step_bodies bodies;
    pinch_kinematic_bodies kinematic;
    bool sleepers;                            /* a body sleeps or may sleep */
    PINCH_LIST(dBodyID) handed;               /* bodies whose joints take part in this step, with contacts or without */
    PINCH_LIST(dBodyID) handed_when_built;    /* in the step that built the islands */
    PINCH_LIST(pinch_step_memory *) memories; /* island k of this step goes on with memory k of the last */
    PINCH_LIST(int) roots;                    /* scratch: each body's representative */
    PINCH_LIST(pinch_fallback_contact) fallback_contacts;
    pinch_islands_before before;
    pinch_backoff backoff;
    pinch_joint_accounts accounts;
    pinch_sleep sleep;
} pinch_island_graph;

enum { PINCH_DRIVE_ROWS = 2 }; /* of a driven finger: one for each way */

/* Returns how many rows the problems of islands with so many joints and bodies may have. */
static inline int pinch_row_room(const pinch_step_bodies *bodies, int joint_count, int body_count)
{
    return PINCH_JOINT_MAX_ROWS * joint_count + (bodies->drives.count > 0 ? PINCH_DRIVE_ROWS * body_count : 0);
}

/* Returns the k-th kinematic body of an island. */
static inline pinch_kinematic_body *pinch_kinematic_body_of(const pinch_island_graph *graph, const pinch_island *island,
                                                            int k)
{
    return &graph->kinematic.items[graph->kinematic.by_island.items[island->kinematic.first + k]];
}

static inline bool pinch_island_is_solved(const pinch_island *island)
{
    return island->phase >= PINCH_ISLAND_SOLVED;
}

/* carried_rest.c, before islands are built anew: notes what rested in the last step. Returns false when memory runs
 * out.
 */
bool pinch_note_resting(pinch_island_graph *graph, const pinch_contact_store *contacts,
                        const pinch_step_context *context);
/* carried_rest.c, once all is laid out: islands that are those of the last step, and rested, go on as they were. */
void pinch_carry_resting(pinch_island_graph *graph, pinch_contact_store *contacts);

/* motion.c: finds the kinematic bodies of the islands, and makes room for what moving bodies needs. Returns false when
 * memory runs out. */
bool pinch_lay_out_motion(pinch_island_graph *graph, const pinch_contact_store *contacts,
                          const pinch_joint_store *joints);
/* Tells whether it has been done for these islands, and joints still tie the kinematic bodies that they tied. */
bool pinch_motion_is_laid_out(const pinch_kinematic_bodies *kinematic);
void pinch_kinematic_bodies_free(pinch_kinematic_bodies *kinematic);
size_t pinch_kinematic_bodies_bytes(const pinch_kinematic_bodies *kinematic);
/* backoff.c */
void pinch_backoff_free(pinch_backoff *backoff);
size_t pinch_backoff_bytes(const pinch_backoff *backoff);
/* energy_account.c */
void pinch_accounts_free(pinch_joint_accounts *accounts);
size_t pinch_accounts_bytes(const pinch_joint_accounts *accounts);
/* sleep.c */
void pinch_sleep_free(pinch_sleep *sleep);
size_t pinch_sleep_bytes(const pinch_sleep *sleep);
/* sleep.c, once the islands are numbered: finds out which of them are awake, which bodies may sleep, and how long these
 * have been slow. */
void pinch_find_sleepers(pinch_island_graph *graph, const pinch_contact_store *contacts,
                         const pinch_joint_store *joints, const pinch_step_context *context);
/* sleep.c, once all is laid out: islands all of whose bodies have been slow for long enough are asleep in this step;
 * and once all others are solved: disables their bodies. */
void pinch_choose_sleepers(pinch_island_graph *graph);
void pinch_put_to_sleep(pinch_island_graph *graph);
/* sleep.c, around ODE's step: keeps ODE from stopping single bodies of islands that are awake. */
void pinch_hold_sleep_of_ode(pinch_island_graph *graph);
void pinch_release_sleep_of_ode(pinch_island_graph *graph);

/* Each forgets a body: what ODE puts in the same place of memory is another one. */
void pinch_backoff_forget(pinch_backoff *backoff, dBodyID body);
void pinch_accounts_forget(pinch_joint_accounts *accounts, dBodyID body);
void pinch_sleep_forget(pinch_sleep *sleep, dBodyID body);
/* island_builder.c: all of it, drives included, but not memories. */
void pinch_island_graph_forget(pinch_island_graph *graph, dBodyID body);
/* island_builder.c: forgets the memories of islands that began with one of these bodies. To be called before islands
 * are solved, for all that were forgotten: a walk through the memories for each would take the square of their number.
 */
void pinch_forget_memories(pinch_island_graph *graph, const pinch_key_map *bodies);

void pinch_island_graph_free(pinch_island_graph *graph);
size_t pinch_island_graph_bytes(const pinch_island_graph *graph);

/*
 * Brings the islands up to date with contacts and joints: they are those of the last step where nothing has changed
 * that they depend on, and are built anew otherwise. Returns false when memory runs out.
 */
bool pinch_update_islands(pinch_island_graph *graph, pinch_contact_store *contacts, pinch_joint_store *joints,
                          const pinch_step_context *context, pinch_ode_stats *stats);

#endif
