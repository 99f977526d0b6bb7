/* pinch study: many trials of one scene with varied quantities. */
#define _POSIX_C_SOURCE 200809L

#include "command.h"

#include "common/jobs.h"
#include "common/output.h"
#include "common/own_place.h"
#include "common/process.h"
#include "common/terminal.h"
#include "common/whole_file.h"
#include "study/beside.h"
#include "study/conduct.h"
#include "study/report.h"
#include "study/trial.h"

#include <limits.h>
#include <pinch/version.h>
#include <stdlib.h>
#include <string.h>

static command_status refuse(const char *text, scene_status status)
{
    terminal_text(text, stderr);
    fputc('\n', stderr);
    return status == SCENE_NO_MEMORY ? COMMAND_SYSTEM : COMMAND_BAD_INPUT;
}

static command_status fail(const results_error *error)
{
    command_error("study", "%s", error->text);
    return error->status;
}

/* ---- One trial. ---- */

static command_status check_index(const study *s, long index)
{
    if (index < s->samples) return COMMAND_DONE;
    command_error("study", "--trial: expected a trial from 0 to %ld, got %ld", s->samples - 1, index);
    return COMMAND_BAD_INPUT;
}

static void print_inputs(const study *s, json_t *inputs, int run)
{
    const char *place;
    json_t *value;
    terminal_print(stderr, "%s:", s->name);
    json_object_foreach(inputs, place, value)
    {
        char *text = json_dumps(value, JSON_ENCODE_ANY | JSON_COMPACT | JSON_REAL_PRECISION(6));
        terminal_print(stderr, " %s = %s", place, text ? text : "?");
        free(text);
    }
    const char *direction = protocol_direction(&s->protocol, run);
    terminal_print(stderr, "%s%s\n", *direction ? ", force along " : "", direction);
}

/* Prints the scene of a trial, or runs it as `pinch run` does. */
static command_status show_trial(const options *o, const study *s)
{
    long index = o->given[OPTION_TRIAL] ? o->trial : 0;
    scene_error error;
    scene *drawn;
    double begin;
    command_status status = check_index(s, index);
    if (status != COMMAND_DONE) return status;
    int run = 0;
    dInitODE2(0);
    json_t *inputs = trial_inputs(s, index, o->print ? NULL : &run);
    world_close_ode();
    if (!inputs) return refuse("out of memory", SCENE_NO_MEMORY);
    scene_status read = trial_scene(s, inputs, run, &drawn, &begin, &error);
    if (read != SCENE_OK) {
        json_decref(inputs);
        return refuse(error.text, read);
    }
    if (o->print) {
        status = scene_print(drawn, stdout) == SCENE_OK ? COMMAND_DONE : COMMAND_SYSTEM;
    } else {
        if (!o->quiet) print_inputs(s, inputs, run);
        status = command_run_scene(o, drawn);
    }
    scene_free(drawn);
    json_decref(inputs);
    return status;
}

/* ---- All trials. ---- */

static bool put_row(void *context, const json_t *names, json_t *row)
{
    FILE *stream = context;
    bool header = ftell(stream) == 0;
    for (int k = header ? 0 : 1; k < 2; k++)
        for (size_t i = 0; i < json_array_size(row); i++) {
            const json_t *cell = json_array_get(k == 0 ? names : row, i);
            const char *end = i + 1 < json_array_size(row) ? "," : "\n";
            char number[32];
            if (json_is_string(cell)) {
                csv_text(json_string_value(cell), "", stream);
                fputs(end, stream);
                continue;
            }
            number[0] = '\0';
            if (json_is_integer(cell))
                snprintf(number, sizeof number, "%" JSON_INTEGER_FORMAT, json_integer_value(cell));
            if (json_is_real(cell)) json_number_text(json_real_value(cell), number);
            fprintf(stream, "%s%s", number, end);
        }
    return !ferror(stream);
}

static bool put_csv(results *r, FILE *stream, results_error *error)
{
    return results_make_view(r, error) &&
           results_query(r, "SELECT * FROM results ORDER BY trial", put_row, stream, error);
}

/* The command that runs a trial again, but for --trial, as a shell reads it. NULL when memory runs out. */
static char *start_of_command(const options *o, const study *s)
{
    static const option_id repeated[] = {OPTION_CONTACT_SOLVER, OPTION_STEP};
    char *start = NULL;
    size_t size;
    FILE *stream = open_memstream(&start, &size);
    if (!stream) return NULL;
    fputs("pinch study ", stream);
    options_print_word(s->file, stream);
    for (size_t i = 0; i < sizeof repeated / sizeof *repeated; i++) {
        if (!o->given[repeated[i]]) continue;
        fprintf(stream, " --%s ", options_name(repeated[i]));
        options_print_word(o->text[repeated[i]], stream);
    }
    if (fclose(stream) == 0) return start;
    free(start);
    return NULL;
}

