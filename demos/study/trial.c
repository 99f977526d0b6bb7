/* One trial: its runs and its verdict. */
#include "trial.h"

#include "common/command_status.h"
#include "common/measure.h"
#include "common/output.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- A trial. ---- */

/* What all runs of a trial have come to. */
typedef struct verdict {
    bool success;
    int exit; /* the highest */
    const char *status;
    double wall_time, worst; /* the displacement of the run that is recorded; -1: none yet */
    uint64_t hash;
    json_t *recorded, *directions, *errors;
    json_t *grasp; /* what is recorded of the grasp by its contacts in the run; empty where it is by the scene */
} verdict;

/* Is this run worse than those before? What failed to be solved is worst of all, and then what has moved farthest. */
static bool is_worse(const verdict *v, const trial_outcome *o)
{
    if (v->worst < 0.0 || o->exit > v->exit) return true;
    return o->exit == v->exit && o->displacement > v->worst;
}

static void add_run(const study *s, int run, trial_outcome *o, verdict *v)
{
    const char *direction = protocol_direction(&s->protocol, run);
    if (is_worse(v, o)) {
        v->worst = isnan(o->displacement) ? 0.0 : o->displacement;
        v->status = o->status;
        v->exit = o->exit;
        json_object_clear(v->recorded);
        json_object_update(v->recorded, o->recorded);
    }
    v->success = v->success && o->success;
    v->wall_time += o->wall_time;
    uint64_t hash = strtoull(o->hash, NULL, 16);
    v->hash = s->protocol.type == STUDY_SIX_FORCES ? (v->hash ^ hash) * 0x100000001b3u : hash;
    if (s->protocol.type == STUDY_SIX_FORCES)
        (void)json_array_append_new(
            v->directions, json_pack("{s:s, s:s, s:b, s:i, s:o, s:o, s:f, s:s, s:O}", "direction", direction, "status",
                                     o->status, "success", (int)o->success, "exit", o->exit, "displacement",
                                     json_number(o->displacement), "rotation", json_number(o->rotation), "wall_time",
                                     o->wall_time, "hash", o->hash, "recorded", o->recorded));
    if (*o->message)
        (void)json_array_append_new(v->errors, json_pack("{s:s, s:s, s:s}", "direction", direction, "status", o->status,
                                                         "message", o->message));
    json_decref(o->recorded);
}

/* Runs all directions with the inputs. A verdict that comes of a search for the least value replaces the one before. */
static void run_all(const study *s, json_t *inputs, verdict *v)
{
    int runs = protocol_runs(&s->protocol, 3);
    if (s->protocol.type == STUDY_SIX_FORCES) {
        json_t *dimension = json_object_get(s->scene, "dimension");
        if (json_is_number(dimension)) runs = protocol_runs(&s->protocol, (int)json_number_value(dimension));
    }
    v->success = true;
    v->exit = 0;
    v->worst = -1.0;
    v->hash = 0xcbf29ce484222325u;
    json_array_clear(v->directions);
    json_array_clear(v->errors);
    /* the runs of a trial are one until the protocol begins, which is where the grasp is looked at */
    trial_watch first = {.grasp = v->grasp};
    json_object_clear(v->grasp);
    for (int run = 0; run < runs; run++) {
        trial_outcome o = trial_run_once(s, inputs, run, run == 0 ? &first : NULL);
        add_run(s, run, &o, v);
    }
}

/* ---- The search for the least value. ---- */

typedef struct search {
    const study *s;
    json_t *tried; /* the trial's inputs with the value that was tried last */
    verdict *v;    /* of that one */
} search;

void trial_set_least(const study *s, json_t *inputs, double value)
{
    for (size_t i = 0; i < s->least.place_count; i++) json_object_set_new(inputs, s->least.places[i], json_real(value));
}

static void try_value(search *a, double value)
{
    trial_set_least(a->s, a->tried, value);
    run_all(a->s, a->tried, a->v);
}

/* Nothing could be run: the inputs are no legal scene, or memory ran out. */
static bool is_refused(const verdict *v)
{
    return v->exit >= COMMAND_BAD_INPUT;
}

/* Halves the interval between a value that was tried and failed and one that succeeded. What takes whole numbers alone
 * has no legal scene between them; it is then looked for among these. Ends with the verdict of the least value that
 * succeeded, or of one that is no legal scene. */
