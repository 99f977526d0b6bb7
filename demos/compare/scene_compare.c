/* One scene: once alone for the same bits and the steps worth a look, once in turns for metrics and cost, and once more
 * for the exact answers. */
#include "scene_compare.h"

#include "cli/run.h"
#include "scene_document.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the force scale: what Pinch's forces may differ from the exact ones by. */
static const double FORCE_TOLERANCE = 1e-9;

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

static command_status take_turns(scene_comparison *c)
{
    long steps = simulation_steps(c->contenders[0].simulation);
    for (long step = 0; step < steps; step++)
        for (int k = 0; k < c->contender_count; k++) {
            contender *runs = &c->contenders[k];
            world_status status = contender_step(runs, k ? &c->contenders[0] : NULL);
            if (status != WORLD_OK) return status_of(status, runs->name, c->s);
        }
    for (int k = 0; k < c->contender_count; k++) contender_finish(&c->contenders[k]);
    return COMMAND_DONE;
}

/* Pinch alone: its hash, and which steps are worth a look. */
static command_status choose_moments(const scene_comparison *c, uint64_t *hash, moment *moments, int *count)
{
    char error[256];
    world *w;
    moment_watch watch = {0};
    long steps = lround(c->s->duration / c->s->step);
    world_status status = world_create(c->s, &c->contenders[0].settings, &w, error);
    if (status != WORLD_OK) return status_of(status, "pinch", c->s);
    if (!moments_start(&watch, w, steps)) status = WORLD_NO_MEMORY;
    while (w->steps < steps && status == WORLD_OK) {
        status = world_step(w);
        if (status == WORLD_OK) moments_after_step(&watch);
    }
    if (status == WORLD_OK) {
        *hash = world_hash(w);
        *count = c->settings->samples > 0 ? moments_choose(&watch, c->settings->samples, moments) : 0;
    }
    moments_free(&watch);
    world_destroy(w);
    return status_of(status, "pinch", c->s);
}

/* Where the observer of the third run puts what it sees. */
typedef struct sampler {
    scene_comparison *comparison;
    world_settings runs[CONTENDER_MOST];
    int next;
    double residuals[SAMPLE_RESIDUALS]; /* of the step at hand */
    int residual_count;
} sampler;

static void hear_residual(void *context, int iteration, double residual)
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
        sample_take(w, s->runs, c->contender_count, taken);
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
    for (int k = 0; k < c->contender_count; k++) s.runs[k] = c->contenders[k].settings;
    world_settings settings = s.runs[0];
    settings.solver.progress = hear_residual;
    settings.solver.progress_context = &s;
    world_status status = world_create(c->s, &settings, &w, error);
    if (status != WORLD_OK) return status_of(status, "pinch", c->s);
    w->observe = observe;
    w->observe_context = &s;
    while (s.next < c->sample_count && status == WORLD_OK) status = world_step(w);
    world_destroy(w);
    for (int k = 0; k < c->sample_count; k++)
        if (c->samples[k].status == SAMPLE_NO_MEMORY) status = WORLD_NO_MEMORY;
    return status_of(status, "pinch", c->s);
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The median, 0 <= count; sorts. */
static double median(double *values, int count)
{
    qsort(values, (size_t)count, sizeof *values, ascending);
    return count > 0 ? values[count / 2] : NAN;
}

static void measure_errors(scene_comparison *c)
{
    double starts[COMPARE_MOST_SAMPLES];
    int heard = 0;
    for (int i = 0; i < c->sample_count; i++)
        if (c->samples[i].status == SAMPLE_OK && c->samples[i].residual_count > 0)
            starts[heard++] = c->samples[i].residuals[0];
    c->contenders[0].metrics[METRIC_START_RESIDUAL] = median(starts, heard);
    for (int k = 0; k < c->contender_count; k++) {
        double errors[COMPARE_MOST_SAMPLES], *m = c->contenders[k].metrics;
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
    for (int k = 0; k < c->contender_count; k++) {
        contender *run = &c->contenders[k];
        uint64_t hash = pinch_hash;
        world_status status = k ? contender_hash(run, c->s, &hash) : WORLD_OK;
        if (status != WORLD_OK) return status_of(status, run->name, c->s);
        run->metrics[METRIC_DETERMINISTIC] = hash == run->hash;
    }
    return COMMAND_DONE;
}

/* What Pinch promises: every step verified; with the exact cone and its own tolerance, the exact forces. */
static command_status judge(const scene_comparison *c)
{
    const contender *pinch = &c->contenders[0];
    const world_settings *settings = &pinch->settings;
    double error = pinch->metrics[METRIC_FORCE_ERROR_MAX];
    command_status status = COMMAND_DONE;
    if (run_status(pinch->w) != PINCH_SOLVE_CONVERGED) {
        command_error("compare", "%s: Pinch's answers are not verified (%s)", c->s->file,
                      pinch_solve_status_text(run_status(pinch->w)));
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

static command_status run_all(scene_comparison *c, moment *moments)
{
    uint64_t hash = 0;
    int count = 0;
    command_status status = choose_moments(c, &hash, moments, &count);
    if (status != COMMAND_DONE) return status;
    c->sample_count = count;
    for (int k = 0; k < count; k++) c->samples[k].at = moments[k];
    for (int k = 0; k < c->contender_count && status == COMMAND_DONE; k++)
        status = status_of(contender_start(&c->contenders[k], c->s), c->contenders[k].name, c->s);
    if (status == COMMAND_DONE) status = take_turns(c);
    if (status == COMMAND_DONE) status = compare_bits(c, hash);
    if (status == COMMAND_DONE) status = take_samples(c);
    if (status == COMMAND_DONE) measure_errors(c);
    return status;
}

command_status scene_compare(const scene *s, const compare_settings *settings, json_t **document)
{
    contender contenders[CONTENDER_MOST];
    scene_comparison c = {.s = s, .settings = settings, .contenders = contenders};
    size_t most = (size_t)settings->samples + 1;
    moment *moments = calloc(most, sizeof *moments);
    *document = NULL;
    c.samples = calloc(most, sizeof *c.samples);
    c.contender_count = contender_list(settings, s, contenders);
    command_status status = moments && c.samples ? run_all(&c, moments) : COMMAND_SYSTEM;
    if (status == COMMAND_DONE) {
        *document = scene_comparison_document(&c);
        status = *document ? judge(&c) : COMMAND_SYSTEM;
    }
    for (int k = 0; k < c.contender_count; k++) contender_free(&contenders[k]);
    for (int k = 0; k < c.sample_count; k++) sample_free(&c.samples[k]);
    free(c.samples);
    free(moments);
    return status;
}
