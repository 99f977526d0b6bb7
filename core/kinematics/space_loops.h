/*
 * Loops in a tree of joints whose rates are the coordinates, equations (68) to (71) of core/README.md. Rows that close
 * loops are rows of the rates. Those that are independent of each other hold as many rates, which follow from the
 * others; the rest say nothing new, and share with all hard rows what these carry.
 */
#ifndef PINCH_KINEMATICS_SPACE_LOOPS_H
#define PINCH_KINEMATICS_SPACE_LOOPS_H

#include "kinematics/joint_space.h"

typedef struct pinch_space_loops {
    int count, rank;  /* rows that close loops; how many are independent */
    int *row;         /* of the problem */
    int (*place)[2];  /* per row: the places of its bodies, -1: none */
    int *part;        /* per place: the first one of what joints and loops tie to it, but for what does not move */
    int *end;         /* per such first place: all that is tied to it is before this one */
    double *length;   /* in the metric of the inertia, as of a row of free bodies; rows are divided by it */
    double *pivot;    /* what was left of an independent row when it came to hold a rate */
    int *order;       /* the rows' numbers, the independent ones first */
    double *reduced;  /* the rows in the rates, count x rates; at the end those of independent ones begin with a unit */
    double *combined; /* which rows each of these is combined from, count x count */
    int *held;        /* per independent row: the tree's direction that it holds */
    double *scale;    /* per held rate: it is this times its scaled coordinate */
    double *way;      /* per held rate: how its coordinate moves the bodies by itself, 6 a body */
    double *compliance; /* of all hard rows, six a body, then of those above */
    double *share;      /* count - rank times the same: forces of hard rows that move nothing together */
    double *factors;    /* of share^T compliance share */
    double *common;     /* count: scratch */
    int *pivots;
} pinch_space_loops;

/*
 * Takes the rates that rows hold out of a tree's directions, which are followed. Returns NULL, with the space as it was
 * but for its ways, where rows nearly depend on each other, or when memory ran out.
 */
pinch_space_loops *pinch_space_close_loops(pinch_arena *arena, const pinch_problem *problem, pinch_tree_rows rows,
                                           pinch_joint_space *space);

/* Adds to the space's moves what rows of loops ask for, by held rates alone. Returns false where rows contradict each
 * other. */
bool pinch_space_follow_loops(const pinch_joint_space *space, const pinch_problem *problem);

/* Finds the forces of independent rows that take up x along the rates that they hold, and takes them from x, 6 count.
 */
void pinch_space_bear_by_loops(const pinch_joint_space *space, const pinch_problem *problem, double *x);

/* Shares the forces of all hard rows as their compliances say, and gives rows that close loops theirs. */
void pinch_space_share(const pinch_joint_space *space, pinch_problem *problem);

#endif
