/*
 * The search for the tree that hard joint rows tie bodies into: one joint, whose rows follow each other, from each body
 * to its parent. A place is a body's number in the tree, parents first; a slot its number among the bodies given.
 */
#ifndef PINCH_KINEMATICS_TREE_SEARCH_H
#define PINCH_KINEMATICS_TREE_SEARCH_H

#include "support/arena.h"

#include <pinch/problem.h>

/* Hard rows, by their places in the problem. */
typedef struct pinch_tree_rows {
    const int *index;
    int count;
} pinch_tree_rows;

/* Rows that follow each other and tie the same two bodies, as those of one joint do. */
typedef struct pinch_row_run {
    int first, count; /* among the rows that are searched */
    int end[2];       /* slots of the rows' bodies; -1 is what does not move */
} pinch_row_run;

typedef struct pinch_tree_search {
    int count, run_count, placed;
    pinch_row_run *runs;
    int *place;  /* per slot: its place in the tree, -1: none yet */
    int *slot;   /* per place: its inverse */
    int *parent; /* per place: a place, -1: what does not move, or nothing */
} pinch_tree_search;

/*
 * Places `count` bodies, whose slots are slot_of[], per body of the problem. Returns false where the rows do not tie
 * them all together, or when memory ran out.
 */
bool pinch_tree_find(pinch_arena *arena, const pinch_problem *problem, int count, const int *slot_of,
                     pinch_tree_rows rows, pinch_tree_search *s);

/*
 * Renumbers the places so that what hangs from a body follows right behind it: the motions that a joint gives are then
 * one stretch of the tree's components, and sums over them leave out what is zero. Where the joints are listed from the
 * root on, as hands are, nothing changes. scratch: 3 count.
 */
void pinch_tree_put_subtrees_together(pinch_tree_search *s, int *scratch);

/* Returns the place of the body that a joint's rows are counted to, the child of the two, or -1 if the rows make no
 * tree. */
int pinch_tree_owner(const pinch_tree_search *s, const pinch_row_run *run);

#endif
