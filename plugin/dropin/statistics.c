/* Sums of statistics, and the JSON document that they are written as. */
#define _POSIX_C_SOURCE 200809L

#include "dropin/layer.h"

#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>

/* The counters of a plugin, whose values add up over worlds, and those of which the largest counts. */
/* clang-format off */
#define SUMS(X)                                                                                                        \
    X(steps) X(contacts_solved) X(contacts_left) X(contacts_left_by_scope) X(contacts_left_unsupported)                \
    X(contacts_left_unsolved) X(contacts_asleep) X(contacts_malformed) X(islands) X(unconverged_steps)                 \
    X(islands_at_rest) X(drives_at_limit)                                                                              \
    X(retried_islands) X(fallback_islands) X(backoffs) X(softened_islands) X(too_soft_islands) X(swept_islands)           \
    X(iterations) X(projections) X(newton_steps)                                                                       \
    X(islands_by_projections) X(islands_by_newton) X(islands_by_flow) X(islands_by_lcp)                                \
    X(joints_unmodelled) X(joints_solved) X(joints_left) X(memory)
#define MAXIMA(X)                                                                                                      \
    X(floor_level_max) X(iterations_max) X(points_high_water) X(floor_depth_max) X(floor_residual_max) X(residual_max) X(cone) X(complementarity)   \
    X(slip_direction) X(force_scale) X(step_mismatch) X(step_mismatch_angular) X(depth_max)              \
    X(joint_error_max) X(joint_error_angle_max)
/* The counters of the layer, which add up. */
#define LAYER_SUMS(X)                                                                                                  \
    X(worlds) X(steps) X(steps_refused) X(contacts_offered) X(contacts_idle) X(contacts_refused)                       \
    X(contacts_unrecorded) X(time_pinch) X(time_ode)
#define ADD(counter)         sum->counter += more->counter;
#define KEEP_LARGER(counter) if (more->counter > sum->counter) sum->counter = more->counter;
/* clang-format on */

void pinch_layer_add_plugin_stats(pinch_ode_stats *sum, const pinch_ode_stats *more)
{
    SUMS(ADD)
    MAXIMA(KEEP_LARGER)
}

void pinch_layer_add_stats(pinch_dropin_stats *sum, const pinch_dropin_stats *more)
{
    LAYER_SUMS(ADD)
    pinch_layer_add_plugin_stats(&sum->ode, &more->ode);
}

typedef struct document {
    char *text;
    size_t size;
    int length; /* of the whole, without the NUL; -1 where it cannot be written */
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
    put_count(d, "islands_too_soft", o->too_soft_islands);
    put_count(d, "islands_swept", o->swept_islands);
    put_count(d, "islands_fallback", o->fallback_islands);
    put_count(d, "backoffs", o->backoffs);
    put_number(d, "iterations_mean", o->islands > 0 ? (double)o->iterations / (double)o->islands : 0);
    put_count(d, "iterations_max", o->iterations_max);
    put_count(d, "islands_by_projections", o->islands_by_projections);
    put_count(d, "islands_by_newton", o->islands_by_newton);
    put_count(d, "islands_by_flow", o->islands_by_flow);
    put_count(d, "rung_max", o->floor_level_max);
    put_number(d, "floor_depth_max", o->floor_depth_max);
    put_number(d, "floor_residual_max", o->floor_residual_max);
    put_number(d, "residual_max", o->residual_max);
    put_number(d, "depth_max", o->depth_max);
    put_number(d, "force_max", o->force_scale);
    put_count(d, "joints_unmodelled", o->joints_unmodelled);
    put_count(d, "joints_solved", o->joints_solved);
    put_count(d, "joints_left", o->joints_left);
    put_number(d, "joint_error_max", o->joint_error_max);
    put_number(d, "joint_error_angle_max", o->joint_error_angle_max);
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

static locale_t plain = (locale_t)0; /* the program may have a decimal comma */

static void prepare_plain(void)
{
    plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
}

bool pinch_layer_plain_numbers(void)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    (void)pthread_once(&once, prepare_plain);
    return plain != (locale_t)0;
}

int pinch_layer_write_statistics(const pinch_dropin_stats *stats, const pinch_ode_settings *settings, char *text,
                                 size_t size)
{
    document d = {.text = text, .size = size};
    if (size > 0) text[0] = '\0';
    if (!pinch_layer_plain_numbers()) return -1;
    locale_t own = uselocale(plain);
    put_all(&d, stats, settings);
    (void)uselocale(own);
    return d.length;
}
