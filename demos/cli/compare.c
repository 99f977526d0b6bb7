/* pinch compare: Pinch, quickstep and worldstep on the same scenes, and the exact answer of single steps. */
#define _POSIX_C_SOURCE 200809L

#include "common/jobs.h"
#include "common/json_output.h"
#include "compare/access.h"
#include "compare/baseline.h"
#include "compare/outputs.h"
#include "compare/scene_compare.h"
#include "compare/table.h"
#include "run.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct comparison {
    const options *o;
    compare_settings settings;
} comparison;

static compare_settings settings_from(const options *o)
{
    compare_settings s = {
        .count_count = 3,
        .counts = {20, 50, 200},
        .quickstep = !o->given[OPTION_CONTACT_SOLVER] || o->contact_solver == OPTION_QUICKSTEP,
        .worldstep = !o->given[OPTION_CONTACT_SOLVER] || o->contact_solver == OPTION_WORLDSTEP,
        .manifolds = o->contacts == OPTION_CONTACTS_PINCH,
        .points = o->given[OPTION_POINTS] ? o->points : pinch_ode_default_settings().manifold_points,
        .cold_start = o->cold_start,
        .samples = o->given[OPTION_SAMPLES] ? o->samples : 24,
    };
    if (!o->given[OPTION_QUICKSTEP_ITERATIONS]) return s;
    s.count_count = o->quickstep_iterations.count;
    memcpy(s.counts, o->quickstep_iterations.values, sizeof s.counts);
    return s;
}

static command_status compare_one(void *context, int index, json_t **document)
{
    const comparison *c = context;
    scene *s;
    command_status status = command_load_scene(c->o, c->o->arguments[index], &s);
    if (status != COMMAND_DONE) return status;
    status = command_check_run("compare", s);
    if (status == COMMAND_DONE) {
        dInitODE2(0);
        status = scene_compare(s, &c->settings, document);
        dCloseODE();
    }
    scene_free(s);
    return status;
}

static const char *name_of(void *context, int index)
{
    return baseline_name(((const comparison *)context)->o->arguments[index]);
}

static json_t *settings_document(const options *o, const compare_settings *s)
{
    json_t *counts = json_array();
    for (int i = 0; i < s->count_count; i++) (void)json_array_append_new(counts, json_integer(s->counts[i]));
    return json_pack("{s:s, s:o, s:i, s:b, s:i, s:s?}", "contacts", s->manifolds ? "pinch" : "ode",
                     "quickstep_iterations", counts, "points", s->points, "cold_start", s->cold_start, "samples",
                     s->samples, "solver", o->given[OPTION_SOLVER] ? pinch_solver_name(o->solver) : NULL);
}

static bool has_moved(const json_t *check, const char *path)
{
    const json_t *moves = json_object_get(check, "moved");
    for (size_t i = 0; i < json_array_size(moves); i++)
        if (strcmp(access_text(json_array_get(moves, i), "scene"), baseline_name(path)) == 0) return true;
    return false;
}

/* The first scene that failed, by itself; without --save, which would leave a baseline of one scene. */
static void say_how_to_repeat(const options *o, const job_result *results, const json_t *check)
{
    for (int i = 0; i < o->argument_count; i++) {
        if (results[i].status == COMMAND_DONE && !has_moved(check, o->arguments[i])) continue;
        const char *argument = o->arguments[i];
        fputs("pinch compare: to repeat the first failure: ", stderr);
        options_print(o, OPTION_SAVE, &argument, 1, stderr);
        fputc('\n', stderr);
        return;
    }
}

static void print_tables(const json_t *scenes)
{
    for (size_t i = 0; i < json_array_size(scenes); i++) table_scene(json_array_get(scenes, i), stdout);
    if (json_array_size(scenes) > 1) table_summary(scenes, stdout);
}

/* The documents of the scenes that have one, in their order; the worst status. */
static command_status collect(const options *o, const job_result *results, json_t *scenes)
{
    command_status worst = COMMAND_DONE;
    for (int i = 0; i < o->argument_count; i++) {
        if (results[i].messages) fputs(results[i].messages, stderr);
        if (results[i].document && json_array_append(scenes, results[i].document)) worst = COMMAND_SYSTEM;
        if (results[i].status > worst) worst = results[i].status;
    }
    return worst;
}

