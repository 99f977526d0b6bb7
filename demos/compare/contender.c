#include "contender.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static contender *add(contender *list, int *count, const compare_settings *settings, const scene *s,
                      world_solver solver)
{
    contender *c = &list[(*count)++];
    memset(c, 0, sizeof *c);
    c->settings = world_default_settings(s);
    c->settings.contact_solver = solver;
    c->settings.manifolds = settings->manifolds && solver != WORLD_PINCH;
    c->settings.points = settings->points;
    c->settings.cold_start = settings->cold_start && solver == WORLD_PINCH;
    return c;
}

int contender_list(const compare_settings *settings, const scene *s, contender list[CONTENDER_MOST])
{
    int count = 0;
    strcpy(add(list, &count, settings, s, WORLD_PINCH)->name, "pinch");
    for (int i = 0; i < settings->count_count && settings->quickstep; i++) {
        contender *c = add(list, &count, settings, s, WORLD_QUICKSTEP);
        c->settings.quickstep_iterations = settings->counts[i];
        snprintf(c->name, sizeof c->name, "quickstep-%d", settings->counts[i]);
    }
    if (settings->worldstep) strcpy(add(list, &count, settings, s, WORLD_WORLDSTEP)->name, "worldstep");
    return count;
}

world_status contender_start(contender *c, const scene *s)
{
    char error[256];
    world_status status = world_create(s, &c->settings, &c->w, error);
    if (status != WORLD_OK) return status;
    c->simulation = simulation_start(c->w);
    if (!c->simulation) return WORLD_NO_MEMORY;
    long steps = simulation_steps(c->simulation);
    c->step_s = calloc((size_t)steps + 1, sizeof *c->step_s);
    return c->step_s && recorder_start(&c->record, c->w, steps) ? WORLD_OK : WORLD_NO_MEMORY;
}

world_status contender_step(contender *c, const contender *peer)
{
    double before = c->w->step_s;
    recorder_before_step(&c->record);
    dRandSetSeed(c->random);
    world_status status = simulation_step(c->simulation);
    c->random = dRandGetSeed();
    if (status != WORLD_OK) return status;
    c->step_s[c->w->steps - 1] = c->w->step_s - before;
    recorder_after_step(&c->record, peer ? peer->w : NULL);
    return WORLD_OK;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static bool dropped(const simulation_result *r)
{
    for (int i = 0; i < r->event_count; i++)
        if (r->events[i].type == EVENT_DROPPED) return true;
    return false;
}

static void pinch_metrics(const contender *c, double *m)
{
    pinch_ode_stats stats = pinch_ode_statistics(c->w->plugin);
    const energy_ledger *ledger = &c->w->ledger;
    m[METRIC_VERIFIED] = !c->w->diverged && stats.fallback_islands == 0;
    m[METRIC_UNCONVERGED_STEPS] = (double)stats.unconverged_steps;
    m[METRIC_ITERATIONS_MEAN] = stats.islands > 0 ? (double)stats.iterations / (double)stats.islands : NAN;
    m[METRIC_ITERATIONS_MAX] = stats.iterations_max;
    m[METRIC_ENERGY_CLOSURE] = ledger->closure;
    m[METRIC_ENERGY_CLOSURE_RELATIVE] = ledger->work_size > 0 ? ledger->closure / ledger->work_size : NAN;
    m[METRIC_DIVERGENCE_MAX] = m[METRIC_DIVERGENCE_END] = NAN; /* is what the others are measured against */
}

void contender_finish(contender *c)
{
    double *m = c->metrics;
    for (int i = 0; i < METRIC_COUNT; i++) m[i] = NAN;
    simulation_finish(c->simulation, &c->result);
    c->simulation = NULL;
    c->hash = world_hash(c->w);
    recorder_metrics(&c->record, m);
    m[METRIC_CREEP] = c->result.creep;
    m[METRIC_CREEP_ANGULAR] = c->result.creep_angular;
    m[METRIC_DROPPED] = dropped(&c->result);
    if (c->settings.contact_solver == WORLD_PINCH) pinch_metrics(c, m);
    if (c->settings.contact_solver == WORLD_QUICKSTEP)
        m[METRIC_ITERATIONS_MEAN] = m[METRIC_ITERATIONS_MAX] = c->settings.quickstep_iterations;
    if (c->w->steps == 0) return;
    qsort(c->step_s, (size_t)c->w->steps, sizeof *c->step_s, ascending);
    m[METRIC_COST] = 1e6 * c->step_s[c->w->steps / 2];
}

void contender_free(contender *c)
{
    if (c->simulation) simulation_finish(c->simulation, &c->result);
    simulation_free(&c->result);
    recorder_free(&c->record);
    free(c->step_s);
    world_destroy(c->w);
    memset(c, 0, sizeof *c);
}

world_status contender_hash(const contender *c, const scene *s, uint64_t *hash)
{
    char error[256];
    world *w;
    world_status status = world_create(s, &c->settings, &w, error);
    if (status != WORLD_OK) return status;
    dRandSetSeed(0);
    for (long k = lround(s->duration / s->step); k > 0 && status == WORLD_OK; k--) status = world_step(w);
    *hash = world_hash(w);
    world_destroy(w);
    return status == WORLD_DIVERGED ? WORLD_OK : status;
}
