#ifndef PINCH_HAND_STATIC_SYSTEM_H
#define PINCH_HAND_STATIC_SYSTEM_H

#include "exact/system.h"
#include "scenes/world/world_hand.h"

/*
 * Hands and objects that stand still, as equations in small displacements x from where a step of the world begins:
 *
 *     F = load + W x + sum_c G_c^T r_c(G_c x) + sum_b a_b^T y_b = 0.
 *
 * x: six numbers an object (m, then rad about its centre of mass), and one a joint of a hand (rad or m). G_c: the rows
 * that turn x into the motion of body 1 of contact c against body 2. W: what turning changes of the links' weights. r_c
 * is the contact law with the springs as they are when the step begins. Row b exerts y_b on the coordinate a_b x. A
 * compliant row gives y from x; of a rigid one y is an unknown, which follows the x in z = (x, y). Rotations are the
 * same as lengths over `lever`.
 */

typedef enum static_row_kind {
    STATIC_MOTOR = 0, /* of a joint */
    STATIC_PASSIVE,   /* a joint's own spring, dry friction or stop */
    STATIC_TENDON,    /* what drives a tendon */
    STATIC_TIE        /* a mimic, a tendon's own spring or friction, a loop */
} static_row_kind;

/* Compliant: y = clamp(constant + stiffness (missing - a x), low, high). Rigid: a x = missing within the bounds, more
 * only at low and less only at high. */
typedef struct static_row {
    static_row_kind kind;
    int hand, index; /* a joint, or of the hand's ties */
    double *a;       /* per coordinate */
    bool rigid;
    double constant, stiffness, missing, low, high;
    int unknown; /* rigid: the place of y in z */
    long double y;
} static_row;

typedef struct static_contact {
    const pinch_contact *data;
    int finger;        /* of the world, that it belongs to; -1: none */
    double sign;       /* of the force on the object in that on body 1 */
    dBodyID body[2];   /* NULL: the static world */
    double axis[3][3]; /* normal, tangents */
    exact_law law;
    double *g; /* law.rows rows over the coordinates */
    long double w[4], r[4];
} static_contact;

typedef struct static_system {
    const world *w;
    int coordinates, unknowns;
    int *first_joint; /* per hand: the coordinate of its first joint */
    double lever;     /* m: the largest object's bounding radius */
    double *weight;   /* on each joint's coordinate: of the hands' links (N m or N); solved: where x is the answer */
    double *weight_change; /* coordinates x coordinates: by which it grows as each coordinate does */
    double *load;          /* on each coordinate, where x is 0 */
    int contact_count;
    static_contact *contacts;
    pinch_contact *data;
    int row_count, row_room;
    static_row *rows;
    double scale; /* N: the largest load or force there is */
} static_system;

/* static_read.c: to be called while the world's step is solved and nothing has moved yet (world.observe). On failure
 * `why` (256 bytes) says what the statics do not know, or is empty when memory runs out. Free it in either case. */
bool static_system_read(static_system *system, const world *w, char *why);
void static_system_free(static_system *system);
/* Adds sign times the motion of a body's point along d to the coordinates; `turns`: its rotation about d instead. */
void static_add_motion(const static_system *system, dBodyID body, const double point[3], const double d[3], bool turns,
                       double sign, double *g);

/* static_solve.c: semi-smooth Newton on F from z = 0. Returns the number of steps; -1: no memory. *found tells whether
 * they led to an answer, which z (unknowns), and w, r, y in the system receive. *residual: |F| in N, moments over the
 * lever. */
int static_solve(static_system *system, long double *z, double *residual, bool *found);

/* How far an answer is from the laws, in N, moments over the lever; from the contacts' and the world's data alone. */
typedef struct static_errors {
    double force, torque; /* N, N m: sum of all forces on an object */
    double joint;         /* N m or N: on a joint, from motors, contacts, ties and weights */
    double motor;         /* N m or N: of a row's force from its law */
    double cone, normal, slip_direction;
    double scale; /* N: the largest force */
    bool passed;  /* all within 1e-9 of it */
} static_errors;

/* static_check.c. Returns whether it passed. */
bool static_check(const static_system *system, const long double *z, static_errors *errors);

#endif
