/* pinch bench: the benchmarks by name. */
#include "bench.h"

#include <string.h>

static const struct {
    const char *name;
    command_status (*run)(const options *o);
    const char *summary;
} benchmarks[] = {
    {"collide", bench_collide, "contacts of two geoms by fingertip geometry and by ODE, beside ODE's own box-box"},
    {"paper", bench_paper, "the paper's examples: NSNGRK, NSNMGK, our default and Lemke's method beside the published"},
};
enum { BENCHMARKS = sizeof benchmarks / sizeof benchmarks[0] };

static command_status run_bench(const options *o)
{
    for (int i = 0; i < BENCHMARKS; i++)
        if (strcmp(o->arguments[0], benchmarks[i].name) == 0) return benchmarks[i].run(o);
    command_error("bench", "unknown benchmark \"%s\"; there are:", o->arguments[0]);
    for (int i = 0; i < BENCHMARKS; i++) fprintf(stderr, "  %-10s %s\n", benchmarks[i].name, benchmarks[i].summary);
    return COMMAND_BAD_INPUT;
}

static const option_id bench_options[] = {OPTION_JSON, OPTION_PLOT, OPTION_QUIET, OPTION_COUNT};

const command command_bench = {
    .name = "bench",
    .arguments = "NAME",
    .summary = "a benchmark: collide, paper",
    .min_arguments = 1,
    .max_arguments = 1,
    .options = bench_options,
    .run = run_bench,
};
