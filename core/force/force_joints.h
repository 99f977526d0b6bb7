/* The multipliers with which all joint rows hold, whatever the contacts' forces. */
#ifndef PINCH_FORCE_FORCE_JOINTS_H
#define PINCH_FORCE_FORCE_JOINTS_H

#include "force/force_system.h"

/* S = J J^T + C + kappa and its Cholesky factor L; `place` of a multiplier is its row in both. J is without the rows of
 * multipliers that are held at a bound. */
typedef struct pinch_force_joints {
    int count;        /* multipliers */
    bool bounded;     /* some have bounds; whether each is where it has to be is for the caller to find out */
    int *held;        /* per multiplier: -1, 1: at its lower or upper bound, 0: its row holds */
    int *start;       /* per cluster: the multipliers that act on it, clusters + 1, */
    int *multiplier;  /* one by one, */
    int *block;       /* and which of their blocks is the cluster's */
    int *place;       /* per multiplier */
    int *begin;       /* per row of L: the first column that is not zero, */
    double **line;    /* and where column 0 would be */
    double *inverse;  /* per row of L: one over its diagonal */
    double *solution; /* scratch: one per row */
} pinch_force_joints;

/* Sets system->joints where a factor is possible and worth it, and leaves NULL elsewhere. Multipliers that start from a
 * bound are held there. Returns false when memory ran out. */
bool pinch_force_factor_joints(pinch_arena *arena, pinch_force_system *system);

/* Sets the multipliers to those with which all rows hold that are not held at a bound, and q to the motion with them:
 * at the forces as they are, or where all forces are zero. */
void pinch_force_satisfy_rows(pinch_force_system *system, bool forces);

/* Sets q to the motion that a next proximal pass adds, equation (54), while contacts keep their forces: to what takes
 * out what rows missed after the one before. */
void pinch_force_advance_rows(pinch_force_system *system);

/* Takes what rows miss at the point last evaluated out of the multipliers once more: what rounding has left. */
void pinch_force_refine_rows(pinch_force_system *system);

#endif
