/* The bounds of multipliers within a Newton step. */
#ifndef PINCH_FORCE_FORCE_BOUNDS_H
#define PINCH_FORCE_FORCE_BOUNDS_H

#include "force/force_system.h"

enum { PINCH_FORCE_MOST_CHANGED = 48 };

/* The multipliers that have a bound, in numbers of their own, and how they answer to changes of bounds. */
typedef struct pinch_force_bounds {
    int count;
    int *multiplier; /* per number, ascending */
    int *base;       /* the bound of each that the factors in system->lu are for */
    int *column;     /* its column of the answers, -1: none yet */
    double *value;   /* its y where `base` is 0, otherwise its row's error: after the step with these factors, */
    double *changed; /* and with other bounds */
    double *answer;  /* MOST_CHANGED columns: what a unit of the other of the two adds to all values */
    double *amount;  /* per column: that other of the two */
    double *matrix, *scratch, *rhs;
    int *of, *active, *pivot; /* per column: whose it is; scratch */
} pinch_force_bounds;

typedef enum pinch_force_bounds_end {
    PINCH_FORCE_BOUNDS_RIGHT, /* those that the factors are for are right */
    PINCH_FORCE_BOUNDS_NEW,   /* others should be: to be factored anew, and looked at again */
    PINCH_FORCE_BOUNDS_LAST   /* none are right; these are the last to be tried */
} pinch_force_bounds_end;

/* Sets system->bounds, and NULL where no multiplier can leave or reach a bound. To be called once system->rhs is there.
 * Returns false when memory ran out. */
bool pinch_force_plan_bounds(pinch_arena *arena, pinch_force_system *system);

/* Finds the bounds that hold after a step, from that with the bounds as they are: its factors are in system->lu and its
 * solution is in system->rhs. Sets each multiplier's `bound`. */
pinch_force_bounds_end pinch_force_settle_bounds(pinch_force_system *system);

/* Where the multiplier stands in the right hand side, and in the solution. */
static inline double *pinch_force_unknown_of(const pinch_force_system *s, const pinch_force_multiplier *m, double *x)
{
    return &x[s->block_first[m->joint] + m->place];
}

#endif
