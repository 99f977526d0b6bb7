/*
 * The motions of a tree of bodies in the rates of its joints, equations (64) to (67) of core/README.md. Where servos,
 * motors, friction or stops act along all freedoms of all joints, their rows and the hard ones make a regular 6 x 6
 * block for each body: its motion follows from its parent's and from the rates along those rows. A row along a joint
 * then has one column, and nothing has to be made orthonormal; the inertia is a matrix in place of the identity.
 */
#ifndef PINCH_KINEMATICS_JOINT_SPACE_H
#define PINCH_KINEMATICS_JOINT_SPACE_H

#include "kinematics/tree_search.h"
#include "support/lanes.h"

/* A row along a freedom of a joint is `factor` times the rate along a direction of its tree. */
typedef struct pinch_joint_rate {
    int direction; /* among those of its tree, -1: the row is no such multiple, or the rate is one of several unknowns
                    */
    double factor;
} pinch_joint_rate;

/* The rows of a problem that are not eliminated, listed by body. */
typedef struct pinch_loose_rows {
    int *first;             /* per body: its first row, -1: none */
    int *next[2];           /* per row and side: the next row of the body on that side */
    pinch_joint_rate *rate; /* per row of the problem, set for those that are listed */
} pinch_loose_rows;

typedef struct pinch_space_body {
    int body;             /* of the problem */
    int parent;           /* earlier place, -1: what does not move, or nothing */
    int end;              /* what hangs from it has the places from its own to before this one */
    int hard;             /* the first of its six rows, which are eliminated; the others' rates are the coordinates */
    int first_direction;  /* its 6 - hard directions follow each other, behind those of all later places */
    int row[6];           /* of the problem; -1: a component of the body's own velocity */
    double pivot[6];      /* per row: what is left of it beside the others, as a part of its length */
    double unit[6][6];    /* per row: how it moves at a rate of one along it */
    bool pinned;          /* it turns with its parent, and a turn moves it by `lever`; otherwise `carried` is set */
    double lever[3][3];   /* per component of its parent's turn: its way */
    double carried[6][6]; /* per component of its parent's motion: how it moves with it, all rates being zero */
} pinch_space_body;

/* The bodies that a direction moves are from one place to before another one. */
typedef struct pinch_space_stretch {
    int first, end;
} pinch_space_stretch;

/* a . b over a stretch of bodies, of vectors of six components a body */
static inline double pinch_space_dot(const double *a, const double *b, pinch_space_stretch of)
{
    pinch_lanes sum = {0, 0};
    for (const double *last = a + 6 * of.end, *x = a + 6 * of.first, *y = b + 6 * of.first; x < last; x += 6, y += 6)
        sum += pinch_lanes_at(x) * pinch_lanes_at(y) + pinch_lanes_at(x + 2) * pinch_lanes_at(y + 2) +
               pinch_lanes_at(x + 4) * pinch_lanes_at(y + 4);
    return sum[0] + sum[1];
}

struct pinch_space_loops;

typedef struct pinch_joint_space {
    int count;    /* bodies, parents first, and what hangs from a body right behind it */
    int rates;    /* directions of the tree */
    int freedoms; /* directions that are left: all of them, but for those that loops hold */
    pinch_space_body *bodies;
    struct pinch_space_loops *loops; /* NULL: there are none */
    double *scale;   /* per direction: its rate is scale times its coordinate: the inertia's diagonal is 1 */
    double *inertia; /* U^T M U, freedoms^2 */
    double *factor;  /* of it, L^T D L, freedoms^2 */
    double *moved;   /* U^T M (v0 - v*), freedoms */
    int *above;      /* per direction: the next one that moves its body, towards the root; -1: none */
    int *moving;     /* per body: the first direction that moves it, -1: none */
    pinch_space_stretch *moved_bodies; /* per direction */
    double *way;      /* per direction, 6 count: how its rate of one moves the bodies, set where it does */
    double *momentum; /* the same of their momenta */
    double *moves;    /* v0 - v*, 6 count */
    double *speed;    /* per direction of the tree: its rate at v0 */
    int *unknown;     /* per direction of the tree: the one whose rate it is a multiple of, -1: of no single one */
    double *follows;  /* and which multiple */
    double *force;    /* scratch for hard rows: six a body, and one for each row that closes a loop */
} pinch_joint_space;

