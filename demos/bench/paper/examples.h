#ifndef PINCH_BENCH_PAPER_EXAMPLES_H
#define PINCH_BENCH_PAPER_EXAMPLES_H

#include "common/command_status.h"
#include "scenes/grasp.h"

#include <jansson.h>
#include <stdint.h>

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

#endif
