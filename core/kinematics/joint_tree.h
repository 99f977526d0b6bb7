/*
 * The hard joint rows of a cluster whose bodies they tie into a tree, one joint block from each body to its parent.
 * They are eliminated body by body, equation (16) of core/README.md: directions and v0 follow from the root
 * on, and forces from the leaves on. The directions are made orthonormal (the inertia is the identity in u) by Gram and
 * Schmidt's method.
 */
#ifndef PINCH_KINEMATICS_JOINT_TREE_H
#define PINCH_KINEMATICS_JOINT_TREE_H

#include "kinematics/constraint_factor.h"
#include "kinematics/tree_search.h"

/* One hard row. */
typedef struct pinch_tree_row {
    int row;          /* of the problem */
    double length;    /* of the whole row before it was scaled to 1 */
    double vector[6]; /* of Q: Householder vector of C's row, entries before its own place 0 */
    double scale;     /* the reflection is 1 - scale v v^T */
    double r[6];      /* column of R, diagonal included */
    double parent[6]; /* row of P */
    double rhs;       /* (c - J v*) / length */
} pinch_tree_row;

typedef struct pinch_tree_body {
    int parent;          /* earlier place, -1: what does not move, or nothing */
    int end;             /* what hangs from it has the places from its own to before this one */
    int first_row;       /* its rows follow each other */
    int rows;            /* 0 to 6; 0: the root of a tree that nothing holds */
    int first_direction; /* its 6 - rows directions follow each other, behind those of all later places */
    pinch_root_inverse root;
} pinch_tree_body;

/* Components of a vector of 6 a body. */
typedef struct pinch_tree_range {
    int first, count;
} pinch_tree_range;

typedef struct pinch_joint_tree {
    int count; /* bodies, parents first, and what hangs from a body right behind it */
    int freedoms;
    pinch_tree_body *bodies;
    pinch_tree_row *rows;
    double *directions;      /* freedoms x 6 count, orthonormal, set where they move something */
    pinch_tree_range *moves; /* per direction: the components that it moves */
    double *moved;           /* 6 count: Y^-1 (v0 - v*) */
} pinch_joint_tree;

/*
 * Tells whether hard rows make a tree of `count` bodies in which no row nearly depends on others; slot_of: per body of
 * the problem, its place among the bodies; roots: per body of the problem. False, with arena->failed, when memory ran
 * out.
 */
bool pinch_joint_tree_is_independent(pinch_arena *arena, const pinch_problem *problem, const pinch_root_inverse *roots,
                                     int count, const int *slot_of, pinch_tree_rows rows);
/*
 * The tree of `count` bodies (problem indices) and the hard rows among them. bodies[] is put into the tree's order;
 * slot_of: per body of the problem, its place in bodies[], kept up; roots: per body of the problem. NULL without
 * arena->failed where the rows make no tree or nearly depend on each other: nothing is changed then.
 */
pinch_joint_tree *pinch_joint_tree_build(pinch_arena *arena, const pinch_problem *problem,
                                         const pinch_root_inverse *roots, int *bodies, int count, int *slot_of,
                                         pinch_tree_rows rows);
/* U = Y times the directions: 6 count x freedoms, row major. Of a body, columns before its first direction are not set:
 * they are zero. */
void pinch_joint_tree_basis(const pinch_joint_tree *tree, double *basis);
/* Writes v0 of the tree's bodies, 6 per body in the tree's order. */
void pinch_joint_tree_v0(pinch_joint_tree *tree, const pinch_problem *problem, const int *bodies, double *v0);
/* The rows' multipliers and pivots; wrench as in pinch_mobility_joint_forces, scratch: 6 count. */
void pinch_joint_tree_forces(const pinch_joint_tree *tree, pinch_problem *problem, const int *bodies,
                             const double *wrench, double *scratch);

#endif
