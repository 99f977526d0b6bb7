/*
 * The motions that the hard joint rows of an island leave, as reduced coordinates: v+ = v0 + U q, equations (12) to
 * (15) of core/README.md, or in the rates of joints (64) to (71). Bodies that hard rows tie together form a cluster.
 */
#ifndef PINCH_KINEMATICS_MOBILITY_H
#define PINCH_KINEMATICS_MOBILITY_H

#include "kinematics/constraint_factor.h"
#include "kinematics/joint_space.h"

#include <pinch/problem.h>

#include <math.h>

struct pinch_joint_tree;

typedef struct pinch_cluster {
    int body_count;
    int *bodies;                     /* problem indices; of a tree, parents first */
    int first;                       /* its first unknown */
    int freedoms;                    /* number of its unknowns */
    double inertia;                  /* diagonal of U^T M U: 1; 0 for a massless drive */
    bool free;                       /* one body with mass and without hard rows: U = Y, six freedoms */
    double *basis;                   /* U: 6 body_count x freedoms, row major; of a free body PINCH_FREE_BASIS; of
                                      * rates of joints NULL: the space has it */
    double *v0;                      /* 6 body_count */
    pinch_joint_space *space;        /* where the rates of joints are its unknowns: U^T M U is no diagonal matrix */
    struct pinch_joint_tree *tree;   /* where hard rows make one, well conditioned */
    pinch_constraint_factor *factor; /* of other hard rows */
    double *scratch;                 /* 6 body_count, where hard rows act */
} pinch_cluster;

typedef struct pinch_mobility {
    int cluster_count;
    pinch_cluster *clusters;
    pinch_root_inverse *roots; /* per body with mass, but for those of rates of joints: Y */
    int *cluster_of;           /* per body */
    int *slot_of;              /* per body: its place among its cluster's bodies */
    int unknowns;              /* sum of freedoms */
    bool *eliminated;          /* per joint row: it is hard, and its force follows from the others */
    pinch_loose_rows loose;    /* with PINCH_ELIMINATE_INTO_RATES: the others */
    int eliminated_count;
    int *remaining; /* the rows that are not, in their order: row_count - eliminated_count */
    int remaining_count;
    int kept_count;      /* hard rows that are not eliminated; one that continues in others counts once */
    int dependent_count; /* of these, rows that may depend on each other */
} pinch_mobility;

/* U of a free body, PINCH_FREE_BASIS doubles: a multiple of the identity beside an upper triangle. */
enum { PINCH_FREE_LINEAR, PINCH_FREE_T, PINCH_FREE_BASIS = PINCH_FREE_T + 6 }; /* t00 t01 t02 t11 t12 t22 */

/* U of the body at slot k, 6 x freedoms, of a cluster without a space; expanded: room for that of a free one. */
const double *pinch_cluster_basis(const pinch_cluster *cluster, int slot, double expanded[36]);

/* Returns the first of a cluster's directions that can move its k-th body: those before it move others, and the
 * columns of the body's U that are theirs are not set. */
int pinch_cluster_first_direction(const pinch_cluster *cluster, int slot);

/* Which hard rows are eliminated. */
typedef enum pinch_elimination {
    PINCH_ELIMINATE_WHERE_CHEAP, /* as the next, without trees that it costs less to keep the rows of */
    PINCH_ELIMINATE_INTO_RATES,  /* as the first; where the joints of a tree are driven, their rates are the unknowns */
    PINCH_ELIMINATE_INDEPENDENT, /* those of clusters of moderate size in which no row depends on others */
    PINCH_ELIMINATE_ALL          /* all; those that depend on others are dropped */
} pinch_elimination;

/* Is the row two-sided and without compliance? */
static inline bool pinch_row_is_hard(const pinch_joint_row *row)
{
    return row->cfm == 0 && row->low == -INFINITY && row->high == INFINITY;
}

/* Returns how many rows of the problem row k is made of: itself and those that continue it. */
static inline int pinch_row_parts(const pinch_problem *problem, int k)
{
    int end = k + 1;
    while (end < problem->row_count && problem->rows[end].continues) end++;
    return end - k;
}

/* Does the row go on in the one behind it? */
static inline bool pinch_row_goes_on(const pinch_problem *problem, int k)
{
    return k + 1 < problem->row_count && problem->rows[k + 1].continues;
}

/* Is row k a hard one for more than two bodies? */
static inline bool pinch_row_is_coupling(const pinch_problem *problem, int k)
{
    const pinch_joint_row *row = &problem->rows[k];
    return !row->continues && pinch_row_goes_on(problem, k) && pinch_row_is_hard(row);
}

/* Returns the index of the cluster of a row's first body, of one that ties a single cluster. */
static inline int pinch_cluster_of_row(const pinch_mobility *mobility, const pinch_joint_row *row)
{
    return mobility->cluster_of[row->body1 >= 0 ? row->body1 : row->body2];
}

/*
 * Tells whether the hard rows for more than two bodies are rows of the rates of joints alone, each with a rate that no
 * stop and no other coupling holds, as the follower of a mimic joint is one away from its stops. Where a gripper is
 * against the stops of both fingers, three rows hold two rates. False, with arena->failed, when memory ran out.
 */
bool pinch_couplings_follow_rates(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility);

/*
 * Tells whether no unknown of joints with loops is held by more than one row without compliance. All rates of a loop
 * may be multiples of one unknown, and then stops and dry friction of several joints hold the same. False, with
 * arena->failed, when memory ran out.
 */
bool pinch_loops_are_held_once(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility);

/* Do joints make loops, whose rates are unknowns? */
bool pinch_mobility_has_loops(const pinch_mobility *mobility);

/*
 * A part of the next function: finds the clusters, their unknowns, and the directions of these, of which `eliminated`
 * tells the rows. Where rows are to be kept, it takes them out of `eliminated`, and wants to be called once more.
 * Returns false as the next function does.
 */
bool pinch_mobility_find_structure(pinch_arena *arena, const pinch_problem *problem, pinch_elimination elimination,
                                   pinch_mobility *mobility);

/* Returns false when memory ran out, an inertia is not positive definite, or a hard row acts on a massless drive. */
bool pinch_mobility_build(pinch_arena *arena, const pinch_problem *problem, pinch_elimination elimination,
                          pinch_mobility *mobility);

/*
 * The direction in which a massless drive moves at a coordinate of one. A drive without mass has one freedom and no
 * inertia; its row is a balance of forces. What resists it in a step is the normal laws of its contacts, h (h kn + cn)
 * in kg: the root of that scales it as a mass scales a body's freedoms.
 */
void pinch_drive_direction(const pinch_problem *problem, int drive, double direction[3]);

/* v+ of one body at the reduced coordinates x */
void pinch_mobility_velocity(const pinch_mobility *mobility, int body, const double *x, double v[6]);

/*
 * Writes the forces of the hard rows into problem->rows[].force, equation (15): wrench (6 per body) is the sum of all
 * other forces on each body that are not in v*. Rows that depend on others get 0.
 */
void pinch_mobility_joint_forces(const pinch_mobility *mobility, pinch_problem *problem, const double *wrench);

#endif
