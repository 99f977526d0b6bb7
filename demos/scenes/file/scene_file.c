/* The scene file as a whole: reading it, its top level, and letting go of a scene. */

#include "common/utf8.h"
#include "hands/hand.h"
#include "reader.h"
#include "scenes/shape/shape.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

static const char *const formulation_names[SCENE_FORMULATION_COUNT] = {
    [SCENE_COULOMB] = "coulomb",
    [SCENE_LCP] = "lcp",
};

const char *scene_formulation_name(scene_formulation formulation)
{
    return formulation_names[formulation];
}

bool scene_formulation_from_name(const char *name, scene_formulation *formulation)
{
    for (int i = 0; i < SCENE_FORMULATION_COUNT; i++)
        if (strcmp(name, formulation_names[i]) == 0) {
            *formulation = (scene_formulation)i;
            return true;
        }
    return false;
}

/* The file's name without folder and .json, as text. */
static char *name_of_file(const char *file)
{
    const char *slash = strrchr(file, '/');
    char *name = utf8_copy(slash ? slash + 1 : file);
    char *suffix = name ? strrchr(name, '.') : NULL;
    if (suffix && suffix != name && strcmp(suffix, ".json") == 0) *suffix = '\0';
    return name;
}

static bool read_dimension(const scene_node *root, scene *s)
{
    s->dimension = 3;
    if (!scene_read_integer(root, "dimension", 2, 3, &s->dimension)) return false;
    root->reader->dimension = s->dimension;
    s->gravity[s->dimension == 2 ? 1 : 2] = -9.81;
    return scene_read_vector(root, "gravity", SCENE_POLAR, "m/s^2", s->gravity);
}

bool scene_steps_fit(double duration, double step)
{
    double steps = duration / step;
    return duration == 0.0 || (steps >= 0.5 && steps <= SCENE_MOST_STEPS);
}

static bool read_simulation(const scene_node *root, scene *s)
{
    scene_node node = scene_member(root, "simulation");
    s->step = 0.001;
    s->duration = 2.0;
    if (!node.value) return true;
    if (!scene_check_object(&node, "simulation", NULL) ||
        !scene_read_number(&node, "step", SCENE_POSITIVE, "s", &s->step) ||
        !scene_read_number(&node, "duration", SCENE_NOT_NEGATIVE, "s", &s->duration))
        return false;
    if (scene_steps_fit(s->duration, s->step)) return true;
    if (scene_has(&node, "duration")) {
        scene_node duration = scene_member(&node, "duration");
        return scene_refuse(&duration, "0, or half a step of %g s to %g steps", s->step, SCENE_MOST_STEPS);
    }
    scene_node step = scene_member(&node, "step");
    return scene_refuse(&step, "at most twice the duration of %g s and at least %g of it", s->duration,
                        1.0 / SCENE_MOST_STEPS);
}

static bool read_solver(const scene_node *root, scene_solver *solver)
{
    scene_node node = scene_member(root, "solver");
    const char *names[PINCH_SOLVER_COUNT];
    for (int i = 0; i < PINCH_SOLVER_COUNT; i++) names[i] = pinch_solver_name((pinch_solver)i);
    *solver = (scene_solver){PINCH_SOLVER_NSNMGK, SCENE_COULOMB, 1e-10, 20000, 8};
    if (!node.value) return true;
    int name = solver->name, formulation = solver->formulation;
    if (!scene_check_object(&node, "solver", NULL) ||
        !scene_read_name(&node, "name", names, PINCH_SOLVER_COUNT, &name) ||
        !scene_read_name(&node, "formulation", formulation_names, SCENE_FORMULATION_COUNT, &formulation))
        return false;
    solver->name = (pinch_solver)name;
    solver->formulation = (scene_formulation)formulation;
    return scene_read_number(&node, "tolerance", SCENE_POSITIVE, "", &solver->tolerance) &&
           scene_read_integer(&node, "max_iterations", 1, INT_MAX, &solver->max_iterations) &&
           scene_read_integer(&node, "pyramid_faces", SCENE_MIN_FACES, SCENE_MAX_FACES, &solver->pyramid_faces);
}

static bool read_format(const scene_node *root)
{
    static const char *const formats[] = {"pinch-scene/1"};
    int format;
    return scene_read_name(root, "format", formats, 1, &format);
}

