/* pinch bench: the benchmarks by name. */
#include "bench.h"

#include <string.h>

static const struct {
    const char *name;
    command_status (*run)(const options *o);
    const char *summary;
} benchmarks[] = {
    {"articulated", bench_articulated, "hands of five fingers with three hinges each: a step beside ODE's solvers"},
    {"carried", bench_carried, "the hands of `hands` carried up and down: nothing is at rest"},
    {"cold", bench_cold, "hands without a warm start"},
    {"collide", bench_collide, "contacts of two geoms by fingertip geometry and by ODE, beside ODE's own box-box"},
    {"hands", bench_hands, "grasps of five fingertips, 1 to 10,000 in a world"},
    {"paper", bench_paper, "the paper's examples: NSNGRK, NSNMGK, our default and Lemke's method beside the published"},
    {"pile", bench_pile, "walls, box and sphere piles of 60 to 2,000 bodies, stiff contacts"},
    {"slip", bench_slip, "everything slipping"},
    {"step", bench_step_of_object, "one object held by 2 to 10,000 fingertips"},
};
enum { BENCHMARKS = sizeof benchmarks / sizeof benchmarks[0] };

static command_status run_bench(const options *o)
{
    for (int i = 0; i < BENCHMARKS; i++)
        if (strcmp(o->arguments[0], benchmarks[i].name) == 0) return benchmarks[i].run(o);
    command_error("bench", "unknown benchmark \"%s\"; there are:", o->arguments[0]);
    for (int i = 0; i < BENCHMARKS; i++) fprintf(stderr, "  %-12s %s\n", benchmarks[i].name, benchmarks[i].summary);
    return COMMAND_BAD_INPUT;
}

static const option_id bench_options[] = {OPTION_MIN_SIZE, OPTION_MAX_SIZE, OPTION_THREADS, OPTION_BUDGET,
                                          OPTION_JSON,     OPTION_PLOT,     OPTION_QUIET,   OPTION_COUNT};

const command command_bench = {
    .name = "bench",
    .arguments = "NAME",
    .summary = "a benchmark: articulated, carried, cold, collide, hands, paper, pile, slip, step",
    .min_arguments = 1,
    .max_arguments = 1,
    .options = bench_options,
    .run = run_bench,
};