static command_status present(const options *o, const json_t *baseline, json_t *document, job_result *results)
{
    command_status worst = collect(o, results, json_object_get(document, "scenes")), ended = worst;
    command_status status = outputs_check(o, baseline, document);
    if (status > worst) worst = status;
    /* a file that lacks a scene that was asked for is no answer */
    status = ended == COMMAND_BAD_INPUT ? COMMAND_DONE : outputs_write(o, document, ended == COMMAND_DONE);
    if (status > worst) worst = status;
    if (o->json)
        json_print(document, stdout);
    else if (!o->quiet)
        print_tables(json_object_get(document, "scenes"));
    if (o->argument_count > 1) say_how_to_repeat(o, results, json_object_get(document, "check"));
    return worst;
}

/* What can be said before anything runs: the baseline is one of these scenes, and scenes have names of their own there.
 */
static command_status check_arguments(const options *o, json_t **baseline)
{
    for (int i = 0; i < o->argument_count && o->save; i++)
        for (int k = 0; k < i; k++) {
            if (strcmp(baseline_name(o->arguments[i]), baseline_name(o->arguments[k])) != 0) continue;
            command_error("compare", "--save: two scenes are named %s", baseline_name(o->arguments[i]));
            return COMMAND_BAD_INPUT;
        }
    return o->check ? baseline_load(o->check, o->arguments, o->argument_count, baseline) : COMMAND_DONE;
}

static command_status run_compare(const options *o)
{
    comparison c = {o, settings_from(o)};
    json_t *baseline = NULL;
    command_status status = check_arguments(o, &baseline);
    if (status != COMMAND_DONE) return status;
    job_result *results = calloc((size_t)o->argument_count, sizeof *results);
    json_t *document = json_pack("{s:s, s:s, s:o, s:[]}", "command", "compare", "format", "pinch-compare/1", "settings",
                                 settings_document(o, &c.settings), "scenes");
    job_list list = {
        .count = o->argument_count,
        .at_a_time = o->given[OPTION_JOBS] ? o->jobs : jobs_default(),
        .work = compare_one,
        .name = name_of,
        .context = &c,
        .progress = !o->quiet && isatty(STDERR_FILENO),
    };
    status = COMMAND_SYSTEM;
    if (!results || !document)
        command_error("compare", "out of memory");
    else if (!jobs_run(&list, results))
        command_error("compare", "cannot start processes: %s", strerror(errno));
    else
        status = present(o, baseline, document, results);
    if (results) jobs_free(results, o->argument_count);
    free(results);
    json_decref(document);
    json_decref(baseline);
    return status;
}

static const option_id compare_options[] = {
    OPTION_SOLVER,
    OPTION_TOLERANCE,
    OPTION_MAX_ITERATIONS,
    OPTION_DURATION,
    OPTION_STEP,
    OPTION_CONTACT_SOLVER,
    OPTION_QUICKSTEP_ITERATIONS,
    OPTION_CONTACTS,
    OPTION_SAMPLES,
    OPTION_POINTS,
    OPTION_COLD_START,
    OPTION_JSON,
    OPTION_CSV,
    OPTION_SAVE,
    OPTION_CHECK,
    OPTION_REPORT,
    OPTION_JOBS,
    OPTION_QUIET,
    OPTION_COUNT,
};

const command command_compare = {
    .name = "compare",
    .arguments = "SCENE...",
    .summary = "Pinch, quickstep and worldstep side by side on the same scenes, and the exact answer",
    .notes = "Every run starts from the same state. At the sampled steps of Pinch's run the same contact problem is\n"
             "solved to machine precision by other means, and once by each of ODE's solvers: the differences are\n"
             "the force errors. --contact-solver pinch runs Pinch alone, quickstep or worldstep that one beside it.\n"
             "--points and --cold-start take something away from Pinch, to see what it does and that --check sees it.\n"
             "Costs are medians of runs that take turns; with --jobs 1 they are quietest. All else is the same\n"
             "whatever the jobs. assets/schema/pinch-compare-1.json describes the JSON document,\n"
             "assets/reference/compare.json is the baseline of the shipped scenes.",
    .min_arguments = 1,
    .max_arguments = INT_MAX,
    .options = compare_options,
    .run = run_compare,
};
