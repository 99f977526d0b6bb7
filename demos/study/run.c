/* One run of a trial: its scene, its steps, and how it went. */
#include "trial.h"

#include "common/measure.h"
#include "common/output.h"
#include "common/vector.h"
#include "scenes/world/simulation.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The scene's document with the inputs in their places. */
static scene_status set_inputs(const study *s, json_t *inputs, json_t *document, scene_error *error)
{
    const char *place;
    json_t *value;
    json_object_foreach(inputs, place, value)
    {
        /* what is set in the scene belongs to it alone, because a later place may lie within it */
        json_t *own = json_deep_copy(value);
        if (!document || !own) {
            json_decref(own);
            snprintf(error->text, sizeof error->text, "out of memory");
            return SCENE_NO_MEMORY;
        }
        if (pointer_set(document, place, own, s->full_scene)) continue;
        snprintf(error->text, sizeof error->text, "%.4096s: %.1000s: expected a place of the scene", s->scene_file,
                 place);
        return SCENE_BAD_INPUT;
    }
    return SCENE_OK;
}

scene_status trial_scene(const study *s, json_t *inputs, int run, scene **result, double *begin, scene_error *error)
{
    json_t *document = json_deep_copy(s->scene);
    *result = NULL;
    scene_status status = set_inputs(s, inputs, document, error);
    if (status == SCENE_OK)
        status = scene_load_document(s->scene_file, s->scene_text, s->scene_length, document, result, error);
    json_decref(document);
    if (status != SCENE_OK) return status;
    char reason[SCENE_SOLVER_TEXT];
    if (s->contact_solver == WORLD_PINCH && !scene_check_solver(*result, reason)) {
        snprintf(error->text, sizeof error->text, "%.4096s: %s", s->scene_file, reason);
        scene_free(*result);
        *result = NULL;
        return SCENE_BAD_INPUT;
    }
    if (s->step > 0.0) (*result)->step = s->step;
    (*result)->step = ldexp((*result)->step, -s->halvings);
    if (!protocol_apply(&s->protocol, run, *result, begin)) {
        scene_free(*result);
        *result = NULL;
        snprintf(error->text, sizeof error->text, "out of memory");
        return SCENE_NO_MEMORY;
    }
    if (scene_steps_fit((*result)->duration, (*result)->step)) return SCENE_OK;
    snprintf(error->text, sizeof error->text, "%.4096s: expected at least half a step and at most %g steps, got %g",
             s->scene_file, SCENE_MOST_STEPS, (*result)->duration / (*result)->step);
    scene_free(*result);
    *result = NULL;
    return SCENE_BAD_INPUT;
}

/* ---- A run. ---- */

/* The object's pose as the hand sees it, which the schedule has moved and turned about the world's origin. */
typedef struct pose {
    double position[3], orientation[4];
} pose;

static pose pose_in_hand(const world *w)
{
    pose p;
    double turn[4], from_hand[3];
    scene_loads loads;
    scene_schedule_at(w->scene, w->time, &loads);
    scene_quaternion_from_rotation(loads.v[SCENE_HAND_ROTATION], turn);
    scene_subtract(dBodyGetPosition(w->object), loads.v[SCENE_HAND_TRANSLATION], from_hand);
    scene_rotate_back(turn, from_hand, p.position);
    double back[4] = {turn[0], -turn[1], -turn[2], -turn[3]};
    scene_quaternion_product(back, dBodyGetQuaternion(w->object), p.orientation);
    return p;
}

static double distance(const pose *a, const pose *b)
{
    double d[3];
    scene_subtract(a->position, b->position, d);
    return scene_norm(d);
}

static double angle(const pose *a, const pose *b)
{
    double back[4] = {a->orientation[0], -a->orientation[1], -a->orientation[2], -a->orientation[3]}, turn[4];
    scene_quaternion_product(back, b->orientation, turn);
    return 2.0 * atan2(scene_norm(turn + 1), fabs(turn[0]));
}

static void fail(trial_outcome *o, const char *status, int code, const char *message)
{
    o->status = status;
    o->exit = code;
    o->success = false;
    snprintf(o->message, sizeof o->message, "%.1000s", message);
}

/* What an object that lies in the hand when the protocol begins has done before is no drop: it has come to lie there.
 */
static void forget_early_drops(simulation_result *r, double begin, bool held)
{
    int kept = 0;
    for (int i = 0; i < r->event_count; i++)
        if (!held || r->events[i].type != EVENT_DROPPED || r->events[i].time > begin) r->events[kept++] = r->events[i];
    r->event_count = kept;
}

static bool needs_statics(const study *s)
{
    for (size_t i = 0; i < s->record_count; i++)
        if (strncmp(s->records[i], "statics", 7) == 0) return true;
    return false;
}

