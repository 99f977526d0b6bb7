#ifndef PINCH_BENCH_H
#define PINCH_BENCH_H

#include "common/command_status.h"
#include "common/progress.h"

#include <stdbool.h>
#include <stdint.h>

/* What `pinch bench NAME` was asked for. */
typedef struct bench_request {
    const char *name; /* the benchmark's name */
    uint64_t seed;
    bool faithful;          /* paper: NSNGRK and NSNMGK alone */
    int faces;              /* paper: faces of the friction pyramid; 0: all the numbers of faces that the paper has */
    int min_size, max_size; /* steps: sizes outside are left out */
    int threads;            /* steps, threads: the threads of Pinch, the most of them; 0: the benchmark's own number */
    double budget;          /* s of measuring; 0: the benchmark's own budget */
    const char *plot;       /* folder for plots; NULL: none */
    const char *report;     /* paper: HTML file; NULL: none */
    bool json, quiet;
    progress *line; /* tells how far it has come; progress_end comes before anything is printed */
} bench_request;

/* paper.c: the examples of the paper beside what it published. */
command_status bench_paper(const bench_request *request);
/* collide.c: contacts of two geoms by Pinch's collision detection and by ODE. */
command_status bench_collide(const bench_request *request);
/* steps.c: a step of a world with each solver. Its table has the benchmarks by name. */
command_status bench_steps(const bench_request *request);

/* pareto.c: force error over time per step, of many settings of ODE's solvers and Pinch. */
command_status bench_pareto(const bench_request *request);
/* threads.c: the same worlds with one thread and with more. */
command_status bench_threads(const bench_request *request);
/* robot_hands.c: hands with joints, motors and tendons that hold something. */
command_status bench_robots(const bench_request *request);

/* sizes.c: is the size one that the request does not leave out? */
bool bench_wants_size(const bench_request *request, int size);
/* sizes.c: complains where the request leaves out all sizes in the lists, each of which ends with a 0. */
command_status bench_check_sizes(const bench_request *request, const int *const *lists, int count);

/* Seeds dRand, from which quickstep draws the order of its rows. */
void bench_seed_ode(uint64_t seed);

#endif
