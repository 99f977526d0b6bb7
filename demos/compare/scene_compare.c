/* One scene is run three times: by Pinch alone, for the hash and for the steps to sample; by all solvers in turn, for
 * metrics and cost; and by Pinch again, for the exact answers of the sampled steps. */
#include "scene_compare.h"

#include "common/measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* How far Pinch's forces may be from the exact ones, over the force scale. */
static const double FORCE_TOLERANCE = 1e-9;

/* A report has many scenes: their films have at most so many pictures a second, and in all. */
static const double FILM_RATE = 30, FILM_FRAMES = 150;

static command_status status_of(world_status status, const char *name, const scene *s)
{
    if (status == WORLD_OK) return COMMAND_DONE;
    if (status == WORLD_NO_MEMORY) {
        command_error("compare", "%s: out of memory", s->file);
        return COMMAND_SYSTEM;
    }
    command_error("compare", "%s: with %s the numbers grew out of range", s->file, name);
    return COMMAND_FAILED;
}

static solver_run *add(solver_run *list, int *count, const compare_settings *settings, const scene *s,
                       world_solver solver)
{
    solver_run *c = &list[(*count)++];
    memset(c, 0, sizeof *c);
    c->settings = world_default_settings(s);
    c->settings.contact_solver = solver;
    c->settings.manifolds = settings->manifolds && solver != WORLD_PINCH;
    c->settings.points = settings->points;
    c->settings.cold_start = settings->cold_start && solver == WORLD_PINCH;
    return c;
}

/* Names and world settings of the runs that the settings ask for, Pinch's first. Returns how many there are. */
static int list_runs(const compare_settings *settings, const scene *s, solver_run runs[COMPARE_MOST_RUNS])
{
    int count = 0;
    strcpy(add(runs, &count, settings, s, WORLD_PINCH)->name, "pinch");
    for (int i = 0; i < settings->count_count && settings->quickstep; i++) {
        solver_run *c = add(runs, &count, settings, s, WORLD_QUICKSTEP);
        c->settings.quickstep_iterations = settings->counts[i];
        snprintf(c->name, sizeof c->name, "quickstep-%d", settings->counts[i]);
    }
    if (settings->worldstep) strcpy(add(runs, &count, settings, s, WORLD_WORLDSTEP)->name, "worldstep");
    for (int k = 0; k < count && settings->films; k++)
        if (k < 2 || runs[k].settings.contact_solver == WORLD_WORLDSTEP)
            runs[k].film_rate = fmin(FILM_RATE, FILM_FRAMES / s->duration);
    return count;
}

/* A turn is short beside the seconds for which other programs disturb the machine, so that all runs are disturbed
 * alike, and long enough for a run to find its code and data in the caches again, as it would if it ran alone. */
enum { TURN = 50 }; /* steps */

static command_status run_in_turns(scene_comparison *c)
{
    long steps = simulation_steps(c->runs[0].simulation);
    for (long first = 0; first < steps; first += TURN)
        for (int k = 0; k < c->run_count; k++)
            for (long step = first; step < steps && step < first + TURN; step++) {
                solver_run *run = &c->runs[k];
                world_status status = solver_run_step(run, k ? &c->runs[0] : NULL);
                if (status != WORLD_OK) return status_of(status, run->name, c->s);
                job_share_step(c->settings->share);
            }
    for (int k = 0; k < c->run_count; k++) solver_run_finish(&c->runs[k]);
    return COMMAND_DONE;
}