static command_status close_file(whole_file *file, const char *path, bool good, const results_error *error)
{
    if (!whole_file_close(file, good) && good) return command_cannot_write("study", path);
    return good ? COMMAND_DONE : fail(error);
}

static command_status write_csv(const char *path, results *r)
{
    whole_file file;
    results_error error;
    if (!path) return COMMAND_DONE;
    if (!whole_file_open(&file, path)) return command_cannot_write("study", path);
    return close_file(&file, path, put_csv(r, file.stream, &error), &error);
}

static command_status write_report(const options *o, const study *s, results *r, const page_libraries *libraries,
                                   const json_t *beside)
{
    whole_file file;
    results_error error;
    if (!o->report) return COMMAND_DONE;
    char *start = start_of_command(o, s);
    report_settings settings = {libraries, start, beside};
    command_status status = COMMAND_SYSTEM;
    if (!start)
        command_error("study", "out of memory");
    else if (!whole_file_open(&file, o->report))
        status = command_cannot_write("study", o->report);
    else
        status = close_file(&file, o->report, study_report(r, s, &settings, file.stream, &error), &error);
    free(start);
    return status;
}

/* ---- Beside other results. ---- */

static long count_of(const json_t *beside, const char *key)
{
    return (long)json_integer_value(json_object_get(json_object_get(beside, "trials"), key));
}

static void print_verdicts(const json_t *list)
{
    size_t i;
    json_t *v;
    json_array_foreach(list, i, v) putchar(json_is_true(json_object_get(v, "success")) ? '+' : '-');
}

static void print_beside(const study *s, const json_t *beside)
{
    size_t i;
    json_t *of;
    const char *here = world_solver_name(s->contact_solver),
               *other = json_string_value(json_object_get(beside, "contact_solver"));
    terminal_print(
        stdout,
        "  beside %s (%s): %ld trials, %ld succeed and %ld fail with both, %ld succeed here alone, %ld there alone\n",
        json_string_value(json_object_get(beside, "results")), other, count_of(beside, "compared"),
        count_of(beside, "both_succeed"), count_of(beside, "both_fail"), count_of(beside, "only_here"),
        count_of(beside, "only_beside"));
    json_array_foreach(json_object_get(beside, "refined"), i, of)
    {
        if (i == 0) terminal_print(stdout, "  trial, verdicts while the step is halved (+ success), who is right:\n");
        terminal_print(stdout, "  %8ld  %s ", (long)json_integer_value(json_object_get(of, "trial")), here);
        print_verdicts(json_object_get(of, "here"));
        terminal_print(stdout, "  %s ", other);
        print_verdicts(json_object_get(of, "beside"));
        const char *right = json_string_value(json_object_get(of, "right"));
        terminal_print(stdout, "  %s\n",
                       strcmp(right, "here") == 0     ? here
                       : strcmp(right, "beside") == 0 ? other
                                                      : right);
    }
}

static command_status attach(const options *o, results *r)
{
    results_error error;
    if (!o->beside || results_attach(r, o->beside, &error)) return COMMAND_DONE;
    return fail(&error);
}

/* Brings trials on which both differ to verdicts that stay. */
static command_status refine(const options *o, const study *s, results *r, crew *c)
{
    results_error error;
    conduct_settings settings = {.progress = !o->quiet};
    crew_order *list = NULL;
    if (!o->refine) return COMMAND_DONE;
    if (!beside_orders(r, s, o->refine, &list, &settings.list_count, &error)) {
        free(list);
        return fail(&error);
    }
    settings.list = list;
    command_status status = conduct(s, r, c, &settings, &error);
    free(list);
    return status == COMMAND_DONE || status >= COMMAND_INTERRUPTED ? status : fail(&error);
}

/* ---- What is shown. ---- */

static json_t *run_document(const conduct_run *run)
{
    return json_pack("{s:i, s:I, s:f, s:o}", "workers", run->workers, "trials", (json_int_t)run->trials, "elapsed_s",
                     run->elapsed, "busy", run->trials > 0 ? json_real(run->busy) : json_null());
}

