/* pinch compare: Pinch, quickstep and worldstep on the same scenes, taking turns step by step. */
#include "json_output.h"
#include "run.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CONTENDERS = 3 };

typedef struct contender {
    world *w;
    simulation *simulation;
    simulation_result result;
    double *step_s; /* wall time of every step */
} contender;

static double length(const double *v)
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The median over the run: a machine that does other things as well must not decide. The times are sorted at the end.
 */
static double step_us(const contender *c)
{
    return c->w->steps > 0 ? 1e6 * c->step_s[c->w->steps / 2] : NAN;
}

static const char *contender_name(const contender *c)
{
    static const char *const names[] = {"pinch", "quickstep", "worldstep"};
    return names[c->w->settings.contact_solver];
}

/* Pinch's cost over the faster of ODE's two. */
static double cost_ratio(const contender *c)
{
    return step_us(&c[0]) / fmin(step_us(&c[1]), step_us(&c[2]));
}

static bool was_dropped(const simulation_result *r)
{
    for (int i = 0; i < r->event_count; i++)
        if (r->events[i].type == EVENT_DROPPED) return true;
    return false;
}

static void print_fingers(const contender *contenders, FILE *stream)
{
    const world *first = contenders[0].w;
    fprintf(stream, "  %-12s", "finger");
    for (int k = 0; k < CONTENDERS; k++)
        fprintf(stream, " | %-9s %9s %9s %9s", contender_name(&contenders[k]), "normal N", "tang. N", "slip um");
    fputc('\n', stream);
    for (int i = 0; i < first->finger_count; i++) {
        fprintf(stream, "  %-12s", first->fingers[i].finger->name);
        for (int k = 0; k < CONTENDERS; k++) {
            const world_finger_state *s = &contenders[k].w->fingers[i].state;
            fprintf(stream, " | %-9s %9.4f %9.4f %9.3g", pinch_contact_state_text(s->state), s->normal_force,
                    length(s->tangential_force), 1e6 * s->slip_total);
        }
        fputc('\n', stream);
    }
}

static void print_row(const contender *c, FILE *stream)
{
    const simulation_result *r = &c->result;
    char verified[8] = "-";
    if (c->w->plugin) strcpy(verified, run_status(c->w) == PINCH_SOLVE_CONVERGED ? "yes" : "no");
    fprintf(stream, "  %-12s %12.6g %11.3g %11.3g %11.2g %11.2g %9s %9.2f%s\n", contender_name(c),
            1e3 * length(r->displacement), 1e6 * r->creep, 1e3 * r->creep_angular, r->force_error, r->torque_error,
            verified, step_us(c), was_dropped(r) ? "  dropped" : "");
}

static void print_table(const contender *contenders, FILE *stream)
{
    const world *w = contenders[0].w;
    fprintf(stream, "%s: %g s, %ld steps\n", w->scene->name, w->time, w->steps);
    print_fingers(contenders, stream);
    fprintf(stream, "  %-12s %12s %11s %11s %11s %11s %9s %9s\n", "", "moved mm", "creep um/s", "mrad/s", "balance N",
            "N m", "verified", "us/step");
    for (int k = 0; k < CONTENDERS; k++) print_row(&contenders[k], stream);
    fprintf(stream, "  a step with Pinch costs %.2f times the faster of ODE's two\n\n", cost_ratio(contenders));
}

static json_t *contender_document(const contender *c)
{
    const simulation_result *r = &c->result;
    json_t *forces = json_array();
    for (int i = 0; i < c->w->finger_count; i++)
        (void)json_array_append_new(forces, json_numbers(c->w->fingers[i].state.force, 3));
    return json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:b}", "contact_solver", contender_name(c),
                     "status", pinch_solve_status_text(run_status(c->w)), "step_us", json_number(step_us(c)),
                     "displacement", json_numbers(r->displacement, 3), "creep", json_number(r->creep), "creep_angular",
                     json_number(r->creep_angular), "force_error", json_number(r->force_error), "torque_error",
                     json_number(r->torque_error), "forces", forces, "dropped", was_dropped(r));
}

static json_t *scene_document(const contender *contenders)
{
    json_t *list = json_array();
    for (int k = 0; k < CONTENDERS; k++) (void)json_array_append_new(list, contender_document(&contenders[k]));
    return json_pack("{s:s, s:o, s:o}", "scene", contenders[0].w->scene->file, "cost_ratio",
                     json_number(cost_ratio(contenders)), "contact_solvers", list);
}

