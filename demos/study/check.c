/* What is checked before any trial. */
#include "trial.h"

#include <stdio.h>
#include <string.h>

/* ---- What is recorded. ---- */

/* The document of a run of no steps has all the names that there are. The links of a hand are in it, too, although
 * nothing touches them yet. */
static json_t *document_of(world *w)
{
    simulation_result result;
    simulation *sim = simulation_start(w);
    if (!sim) return NULL;
    for (int i = 0; i < w->finger_count; i++) w->fingers[i].state.peak_normal_force = 1.0;
    simulation_finish(sim, &result);
    json_t *document = simulation_document(w, &result, true);
    simulation_free(&result);
    return document;
}

static scene_status example_document(const study *s, json_t **document, scene_error *error)
{
    scene *base;
    world *w;
    char reason[256];
    *document = NULL;
    scene_status status = scene_load_document(s->scene_file, s->scene_text, s->scene_length, s->scene, &base, error);
    if (status != SCENE_OK) return status;
    world_settings settings = world_default_settings(base);
    settings.contact_solver = s->contact_solver;
    settings.solver.solver = PINCH_SOLVER_NSNMGK; /* names are the same with all, and this one does all laws */
    world_status made = world_create(base, &settings, &w, reason);
    if (made == WORLD_OK) {
        *document = document_of(w);
        world_free(w);
        snprintf(reason, sizeof reason, "out of memory");
    }
    scene_free(base);
    if (*document) return SCENE_OK;
    snprintf(error->text, sizeof error->text, "%.4096s: %s", s->scene_file, reason);
    return made == WORLD_OK || made == WORLD_NO_MEMORY ? SCENE_NO_MEMORY : SCENE_BAD_INPUT;
}

/* May fingers and joints of trials have other names than those of the scene? Numbers give none. */
static bool names_vary(const study *s)
{
    for (size_t i = 0; i < s->variation_count; i++)
        for (size_t k = 0; k < json_array_size(s->variations[i].values); k++) {
            const json_t *value = json_array_get(s->variations[i].values, k);
            if (json_is_object(value) || json_is_array(value) || json_is_string(value)) return true;
        }
    return false;
}

/* The result under any name of the list, fingers or joints. */
static bool is_of_any(const json_t *document, const char *list, const char *name)
{
    char any[512];
    size_t length = strlen(list);
    const char *rest = strncmp(name, list, length) == 0 && name[length] == '.' ? strchr(name + length + 1, '.') : NULL;
    if (!rest || snprintf(any, sizeof any, "%s.*%s", list, rest) >= (int)sizeof any) return false;
    json_t *found = json_object();
    bool known = found && record_take(document, any, found) > 0;
    json_decref(found);
    return known;
}

static bool is_recordable(const study *s, const json_t *document, size_t index)
{
    const char *name = s->records[index];
    json_t *found = json_object();
    bool known;
    if (record_is_static(name)) {
        study one = *s;
        scene nothing = {.finger_count = 0};
        one.records = s->records + index;
        one.record_count = 1;
        known = record_grasp(&one, &nothing, 0.0, found);
    } else {
        known = record_take(document, name, found) > 0;
        if (!known && names_vary(s))
            known = is_of_any(document, "fingers", name) || is_of_any(document, "joints", name);
    }
    json_decref(found);
    return known;
}

static scene_status check_records(const study *s, scene_error *error)
{
    json_t *document;
    if (s->record_count == 0) return SCENE_OK;
    scene_status status = example_document(s, &document, error);
    for (size_t i = 0; i < s->record_count && status == SCENE_OK; i++)
        if (!is_recordable(s, document, i)) status = study_refuse_record(s, i, error);
    json_decref(document);
    return status;
}

/* ---- What is drawn. ---- */

static scene_status check_scene(const study *s, json_t *inputs, scene_error *error)
{
    scene *drawn;
    double begin;
    scene_status status = trial_scene(s, inputs, 0, &drawn, &begin, error);
    scene_free(drawn);
    return status;
}

/* Is the trial a legal scene, with both ends of a search? */
static scene_status check_draw(const study *s, long index, scene_error *error)
{
    json_t *inputs = study_draw(s, index);
    snprintf(error->text, sizeof error->text, "out of memory");
    if (!inputs) return SCENE_NO_MEMORY;
    if (s->least.path) trial_set_least(s, inputs, s->least.from);
    scene_status status = check_scene(s, inputs, error);
    if (s->least.path && status == SCENE_OK) {
        trial_set_least(s, inputs, s->least.to);
        status = check_scene(s, inputs, error);
    }
    json_decref(inputs);
    return status;
}

/* What is wrong stands in the scene's place for it, but came from the study. */
static void say_where_from(const study *s, scene_error *error)
{
    scene_error of_scene = *error;
    const char *from = !s->least.path ? "vary" : s->variation_count > 0 ? "vary, least" : "least";
    if (s->variation_count == 0 && !s->least.path) return;
    snprintf(error->text, sizeof error->text, "%.2048s: %s: no trial tried is a legal scene; in trial 0, %.3900s",
             s->file, from, of_scene.text);
}

/* A bad draw is a row of the results, wherever it comes. Only where all trials are bad is there nothing to run. That
 * takes as long as reading so many scenes, so that of a larger study nobody looks whether it is so. */
scene_status trial_check(const study *s, scene_error *error)
{
    enum { MOST_TRIED = 1000 };
    scene_status status = check_records(s, error);
    if (status != SCENE_OK) return status;
    scene_error later;
    long tried = s->samples < MOST_TRIED ? s->samples : MOST_TRIED;
    for (long k = 0; k < tried; k++) {
        status = check_draw(s, k, k == 0 ? error : &later);
        if (status == SCENE_NO_MEMORY && k > 0) *error = later;
        if (status != SCENE_BAD_INPUT) return status; /* one that is legal is enough */
    }
    if (s->samples > tried) return SCENE_OK;
    say_where_from(s, error);
    return SCENE_BAD_INPUT;
}
