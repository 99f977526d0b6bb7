/* The parts of `pinch bench paper`:
 *
 *     examples.c   the examples of Ai and Li (2025), and what is published of them
 *     measure.c    iterations, residuals and times of the methods
 *     rows.c       the table of them
 */
#ifndef PINCH_BENCH_PAPER_H
#define PINCH_BENCH_PAPER_H

#include "bench/bench.h"
#include "scenes/grasp.h"

#include <jansson.h>
#include <stdint.h>
#include <stdio.h>

/* ---- examples.c ---- */

/* The examples of Ai and Li (2025), as assets/scenes/paper has them. */
enum { PAPER_EXAMPLES = 5, PAPER_MOST_FINGERS = 6 };

typedef struct paper_example {
    const char *name; /* "1", "1b", "2", "3", "4" */
    scene *s;
    pinch_finger *fingers;
    pinch_finger_result *results; /* as many */
    pinch_grasp grasp;
    bool frictional;
} paper_example;

/* Loads all examples, with a message where that fails. paper_unload releases what there is, whatever the outcome. */
command_status paper_load(paper_example examples[PAPER_EXAMPLES]);
void paper_unload(paper_example examples[PAPER_EXAMPLES]);

/* Reads assets/reference/paper.json: what is published, with tolerances. NULL, with a message, where that fails. */
json_t *paper_published(void);

/* The settings of the paper: start at 0, ||F|| <= 1e-4, at most 20,000 iterations. */
pinch_statics_settings paper_settings(int faces, pinch_solver solver, uint64_t seed);

/* The complementarity problem of an example as the paper solves it, with room for its solution. */
typedef struct paper_problem {
    const paper_example *example;
    int faces;
    pinch_lcp lcp;
    pinch_lcp_workspace *workspace;
    double *memory, *z, *w;
    bool *free_rows;
} paper_problem;

/* Returns false where memory ran out. paper_problem_free releases it in any case. */
bool paper_problem_create(pinch_statics *statics, const paper_example *example, int faces, paper_problem *problem);
void paper_problem_free(paper_problem *problem);

/* Solves the problem from z = 0 by the method of the settings. */
pinch_solver_result paper_problem_solve(paper_problem *problem, const pinch_solver_settings *settings);

/* ---- measure.c ---- */

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

/* ---- rows.c ---- */

/* The parts of the document of `pinch bench paper --json`. Each function returns NULL where memory ran out. */

/* One row of the table: an example with a number of faces. */
typedef struct paper_row {
    const char *example;
    int faces, size; /* faces 0: no friction; size: unknowns */
    paper_pair pair;
    paper_measurement standard, lemke; /* not with --faithful */
} paper_row;

/* rows.c */
bool paper_measure_row(const bench_request *o, paper_example *e, pinch_statics *statics, int faces, paper_row *row);
json_t *paper_row_document(const paper_row *row, bool faithful, const json_t *published);
json_t *paper_measurement_document(const paper_measurement *m);
/* The published number for that quantity; NULL where none survives. faces 0: no friction. */
const json_t *paper_published_value(const json_t *published, const char *example, int faces, const char *method,
                                    const char *quantity);

#endif
