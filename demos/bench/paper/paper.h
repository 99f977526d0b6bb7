/* The parts of `pinch bench paper`:
 *
 *     examples.c   the examples of Ai and Li (2025), and what is published of them
 *     measure.c    iterations, residuals and times of the methods
 *     rows.c       the table of them
 *     answers.c    what the examples are, the answers, the residual curves
 *     solvers.c    every solver on the examples
 *     random.c     every solver on random grasps
 *     dynamics.c   the run scenes by the paper's method
 *     peers.c      solvers of others
 *     verdicts.c   published values beside ours, and the paper's claims
 *     page.c       all of it as a page, with drawings.c
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
    paper_spread speedup; /* over the seeds; a seed's is the median over its rounds */
    int rounds;           /* how often each seed was run */
} paper_pair;

/*
 * Times NSNGRK with the seeds from `first` on, each several times, and NSNMGK in turn with it. Both are timed alike,
 * the solve alone. CPU time does not count what other programs take away altogether, but they slow what they leave:
 * each run of NSNGRK is therefore compared with the mean of the two runs of NSNMGK right before and after it. A seed's
 * time is the median of its runs. It ends after `budget` seconds, but not before each has run
 * once; with a budget of 0 after a second, but not before each has run five times. Returns false where memory ran out.
 */
bool paper_measure_pair(paper_problem *problem, uint64_t first, double budget, paper_pair *pair);

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

/* answers.c: what an example is, what both methods and the default mode answer, and how the residual falls. */
json_t *paper_example_document(paper_example *e, pinch_statics *statics, uint64_t first_seed, const json_t *about);

/* solvers.c: every solver on one example. */
json_t *paper_solvers_document(paper_example *e, pinch_statics *statics, int faces);

/* random.c: every solver on random grasps of growing size. */
enum { PAPER_RANDOM_SIZES = 7 };
json_t *paper_random_document(const bench_request *o);

/* dynamics.c: the run scenes by the paper's method and by the default mode. */
json_t *paper_dynamics_document(const bench_request *o);

/* peers.c: ADMM on the exact cone of a grasp without force limits. Writes the forces r of the fingers and nothing else.
 * The tolerance is for newtons and metres alike. */
pinch_solver_result paper_admm(const pinch_grasp *grasp, double tolerance, int max_iterations,
                               pinch_finger_result *fingers);
/* Modulus-based Gauss-Seidel splitting; z[size] receives the solution, v[size] is scratch. */
pinch_solver_result paper_modulus(const pinch_lcp *lcp, double tolerance, int max_iterations, double *z, double *v);

/* verdicts.c: published values beside ours, and the claims of the paper. Both read the document made so far. */
json_t *paper_comparison_document(const json_t *document, const json_t *published);
json_t *paper_claims_document(const json_t *document);

/* drawings.c: inline SVG of one of the document's examples and of its curves. */
void paper_draw_configuration(const json_t *example, FILE *stream);
void paper_draw_curves(const json_t *curves, FILE *stream);

/* page.c: the whole document as a page that needs no network. */
void paper_page(const json_t *document, FILE *stream);

#endif
