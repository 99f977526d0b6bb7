/* pinch run: a scene in ODE, with Pinch or one of ODE's own solvers for the contacts. */
#define _POSIX_C_SOURCE 200809L

#include "run.h"

#include <math.h>
#include <stdlib.h>
#include <sys/stat.h>

static world_settings settings_from(const options *o, const scene *s)
{
    world_settings settings = world_default_settings(s);
    static const world_solver of_option[] = {WORLD_PINCH, WORLD_QUICKSTEP, WORLD_WORLDSTEP};
    settings.contact_solver = of_option[o->contact_solver];
    if (o->given[OPTION_SEED]) settings.solver.seed = o->seed;
    if (o->no_newton) settings.solver.newton_finish = false;
    return settings;
}

/* Steps the world through its duration, with a CSV row a step when `csv` is open. */
static world_status simulate(world *w, FILE *csv, simulation_result *result)
{
    simulation *s = simulation_start(w);
    if (!s) return WORLD_NO_MEMORY;
    world_status status = WORLD_OK;
    for (long k = 0; k < simulation_steps(s) && status == WORLD_OK && !(csv && ferror(csv)); k++) {
        status = simulation_step(s);
        if (csv && status == WORLD_OK) run_csv_row(w, csv);
    }
    simulation_finish(s, result);
    return status;
}

static bool is_regular(FILE *stream)
{
    struct stat about;
    return fstat(fileno(stream), &about) == 0 && S_ISREG(about.st_mode);
}

/* A CSV file that could not be completed is removed; a device or pipe is not ours to remove. */
static command_status simulate_and_record(const options *o, world *w, simulation_result *result)
{
    FILE *csv = NULL;
    if (o->csv) {
        csv = fopen(o->csv, "w");
        if (!csv) {
            command_error("run", "%s: cannot be written", o->csv);
            return COMMAND_SYSTEM;
        }
        run_csv_header(w, csv);
    }
    world_status status = simulate(w, csv, result);
    bool written = true;
    if (csv) {
        bool removable = is_regular(csv);
        written = !ferror(csv);
        written = fclose(csv) == 0 && written;
        if ((!written || status == WORLD_NO_MEMORY) && removable) remove(o->csv);
    }
    if (!written)
        command_error("run", "%s: cannot be written", o->csv);
    else if (status == WORLD_NO_MEMORY)
        command_error("run", "out of memory");
    return written && status != WORLD_NO_MEMORY ? COMMAND_DONE : COMMAND_SYSTEM;
}

static command_status present(const options *o, const world *w, const simulation_result *result)
{
    if (o->json) {
        if (!run_print_json(w, result, stdout)) {
            command_error("run", "out of memory");
            return COMMAND_SYSTEM;
        }
    } else if (!o->quiet) {
        run_print_table(w, result, stdout);
    }
    return run_status(w) == PINCH_SOLVE_CONVERGED ? COMMAND_DONE : COMMAND_FAILED;
}

static command_status run_scene(const options *o, const scene *s)
{
    char error[256];
    world *w;
    simulation_result result = {.events = NULL};
    world_settings settings = settings_from(o, s);
    dInitODE2(0);
    command_status status = COMMAND_SYSTEM;
    switch (world_create(s, &settings, &w, error)) {
    case WORLD_OK:
        status = simulate_and_record(o, w, &result);
        if (status == COMMAND_DONE) status = present(o, w, &result);
        simulation_free(&result);
        world_destroy(w);
        break;
    default:
        command_error("run", "%s", error);
    }
    dCloseODE();
    return status;
}

static command_status run_run(const options *o)
{
    scene *s;
    command_status status = command_load_scene(o, o->arguments[0], &s);
    if (status != COMMAND_DONE) return status;
    if (o->contact_solver == OPTION_PINCH) status = command_check_run("run", s);
    if (status == COMMAND_DONE) status = run_scene(o, s);
    scene_free(s);
    return status;
}

static const option_id run_options[] = {
    OPTION_SOLVER, OPTION_FORMULATION, OPTION_TOLERANCE, OPTION_MAX_ITERATIONS, OPTION_FACES,
    OPTION_SEED,   OPTION_NO_NEWTON,   OPTION_DURATION,  OPTION_STEP,           OPTION_CONTACT_SOLVER,
    OPTION_JSON,   OPTION_CSV,         OPTION_QUIET,     OPTION_COUNT,
};

const command command_run = {
    .name = "run",
    .arguments = "SCENE",
    .summary = "simulates a scene in ODE with Pinch as contact solver",
    .min_arguments = 1,
    .max_arguments = 1,
    .options = run_options,
    .run = run_run,
};
