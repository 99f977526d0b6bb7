/*
 * One world run by Pinch, quickstep and worldstep, a step of each in turn in the same process: medians of what their
 * steps cost, and how good their forces are.
 */
#ifndef PINCH_BENCH_DUEL_H
#define PINCH_BENCH_DUEL_H

#include "world.h"

#include <stddef.h>

typedef struct duel_plan {
    void (*build)(bench_world *w, int size);
    double step;          /* s */
    int settle;           /* steps before measuring */
    bool each_settles;    /* on its own; otherwise `settler` does, and the states are copied to all */
    bench_solver settler; /* whose steps */
    double stands;        /* m: what is to stand has fallen where a body has gone farther; 0: nothing is to stand */
    bool cold;
    int threads;    /* >= 1 */
    double budget;  /* s of measuring, about */
    bool worldstep; /* takes part, until a step takes more than a second */
} duel_plan;

/* Of one solver in one world. */
typedef struct duel_side {
    double seconds;         /* median of a step; NAN: not run */
    double residual;        /* N, largest over the last steps: bench_residual */
    double iterations;      /* mean per step; of an ODE step, those it is set to */
    double allocations;     /* calls of an allocator per step, once warm */
    long unsolved;          /* steps with an island that Pinch did not solve at the first try */
    double solver_residual; /* Pinch's own check, relative: residual_max */
    size_t memory;          /* bytes held by Pinch */
    double energy;          /* J, kinetic, at the end: nothing has flown apart */
    double moved;           /* m, the farthest that a body is at the end from where it was built */
    bool stands;
} duel_side;

typedef struct duel {
    int size, contacts, bodies, rounds;
    duel_side side[BENCH_SOLVERS];
    double ratio, worldstep_ratio; /* medians of a round's ratios: Pinch's step to quickstep's, to worldstep's */
} duel;

/* false: memory ran out, or a step failed */
bool duel_run(const duel_plan *plan, int size, duel *result);

#endif
