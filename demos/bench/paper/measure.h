#ifndef PINCH_BENCH_PAPER_MEASURE_H
#define PINCH_BENCH_PAPER_MEASURE_H

#include "examples.h"

enum { PAPER_SEEDS = 50 };

/* A quantity that is spread: the quartiles about its median. */
typedef struct paper_spread {
    double low, median, high;
} paper_spread;

/* What one method did on one problem. */
typedef struct paper_measurement {
    pinch_solve_status status; /* the worst of all runs */
    double iterations;         /* mean over the seeds, as in the paper */
    double projections;        /* and so are these: rows projected onto, or pivots */
    double residual;
    paper_spread iterations_spread, residual_spread; /* over the seeds */
    paper_spread time; /* s of CPU time of this thread; over the seeds, or over the repeats of a deterministic method */
    double instructions; /* of one run, mean over the seeds; NaN where they cannot be counted */
} paper_measurement;

/* The two methods of the paper on one problem. */
typedef struct paper_pair {
    paper_measurement nsngrk, nsnmgk;
    paper_spread speedup; /* median: ratio of the median times; low, high: the quartiles of the seeds' own ratios */
    int rounds;           /* how often each seed was run */
} paper_pair;

/*
 * Times NSNGRK with the seeds from `first` on, each several times, and NSNMGK in turn with it: after each run of the
 * one there is a run of the other, and they change places from run to run. Both are timed alike, the solve alone. What
 * else the machine does then meets both; CPU time does not count what it takes away altogether. A seed's time is the
 * median of its runs. Returns false where memory ran out.
 */
bool paper_measure_pair(paper_problem *problem, uint64_t first, paper_pair *pair);

/* Times one method that needs no seeds, `repeats` times (at most 60). */
paper_measurement paper_measure(paper_problem *problem, const pinch_solver_settings *settings, int repeats);

/* The same for pinch_statics_solve, whatever its settings choose. */
paper_measurement paper_measure_statics(const paper_example *example, pinch_statics *statics,
                                        const pinch_statics_settings *settings, int repeats);

#endif
