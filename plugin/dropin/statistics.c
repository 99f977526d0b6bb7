/* Sums of statistics, and the document they are written as. */
#define _POSIX_C_SOURCE 200809L

#include "dropin/layer.h"

#include <locale.h>
#include <math.h>
#include <stdio.h>

static void keep_larger(double *kept, double other)
{
    if (other > *kept) *kept = other;
}

static void keep_larger_int(int *kept, int other)
{
    if (other > *kept) *kept = other;
}

void pinch_layer_add_plugin_stats(pinch_ode_stats *sum, const pinch_ode_stats *more)
{
    sum->steps += more->steps;
    sum->contacts_solved += more->contacts_solved;
    sum->contacts_left += more->contacts_left;
    sum->contacts_left_by_scope += more->contacts_left_by_scope;
    sum->contacts_left_unsupported += more->contacts_left_unsupported;
    sum->contacts_left_unsolved += more->contacts_left_unsolved;
    sum->contacts_asleep += more->contacts_asleep;
    sum->contacts_malformed += more->contacts_malformed;
    sum->islands += more->islands;
    sum->unconverged_steps += more->unconverged_steps;
    sum->retried_islands += more->retried_islands;
    sum->fallback_islands += more->fallback_islands;
    sum->softened_islands += more->softened_islands;
    sum->iterations += more->iterations;
    sum->projections += more->projections;
    sum->newton_steps += more->newton_steps;
    sum->joints_unmodelled += more->joints_unmodelled;
    sum->joints_solved += more->joints_solved;
    sum->joints_left += more->joints_left;
    sum->memory += more->memory;
    keep_larger_int(&sum->floor_level_max, more->floor_level_max);
    keep_larger_int(&sum->iterations_max, more->iterations_max);
    keep_larger_int(&sum->points_high_water, more->points_high_water);
    keep_larger(&sum->floor_depth_max, more->floor_depth_max);
    keep_larger(&sum->residual_max, more->residual_max);
    keep_larger(&sum->cone, more->cone);
    keep_larger(&sum->complementarity, more->complementarity);
    keep_larger(&sum->slip_direction, more->slip_direction);
    keep_larger(&sum->force_scale, more->force_scale);
    keep_larger(&sum->step_mismatch, more->step_mismatch);
    keep_larger(&sum->step_mismatch_angular, more->step_mismatch_angular);
    keep_larger(&sum->depth_max, more->depth_max);
}

void pinch_layer_add_stats(pinch_dropin_stats *sum, const pinch_dropin_stats *more)
{
    sum->worlds += more->worlds;
    sum->steps += more->steps;
    sum->steps_refused += more->steps_refused;
    sum->contacts_offered += more->contacts_offered;
    sum->contacts_idle += more->contacts_idle;
    sum->contacts_refused += more->contacts_refused;
    sum->contacts_unrecorded += more->contacts_unrecorded;
    sum->time_pinch += more->time_pinch;
    sum->time_ode += more->time_ode;
    pinch_layer_add_plugin_stats(&sum->ode, &more->ode);
}

typedef struct document {
    char *text;
    size_t size;
    int length; /* without the NUL, of the whole; -1: it cannot be written */
} document;

#define PUT(d, ...)                                                                                                    \
    put_length((d), (d)->length < 0 ? -1                                                                               \
                                    : snprintf((size_t)(d)->length < (d)->size ? (d)->text + (d)->length : NULL,       \
                                               (size_t)(d)->length < (d)->size ? (d)->size - (size_t)(d)->length : 0,  \
                                               __VA_ARGS__))

static void put_length(document *d, int n)
{
    d->length = n < 0 ? -1 : d->length + n;
}

static void put_count(document *d, const char *key, long value)
{
    PUT(d, ",\n  \"%s\": %ld", key, value);
}

