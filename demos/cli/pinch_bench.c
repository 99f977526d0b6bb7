/* pinch bench: the benchmarks by name. */
#include "command.h"

#include "bench/bench.h"

#include <limits.h>
#include <string.h>

static const option_id paper_takes[] = {OPTION_SEED,   OPTION_FAITHFUL, OPTION_FACES, OPTION_BUDGET, OPTION_JSON,
                                        OPTION_REPORT, OPTION_PLOT,     OPTION_QUIET, OPTION_COUNT};
static const option_id collide_takes[] = {OPTION_SEED, OPTION_BUDGET, OPTION_JSON, OPTION_QUIET, OPTION_COUNT};
static const option_id robots_take[] = {OPTION_SEED, OPTION_MIN_SIZE, OPTION_MAX_SIZE, OPTION_BUDGET,
                                        OPTION_JSON, OPTION_QUIET,    OPTION_COUNT};
static const option_id pareto_takes[] = {OPTION_SEED, OPTION_MIN_SIZE, OPTION_MAX_SIZE, OPTION_BUDGET,
                                         OPTION_JSON, OPTION_PLOT,     OPTION_QUIET,    OPTION_COUNT};
static const option_id threads_take[] = {OPTION_SEED,   OPTION_MIN_SIZE, OPTION_MAX_SIZE, OPTION_THREADS,
                                         OPTION_BUDGET, OPTION_JSON,     OPTION_QUIET,    OPTION_COUNT};
static const option_id steps_take[] = {OPTION_SEED, OPTION_MIN_SIZE, OPTION_MAX_SIZE, OPTION_THREADS, OPTION_BUDGET,
                                       OPTION_JSON, OPTION_PLOT,     OPTION_QUIET,    OPTION_COUNT};

static const struct {
    const char *name;
    command_status (*run)(const bench_request *request);
    const option_id *takes;
    const char *summary;
} benchmarks[] = {
    {"articulated", bench_steps, steps_take,
     "hands of five fingers with three hinges each: a step beside ODE's solvers"},
    {"carried", bench_steps, steps_take, "the hands of `hands` carried up and down, so that nothing is at rest"},
    {"cold", bench_steps, steps_take, "hands without a warm start"},
    {"collide", bench_collide, collide_takes,
     "contacts of two geoms by Pinch's collision detection and by ODE's, beside ODE's own box-box"},
    {"hands", bench_steps, steps_take, "grasps of five fingertips, 1 to 10,000 in a world"},
    {"paper", bench_paper, paper_takes,
     "the paper's examples: NSNGRK, NSNMGK, our default and Lemke's method beside the published values"},
    {"pareto", bench_pareto, pareto_takes,
     "grasps: force error over time per step, of worldstep and of quickstep with 10 to 1,000 iterations beside Pinch"},
    {"pile", bench_steps, steps_take, "walls, box and sphere piles of 60 to 2,000 bodies, stiff contacts"},
    {"pyramid", bench_steps, steps_take,
     "pyramids of 55 to 5,050 boxes whose neighbours touch without load, or do not touch"},
    {"robots", bench_robots, robots_take,
     "hands of 16 and 24 joints with motors and tendons that hold a cube, at rest and shaken, beside quickstep"},
    {"slip", bench_steps, steps_take, "grasps in which every contact slips"},
    {"step", bench_steps, steps_take, "one object held by 2 to 10,000 fingertips"},
    {"threads", bench_threads, threads_take, "carried hands, walls and heaps: what further threads gain"},
};
enum { BENCHMARKS = sizeof benchmarks / sizeof benchmarks[0] };

static const char *benchmark_name(int i)
{
    return i < BENCHMARKS ? benchmarks[i].name : NULL;
}

/* Refuses an option that means nothing for this benchmark, with a message. */
static command_status check_options(const options *o, const char *name, const option_id *takes)
{
    option_id wrong = options_beyond(o, takes);
    if (wrong == OPTION_COUNT) return COMMAND_DONE;
    char known[256];
    options_list(takes, known, sizeof known);
    command_error("bench", "--%s means nothing for %s; it takes%s", options_name(wrong), name, known);
    return COMMAND_BAD_INPUT;
}

static bench_request request_from(const options *o, const char *name)
{
    return (bench_request){
        .name = name,
        .seed = o->seed,
        .faithful = o->faithful,
        .faces = o->faces,
        .min_size = o->min_size,
        .max_size = o->given[OPTION_MAX_SIZE] ? o->max_size : INT_MAX,
        .threads = o->given[OPTION_THREADS] ? o->threads : 0,
        .budget = o->budget,
        .plot = o->plot,
        .report = o->report,
        .json = o->json,
        .quiet = o->quiet,
    };
}

static command_status run_bench(const options *o)
{
    for (int i = 0; i < BENCHMARKS; i++) {
        if (strcmp(o->arguments[0], benchmarks[i].name) != 0) continue;
        command_status status = check_options(o, benchmarks[i].name, benchmarks[i].takes);
        if (status != COMMAND_DONE) return status;
        if (o->given[OPTION_MAX_SIZE] && o->max_size < o->min_size) {
            command_error("bench", "--max-size: expected at least the --min-size of %d, got %d", o->min_size,
                          o->max_size);
            return COMMAND_BAD_INPUT;
        }
        progress line;
        bench_request request = request_from(o, benchmarks[i].name);
        request.line = &line;
        progress_start(&line, !o->quiet);
        status = benchmarks[i].run(&request);
        progress_end(&line);
        return status;
    }
    command_error("bench", "unknown benchmark \"%s\"; there are:", o->arguments[0]);
    for (int i = 0; i < BENCHMARKS; i++) fprintf(stderr, "  %-12s %s\n", benchmarks[i].name, benchmarks[i].summary);
    return COMMAND_BAD_INPUT;
}

static const option_id bench_options[] = {OPTION_SEED,     OPTION_FAITHFUL, OPTION_FACES,  OPTION_MIN_SIZE,
                                          OPTION_MAX_SIZE, OPTION_THREADS,  OPTION_BUDGET, OPTION_JSON,
                                          OPTION_PLOT,     OPTION_REPORT,   OPTION_QUIET,  OPTION_COUNT};

const command command_bench = {
    .name = "bench",
    .arguments = "NAME",
    .summary = "runs a benchmark: articulated, carried, cold, collide, hands, paper, pareto, pile, pyramid, robots, "
               "slip, step, threads",
    .notes =
        "All benchmarks take --seed, --json and --quiet. paper also takes --faithful (NSNGRK and NSNMGK alone),\n"
        "--faces (that number of faces alone), --budget, --report and --plot; collide takes --budget; robots takes\n"
        "--min-size, --max-size and --budget; pareto takes these and --plot; threads takes these and --threads,\n"
        "the most that it tries; the others take all of them. The seed sets the rows that NSNGRK draws in paper\n"
        "(50 seeds are run, from this one on), the poses in collide, and the order in which quickstep takes its\n"
        "rows in the others.",
    .min_arguments = 1,
    .max_arguments = 1,
    .argument_name = benchmark_name,
    .options = bench_options,
    .run = run_bench,
};
