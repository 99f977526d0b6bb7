/*
 * The same world stepped by Pinch, quickstep and worldstep in turn, in one process. The results are medians of the
 * steps' wall times, and how well each solver's forces obey the contact law.
 */
#ifndef PINCH_BENCH_SIDE_BY_SIDE_H
#define PINCH_BENCH_SIDE_BY_SIDE_H

#include "world.h"

#include "common/progress.h"

#include <stddef.h>

/* What the line on a terminal needs to know of a series of sizes. */
typedef struct timing_progress {
    progress *line;
    const char *series;
    int later;         /* sizes that come after this one */
    double later_size; /* their sum */
    double pace;       /* s a step and unit of size while worlds settle, as the last of them took */
} timing_progress;

typedef struct timing_plan {
    void (*build)(bench_world *w, int size);
    double step;          /* s */
    int settle;           /* steps before measuring */
    bool each_settles;    /* every solver settles its own world; otherwise `settler` does, and all get its state */
    bench_solver settler; /* the solver that settles the world */
    double stands;        /* m: a body that has gone farther from where it was built has fallen; 0: nothing can fall */
    bool cold;            /* Pinch starts every solve from nothing that was known */
    int threads;          /* of Pinch, >= 1 */
    double budget;        /* s of measuring, about */
    bool worldstep;       /* worldstep takes part, until one of its steps takes more than a second */
    timing_progress *progress;
} timing_plan;

/* The results of one solver. */
typedef struct solver_timing {
    double seconds;         /* median of the contact part of a step; NAN: the solver was not run */
    double whole;           /* the same of the whole step, with collision detection */
    double residual;        /* N: the largest bench_residual of the measured steps */
    double iterations;      /* mean per step; for quickstep the number it is set to */
    double allocations;     /* calls of an allocator per step, once the world has been running */
    long unsolved;          /* steps with an island that Pinch did not solve at the first try */
    double solver_residual; /* Pinch's own check: the largest relative residual */
    size_t memory;          /* bytes held by Pinch */
    double fastest;         /* m/s: of the fastest body, at the end */
    double energy;          /* J, kinetic, at the end: large where the world has flown apart */
    double moved;           /* m: how far the farthest body is from where it was built */
    bool stands;            /* no body is farther than the plan's `stands` */
} solver_timing;

typedef struct side_by_side {
    int size, contacts, bodies, rounds;
    solver_timing of[BENCH_SOLVERS];
    double ratio[2], worldstep_ratio[2]; /* medians over the rounds: Pinch's step over quickstep's, over worldstep's;
                                            the contact part's and the whole step's */
} side_by_side;

/* Returns false when memory runs out or a step fails. */
bool time_side_by_side(const timing_plan *plan, int size, side_by_side *result);

#endif