static void put_number(document *d, const char *key, double value)
{
    if (isfinite(value))
        PUT(d, ",\n  \"%s\": %.17g", key, value);
    else
        PUT(d, ",\n  \"%s\": null", key);
}

static void put_contacts(document *d, const pinch_dropin_stats *s)
{
    const pinch_ode_stats *o = &s->ode;
    put_count(d, "contacts_offered", s->contacts_offered);
    put_count(d, "contacts_solved", o->contacts_solved);
    put_count(d, "contacts_left",
              o->contacts_left + s->contacts_out_of_scope + s->contacts_refused + s->contacts_unrecorded);
    put_count(d, "contacts_left_by_scope", o->contacts_left_by_scope + s->contacts_out_of_scope);
    put_count(d, "contacts_left_unsupported", o->contacts_left_unsupported);
    put_count(d, "contacts_left_unsolved", o->contacts_left_unsolved);
    put_count(d, "contacts_left_refused", s->contacts_refused);
    put_count(d, "contacts_left_unrecorded", s->contacts_unrecorded);
    put_count(d, "contacts_malformed", o->contacts_malformed);
    put_count(d, "contacts_asleep", o->contacts_asleep);
    put_count(d, "contacts_idle", s->contacts_idle);
}

static void put_solves(document *d, const pinch_ode_stats *o)
{
    put_count(d, "unconverged_steps", o->unconverged_steps);
    put_count(d, "islands", o->islands);
    put_count(d, "islands_retried", o->retried_islands);
    put_count(d, "islands_softened", o->softened_islands);
    put_count(d, "islands_fallback", o->fallback_islands);
    put_number(d, "iterations_mean", o->islands > 0 ? (double)o->iterations / (double)o->islands : 0);
    put_count(d, "iterations_max", o->iterations_max);
    put_count(d, "rung_max", o->floor_level_max);
    put_number(d, "floor_depth_max", o->floor_depth_max);
    put_number(d, "residual_max", o->residual_max);
    put_number(d, "depth_max", o->depth_max);
    put_number(d, "force_max", o->force_scale);
    put_count(d, "joints_unmodelled", o->joints_unmodelled);
    put_count(d, "joints_solved", o->joints_solved);
    put_count(d, "joints_left", o->joints_left);
    put_number(d, "step_mismatch", o->step_mismatch);
    put_number(d, "step_mismatch_angular", o->step_mismatch_angular);
}

static void put_settings(document *d, const pinch_ode_settings *settings)
{
    static const char *const scopes[] = {"all", "soft", "material"};
    PUT(d, ",\n  \"settings\": {\"only\": \"%s\", \"kt_ratio\": %.17g, \"solver\": \"%s\", ", scopes[settings->scope],
        settings->tangential_ratio, pinch_solver_name(settings->solver.solver));
    PUT(d, "\"tolerance\": %.17g, \"max_iterations\": %d}", settings->solver.tolerance,
        settings->solver.max_iterations);
}

static void put_all(document *d, const pinch_dropin_stats *s, const pinch_ode_settings *settings)
{
    PUT(d, "{\n  \"steps\": %ld", s->steps);
    put_count(d, "steps_refused", s->steps_refused);
    put_count(d, "worlds", s->worlds);
    put_contacts(d, s);
    put_solves(d, &s->ode);
    put_number(d, "time_pinch_s", s->time_pinch);
    put_number(d, "time_ode_s", s->time_ode);
    put_settings(d, settings);
    PUT(d, "\n}\n");
}

int pinch_layer_write_statistics(const pinch_dropin_stats *stats, const pinch_ode_settings *settings, char *text,
                                 size_t size)
{
    document d = {.text = text, .size = size};
    if (size > 0) text[0] = '\0';
    /* the program may have a decimal comma */
    locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (plain == (locale_t)0) return -1;
    locale_t own = uselocale(plain);
    put_all(&d, stats, settings);
    (void)uselocale(own);
    freelocale(plain);
    return d.length;
}