static command_status present(const options *o, const study *s, results *r, const page_libraries *libraries,
                              const conduct_run *run)
{
    results_error error;
    results_counts n;
    json_t *beside = NULL;
    if (o->beside && !(beside = beside_document(r, s, &error))) return fail(&error);
    command_status status = write_csv(o->csv, r);
    if (status == COMMAND_DONE) status = write_report(o, s, r, libraries, beside);
    if (status == COMMAND_DONE && !results_count(r, &n, &error)) status = fail(&error);
    if (status != COMMAND_DONE) {
        json_decref(beside);
        return status;
    }
    if (o->json) {
        json_t *document =
            json_pack("{s:s, s:s, s:o, s:I, s:I, s:I, s:I, s:I, s:b}", "command", "study", "study", s->name, "results",
                      json_text(o->out), "trials", (json_int_t)n.trials, "done", (json_int_t)n.done, "succeeded",
                      (json_int_t)n.succeeded, "unsolved", (json_int_t)n.unsolved, "refused", (json_int_t)n.refused,
                      "interrupted", process_interrupted() != 0);
        json_object_set_new(document, "run", run_document(run));
        if (beside) json_object_set(document, "beside", beside);
        json_print_new(document, stdout);
    } else if (!o->quiet) {
        terminal_print(stdout, "%s: %ld of %ld trials, %ld succeeded", s->name, n.done, n.trials, n.succeeded);
        if (n.done > 0) terminal_print(stdout, " (%.2f %%)", 100.0 * (double)n.succeeded / (double)n.done);
        terminal_print(stdout, "\n");
        if (n.unsolved > 0)
            terminal_print(stdout, "  %ld were not solved or not verified; they do not count as success\n", n.unsolved);
        if (n.refused > 0) terminal_print(stdout, "  %ld draws are no legal scenes\n", n.refused);
        if (run->trials > 0)
            terminal_print(stdout, "  %ld trials in %.3g s by %d, busy for %.1f %% of it\n", run->trials, run->elapsed,
                           run->workers, 100.0 * run->busy);
        if (beside) print_beside(s, beside);
    }
    json_decref(beside);
    return COMMAND_DONE;
}

static command_status conduct_trials(const options *o, const study *s, results *r, crew *c,
                                     const page_libraries *libraries)
{
    results_error error;
    conduct_run run = {.workers = c->size};
    conduct_settings settings = {
        .limit = o->given[OPTION_LIMIT] ? o->limit : LONG_MAX, .progress = !o->quiet, .run = &run};
    command_status status = conduct(s, r, c, &settings, &error);
    if (status != COMMAND_DONE && status < COMMAND_INTERRUPTED) {
        c->end(c, true);
        return fail(&error);
    }
    if (status == COMMAND_DONE) status = refine(o, s, r, c);
    c->end(c, status != COMMAND_DONE);
    if (status != COMMAND_DONE && status < COMMAND_INTERRUPTED) return status;
    command_status shown = present(o, s, r, libraries, &run);
    if (status >= COMMAND_INTERRUPTED) {
        results_counts n = {0};
        (void)results_count(r, &n, &error);
        command_error("study", "%s: interrupted after %ld of %ld trials; --resume goes on", o->out, n.done, n.trials);
    }
    return status != COMMAND_DONE ? status : shown;
}

static command_status run_trials(const options *o, study *s, results *r, bool ranks, const page_libraries *libraries)
{
    crew c;
    int jobs = o->given[OPTION_JOBS] ? o->jobs : jobs_default();
    if ((long)jobs > s->samples) jobs = (int)s->samples;
    dInitODE2(0);
    command_status status = COMMAND_SYSTEM;
    if (ranks) crew_of_ranks(&c);
    if (ranks || crew_of_processes(&c, jobs, conduct_work, s))
        status = conduct_trials(o, s, r, &c, libraries);
    else
        command_error("study", "no process could be started");
    world_close_ode();
    return status;
}

static command_status check_trials(const study *s)
{
    scene_error error;
    dInitODE2(0);
    scene_status status = trial_check(s, &error);
    world_close_ode();
    return status == SCENE_OK ? COMMAND_DONE : refuse(error.text, status);
}

/* What is written when all trials are done may be hours away. What is there stays. */
static command_status check_written(const char *path)
{
    return !path || whole_file_can_be_written(path) ? COMMAND_DONE : command_cannot_write("study", path);
}

/* What could go wrong at the end is looked at before anything is begun. */
static command_status check_ends(const options *o, const study *s)
{
    results_error error;
    command_status status = check_written(o->csv);
    if (status == COMMAND_DONE) status = check_written(o->report);
    if (status != COMMAND_DONE || !o->beside || results_check_beside(o->beside, s, &error)) return status;
    return fail(&error);
}

/* Rank 0, or a process without MPI. */
static command_status run_all(const options *o, study *s, bool ranks)
{
    results_error error;
    page_libraries *libraries = NULL;
    command_status status = check_trials(s);
    if (status == COMMAND_DONE) status = check_ends(o, s);
    if (status == COMMAND_DONE && o->report) status = page_libraries_load("study", &libraries);
    if (status != COMMAND_DONE) return status;
    process_keep_signals(); /* from here on the end is in order */
    results *r = results_open(o->out, s, pinch_version(), o->study_resume, &error);
    status = r ? attach(o, r) : fail(&error);
    if (status == COMMAND_DONE) status = run_trials(o, s, r, ranks, libraries);
    page_libraries_free(libraries);
    if (!results_close(r, &error) && status == COMMAND_DONE) status = fail(&error);
    return status;
}

