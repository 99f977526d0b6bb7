/* pinch exec: an unmodified ODE program with Pinch under it. */
#define _POSIX_C_SOURCE 200809L

#include "exec_launch.h"

#include "command.h"
#include "preload/report.h"

#include <pinch/ode_dropin.h>

#include <errno.h>
#include <jansson.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

static const char STEPPING_SOLVERS[] = "nsnmgk, nsngrk or newton";

static bool can_step(const options *o)
{
    return !o->given[OPTION_SOLVER] || command_pair_exists(COMMAND_RUN, o->solver, SCENE_COULOMB);
}

static command_status refuse_key(const char *file, const char *key, const char *expected)
{
    command_error("exec", "%s: $.%s: expected %s", file, key, expected);
    return COMMAND_BAD_INPUT;
}

/* One key of the configuration; what the command line says as well stays as it is there. */
static command_status read_key(const char *file, const char *key, const json_t *value, options *o)
{
    option_id id = options_find(key);
    if (id == OPTION_COUNT || id == OPTION_CONFIG || !options_takes(o->command, id))
        return refuse_key(file, key, "a known key (only, kt_ratio, solver, tolerance, max_iterations, stats)");
    char number[64], expected[160];
    const char *text = ""; /* which no option takes */
    if (json_is_number(value) && options_is_number(id)) {
        snprintf(number, sizeof number, "%.17g", json_number_value(value));
        text = number;
    } else if (json_is_string(value) && !options_is_number(id)) {
        text = json_string_value(value);
    }
    options read = *o;
    if (!options_store(&read, id, text, expected, sizeof expected)) return refuse_key(file, key, expected);
    read.given[id] = true;
    if (!can_step(&read)) return refuse_key(file, key, STEPPING_SOLVERS);
    if (!o->given[id]) *o = read;
    return COMMAND_DONE;
}

/* *document stays the caller's to release: texts of the options point into it. */
static command_status read_config(options *o, json_t **document)
{
    json_error_t error;
    FILE *stream = fopen(o->config, "r");
    if (!stream) {
        command_error("exec", "%s: cannot be read: %s", o->config, strerror(errno));
        return COMMAND_BAD_INPUT;
    }
    *document = json_loadf(stream, JSON_REJECT_DUPLICATES, &error);
    fclose(stream);
    if (!*document) {
        command_error("exec", "%s:%d: expected JSON: %s", o->config, error.line, error.text);
        return COMMAND_BAD_INPUT;
    }
    if (!json_is_object(*document)) {
        command_error("exec", "%s: $: expected an object", o->config);
        return COMMAND_BAD_INPUT;
    }
    const char *key;
    json_t *value;
    command_status status = COMMAND_DONE;
    json_object_foreach(*document, key, value)
    {
        if (status == COMMAND_DONE) status = read_key(o->config, key, value, o);
    }
    return status;
}

static bool set_text(const char *name, const char *value)
{
    return (value ? setenv(name, value, 1) : unsetenv(name)) == 0;
}

static bool set_number(const char *name, bool given, double value)
{
    char text[64];
    snprintf(text, sizeof text, "%.17g", value);
    return set_text(name, given ? text : NULL);
}

/* What is not given is taken out, whatever was in the environment before. */
static bool set_environment(const options *o)
{
    static const char *const scopes[] = {"all", "soft", "material"};
    return set_text(PINCH_ENV_SCOPE, o->given[OPTION_ONLY] ? scopes[o->only] : NULL) &&
           set_text(PINCH_ENV_SOLVER, o->given[OPTION_SOLVER] ? pinch_solver_name(o->solver) : NULL) &&
           set_number(PINCH_ENV_RATIO, o->given[OPTION_KT_RATIO], o->kt_ratio) &&
           set_number(PINCH_ENV_TOLERANCE, o->given[OPTION_TOLERANCE], o->tolerance) &&
           set_number(PINCH_ENV_MAX_ITERATIONS, o->given[OPTION_MAX_ITERATIONS], o->max_iterations);
}

/* The settings as the statistics of a program show them that Pinch does not reach. */
static void use_settings(const options *o)
{
    pinch_ode_settings settings = pinch_ode_default_settings();
    if (o->given[OPTION_ONLY]) settings.scope = (pinch_ode_scope)o->only;
    if (o->given[OPTION_SOLVER]) settings.solver.solver = o->solver;
    if (o->given[OPTION_KT_RATIO]) settings.tangential_ratio = o->kt_ratio;
    if (o->given[OPTION_TOLERANCE]) settings.solver.tolerance = o->tolerance;
    if (o->given[OPTION_MAX_ITERATIONS]) settings.solver.max_iterations = o->max_iterations;
    if (settings.solver.goal > settings.solver.tolerance) settings.solver.goal = settings.solver.tolerance;
    (void)pinch_dropin_set_settings(&settings);
}

static command_status run_exec(const options *given)
{
    options o = *given;
    if (!can_step(&o)) {
        command_error("exec", "--solver: expected %s, got \"%s\"", STEPPING_SOLVERS, pinch_solver_name(o.solver));
        return COMMAND_BAD_INPUT;
    }
    json_t *document = NULL;
    command_status status = o.given[OPTION_CONFIG] ? read_config(&o, &document) : COMMAND_DONE;
    if (status == COMMAND_DONE) {
        use_settings(&o);
        if (set_environment(&o)) {
            status = exec_launch(o.given[OPTION_STATS] ? o.stats : NULL, o.arguments, o.argument_count);
        } else {
            command_error("exec", "out of memory");
            status = COMMAND_SYSTEM;
        }
    }
    json_decref(document);
    return status;
}

static const option_id exec_options[] = {OPTION_ONLY,           OPTION_KT_RATIO, OPTION_SOLVER, OPTION_TOLERANCE,
                                         OPTION_MAX_ITERATIONS, OPTION_CONFIG,   OPTION_STATS,  OPTION_COUNT};

const command command_exec = {
    .name = "exec",
    .arguments = "-- PROGRAM [ARGUMENTS...]",
    .summary = "an unmodified ODE program with Pinch as its contact solver",
    .notes =
        "The program reaches Pinch through the dynamic symbols of libode.so.8. Out of reach are programs that are\n"
        "linked with libode.a or statically as a whole, that run with other rights than their caller's (setuid),\n"
        "or that look ODE's functions up by themselves, with dlsym in a library they opened.\n\n"
        "--config FILE.json: {\"only\", \"kt_ratio\", \"solver\", \"tolerance\", \"max_iterations\", \"stats\"}; what "
        "is\n"
        "on the command line goes first. --stats is written whenever ODE is closed, at times when a world is\n"
        "destroyed, and at the end; on standard error only at the end. \"steps\": 0 in it means that no ODE world\n"
        "was ever stepped. Of several processes that step worlds it is the one that wrote last.\n\n"
        "Exit status: the program's own; 127 where there is no such program, 126 where it cannot be run; 2 for\n"
        "wrong options, 3 where the system fails or the library that Pinch loads is missing or damaged: then the\n"
        "program is not run.",
    .min_arguments = 1,
    .max_arguments = INT_MAX,
    .takes_program = true,
    .options = exec_options,
    .run = run_exec,
};
