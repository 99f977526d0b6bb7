/* pinch compare: Pinch, quickstep and worldstep on the same scenes, and the exact answer of single steps. */
#define _POSIX_C_SOURCE 200809L

#include "command.h"

#include "common/jobs.h"
#include "common/output.h"
#include "common/process.h"
#include "common/terminal.h"
#include "common/utf8.h"
#include "common/whole_file.h"
#include "compare/access.h"
#include "compare/baseline.h"
#include "compare/report/report.h"
#include "compare/scene_compare.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

typedef struct comparison {
    const options *o;
    compare_settings settings;
} comparison;

static compare_settings settings_from(const options *o)
{
    compare_settings s = {
        .count_count = 3,
        .counts = {20, 50, 200},
        .quickstep = !o->given[OPTION_CONTACT_SOLVER] || o->contact_solver == WORLD_QUICKSTEP,
        .worldstep = !o->given[OPTION_CONTACT_SOLVER] || o->contact_solver == WORLD_WORLDSTEP,
        .manifolds = o->contacts == OPTION_CONTACTS_PINCH,
        .points = o->given[OPTION_POINTS] ? o->points : pinch_ode_default_settings().manifold_points,
        .cold_start = o->cold_start,
        .films = o->report != NULL,
        .samples = o->given[OPTION_SAMPLES] ? o->samples : 24,
    };
    if (!o->given[OPTION_QUICKSTEP_ITERATIONS]) return s;
    s.count_count = o->quickstep_iterations.count;
    memcpy(s.counts, o->quickstep_iterations.values, sizeof s.counts);
    return s;
}