#define MODULE "libpinch_mpi.so"

/* *rank and *size are 0 and 1 for a process that MPI did not start. */
static command_status start_ranks(int *rank, int *size)
{
    static const char *const places[] = {MODULE, PINCH_LIBRARY_FROM_COMMAND "/" MODULE, NULL};
    char path[4096], reason[1024];
    *rank = 0;
    *size = 1;
    if (!crew_under_mpi()) return COMMAND_DONE;
    if (!own_place_find(places, path, sizeof path)) {
        command_error("study", "started by MPI, but this pinch was built without it (" MODULE " is missing); "
                               "install libopenmpi-dev and build again, or start it without mpirun");
        return COMMAND_SYSTEM;
    }
    if (crew_start_mpi(path, rank, size, reason, sizeof reason)) return COMMAND_DONE;
    command_error("study", "MPI: %s", reason);
    return COMMAND_SYSTEM;
}

static command_status run_with_ranks(const options *o, study *s)
{
    int rank, size;
    command_status status = start_ranks(&rank, &size);
    if (status != COMMAND_DONE) return status;
    if (rank > 0) {
        dInitODE2(0);
        if (!crew_work_as_rank(conduct_work, s)) status = COMMAND_SYSTEM;
        world_close_ode();
    } else {
        status = run_all(o, s, size > 1);
        fflush(stdout);
    }
    /* ranks that wait for orders are ended where rank 0 has failed */
    crew_leave_mpi((int)status);
    return status;
}

/* What is of all trials says nothing of one, and the other way round. */
static command_status check_options(const options *o, bool one)
{
    static const option_id of_all[] = {OPTION_OUT,    OPTION_JOBS,   OPTION_STUDY_RESUME, OPTION_LIMIT,
                                       OPTION_BESIDE, OPTION_REFINE, OPTION_REPORT,       OPTION_COUNT};
    static const option_id of_one[] = {OPTION_VIEW, OPTION_GLTF, OPTION_COUNT};
    static const option_id of_run[] = {OPTION_VIEW, OPTION_GLTF, OPTION_CSV, OPTION_JSON, OPTION_COUNT};
    command_status status = COMMAND_DONE;
    if (one) status = command_refuse_given(o, of_all, "expected without --trial and --print, which are of one trial");
    if (!one) status = command_refuse_given(o, of_one, "expected --trial K with it");
    if (status == COMMAND_DONE && o->print)
        status = command_refuse_given(o, of_run, "expected without --print, which runs nothing");
    return status;
}

/* Outputs must not be files that the trials are made from. */
static command_status check_files(const options *o, const study *s)
{
    command_status status = command_check_file(o, s->scene_file);
    if (status == COMMAND_DONE && s->table.file) status = command_check_file(o, s->table.file);
    for (size_t i = 0; i < s->file_count && status == COMMAND_DONE; i++)
        status = command_check_file(o, s->file_names[i]);
    return status;
}

static command_status run_study(const options *o)
{
    study *s;
    scene_error error;
    bool one = o->print || o->given[OPTION_TRIAL];
    if (!one && !o->given[OPTION_OUT]) {
        command_error("study", "expected --out RESULTS.sqlite, --trial K or --print");
        return COMMAND_BAD_INPUT;
    }
    if (check_options(o, one) != COMMAND_DONE) return COMMAND_BAD_INPUT;
    scene_status read = study_load(o->arguments[0], &s, &error);
    if (read != SCENE_OK) return refuse(error.text, read);
    s->contact_solver = o->contact_solver;
    if (o->given[OPTION_STEP]) s->step = o->step;
    command_status status = check_files(o, s);
    if (status == COMMAND_DONE) status = one ? show_trial(o, s) : run_with_ranks(o, s);
    study_free(s);
    return status;
}

static const option_id study_options[] = {
    OPTION_OUT, OPTION_JOBS,           OPTION_STUDY_RESUME, OPTION_LIMIT, OPTION_BESIDE, OPTION_REFINE,
    OPTION_CSV, OPTION_REPORT,         OPTION_TRIAL,        OPTION_PRINT, OPTION_GLTF,   OPTION_VIEW,
    OPTION_FPS, OPTION_CONTACT_SOLVER, OPTION_STEP,         OPTION_JSON,  OPTION_QUIET,  OPTION_COUNT,
};

const command command_study = {
    .name = "study",
    .arguments = "STUDY",
    .files = "json",
    .summary = "runs a scene in many trials with varied quantities, and keeps the results in a database",
    .min_arguments = 1,
    .max_arguments = 1,
    .options = study_options,
    .run = run_study,
};
