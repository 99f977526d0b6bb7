#include "scene_document.h"

#include "cli/run.h"
#include "common/json_output.h"
#include "common/vector.h"
#include "drawing.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* Curves and contacts are looked at, not calculated with: seven digits. */
static json_t *short_number(double value)
{
    char text[32];
    if (!isfinite(value)) return json_null();
    snprintf(text, sizeof text, "%.7g", value);
    return json_real(strtod(text, NULL));
}

static json_t *short_numbers(const double *values, int count, int stride)
{
    json_t *list = json_array();
    for (int i = 0; i < count; i++) (void)json_array_append_new(list, short_number(values[i * stride]));
    return list;
}

static const char *solver_name(const contender *c)
{
    static const char *const names[] = {"pinch", "quickstep", "worldstep"};
    return names[c->settings.contact_solver];
}

static json_t *metrics_document(const contender *c)
{
    json_t *document = json_object();
    for (int m = 0; m < METRIC_COUNT; m++) {
        const metric_info *about = metric_about((metric)m);
        double value = c->metrics[m];
        json_t *entry = *about->unit || isnan(value) ? json_number(value) : json_boolean(value != 0);
        (void)json_object_set_new(document, about->key, entry);
    }
    return document;
}

static json_t *event_documents(const contender *c)
{
    json_t *list = json_array();
    for (int i = 0; i < c->result.event_count; i++) {
        const simulation_event *e = &c->result.events[i];
        json_t *finger = e->finger >= 0 ? json_string(c->w->fingers[e->finger].finger->name) : json_null();
        (void)json_array_append_new(list, json_pack("{s:o, s:o, s:s}", "time", json_number(e->time), "finger", finger,
                                                    "type", simulation_event_name(e->type)));
    }
    return list;
}

static json_t *finger_documents(const contender *c)
{
    json_t *list = json_array();
    for (int i = 0; i < c->w->finger_count; i++) {
        const world_finger *finger = &c->w->fingers[i];
        const world_finger_state *s = &finger->state;
        (void)json_array_append_new(
            list,
            json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:o}", "name", finger->finger->name, "state",
                      pinch_contact_state_text(s->state), "force", json_numbers(s->force, 3), "normal_force",
                      json_number(s->normal_force), "tangential_force", json_number(scene_norm(s->tangential_force)),
                      "slip", json_number(s->slip_total), "slip_margin", json_number(run_slip_margin(finger))));
    }
    return list;
}

static json_t *curve_documents(const contender *c)
{
    const recorder *r = &c->record;
    json_t *fingers = json_array();
    for (int f = 0; f < c->w->finger_count; f++) {
        const double *part = r->curve + RECORDER_FINGERS + RECORDER_PER_FINGER * f;
        (void)json_array_append_new(fingers,
                                    json_pack("{s:s, s:o, s:o, s:o}", "name", c->w->fingers[f].finger->name, "normal",
                                              short_numbers(part + RECORDER_NORMAL, r->rows, r->columns), "tangential",
                                              short_numbers(part + RECORDER_TANGENTIAL, r->rows, r->columns), "slip",
                                              short_numbers(part + RECORDER_SLIP, r->rows, r->columns)));
    }
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "time",
                     short_numbers(r->curve + RECORDER_TIME, r->rows, r->columns), "x",
                     short_numbers(r->curve + RECORDER_POSITION, r->rows, r->columns), "y",
                     short_numbers(r->curve + RECORDER_POSITION + 1, r->rows, r->columns), "z",
                     short_numbers(r->curve + RECORDER_POSITION + 2, r->rows, r->columns), "rotation",
                     short_numbers(r->curve + RECORDER_ROTATION, r->rows, r->columns), "divergence",
                     short_numbers(r->curve + RECORDER_DIVERGENCE, r->rows, r->columns), "balance",
                     short_numbers(r->curve + RECORDER_BALANCE, r->rows, r->columns), "fingers", fingers);
}

static void append_text(void *context, const char *text)
{
    (void)json_array_append_new(context, json_string(text));
}

static json_t *run_document(const contender *c)
{
    char hash[24];
    bool quick = c->settings.contact_solver == WORLD_QUICKSTEP, pinch = c->settings.contact_solver == WORLD_PINCH;
    json_t *not_expressed = json_array();
    world_not_expressed(c->w, append_text, not_expressed);
    snprintf(hash, sizeof hash, "%016" PRIx64, c->hash);
    return json_pack("{s:s, s:s, s:o, s:o, s:s, s:o, s:o, s:o, s:o, s:o, s:s, s:o}", "run", c->name, "contact_solver",
                     solver_name(c), "solver",
                     pinch ? json_string(pinch_solver_name(c->settings.solver.solver)) : json_null(),
                     "quickstep_iterations", quick ? json_integer(c->settings.quickstep_iterations) : json_null(),
                     "status", pinch_solve_status_text(run_status(c->w)), "metrics", metrics_document(c),
                     "displacement", json_numbers(c->result.displacement, 3), "fingers", finger_documents(c), "events",
                     event_documents(c), "not_expressed", not_expressed, "hash", hash, "curves", curve_documents(c));
}

/* A run in short: Pinch, quickstep with the first number of iterations, worldstep. */
static json_t *short_document(const contender *c)
{
    const simulation_result *r = &c->result;
    json_t *forces = json_array();
    for (int i = 0; i < c->w->finger_count; i++)
        (void)json_array_append_new(forces, json_numbers(c->w->fingers[i].state.force, 3));
    return json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:b}", "contact_solver", solver_name(c), "status",
                     pinch_solve_status_text(run_status(c->w)), "step_us", json_number(c->metrics[METRIC_COST]),
                     "displacement", json_numbers(r->displacement, 3), "creep", json_number(r->creep), "creep_angular",
                     json_number(r->creep_angular), "force_error", json_number(r->force_error), "torque_error",
                     json_number(r->torque_error), "forces", forces, "dropped", c->metrics[METRIC_DROPPED] != 0);
}