static bool read_scene(const scene_node *root, scene *s)
{
    s->file = scene_copy_text(root->reader->file);
    s->name = name_of_file(root->reader->file);
    s->source = scene_copy_text("");
    if (!s->file || !s->name || !s->source) return scene_refuse_memory(root->reader);
    return scene_check_object(root, "scene", NULL) && read_format(root) &&
           scene_read_string(root, "name", false, &s->name) && scene_read_string(root, "source", true, &s->source) &&
           read_dimension(root, s) && scene_read_objects(root, s) && scene_read_hands(root, s) &&
           scene_read_fingers(root, s) && scene_read_environment(root, s) && scene_read_schedule(root, s) &&
           read_simulation(root, s) && read_solver(root, &s->solver);
}

/* Reads the scene from the document, whose text the reader has. */
static scene_status read_document_of(scene_reader *reader, json_t *document, scene **result)
{
    scene_node root = {.reader = reader, .value = document};
    scene *s = calloc(1, sizeof *s);
    bool good = s ? read_scene(&root, s) : scene_refuse_memory(reader);
    if (good)
        *result = s;
    else
        scene_free(s);
    return reader->status;
}

scene_status scene_load(const char *path, scene **result, scene_error *error)
{
    scene_reader reader = {.file = path,
                           .is_standard_input = strcmp(path, "-") == 0,
                           .what = "scene file",
                           .status = SCENE_OK,
                           .error = error};
    char *text = NULL;
    json_t *document = NULL;
    *result = NULL;
    error->text[0] = '\0';
    if (scene_read_document(&reader, &text, &document)) read_document_of(&reader, document, result);
    json_decref(document);
    free(text);
    return reader.status;
}

scene_status scene_load_document(const char *path, const char *text, size_t length, json_t *document, scene **result,
                                 scene_error *error)
{
    scene_reader reader = {.file = path, .text = text, .length = length, .status = SCENE_OK, .error = error};
    *result = NULL;
    error->text[0] = '\0';
    return read_document_of(&reader, document, result);
}

/* ---- The files that a scene refers to. ---- */

static bool take_mesh(const scene_shape *shape, bool (*take)(void *context, const char *path), void *context)
{
    return shape->type != SCENE_MESH || take(context, shape->u.mesh.file);
}

/* Meshes that only pictures show have not been read. */
static bool take_hand(const hand *model, bool (*take)(void *context, const char *path), void *context)
{
    for (size_t i = 0; i < model->file_count; i++)
        if (!take(context, model->files[i])) return false;
    for (size_t i = 0; i < model->mesh_count; i++)
        if (model->meshes[i].hull.vertex_count > 0 && !take(context, model->meshes[i].file)) return false;
    return true;
}

bool scene_each_file(const scene *s, bool (*take)(void *context, const char *path), void *context)
{
    for (size_t i = 0; i < s->object_count; i++)
        if (!take_mesh(&s->objects[i].shape, take, context)) return false;
    for (size_t i = 0; i < s->finger_count; i++)
        if (!take_mesh(&s->fingers[i].tip, take, context)) return false;
    for (size_t i = 0; i < s->environment_count; i++)
        if (!take_mesh(&s->environment[i].shape, take, context)) return false;
    for (size_t i = 0; i < s->hand_count; i++)
        if (!take_hand(s->hands[i].model, take, context)) return false;
    return true;
}

/* ---- Letting go of a scene. ---- */

static void free_finger(scene_finger *finger)
{
    free(finger->name);
    scene_shape_free(&finger->tip);
    if (finger->drive.type == SCENE_DRIVE_PATH) free(finger->drive.u.path.points);
}

void scene_free(scene *s)
{
    if (!s) return;
    for (size_t i = 0; i < s->finger_count; i++) free_finger(&s->fingers[i]);
    for (size_t i = 0; i < s->environment_count; i++) {
        free(s->environment[i].name);
        scene_shape_free(&s->environment[i].shape);
    }
    for (size_t i = 0; i < s->object_count; i++) {
        free(s->objects[i].name);
        scene_shape_free(&s->objects[i].shape);
    }
    for (size_t i = 0; i < s->hand_count; i++) scene_hand_free(&s->hands[i]);
    free(s->objects);
    free(s->hands);
    free(s->fingers);
    free(s->environment);
    free(s->schedule);
    free(s->file);
    free(s->name);
    free(s->source);
    free(s);
}
