/* The run scenes by the paper's method: what the paper announces as future work. */
#define _POSIX_C_SOURCE 200809L

#include "paper.h"

#include "common/output.h"
#include "common/own_place.h"
#include "common/vector.h"
#include "scenes/world/simulation.h"

#include <dirent.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What is compared of a run. */
typedef struct outcome {
    pinch_ode_stats stats;
    double step_us, solve_us;
    int finger_count;
    double forces[3 * 16], position[3];
    const char *status, *outcome;
} outcome;

static bool run(const scene *s, const world_settings *settings, outcome *o)
{
    char error[256];
    world *w;
    simulation_result result = {.events = NULL};
    *o = (outcome){.status = "failed"};
    if (world_create(s, settings, &w, error) != WORLD_OK) return false;
    simulation *run = simulation_start(w);
    world_status status = run ? WORLD_OK : WORLD_NO_MEMORY;
    for (long k = 0; run && k < simulation_steps(run) && status == WORLD_OK; k++) status = simulation_step(run);
    if (run) simulation_finish(run, &result);
    bool done = status != WORLD_NO_MEMORY && w->plugin;
    if (done) {
        o->stats = pinch_ode_statistics(w->plugin);
        o->step_us = w->steps > 0 ? 1e6 * w->step_s / (double)w->steps : NAN;
        o->solve_us = w->steps > 0 ? 1e6 * w->solve_s / (double)w->steps : NAN;
        o->status = pinch_solve_status_text(world_solve_status(w));
        o->outcome = w->diverged ? "diverged" : simulation_outcome(&result);
        o->finger_count = w->finger_count < 16 ? w->finger_count : 16;
        for (int i = 0; i < o->finger_count; i++) scene_copy(w->fingers[i].state.force, o->forces + 3 * i);
        scene_copy(dBodyGetPosition(w->object), o->position);
    }
    simulation_free(&result);
    world_free(w);
    return done;
}

/* The largest difference of a finger's force at the end, N. */
static double force_difference(const outcome *a, const outcome *b)
{
    double worst = 0.0;
    for (int i = 0; i < a->finger_count; i++) {
        double apart[3];
        for (int j = 0; j < 3; j++) apart[j] = a->forces[3 * i + j] - b->forces[3 * i + j];
        worst = fmax(worst, scene_norm(apart));
    }
    return worst;
}

static json_t *outcome_document(const char *mode, const outcome *o, const outcome *standard)
{
    const pinch_ode_stats *s = &o->stats;
    double apart[3];
    for (int j = 0; j < 3; j++) apart[j] = o->position[j] - standard->position[j];
    long solved = s->islands_by_newton + s->islands_by_projections + s->islands_by_flow + s->islands_by_lcp;
    return json_pack("{s:s, s:s, s:s, s:o, s:i, s:I, s:I, s:I, s:I, s:o, s:o, s:o, s:o}", "mode", mode, "status",
                     o->status, "outcome", o->outcome, "iterations_of_a_solve",
                     json_number(solved > 0 ? (double)s->iterations / (double)solved : NAN), "iterations_max",
                     s->iterations_max, "by_projections", (json_int_t)s->islands_by_projections, "by_newton",
                     (json_int_t)s->islands_by_newton, "by_flow", (json_int_t)s->islands_by_flow, "first_solves_failed",
                     (json_int_t)s->retried_islands, "step_us", json_number(o->step_us), "solve_us",
                     json_number(o->solve_us), "force_difference_N", json_number(force_difference(o, standard)),
                     "position_difference_m", json_number(scene_norm(apart)));
}

static json_t *scene_runs(const char *file)
{
    enum { DEFAULT_MODE, CONE, PYRAMID, MODES };
    static const char *const modes[MODES] = {"default", "NSNMGK, exact cone", "NSNMGK, pyramid"};
    scene *s;
    scene_error error;
    if (scene_load(file, &s, &error) != SCENE_OK) return NULL;
    json_t *list = json_array();
    outcome outcomes[MODES];
    bool done = true;
    for (int mode = 0; mode < MODES && done; mode++) {
        world_settings settings = world_default_settings(s);
        settings.faces = mode == PYRAMID ? s->solver.pyramid_faces : 0;
        settings.solver.solver = PINCH_SOLVER_NSNMGK;
        settings.solver.newton_finish = mode == DEFAULT_MODE;
        done = run(s, &settings, &outcomes[mode]);
        if (done) json_array_append_new(list, outcome_document(modes[mode], &outcomes[mode], &outcomes[DEFAULT_MODE]));
    }
    json_t *document = done ? json_pack("{s:s, s:O}", "scene", s->name, "runs", list) : NULL;
    json_decref(list);
    scene_free(s);
    return document;
}

static int is_scene(const struct dirent *entry)
{
    size_t length = strlen(entry->d_name);
    return length > 5 && strcmp(entry->d_name + length - 5, ".json") == 0;
}

json_t *paper_dynamics_document(const bench_request *o)
{
    struct dirent **entries;
    char folder[900];
    if (!own_place_data("scenes", folder, sizeof folder)) return json_null(); /* installed without them */
    int count = scandir(folder, &entries, is_scene, alphasort);
    if (count < 0) return json_null();
    json_t *list = json_array();
    bool done = true;
    dInitODE2(0);
    for (int i = 0; i < count; i++) {
        char file[1200];
        snprintf(file, sizeof file, "%s/%s", folder, entries[i]->d_name);
        progress_part(o->line, "the shipped scenes, by the paper's method");
        json_t *runs = done ? scene_runs(file) : NULL;
        done = runs && json_array_append_new(list, runs) == 0;
        free(entries[i]);
    }
    free(entries);
    world_close_ode();
    if (done) return list;
    json_decref(list);
    return NULL;
}
