/* One trial: its runs and its verdict. */
#include "trial.h"

#include "common/measure.h"
#include "common/output.h"
#include "scenes/world/simulation.h"

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

static void set_least(const study *s, json_t *inputs, double value)
{
    for (size_t i = 0; i < s->least.place_count; i++) json_object_set_new(inputs, s->least.places[i], json_real(value));
}

/* Halves the bracket between a value that fails and one that succeeds, by ratio where both are positive. The verdict is
 * that of the least value that succeeded; where even the greatest fails, of that one. */
static void search_least(const study *s, json_t *inputs, verdict *v)
{
    double fails = s->least.from, holds = s->least.to;
    json_t *tried = json_deep_copy(inputs);
    set_least(s, tried, holds);
    run_all(s, tried, v);
    bool found = v->success;
    while (found && holds - fails > s->least.precision * holds && holds - fails > 1e-15 * s->least.to) {
        double middle = 0.5 * (fails + holds);
        if (!(middle > fails && middle < holds)) break;
        set_least(s, tried, middle);
        run_all(s, tried, v);
        *(v->success ? &holds : &fails) = middle;
    }
    if (found && !v->success) {
        set_least(s, tried, holds);
        run_all(s, tried, v);
    }
    json_decref(tried);
    json_object_set_new(v->recorded, "least.holds", json_number(found ? holds : NAN));
    json_object_set_new(v->recorded, "least.fails", json_number(fails));
}

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

json_t *trial_run(const study *s, long index)
{
    verdict v = {.recorded = json_object(), .directions = json_array(), .errors = json_array(), .grasp = json_object()};
    json_t *inputs = study_draw(s, index);
    if (!inputs) return NULL;
    double started = clock_seconds();
    if (s->least.path)
        search_least(s, inputs, &v);
    else
        run_all(s, inputs, &v);
    add_grasp(s, inputs, v.recorded);
    json_object_update(v.recorded, v.grasp);
    json_decref(v.grasp);
    char hash[24];
    snprintf(hash, sizeof hash, "%016" PRIx64, v.hash);
    json_t *answer = json_pack("{s:I, s:o, s:s, s:b, s:i, s:f, s:f, s:s, s:o, s:o, s:o}", "index", (json_int_t)index,
                               "inputs", inputs, "status", v.status, "success", (int)v.success, "exit", v.exit,
                               "wall_time", clock_seconds() - started, "run_time", v.wall_time, "hash", hash,
                               "recorded", v.recorded, "directions", v.directions, "errors", v.errors);
    return answer;
}

/* ---- Before any trial. ---- */

/* The document of a run of no steps has all the names there are. */
static json_t *example_document(const study *s, scene_error *error)
{
    scene *base;
    world *w;
    char reason[256];
    json_t *document = NULL;
    if (scene_load_document(s->scene_file, s->scene_text, s->scene_length, s->scene, &base, error) != SCENE_OK)
        return NULL;
    world_settings settings = world_default_settings(base);
    settings.contact_solver = s->contact_solver;
    if (world_create(base, &settings, &w, reason) == WORLD_OK) {
        simulation_result result;
        simulation *sim = simulation_start(w);
        if (sim) {
            simulation_finish(sim, &result);
            document = simulation_document(w, &result, true);
            simulation_free(&result);
        }
        world_free(w);
    } else {
        snprintf(error->text, sizeof error->text, "%.4096s: %s", s->scene_file, reason);
    }
    scene_free(base);
    return document;
}

/* Tells whether a result of `list`, fingers or joints, may be there in a trial and not in the example. Hands have
 * fingers where they touch: as long as none does, nobody knows their names, nor what is known of them. */
static bool may_come(const json_t *document, const char *list, const char *name)
{
    size_t length = strlen(list);
    const char *rest = strncmp(name, list, length) == 0 && name[length] == '.' ? strchr(name + length + 1, '.') : NULL;
    if (!rest) return false;
    if (json_array_size(json_object_get(document, list)) == 0) return true;
    char any[256];
    json_t *found = json_object();
    bool known = found && snprintf(any, sizeof any, "%s.*%s", list, rest) < (int)sizeof any &&
                 record_take(document, any, found) > 0;
    json_decref(found);
    return known;
}

static scene_status check_records(const study *s, scene_error *error)
{
    if (s->record_count == 0) return SCENE_OK;
    json_t *document = example_document(s, error), *found = json_object();
    scene_status status = document ? SCENE_OK : SCENE_BAD_INPUT;
    for (size_t i = 0; i < s->record_count && status == SCENE_OK; i++) {
        bool is_known = record_is_static(s->records[i]);
        if (is_known) {
            study one = *s;
            one.records = s->records + i;
            one.record_count = 1;
            scene nothing = {.finger_count = 0};
            is_known = record_grasp(&one, &nothing, 0.0, found);
        } else {
            is_known = record_take(document, s->records[i], found) > 0 || strncmp(s->records[i], "statics", 7) == 0 ||
                       may_come(document, "fingers", s->records[i]) || may_come(document, "joints", s->records[i]);
        }
        if (is_known) continue;
        status = study_refuse_record(s, i, error);
    }
    json_decref(document);
    json_decref(found);
    return status;
}

/* What is wrong stands in the scene's place for it, but came from a draw. */
static void say_that_it_was_drawn(const study *s, scene_error *error)
{
    scene_error of_scene = *error;
    snprintf(error->text, sizeof error->text, "%.2048s: vary: no trial tried is a legal scene; in trial 0, %.3900s",
             s->file, of_scene.text);
}

scene_status trial_check(const study *s, scene_error *error)
{
    enum { DRAWS = 8 };
    scene_status status = check_records(s, error);
    scene_error first;
    bool illegal = false;
    for (long k = 0; k < DRAWS && k < s->samples && status == SCENE_OK; k++) {
        scene *drawn;
        double begin;
        json_t *inputs = study_draw(s, k);
        if (!inputs) return SCENE_NO_MEMORY;
        scene_status drawn_status = trial_scene(s, inputs, 0, &drawn, &begin, k == 0 ? error : &first);
        scene_free(drawn);
        json_decref(inputs);
        if (drawn_status != SCENE_BAD_INPUT) return drawn_status; /* one that is legal is enough */
        illegal = k + 1 == DRAWS || k + 1 == s->samples;
        if (illegal) status = SCENE_BAD_INPUT;
    }
    if (illegal && s->variation_count > 0) say_that_it_was_drawn(s, error);
    return status;
}
