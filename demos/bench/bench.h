#ifndef PINCH_BENCH_H
#define PINCH_BENCH_H

#include "cli/command.h"

#include <pinch/statics.h>

/* The benchmarks of `pinch bench NAME`: one function each, listed in bench.c. */
command_status bench_paper(const options *o);
command_status bench_collide(const options *o);
command_status bench_step_of_object(const options *o);
command_status bench_hands(const options *o);
command_status bench_articulated(const options *o);
command_status bench_carried(const options *o);
command_status bench_slip(const options *o);
command_status bench_cold(const options *o);
command_status bench_pile(const options *o);

/* Seeds dRand, from which quickstep draws the order of its rows. */
void bench_seed_ode(uint64_t seed);

/* One of the paper's examples, ready to be solved. */
typedef struct paper_example {
    const char *name; /* "1", "1b", "2", "3", "4" */
    scene *s;
    pinch_finger *fingers;
    pinch_finger_result *results;
    pinch_grasp grasp;
    bool frictional;
} paper_example;

/* The paper's own settings on an example: faithful, linearized. */
pinch_statics_settings paper_settings(int faces, pinch_solver solver, uint64_t seed);

/* log10 RES against IT of both methods for the examples the paper has figures of; SVG, PNG and the data into `folder`.
 * NSNGRK draws by `seed`. */
command_status paper_plot(const char *folder, uint64_t seed, paper_example *examples, int count,
                          pinch_statics *statics);

#endif