/* What a rate is in its unknown, and what it is at v0. */
static inline double pinch_joint_rate_gain(const pinch_joint_space *space, const pinch_joint_rate *rate)
{
    return rate->factor * space->follows[rate->direction] * space->scale[space->unknown[rate->direction]];
}

static inline double pinch_joint_rate_start(const pinch_joint_space *space, const pinch_joint_rate *rate)
{
    return rate->factor * space->speed[rate->direction];
}

/* Lists rows of the problem, which are given in their order. Returns false when memory ran out. */
bool pinch_loose_rows_list(pinch_arena *arena, const pinch_problem *problem, pinch_tree_rows rows,
                           pinch_loose_rows *loose);

/* A row on a body and on its parent. */
typedef struct pinch_row_ends {
    const double *own, *parent;
} pinch_row_ends;

static inline pinch_row_ends pinch_row_ends_of(const pinch_joint_row *row, int body)
{
    return row->body1 == body ? (pinch_row_ends){row->j1, row->j2} : (pinch_row_ends){row->j2, row->j1};
}

/*
 * Completes the rows of a body, which has `hard` of them, by those along its joint, and tells of all that are along it
 * which they are multiples of. bodies: the space's. Returns false where freedoms are left over.
 */
bool pinch_space_body_coordinates(const pinch_problem *problem, const pinch_space_body *bodies, pinch_loose_rows *loose,
                                  pinch_space_body *b);
/*
 * Computes how a body moves by its six rows and with its parent. Returns false where three of them do not turn it
 * alone, or they nearly depend on each other.
 */
bool pinch_space_body_solve(const pinch_problem *problem, pinch_space_body *b);
/* Takes back what pinch_space_body_coordinates told of the rows of all bodies. */
void pinch_space_forget_rates(const pinch_problem *problem, const pinch_joint_space *space, pinch_loose_rows *loose);

/* Takes it back of rows along rates that are no multiples of one unknown. */
void pinch_space_forget_mixed_rates(const pinch_problem *problem, const pinch_joint_space *space,
                                    pinch_loose_rows *loose);

/* The bodies of a cluster, as problem indices. */
typedef struct pinch_space_members {
    int *bodies; /* put into the tree's order */
    int count;
    int *slot_of; /* per body of the problem: its place in bodies[], kept up */
} pinch_space_members;

/*
 * The space of the bodies and the hard rows among them. Rows beyond those of a tree close loops. Returns NULL without
 * arena->failed where a joint has a freedom along which no row acts, the tree is too deep for its inertia to be well
 * conditioned, the rows of a body nearly depend on each other, or those of loops do or contradict each other: nothing
 * is changed then. With it the rates of the rows along its joints are set.
 */
pinch_joint_space *pinch_joint_space_build(pinch_arena *arena, const pinch_problem *problem, pinch_space_members of,
                                           pinch_tree_rows rows, pinch_loose_rows *loose);

/* Writes v0, 6 per body. */
void pinch_joint_space_v0(const pinch_joint_space *space, const pinch_problem *problem, double *v0);

/* v += U x of the body at a place, of which v is the velocity */
void pinch_joint_space_add_velocity(const pinch_joint_space *space, int place, const double *x, double *v);

/* g += sign times `jacobian`, rows x 6, times U of the body at a place; g is rows x freedoms */
void pinch_joint_space_reduce(const pinch_joint_space *space, int place, int rows, const double *jacobian, double sign,
                              double *g);

/* size += |h U^T wrench| of the body at a place */
void pinch_joint_space_add_size(const pinch_joint_space *space, int place, double h, const double *wrench,
                                double *size);

/* y += (U^T M U - 1) x */
void pinch_joint_space_add_coupling(const pinch_joint_space *space, const double *x, double *y);

/* x <- (U^T M U)^-1 x */
void pinch_joint_space_solve(const pinch_joint_space *space, double *x);

/* momentum = M v of one body */
void pinch_space_momentum(const pinch_body *body, const double *v, double *momentum);

/* The forces of the hard rows, six a body, that take up x, what is left of forces on the bodies, 6 count. From the
 * leaves on, what a body's rows take up goes on to its parent, in x. */
void pinch_space_bear(const pinch_joint_space *space, const pinch_problem *problem, double *x, double *force);

/* The multipliers and pivots of the hard rows, from the velocities at the end; wrench as in
 * pinch_mobility_joint_forces, scratch: 6 count. */
void pinch_joint_space_forces(const pinch_joint_space *space, pinch_problem *problem, const double *wrench,
                              double *scratch);

#endif