static void halve(search *a, double *fails, double *holds)
{
    const study_least *l = &a->s->least;
    bool whole = false, current = true;
    while (*holds - *fails > fmax(l->precision * *holds, 1e-15 * l->to)) {
        double middle = 0.5 * (*fails + *holds);
        if (whole) middle = floor(middle);
        if (!(middle > *fails && middle < *holds)) break;
        try_value(a, middle);
        if (is_refused(a->v)) {
            bool between = middle != floor(middle) && l->from == floor(l->from) && l->to == floor(l->to);
            if (!between) return;
            whole = true;
            current = false;
            continue;
        }
        current = a->v->success;
        *(current ? holds : fails) = middle;
    }
    if (!current) try_value(a, *holds);
}

/* Both ends are tried before anything between them. Where even the greatest value fails, the verdict is of that one. A
 * value that is no legal scene makes the trial a bad draw, of which nothing is recorded. */
static void find_least(search *a)
{
    const study_least *l = &a->s->least;
    double fails = NAN, holds = NAN;
    try_value(a, l->from);
    if (a->v->success) {
        holds = l->from;
    } else if (!is_refused(a->v)) {
        fails = l->from;
        try_value(a, l->to);
        if (a->v->success) {
            holds = l->to;
            halve(a, &fails, &holds);
        } else {
            fails = l->to;
        }
    }
    if (is_refused(a->v)) return;
    json_object_set_new(a->v->recorded, "least.holds", json_number(holds));
    json_object_set_new(a->v->recorded, "least.fails", json_number(fails));
}

/* ---- All of a trial. ---- */

/* The quality of the grasp is that of the scene without protocol, as it is when the protocol begins. */
static void add_grasp(const study *s, json_t *inputs, json_t *recorded)
{
    study_protocol none = {.type = STUDY_NO_PROTOCOL};
    study plain = *s;
    scene_error error;
    scene *base;
    double begin;
    bool any = false;
    for (size_t i = 0; i < s->record_count; i++) any = any || record_is_static(s->records[i]);
    plain.protocol = none;
    if (!any || trial_scene(&plain, inputs, 0, &base, &begin, &error) != SCENE_OK) return;
    double time = s->protocol.type == STUDY_NO_PROTOCOL ? base->duration : protocol_schedule_end(base);
    (void)record_grasp(s, base, time, recorded);
    scene_free(base);
}

static verdict empty_verdict(void)
{
    return (verdict){
        .recorded = json_object(), .directions = json_array(), .errors = json_array(), .grasp = json_object()};
}

static void free_verdict(verdict *v)
{
    json_decref(v->recorded);
    json_decref(v->directions);
    json_decref(v->errors);
    json_decref(v->grasp);
}

/* Runs the trial with what was drawn. Returns the inputs that the verdict is of: with a search they have its value,
 * too. NULL when memory runs out. */
static json_t *run_with(const study *s, const json_t *drawn, verdict *v)
{
    json_t *inputs = json_deep_copy(drawn);
    search a = {s, inputs, v};
    if (!inputs) return NULL;
    if (s->least.path)
        find_least(&a);
    else
        run_all(s, inputs, v);
    return inputs;
}

json_t *trial_inputs(const study *s, long index, int *run)
{
    json_t *drawn = study_draw(s, index);
    bool several = run && s->protocol.type == STUDY_SIX_FORCES;
    if (run) *run = 0;
    if (!drawn || !(several || s->least.path)) return drawn;
    verdict v = empty_verdict();
    json_t *inputs = run_with(s, drawn, &v);
    for (size_t i = several ? json_array_size(v.directions) : 0; i-- > 0;)
        if (!json_is_true(json_object_get(json_array_get(v.directions, i), "success"))) *run = (int)i;
    json_decref(drawn);
    free_verdict(&v);
    return inputs;
}

json_t *trial_run(const study *s, long index)
{
    json_t *drawn = study_draw(s, index);
    if (!drawn) return NULL;
    verdict v = empty_verdict();
    double started = clock_seconds();
    json_t *inputs = run_with(s, drawn, &v), *answer = NULL;
    if (inputs) {
        add_grasp(s, inputs, v.recorded);
        json_object_update(v.recorded, v.grasp);
        char hash[24];
        snprintf(hash, sizeof hash, "%016" PRIx64, v.hash);
        answer = json_pack("{s:I, s:O, s:s, s:b, s:i, s:f, s:f, s:s, s:O, s:O, s:O}", "index", (json_int_t)index,
                           "inputs", drawn, "status", v.status, "success", (int)v.success, "exit", v.exit, "wall_time",
                           clock_seconds() - started, "run_time", v.wall_time, "hash", hash, "recorded", v.recorded,
                           "directions", v.directions, "errors", v.errors);
    }
    json_decref(inputs);
    json_decref(drawn);
    free_verdict(&v);
    return answer;
}
