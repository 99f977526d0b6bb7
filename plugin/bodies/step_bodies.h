/*
 * The bodies that take part in a step as unknowns: dynamic bodies, and kinematic ones under force control, which a
 * drive moves along an axis without inertia. Step bodies are found anew whenever the islands are built (see
 * islands/island_builder.c); drives stay until they are taken away.
 */
#ifndef PINCH_BODIES_STEP_BODIES_H
#define PINCH_BODIES_STEP_BODIES_H

#include "bodies/body_motion.h"
#include "step_context.h"
#include "util/list.h"
#include "util/prefetch.h"

#include <stddef.h>
#include <string.h>

typedef struct pinch_drive {
    dBodyID body;
    double axis[3], force; /* unit, world; N */
    double speed;          /* along the axis, as solved for in the last step, m/s */
} pinch_drive;

typedef struct pinch_drives {
    pinch_drive *items;
    int count, room;
    pinch_item_index index;
} pinch_drives;

/* What a step at rest looks at comes first, in as few lines of memory as it fits in. */
typedef struct pinch_step_body {
    dBodyID body;
    int drive;                    /* index of its drive, -1 for a dynamic body */
    int first_joint, joint_count; /* its enabled joints, in the joint store's list `attached` */
    int contact_joints;           /* the program's contact joints on it that Pinch solves in this step; counted only
                                   * where it has many joints, otherwise 0 */
    bool by_pinch;                /* Pinch moves it in this step, and it is disabled while ODE steps */
    bool overlaps_deeply;         /* scratch: it is in another one; see islands/island_contacts.c */
    /* from here on only for a solved island, but for what tells its island */
    uint64_t rest_bits; /* at rest: a checksum of its orientation and its weight */
    double position[3]; /* at the start of the step */
    double wrench[6];   /* force and torque of its contacts; as soon as ODE has those, what ODE had before, and in
                         * wrench[0] of a driven body the force of its drive, N */
    double velocity[6]; /* as solved for; after ODE's step the mismatch, which is ODE's velocity less that one */
    double load[6];     /* scratch: force and torque that ODE has, while those of joints are added */
    int parent;         /* in the union-find forest; once the islands are numbered, its island */
    int local;          /* index among its island's bodies */
    int carrier;        /* scratch: see joints/island_joints.c and joints/joint_loops.c */
} pinch_step_body;

/* The first bytes of the record tell where ODE has the body and its joints, more of them how it rests. */
enum {
    PINCH_STEP_BODY_LINKS = offsetof(pinch_step_body, rest_bits),
    PINCH_STEP_BODY_AT_REST = offsetof(pinch_step_body, velocity)
};

typedef struct pinch_step_bodies {
    pinch_step_body *items;
    int count, room;
    pinch_item_index index;
    PINCH_LIST(int) by_island;                  /* indices of step bodies, island by island */
    PINCH_LIST(pinch_inverse_inertia) inverses; /* of step body k, or of what was in its place before */
    pinch_drives drives;
} pinch_step_bodies;

enum { PINCH_NOT_A_STEP_BODY = -1, PINCH_NO_ROOM_FOR_BODY = -2 };

/* Returns the index of a body's drive, -1 where it has none. */
int pinch_drive_of(const pinch_drives *drives, dBodyID body);
/* As pinch_ode_set_drive. *changed tells whether a drive came, went or has another axis now. */
pinch_status pinch_drives_set(pinch_drives *drives, dBodyID body, const double axis[3], double force, bool *changed);
/* Puts a driven body back to the velocity that its owner prescribed. */
void pinch_drive_stop(const pinch_drive *drive);

void pinch_step_bodies_clear(pinch_step_bodies *bodies);
void pinch_step_bodies_free(pinch_step_bodies *bodies);
size_t pinch_step_bodies_bytes(const pinch_step_bodies *bodies);
/* Returns the index of an ODE body in the step, and adds it where it is new. PINCH_NOT_A_STEP_BODY where the body does
 * not move by itself, PINCH_NO_ROOM_FOR_BODY when memory runs out. */
int pinch_step_bodies_add(pinch_step_bodies *bodies, dBodyID body);
/* Puts two step bodies into one island. Negative indices are allowed and do nothing. */
void pinch_step_bodies_join(pinch_step_bodies *bodies, int a, int b);
/* Returns the representative of a body's island, whose index is the smallest in it. */
int pinch_step_bodies_root(pinch_step_bodies *bodies, int body);

/* Returns the index of an ODE body in the step, -1 where it takes no part. */
int pinch_step_body_of(const pinch_step_bodies *bodies, dBodyID body);

/* Returns the k-th body of an island, whose bodies are a range of the list by_island. */
static inline pinch_step_body *pinch_island_body(const pinch_step_bodies *bodies, pinch_range range, int k)
{
    return &bodies->items[bodies->by_island.items[range.first + k]];
}

/* What a step reads of a body ODE has in the first ten lines or so of the body's memory: in the first four its joints,
 * its flags and its mass, and from its position on what moves and what moves it. What it writes as it enables the body
 * lies behind that. */
enum { PINCH_BODY_BYTES = 10 * PINCH_CACHE_LINE, PINCH_BODY_WITH_MASS = 208 };

/* Asks ahead for all that is read. */
static inline void pinch_prefetch_body(dBodyID body)
{
    const double *position = dBodyGetPosition(body), *torque = dBodyGetTorque(body);
    pinch_prefetch(body, PINCH_BODY_WITH_MASS);
    pinch_prefetch(position, (size_t)((const char *)(torque + 3) - (const char *)position));
}

/* Asks ahead for what enabling a body writes. */
static inline void pinch_prefetch_to_enable(dBodyID body)
{
    pinch_prefetch_to_write(body, PINCH_CACHE_LINE);
    pinch_prefetch_to_write(dBodyGetTorque(body) + 8, 6 * sizeof(double));
}

/* Tells whether the body takes part in the step as it did in the last. */
static inline bool pinch_takes_same_part(const pinch_step_body *b)
{
    if (b->drive >= 0) return dBodyIsKinematic(b->body);
    return !dBodyIsKinematic(b->body) && dBodyIsEnabled(b->body) && !dBodyGetAutoDisableFlag(b->body);
}

/* Tells whether the body's velocity is zero, to the bit. */
static inline bool pinch_body_stands(dBodyID body)
{
    static const double ZERO[3] = {0, 0, 0};
    return memcmp(dBodyGetLinearVel(body), ZERO, sizeof ZERO) == 0 &&
           memcmp(dBodyGetAngularVel(body), ZERO, sizeof ZERO) == 0;
}

/* Fills in mass, inertia, velocity and external forces as the core wants them; joints' motors may add forces before
 * pinch_apply_external makes velocities of them. */
void pinch_fill_step_body(const pinch_step_context *context, const pinch_drives *drives, const pinch_step_body *from,
                          pinch_body *body);
void pinch_apply_external(pinch_body *body, double h);

/* Gives ODE the contact forces of a solved body, or the speed of its drive. */
void pinch_give_contact_forces(pinch_drives *drives, pinch_step_body *body);
/* Puts a body back to the forces it came with; a driven one to its prescribed velocity. */
void pinch_take_back_contact_forces(const pinch_drives *drives, const pinch_step_body *body);

#endif