static command_status start(contender *contenders, const scene *s)
{
    static const world_solver solvers[CONTENDERS] = {WORLD_PINCH, WORLD_QUICKSTEP, WORLD_WORLDSTEP};
    world_settings settings = world_default_settings(s);
    for (int k = 0; k < CONTENDERS; k++) {
        char error[256];
        settings.contact_solver = solvers[k];
        world_status status = world_create(s, &settings, &contenders[k].w, error);
        if (status != WORLD_OK) {
            command_error("compare", "%s: %s", s->file, error);
            return COMMAND_SYSTEM;
        }
        contenders[k].simulation = simulation_start(contenders[k].w);
        if (!contenders[k].simulation) return COMMAND_SYSTEM;
        contenders[k].step_s = calloc((size_t)simulation_steps(contenders[k].simulation) + 1, sizeof(double));
        if (!contenders[k].step_s) return COMMAND_SYSTEM;
    }
    return COMMAND_DONE;
}

static command_status take_turns(contender *contenders)
{
    long steps = simulation_steps(contenders[0].simulation);
    for (long step = 0; step < steps; step++) {
        for (int k = 0; k < CONTENDERS; k++) {
            contender *c = &contenders[k];
            double before = c->w->step_s;
            world_status status = simulation_step(c->simulation);
            if (status == WORLD_NO_MEMORY) return COMMAND_SYSTEM;
            if (status == WORLD_DIVERGED) {
                command_error("compare", "%s: with %s the numbers grew out of range at %g s", c->w->scene->file,
                              contender_name(c), c->w->time);
                return COMMAND_FAILED;
            }
            c->step_s[step] = c->w->step_s - before;
        }
    }
    for (int k = 0; k < CONTENDERS; k++) qsort(contenders[k].step_s, (size_t)steps, sizeof(double), ascending);
    return COMMAND_DONE;
}

static void end(contender *contenders)
{
    for (int k = 0; k < CONTENDERS; k++) {
        if (contenders[k].simulation) {
            simulation_finish(contenders[k].simulation, &contenders[k].result);
            simulation_free(&contenders[k].result);
        }
        world_destroy(contenders[k].w);
        free(contenders[k].step_s);
    }
}

static command_status compare_scene(const options *o, const scene *s, json_t *scenes)
{
    contender contenders[CONTENDERS];
    memset(contenders, 0, sizeof contenders);
    command_status status = start(contenders, s);
    if (status == COMMAND_DONE) status = take_turns(contenders);
    if (status == COMMAND_DONE) {
        for (int k = 0; k < CONTENDERS; k++) {
            simulation_finish(contenders[k].simulation, &contenders[k].result);
            contenders[k].simulation = NULL;
        }
        if (run_status(contenders[0].w) != PINCH_SOLVE_CONVERGED) status = COMMAND_FAILED;
        if (o->json && json_array_append_new(scenes, scene_document(contenders))) status = COMMAND_SYSTEM;
        if (!o->json && !o->quiet) print_table(contenders, stdout);
        for (int k = 0; k < CONTENDERS; k++) simulation_free(&contenders[k].result);
    }
    end(contenders);
    return status;
}

static command_status run_compare(const options *o)
{
    json_t *scenes = json_array();
    command_status worst = COMMAND_DONE;
    dInitODE2(0);
    for (int i = 0; i < o->argument_count; i++) {
        scene *s;
        command_status status = command_load_scene(o, o->arguments[i], &s);
        if (status == COMMAND_DONE) status = command_check_run("compare", s);
        if (status == COMMAND_DONE) status = compare_scene(o, s, scenes);
        if (s) scene_free(s);
        if (status == COMMAND_SYSTEM) command_error("compare", "%s: out of memory", o->arguments[i]);
        if (status > worst) worst = status;
    }
    dCloseODE();
    if (o->json) {
        json_t *document = json_pack("{s:s, s:O}", "command", "compare", "scenes", scenes);
        if (document)
            json_print(document, stdout);
        else
            worst = COMMAND_SYSTEM;
        json_decref(document);
    }
    json_decref(scenes);
    return worst;
}

static const option_id compare_options[] = {
    OPTION_SOLVER, OPTION_TOLERANCE, OPTION_MAX_ITERATIONS, OPTION_DURATION,
    OPTION_STEP,   OPTION_JSON,      OPTION_QUIET,          OPTION_COUNT,
};

const command command_compare = {
    .name = "compare",
    .arguments = "SCENE...",
    .summary = "Pinch, quickstep and worldstep side by side on the same scenes",
    .min_arguments = 1,
    .max_arguments = INT_MAX,
    .options = compare_options,
    .run = run_compare,
};