/* Runs Pinch alone, for its hash and for the steps to sample. */
static command_status choose_steps(const scene_comparison *c, uint64_t *hash, chosen_step *steps_to_sample, int *count)
{
    char error[256];
    world *w;
    step_chooser chooser = {0};
    long steps = lround(c->s->duration / c->s->step);
    world_status status = world_create(c->s, &c->runs[0].settings, &w, error);
    if (status != WORLD_OK) return status_of(status, "pinch", c->s);
    if (!step_chooser_start(&chooser, w, steps)) status = WORLD_NO_MEMORY;
    while (w->steps < steps && status == WORLD_OK) {
        status = world_advance(w);
        if (status == WORLD_OK) step_chooser_after_step(&chooser);
        job_share_step(c->settings->share);
    }
    if (status == WORLD_OK) {
        *hash = world_hash(w);
        /* The exact answers know no joints: of a hand's steps none is sampled. */
        bool sampled = c->settings->samples > 0 && c->s->hand_count == 0;
        *count = sampled ? step_chooser_choose(&chooser, c->settings->samples, steps_to_sample) : 0;
    }
    step_chooser_free(&chooser);
    world_free(w);
    return status_of(status, "pinch", c->s);
}

/* What the observer of the third run works with. */
typedef struct sampler {
    scene_comparison *comparison;
    world_settings runs[COMPARE_MOST_RUNS];
    int next;
    double residuals[SAMPLE_RESIDUALS]; /* of the current step */
    int residual_count;
} sampler;

static void record_residual(void *context, int iteration, double residual)
{
    sampler *s = context;
    (void)iteration;
    if (s->residual_count < SAMPLE_RESIDUALS) s->residuals[s->residual_count++] = residual;
}

static void observe(void *context, const world *w)
{
    sampler *s = context;
    scene_comparison *c = s->comparison;
    if (s->next < c->sample_count && w->steps + 1 == c->samples[s->next].at.step) {
        sample *taken = &c->samples[s->next++];
        sample_take(w, s->runs, c->run_count, taken);
        taken->residual_count = s->residual_count;
        memcpy(taken->residuals, s->residuals, sizeof s->residuals);
    }
    s->residual_count = 0;
}

static command_status take_samples(scene_comparison *c)
{
    char error[256];
    world *w;
    sampler s = {.comparison = c};
    for (int k = 0; k < c->run_count; k++) s.runs[k] = c->runs[k].settings;
    world_settings settings = s.runs[0];
    settings.solver.progress = record_residual;
    settings.solver.progress_context = &s;
    world_status status = world_create(c->s, &settings, &w, error);
    if (status != WORLD_OK) return status_of(status, "pinch", c->s);
    w->observe = observe;
    w->observe_context = &s;
    while (s.next < c->sample_count && status == WORLD_OK) {
        status = world_advance(w);
        job_share_step(c->settings->share);
    }
    world_free(w);
    for (int k = 0; k < c->sample_count; k++)
        if (c->samples[k].status == SAMPLE_NO_MEMORY) status = WORLD_NO_MEMORY;
    return status_of(status, "pinch", c->s);
}

static void measure_errors(scene_comparison *c)
{
    double starts[COMPARE_MOST_SAMPLES];
    int start_count = 0;
    for (int i = 0; i < c->sample_count; i++)
        if (c->samples[i].status == SAMPLE_OK && c->samples[i].residual_count > 0)
            starts[start_count++] = c->samples[i].residuals[0];
    c->runs[0].metrics[METRIC_START_RESIDUAL] = median(starts, start_count);
    for (int k = 0; k < c->run_count; k++) {
        double errors[COMPARE_MOST_SAMPLES], *m = c->runs[k].metrics;
        int count = 0;
        for (int i = 0; i < c->sample_count; i++)
            if (c->samples[i].status == SAMPLE_OK) errors[count++] = c->samples[i].error[k];
        if (count == 0) continue;
        m[METRIC_FORCE_ERROR_MEDIAN] = median(errors, count);
        m[METRIC_FORCE_ERROR_MAX] = errors[count - 1];
    }
}