static command_status compare_one(void *context, int index, job_share *share, json_t **document)
{
    const comparison *c = context;
    compare_settings settings = c->settings;
    settings.share = share;
    scene *s;
    command_status status = command_load_scene(c->o, c->o->arguments[index], &s);
    if (status != COMMAND_DONE) return status;
    status = command_check_run("compare", s);
    if (status == COMMAND_DONE) {
        dInitODE2(0);
        status = scene_compare(s, &settings, document);
        world_close_ode();
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

/* Prints the command line that repeats the first failure alone. --save is left out, because it would leave a baseline
 * of one scene. */
static void print_repeat_command(const options *o, const job_result *results, const json_t *check)
{
    for (int i = 0; i < o->argument_count; i++) {
        if (results[i].status >= COMMAND_INTERRUPTED) return;
        if (results[i].status == COMMAND_DONE && !has_moved(check, o->arguments[i])) continue;
        const char *argument = o->arguments[i];
        fputs("pinch compare: to repeat the first failure: ", stderr);
        options_print(o, OPTION_SAVE, &argument, 1, stderr);
        fputc('\n', stderr);
        return;
    }
}

/* ---- The tables that a person reads. ---- */

/* A terminal has room for three runs: Pinch, the first of quickstep's, and worldstep. */
static json_t *runs_to_show(const json_t *of_scene)
{
    const json_t *runs = json_object_get(of_scene, "runs");
    json_t *shown = json_array();
    bool quick = false;
    for (size_t k = 0; k < json_array_size(runs); k++) {
        json_t *run = json_array_get(runs, k);
        bool is_quick = json_is_integer(json_object_get(run, "quickstep_iterations"));
        if (!(is_quick && quick)) (void)json_array_append(shown, run);
        quick = quick || is_quick;
    }
    return shown;
}

static void print_fingers(const json_t *of_scene, FILE *stream)
{
    json_t *runs = runs_to_show(of_scene);
    size_t fingers = json_array_size(json_object_get(json_array_get(runs, 0), "fingers"));
    terminal_print(stream, "  %-14s", "finger");
    for (size_t k = 0; k < json_array_size(runs); k++)
        terminal_print(stream, " | %-24s %8s", access_text(json_array_get(runs, k), "run"), "slip um");
    fputc('\n', stream);
    for (size_t i = 0; i < fingers; i++) {
        const json_t *first = json_array_get(json_object_get(json_array_get(runs, 0), "fingers"), i);
        terminal_print(stream, "  %-14.14s", access_text(first, "name"));
        for (size_t k = 0; k < json_array_size(runs); k++) {
            const json_t *f = json_array_get(json_object_get(json_array_get(runs, k), "fingers"), i);
            char text[3][48];
            terminal_print(stream, " | %-5s %s %s %s", access_text(f, "state"),
                           number_for_people("%9.4f", access_number(f, "normal_force"), text[0]),
                           number_for_people("%8.4f", access_number(f, "tangential_force"), text[1]),
                           number_for_people("%8.3g", 1e6 * access_number(f, "slip"), text[2]));
        }
        fputc('\n', stream);
    }
    json_decref(runs);
}

static void print_run(const json_t *run, FILE *stream)
{
    char text[8][48];
    const json_t *verified = json_object_get(json_object_get(run, "metrics"), "verified");
    terminal_print(stream, "  %-16s %10s %10s %10s %s %s %s %9s %9s %8s%s\n", access_text(run, "run"),
                   number_for_people("%.2g", access_metric(run, METRIC_FORCE_ERROR_MAX), text[0]),
                   number_for_people("%.2g", access_metric(run, METRIC_FORCE_ERROR_MEDIAN), text[1]),
                   number_for_people("%.2g", access_metric(run, METRIC_FORCE_JITTER), text[2]),
                   number_for_people("%12.6g", 1e3 * access_metric(run, METRIC_DISPLACEMENT), text[5]),
                   number_for_people("%10.3g", 1e6 * access_metric(run, METRIC_CREEP_IN_HAND), text[6]),
                   number_for_people("%10.3g", 1e3 * access_metric(run, METRIC_CREEP_IN_HAND_ANGULAR), text[7]),
                   number_for_people("%.1e", access_metric(run, METRIC_MOMENTUM_ERROR), text[3]),
                   json_is_boolean(verified) ? (json_is_true(verified) ? "yes" : "no") : "-",
                   number_for_people("%.2f", access_metric(run, METRIC_COST), text[4]),
                   access_metric(run, METRIC_DROPPED) > 0 ? "  dropped" : "");
}

/* Prints one scene: its fingers, then its runs. */
static void print_scene(const json_t *of_scene, FILE *stream)
{
    const json_t *runs = json_object_get(of_scene, "runs");
    double ratio = access_number(of_scene, "cost_ratio");
    terminal_print(stream, "%s: %g s, %.0f steps; at the end, normal and tangential forces in N:\n",
                   access_text(of_scene, "name"), access_number(of_scene, "time_s"), access_number(of_scene, "steps"));
    print_fingers(of_scene, stream);
    terminal_print(stream, "  %-16s %10s %10s %10s %12s %10s %10s %9s %9s %8s\n", "", "force err.", "median",
                   "jitter N", "moved mm", "creep um/s", "mrad/s", "balance N", "verified", "us/step");
    for (size_t k = 0; k < json_array_size(runs); k++) print_run(json_array_get(runs, k), stream);
    if (!isnan(ratio)) terminal_print(stream, "  a step with Pinch costs %.2f times the fastest of ODE's\n", ratio);
    fputc('\n', stream);
}

/* Prints the force errors of all scenes by all runs, and what was dropped. All scenes have the same runs. */
static void print_summary(const json_t *scenes, FILE *stream)
{
    const json_t *head = json_object_get(json_array_get(scenes, 0), "runs");
    terminal_print(stream, "largest force error against the exact step, over the force scale; * dropped\n  %-22s",
                   "scene");
    for (size_t k = 0; k < json_array_size(head); k++)
        terminal_print(stream, " %14s", access_text(json_array_get(head, k), "run"));
    fputc('\n', stream);
    for (size_t i = 0; i < json_array_size(scenes); i++) {
        const json_t *of_scene = json_array_get(scenes, i), *runs = json_object_get(of_scene, "runs");
        terminal_print(stream, "  %-22.22s", access_text(of_scene, "name"));
        for (size_t k = 0; k < json_array_size(runs); k++) {
            char text[48];
            const json_t *run = json_array_get(runs, k);
            terminal_print(stream, " %13s%s",
                           number_for_people("%.2g", access_metric(run, METRIC_FORCE_ERROR_MAX), text),
                           access_metric(run, METRIC_DROPPED) > 0 ? "*" : " ");
        }
        fputc('\n', stream);
    }
}

static void print_tables(const json_t *scenes)
{
    for (size_t i = 0; i < json_array_size(scenes); i++) print_scene(json_array_get(scenes, i), stdout);
    if (json_array_size(scenes) > 1) print_summary(scenes, stdout);
}

/* ---- The files, each written as a whole or not at all. ---- */

static command_status write_file(const char *path, const json_t *document,
                                 void (*write)(const json_t *document, FILE *stream))
{
    whole_file file;
    if (whole_file_open(&file, path)) {
        write(document, file.stream);
        if (whole_file_close(&file, true)) return COMMAND_DONE;
    }
    return command_cannot_write("compare", path);
}

/* Writes a header line, then a row for each scene, run and metric. A metric without a value is left empty. */
static void write_csv(const json_t *document, FILE *stream)
{
    const json_t *scenes = json_object_get(document, "scenes");
    fputs("scene,run,metric,value,unit\n", stream);
    for (size_t i = 0; i < json_array_size(scenes); i++) {
        const json_t *of_scene = json_array_get(scenes, i), *runs = json_object_get(of_scene, "runs");
        for (size_t k = 0; k < json_array_size(runs); k++)
            for (int m = 0; m < METRIC_COUNT; m++) {
                const json_t *run = json_array_get(runs, k);
                double value = access_metric(run, (metric)m);
                char text[32] = "";
                if (!isnan(value)) json_number_text(value, text);
                csv_text(access_text(of_scene, "scene"), "", stream);
                fprintf(stream, ",%s,%s,%s,%s\n", access_text(run, "run"), metric_about((metric)m)->key, text,
                        metric_about((metric)m)->unit);
            }
    }
}

static void write_json(const json_t *document, FILE *stream)
{
    json_print((json_t *)document, stream);
}

static void write_picture(const json_t *document, FILE *stream)
{
    picture_write_file(json_array_get(json_object_get(document, "scenes"), 0), stream);
}

static command_status out_of_memory(void)
{
    command_error("compare", "out of memory");
    return COMMAND_SYSTEM;
}

static command_status save(const options *o, const json_t *document)
{
    char *made = NULL;
    size_t size;
    FILE *text = open_memstream(&made, &size);
    if (!text) return out_of_memory();
    options_print(o, OPTION_COUNT, (const char *const *)o->arguments, o->argument_count, text);
    json_t *baseline = fclose(text) == 0 ? baseline_document(document, made) : NULL;
    command_status status = baseline ? write_file(o->save, baseline, write_json) : out_of_memory();
    json_decref(baseline);
    free(made);
    return status;
}

static command_status write_report(const char *path, const json_t *document, const page_libraries *libraries)
{
    whole_file file;
    if (whole_file_open(&file, path)) {
        report_write(document, libraries, file.stream);
        if (whole_file_close(&file, true)) return COMMAND_DONE;
    }
    return command_cannot_write("compare", path);
}

/* Films and their drawings are for the report alone. */
static void drop_films(json_t *scenes)
{
    for (size_t i = 0; i < json_array_size(scenes); i++) {
        json_object_del(json_array_get(scenes, i), "films");
        json_object_del(json_array_get(scenes, i), "thumb");
    }
}

/* Writes --csv, --report and, where `complete` (every scene has its result), --save. */
static command_status write_outputs(const options *o, const json_t *document, const page_libraries *libraries,
                                    bool complete)
{
    command_status worst = COMMAND_DONE, status = o->csv ? write_file(o->csv, document, write_csv) : COMMAND_DONE;
    if (status > worst) worst = status;
    status = o->report ? write_report(o->report, document, libraries) : COMMAND_DONE;
    if (status > worst) worst = status;
    status = o->picture && complete ? write_file(o->picture, document, write_picture) : COMMAND_DONE;
    if (status > worst) worst = status;
    if (o->save && !complete)
        command_error("compare", "%s: not written: a baseline needs all scenes, verified", o->save);
    status = o->save && complete ? save(o, document) : COMMAND_DONE;
    return status > worst ? status : worst;
}

static void value_text(const json_t *move, const char *key, char text[48])
{
    double value = access_number(move, key);
    const char *unit = access_text(move, "unit");
    if (isnan(value))
        snprintf(text, 48, "nothing");
    else if (!*unit)
        snprintf(text, 48, "%s", value != 0 ? "yes" : "no");
    else
        snprintf(text, 48, "%.6g%s%s", value, strcmp(unit, "1") == 0 ? "" : " ", strcmp(unit, "1") == 0 ? "" : unit);
}

static void print_move(const json_t *move)
{
    char from[48], to[48], by[48] = "", limit[48];
    value_text(move, "from", from);
    value_text(move, "to", to);
    bool number = *access_text(move, "unit") && !isnan(access_number(move, "by"));
    if (number) value_text(move, "by", by);
    value_text(move, "limit", limit);
    command_error("compare", "%s, %s: %s moved from %s to %s%s%s%s%s", access_text(move, "scene"),
                  access_text(move, "run"), access_text(move, "metric"), from, to, number ? ", by " : "", by,
                  number ? "; the limit is " : "", number ? limit : "");
}

/* --check: names what moved, and adds it to the document as "check". Returns COMMAND_FAILED where something moved. */
static command_status check_against(const options *o, const json_t *baseline, json_t *document)
{
    if (!baseline) return COMMAND_DONE;
    json_t *moves = baseline_check(baseline, document);
    size_t count = json_array_size(moves);
    for (size_t i = 0; i < count; i++) print_move(json_array_get(moves, i));
    bool complete = json_array_size(json_object_get(document, "scenes")) == (size_t)o->argument_count;
    bool passed = complete && count == 0;
    json_t *check = json_pack("{s:o, s:b, s:o}", "baseline", json_text(o->check), "passed", passed, "moved", moves);
    if (!check || json_object_set_new(document, "check", check)) return out_of_memory();
    return passed ? COMMAND_DONE : COMMAND_FAILED;
}

/* Collects the documents of the scenes in their order, and returns the worst status. */
static command_status collect(const options *o, const job_result *results, json_t *scenes)
{
    command_status worst = COMMAND_DONE;
    for (int i = 0; i < o->argument_count; i++) {
        if (results[i].messages) fputs(results[i].messages, stderr);
        bool lost = results[i].document && json_array_append(scenes, results[i].document);
        if (lost || (results[i].status == COMMAND_SYSTEM && !results[i].messages)) worst = out_of_memory();
        if (results[i].status > worst) worst = results[i].status;
    }
    return worst;
}

static command_status present(const options *o, const json_t *baseline, const page_libraries *libraries,
                              json_t *document, job_result *results)
{
    command_status worst = collect(o, results, json_object_get(document, "scenes")), ended = worst;
    command_status status = check_against(o, baseline, document);
    if (status > worst) worst = status;
    /* A file that lacks one of the scenes would be no answer. */
    json_object_set_new(document, "interrupted", json_boolean(process_interrupted() != 0));
    if (process_interrupted())
        command_error("compare", "interrupted after %zu of %d scenes",
                      json_array_size(json_object_get(document, "scenes")), o->argument_count);
    status = ended == COMMAND_BAD_INPUT ? COMMAND_DONE : write_outputs(o, document, libraries, ended == COMMAND_DONE);
    if (status > worst) worst = status;
    drop_films(json_object_get(document, "scenes"));
    if (o->json)
        json_print(document, stdout);
    else if (!o->quiet)
        print_tables(json_object_get(document, "scenes"));
    if (o->argument_count > 1) print_repeat_command(o, results, json_object_get(document, "check"));
    return worst;
}

/* Checks what can be checked before anything runs: the baseline has these scenes, and in a new baseline no two scenes
 * have the same name. */
static command_status check_arguments(const options *o, json_t **baseline)
{
    static const option_id of_quickstep[] = {OPTION_QUICKSTEP_ITERATIONS, OPTION_COUNT};
    if (o->given[OPTION_CONTACT_SOLVER] && o->contact_solver != WORLD_QUICKSTEP &&
        command_refuse_given(o, of_quickstep, "expected --contact-solver quickstep, or all of them"))
        return COMMAND_BAD_INPUT;
    for (int i = 0; i < o->argument_count && o->save; i++)
        for (int k = 0; k < i; k++) {
            if (strcmp(baseline_name(o->arguments[i]), baseline_name(o->arguments[k])) != 0) continue;
            command_error("compare", "--save: two scenes are named %s", baseline_name(o->arguments[i]));
            return COMMAND_BAD_INPUT;
        }
    for (int i = 0; i < o->argument_count && (o->save || o->check); i++) {
        if (utf8_is(o->arguments[i])) continue;
        command_error("compare", "%s: a baseline is JSON: expected a file name in UTF-8", o->arguments[i]);
        return COMMAND_BAD_INPUT;
    }
    if (o->picture && o->argument_count != 1) {
        command_error("compare", "--picture: expected one scene to draw, got %d", o->argument_count);
        return COMMAND_BAD_INPUT;
    }
    return o->check ? baseline_load(o->check, o->arguments, o->argument_count, baseline) : COMMAND_DONE;
}

static command_status run_compare(const options *o)
{
    comparison c = {o, settings_from(o)};
    json_t *baseline = NULL;
    page_libraries *libraries = NULL;
    command_status status = check_arguments(o, &baseline);
    if (status == COMMAND_DONE && o->report) status = page_libraries_load("compare", &libraries);
    if (status != COMMAND_DONE) {
        json_decref(baseline);
        return status;
    }
    job_result *results = calloc((size_t)o->argument_count, sizeof *results);
    json_t *document = json_pack("{s:s, s:s, s:o, s:[]}", "command", "compare", "format", "pinch-compare/1", "settings",
                                 settings_document(o, &c.settings), "scenes");
    job_list list = {
        .count = o->argument_count,
        .at_a_time = o->given[OPTION_JOBS] ? o->jobs : jobs_default(),
        .work = compare_one,
        .name = name_of,
        .context = &c,
        .progress = !o->quiet,
    };
    status = COMMAND_SYSTEM;
    if (!results || !document)
        command_error("compare", "out of memory");
    else if (!jobs_run(&list, results))
        command_error("compare", "cannot start processes: %s", strerror(errno));
    else
        status = present(o, baseline, libraries, document, results);
    if (results) jobs_free(results, o->argument_count);
    free(results);
    json_decref(document);
    json_decref(baseline);
    page_libraries_free(libraries);
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
    OPTION_PICTURE,
    OPTION_JOBS,
    OPTION_QUIET,
    OPTION_COUNT,
};

const command command_compare = {
    .name = "compare",
    .arguments = "SCENE...",
    .summary = "compares Pinch, quickstep and worldstep on the same scenes, and with the exact answer",
    .notes = COMMAND_SCENE_NOTE
    "\n\n"
    "Every run starts from the same state. At sampled steps of Pinch's run the same contact problem is solved\n"
    "to machine precision by other means, and once by each of ODE's solvers. The differences from the exact\n"
    "answer are the force errors. --contact-solver pinch runs Pinch alone, quickstep or worldstep runs that\n"
    "one beside it. --points and --cold-start take something away from Pinch, to see what it does and that\n"
    "--check notices. Costs are medians of runs that take turns of 50 steps, and are quietest with --jobs 1.\n"
    "Nothing else depends on the jobs. assets/schema/pinch-compare-1.json describes the JSON document,\n"
    "assets/reference/compare.json is the baseline of the shipped scenes.",
    .min_arguments = 1,
    .max_arguments = INT_MAX,
    .files = "json",
    .options = compare_options,
    .run = run_compare,
};