static void record(const study *s, const world *w, const simulation_result *r, trial_outcome *o)
{
    json_object_set_new(o->recorded, "outcome", w->diverged ? json_null() : json_string(simulation_outcome(r)));
    json_object_set_new(o->recorded, "displacement", json_number(o->displacement));
    json_object_set_new(o->recorded, "rotation", json_number(o->rotation));
    if (s->record_count == 0) return;
    json_t *document = simulation_document(w, r, needs_statics(s));
    for (size_t i = 0; i < s->record_count; i++)
        if (!record_is_static(s->records[i])) (void)record_take(document, s->records[i], o->recorded);
    json_decref(document);
}

static void judge(const study *s, const world *w, const simulation_result *r, trial_outcome *o)
{
    pinch_solve_status status = world_solve_status(w);
    o->status = pinch_solve_status_text(status);
    o->exit = status == PINCH_SOLVE_CONVERGED ? 0 : 1;
    /* comparisons that NaN does not pass */
    o->success = o->exit == 0 && o->displacement <= s->success.displacement && o->rotation <= s->success.rotation;
    for (int i = 0; i < r->event_count; i++)
        if (s->success.no_events & 1u << r->events[i].type) o->success = false;
    if (o->exit != 0) snprintf(o->message, sizeof o->message, "the run ended at %g s: %s", w->time, o->status);
}

static bool is_held(const world *w)
{
    for (int i = 0; i < w->finger_count; i++)
        if (w->fingers[i].object == 0 && w->fingers[i].state.points > 0) return true;
    return false;
}

/* The protocol's start. */
typedef struct beginning {
    double time; /* s; 0: from the run's start on */
    bool reached, held;
    pose start;
} beginning;

static void begin_protocol(const study *s, const world *w, const trial_watch *watch, beginning *b)
{
    b->reached = true;
    b->start = pose_in_hand(w);
    b->held = is_held(w);
    if (watch && watch->grasp) record_contacts(s, w, watch->grasp);
}

static void step_through(const study *s, world *w, double begin, const trial_watch *watch, trial_outcome *o)
{
    simulation_result result = {.events = NULL};
    simulation *sim = simulation_start(w);
    if (!sim) {
        fail(o, "no_memory", 3, "out of memory");
        return;
    }
    world_status status = WORLD_OK;
    beginning b = {.time = begin, .start = pose_in_hand(w), .reached = !(begin > 0.0)};
    for (long k = simulation_steps(sim); k > 0 && status == WORLD_OK; k--) {
        status = simulation_step(sim);
        if (!b.reached && w->time >= begin - 0.5 * w->scene->step) begin_protocol(s, w, watch, &b);
        if (watch && watch->step && status == WORLD_OK) watch->step(watch->context, w);
    }
    simulation_finish(sim, &result);
    if (begin > 0.0)
        forget_early_drops(&result, begin, b.held);
    else if (watch && watch->grasp)
        record_contacts(s, w, watch->grasp);
    pose end = pose_in_hand(w);
    o->displacement = distance(&b.start, &end);
    o->rotation = angle(&b.start, &end);
    judge(s, w, &result, o);
    record(s, w, &result, o);
    if (status == WORLD_NO_MEMORY) fail(o, "no_memory", 3, "out of memory");
    snprintf(o->hash, sizeof o->hash, "%016" PRIx64, world_hash(w));
    if (watch && watch->finish) watch->finish(watch->context, w, &result);
    simulation_free(&result);
}

static void run_scene(const study *s, const scene *run, double begin, const trial_watch *watch, trial_outcome *o)
{
    world_settings settings = world_default_settings(run);
    settings.contact_solver = s->contact_solver;
    dRandSetSeed(0); /* quickstep's order of rows does not depend on what this process has run before */
    char error[256];
    world *w;
    switch (world_create(run, &settings, &w, error)) {
    case WORLD_OK:
        step_through(s, w, begin, watch, o);
        world_free(w);
        break;
    case WORLD_NO_MEMORY:
        fail(o, "no_memory", 3, error);
        break;
    default:
        fail(o, "bad_draw", 2, error);
    }
}

trial_outcome trial_run_once(const study *s, json_t *inputs, int run, const trial_watch *watch)
{
    trial_outcome o = {.status = "", .displacement = NAN, .rotation = NAN, .recorded = json_object()};
    double started = clock_seconds(), begin;
    scene_error error;
    scene *scene_of_run;
    switch (trial_scene(s, inputs, run, &scene_of_run, &begin, &error)) {
    case SCENE_OK:
        run_scene(s, scene_of_run, begin, watch, &o);
        break;
    case SCENE_NO_MEMORY:
        fail(&o, "no_memory", 3, error.text);
        break;
    default:
        fail(&o, "bad_draw", 2, error.text);
    }
    scene_free(scene_of_run);
    o.wall_time = clock_seconds() - started;
    return o;
}