static command_status compare_bits(scene_comparison *c, uint64_t pinch_hash)
{
    for (int k = 0; k < c->run_count; k++) {
        solver_run *run = &c->runs[k];
        uint64_t hash = pinch_hash;
        world_status status = k ? solver_run_hash(run, c->s, c->settings->share, &hash) : WORLD_OK;
        if (status != WORLD_OK) return status_of(status, run->name, c->s);
        run->metrics[METRIC_DETERMINISTIC] = hash == run->hash;
    }
    return COMMAND_DONE;
}

/* Checks what Pinch promises: every step is verified, and with the exact cone and Pinch's own tolerance the forces are
 * exact. */
static command_status check_promises(const scene_comparison *c)
{
    const solver_run *pinch = &c->runs[0];
    const world_settings *settings = &pinch->settings;
    double error = pinch->metrics[METRIC_FORCE_ERROR_MAX];
    command_status status = COMMAND_DONE;
    if (world_solve_status(pinch->w) != PINCH_SOLVE_CONVERGED) {
        command_error("compare", "%s: Pinch's answers are not verified (%s)", c->s->file,
                      pinch_solve_status_text(world_solve_status(pinch->w)));
        status = COMMAND_FAILED;
    }
    for (int i = 0; i < c->sample_count; i++) {
        if (c->samples[i].status != SAMPLE_NO_EXACT) continue;
        command_error("compare", "%s: no exact answer was found for the step at %g s", c->s->file, c->samples[i].time);
        status = COMMAND_FAILED;
    }
    bool newton = settings->solver.solver == PINCH_SOLVER_NEWTON || settings->solver.solver == PINCH_SOLVER_NSNMGK;
    if (settings->faces == 0 && newton && error > fmax(FORCE_TOLERANCE, 100 * settings->solver.tolerance)) {
        command_error("compare", "%s: Pinch's forces differ from the exact ones by %.3g of the force scale", c->s->file,
                      error);
        status = COMMAND_FAILED;
    }
    return status;
}

static command_status run_all(scene_comparison *c, chosen_step *steps_to_sample)
{
    uint64_t hash = 0;
    int count = 0;
    command_status status = choose_steps(c, &hash, steps_to_sample, &count);
    if (status != COMMAND_DONE) return status;
    c->sample_count = count;
    for (int k = 0; k < count; k++) c->samples[k].at = steps_to_sample[k];
    for (int k = 0; k < c->run_count && status == COMMAND_DONE; k++)
        status = status_of(solver_run_start(&c->runs[k], c->s), c->runs[k].name, c->s);
    if (status == COMMAND_DONE) status = run_in_turns(c);
    if (status == COMMAND_DONE) status = compare_bits(c, hash);
    if (status == COMMAND_DONE) status = take_samples(c);
    if (status == COMMAND_DONE) measure_errors(c);
    return status;
}

command_status scene_compare(const scene *s, const compare_settings *settings, json_t **document)
{
    solver_run runs[COMPARE_MOST_RUNS];
    scene_comparison c = {.s = s, .settings = settings, .runs = runs};
    size_t most = (size_t)settings->samples + 1;
    chosen_step *steps_to_sample = calloc(most, sizeof *steps_to_sample);
    *document = NULL;
    c.samples = calloc(most, sizeof *c.samples);
    c.run_count = list_runs(settings, s, runs);
    /* Pinch alone, all in turn, ODE's solvers for their bits, and Pinch once more for the samples */
    job_share_start(settings->share, lround(s->duration / s->step) * (2L * c.run_count + (settings->samples > 0)),
                    s->step);
    command_status status = steps_to_sample && c.samples ? run_all(&c, steps_to_sample) : COMMAND_SYSTEM;
    if (status == COMMAND_DONE) {
        *document = scene_comparison_document(&c);
        status = *document ? check_promises(&c) : COMMAND_SYSTEM;
    }
    for (int k = 0; k < c.run_count; k++) solver_run_free(&runs[k]);
    for (int k = 0; k < c.sample_count; k++) sample_free(&c.samples[k]);
    free(c.samples);
    free(steps_to_sample);
    return status;
}