static json_t *short_documents(const scene_comparison *c)
{
    json_t *list = json_array();
    bool quick = false;
    for (int k = 0; k < c->contender_count; k++) {
        bool is_quick = c->contenders[k].settings.contact_solver == WORLD_QUICKSTEP;
        if (!(is_quick && quick)) (void)json_array_append_new(list, short_document(&c->contenders[k]));
        quick = quick || is_quick;
    }
    return list;
}

/* Pinch's cost over the fastest of ODE's. */
static double cost_ratio(const scene_comparison *c)
{
    double fastest = NAN;
    for (int k = 1; k < c->contender_count; k++) fastest = fmin(fastest, c->contenders[k].metrics[METRIC_COST]);
    return c->contenders[0].metrics[METRIC_COST] / fastest;
}

static json_t *contact_document(const scene_comparison *c, const sample *s, const sample_contact *contact)
{
    json_t *forces = json_object(), *errors = json_object();
    double radius = c->s->object.shape.bounding_radius;
    for (int k = 0; k < c->contender_count; k++) {
        (void)json_object_set_new(forces, c->contenders[k].name, short_numbers(contact->force[k], 3, 1));
        (void)json_object_set_new(errors, c->contenders[k].name,
                                  short_number(sample_contact_error(s, contact, k, radius)));
    }
    json_t *finger = contact->finger >= 0 ? json_string(c->s->fingers[contact->finger].name) : json_null();
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "finger", finger, "position",
                     short_numbers(contact->position, 3, 1), "normal", short_numbers(contact->normal, 3, 1), "depth",
                     short_number(contact->depth), "friction", short_number(contact->friction), "exact",
                     short_numbers(contact->exact, 3, 1), "exact_torsion", short_number(contact->exact_torsion),
                     "forces", forces, "errors", errors);
}

static json_t *sample_document(const scene_comparison *c, const sample *s)
{
    static const char *const statuses[] = {"solved", "no contact", "no exact answer", "left to ODE", "out of memory"};
    json_t *errors = json_object(), *contacts = json_array();
    for (int k = 0; k < c->contender_count; k++)
        (void)json_object_set_new(errors, c->contenders[k].name,
                                  s->status == SAMPLE_OK ? json_number(s->error[k]) : json_null());
    for (int i = 0; i < s->contact_count; i++)
        (void)json_array_append_new(contacts, contact_document(c, s, &s->contacts[i]));
    bool solved = s->status == SAMPLE_OK;
    return json_pack("{s:I, s:o, s:s, s:s, s:o, s:o, s:o, s:o, s:o}", "step", (json_int_t)s->at.step, "time",
                     json_number(s->time), "reason", moment_reason_text(s->at.reason), "status", statuses[s->status],
                     "force_scale", json_number(solved ? s->scale : NAN), "exact_residual",
                     json_number(solved ? s->residual : NAN), "errors", errors, "residuals",
                     short_numbers(s->residuals, s->residual_count, 1), "contacts", contacts);
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* quickstep's error by the number of its iterations, median over the samples. */
static json_t *convergence_document(const scene_comparison *c)
{
    json_t *iterations = json_array(), *errors = json_array();
    for (int i = 0; i < SAMPLE_COUNTS && c->contender_count > 1; i++) {
        double values[COMPARE_MOST_SAMPLES];
        int count = 0;
        for (int k = 0; k < c->sample_count; k++)
            if (c->samples[k].status == SAMPLE_OK) values[count++] = c->samples[k].count_error[i];
        qsort(values, (size_t)count, sizeof *values, ascending);
        (void)json_array_append_new(iterations, json_integer(sample_counts[i]));
        (void)json_array_append_new(errors, json_number(count ? values[count / 2] : NAN));
    }
    return json_pack("{s:o, s:o}", "iterations", iterations, "quickstep", errors);
}

/* The sample to draw: the last with a contact under load. */
static const sample *to_draw(const scene_comparison *c)
{
    for (int k = c->sample_count - 1; k >= 0; k--)
        if (c->samples[k].status == SAMPLE_OK) return &c->samples[k];
    return NULL;
}

json_t *scene_comparison_document(const scene_comparison *c)
{
    const scene *s = c->s;
    const world *w = c->contenders[0].w;
    json_t *runs = json_array(), *samples = json_array();
    for (int k = 0; k < c->contender_count; k++) (void)json_array_append_new(runs, run_document(&c->contenders[k]));
    for (int k = 0; k < c->sample_count; k++) (void)json_array_append_new(samples, sample_document(c, &c->samples[k]));
    const sample *drawn = to_draw(c);
    return json_pack("{s:s, s:s, s:i, s:I, s:o, s:o, s:o, s:o, s:s, s:i, s:b, s:o, s:o, s:o, s:o, s:o, s:o}", "scene",
                     s->file, "name", s->name, "dimension", s->dimension, "steps", (json_int_t)w->steps, "time_s",
                     json_number(w->time), "step_s", json_number(s->step), "radius",
                     json_number(s->object.shape.bounding_radius), "mass", json_number(s->object.mass), "contacts",
                     c->settings->manifolds ? "pinch" : "ode", "points", c->settings->points, "cold_start",
                     c->settings->cold_start, "cost_ratio", json_number(cost_ratio(c)), "contact_solvers",
                     short_documents(c), "runs", runs, "samples", samples, "convergence", convergence_document(c),
                     "drawing", drawn ? drawing_document(w, drawn) : json_null());
}
