/* Reads the document of a recorded solve. plugin/record/document.c writes it. */
#include "island_file.h"

#include "scenes/file/reader.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The tag only says that the memory is this island's. */
enum { TAG = 1, MOST_COUNT = 1000000 };

#define KIND(title, list) static const scene_kind title = {#title, sizeof list / sizeof *list, list};

static const scene_key document_keys[] = {{"format", true}, {"step_number", true}, {"island", true},
                                          {"solver", true}, {"problem", true},     {"ended", true}};
static const scene_key solver_keys[] = {{"name", true},           {"tolerance", true},     {"goal", true},
                                        {"max_iterations", true}, {"newton_finish", true}, {"seed", true},
                                        {"budget", false},        {"sweeps", false},       {"sweeps_alone", false}};
static const scene_key problem_keys[] = {{"step", true},     {"faces", true}, {"bodies", true},
                                         {"contacts", true}, {"rows", true},  {"memory", true}};
static const scene_key body_keys[] = {{"mass", true},        {"inertia", true},     {"position", true},
                                      {"velocity", true},    {"external", true},    {"radius", true},
                                      {"drive_axis", false}, {"drive_force", false}};
static const scene_key contact_keys[] = {{"bodies", true},           {"model", true},      {"position", true},
                                         {"normal", true},           {"tangent1", true},   {"depth", true},
                                         {"surface_velocity", true}, {"stiffness", true},  {"damping", true},
                                         {"elastic", true},          {"friction", true},   {"torsional_friction", true},
                                         {"rolling_friction", true}, {"viscous", true},    {"friction_limit", true},
                                         {"max_force", true},        {"may_soften", true}, {"hold", true},
                                         {"hold_span", false},       {"floor", true},      {"compliance", true},
                                         {"rolling_elastic", true},  {"force", true},      {"rolling_moment", true}};
static const scene_key row_keys[] = {{"bodies", true}, {"j1", true},   {"j2", true},     {"continues", false},
                                     {"rhs", true},    {"cfm", true},  {"yield", false}, {"low", true},
                                     {"high", true},   {"force", true}};
static const scene_key memory_keys[] = {{"states", true}, {"pivot", true}, {"factors", true}};
static const scene_key ended_keys[] = {{"status", true},    {"iterations", true}, {"newton_steps", true},
                                       {"residual", true},  {"velocities", true}, {"contact_forces", true},
                                       {"row_forces", true}};
KIND(document_kind, document_keys)
KIND(solver_kind, solver_keys)
KIND(problem_kind, problem_keys)
KIND(body_kind, body_keys)
KIND(contact_kind, contact_keys)
KIND(row_kind, row_keys)
KIND(memory_kind, memory_keys)
KIND(ended_kind, ended_keys)

/* Reads a list of numbers in which null stands for `missing`. */
static bool read_list(const scene_node *node, size_t count, double missing, double *out)
{
    if (!json_is_array(node->value) || json_array_size(node->value) != count)
        return scene_refuse(node, "a list of %zu numbers", count);
    for (size_t i = 0; i < count; i++) {
        const json_t *value = json_array_get(node->value, i);
        scene_node element = scene_element(node, i);
        bool none = json_is_null(value) && !(missing == 0);
        if (!none && !json_is_number(value))
            return scene_refuse(&element, missing == 0 ? "a number" : "a number or null");
        out[i] = none ? missing : json_number_value(value);
    }
    return true;
}

static bool read_member(const scene_node *parent, const char *key, size_t count, double missing, double *out)
{
    scene_node node = scene_member(parent, key);
    return read_list(&node, count, missing, out);
}

static bool read_one(const scene_node *parent, const char *key, double missing, double *out)
{
    scene_node node = scene_member(parent, key);
    bool none = json_is_null(node.value) && !(missing == 0);
    if (!none && !json_is_number(node.value))
        return scene_refuse(&node, missing == 0 ? "a number" : "a number or null");
    *out = none ? missing : json_number_value(node.value);
    return true;
}

static bool read_places(const scene_node *parent, int bodies, int out[2])
{
    scene_node node = scene_member(parent, "bodies");
    double place[2];
    if (!read_list(&node, 2, 0, place)) return false;
    for (int i = 0; i < 2; i++) {
        scene_node element = scene_element(&node, (size_t)i);
        if (!(place[i] >= PINCH_STATIC_BODY && place[i] < bodies) || place[i] != floor(place[i]))
            return scene_refuse(&element, "the place of a body, 0 to %d, or %d for none", bodies - 1,
                                PINCH_STATIC_BODY);
        out[i] = (int)place[i];
    }
    return true;
}

static bool read_body(const scene_node *node, pinch_body *b)
{
    if (!scene_check_kind(node, &body_kind, NULL) || !read_one(node, "mass", 0, &b->mass)) return false;
    if (b->mass == 0 &&
        (!read_member(node, "drive_axis", 3, 0, b->drive_axis) || !read_one(node, "drive_force", 0, &b->drive_force)))
        return false;
    return read_member(node, "inertia", 9, 0, b->inertia) && read_member(node, "position", 3, 0, b->position) &&
           read_member(node, "velocity", 6, 0, b->velocity) && read_member(node, "external", 6, 0, b->external) &&
           read_one(node, "radius", 0, &b->radius);
}

static bool read_law(const scene_node *node, pinch_contact *c)
{
    return read_member(node, "stiffness", 3, 0, c->stiffness) && read_member(node, "damping", 3, 0, c->damping) &&
           read_member(node, "friction", 2, INFINITY, c->friction) &&
           read_one(node, "torsional_friction", INFINITY, &c->torsional_friction) &&
           read_member(node, "rolling_friction", 2, INFINITY, c->rolling_friction) &&
           read_member(node, "friction_limit", 5, INFINITY, c->friction_limit) &&
           read_member(node, "viscous", 2, 0, c->viscous) && read_one(node, "max_force", INFINITY, &c->max_force) &&
           scene_read_boolean(node, "may_soften", &c->may_soften) &&
           scene_read_integer(node, "hold", 0, INT_MAX, &c->hold) &&
           (!scene_has(node, "hold_span") || scene_read_integer(node, "hold_span", 0, INT_MAX / 2, &c->hold_span)) &&
           read_one(node, "floor", 0, &c->floor) && read_member(node, "compliance", 3, 0, c->compliance);
}

static bool read_contact(const scene_node *node, int bodies, pinch_contact *c)
{
    static const char *const names[] = {"frictionless", "hard", "soft", "rolling"};
    static const pinch_contact_model models[] = {PINCH_CONTACT_FRICTIONLESS, PINCH_CONTACT_HARD, PINCH_CONTACT_SOFT,
                                                 PINCH_CONTACT_ROLLING};
    int body[2], model;
    if (!scene_check_kind(node, &contact_kind, NULL) || !read_places(node, bodies, body) ||
        !scene_read_name(node, "model", names, 4, &model))
        return false;
    c->body1 = body[0];
    c->body2 = body[1];
    c->model = models[model];
    return read_member(node, "position", 3, 0, c->position) && read_member(node, "normal", 3, 0, c->normal) &&
           read_member(node, "tangent1", 3, 0, c->tangent1) &&
           read_member(node, "surface_velocity", 6, 0, c->surface_velocity) && read_one(node, "depth", 0, &c->depth) &&
           read_law(node, c) && read_member(node, "elastic", 3, 0, c->elastic) &&
           read_member(node, "rolling_elastic", 2, 0, c->rolling_elastic) &&
           read_member(node, "rolling_moment", 2, 0, c->rolling_moment) && read_member(node, "force", 4, 0, c->force);
}

static bool read_row(const scene_node *node, int bodies, pinch_joint_row *row)
{
    int body[2];
    if (!scene_check_kind(node, &row_kind, NULL) || !read_places(node, bodies, body)) return false;
    row->body1 = body[0];
    row->body2 = body[1];
    return read_member(node, "j1", 6, 0, row->j1) && read_member(node, "j2", 6, 0, row->j2) &&
           scene_read_boolean(node, "continues", &row->continues) && read_one(node, "rhs", 0, &row->rhs) &&
           read_one(node, "cfm", 0, &row->cfm) &&
           (!json_object_get(node->value, "yield") || read_one(node, "yield", 0, &row->yield)) &&
           read_one(node, "low", -INFINITY, &row->low) && read_one(node, "high", INFINITY, &row->high) &&
           read_one(node, "force", 0, &row->force);
}

/* Reads the list of this key, of which there have to be `least`. *items becomes room for its elements, all zero. */
static bool open_list(const scene_node *parent, const char *key, int least, size_t size, scene_node *node, void **items,
                      int *count)
{
    *node = scene_member(parent, key);
    if (!scene_check_array(node, key)) return false;
    size_t n = json_array_size(node->value);
    if (n < (size_t)least || n > MOST_COUNT) return scene_refuse(node, "a list of %d to %d", least, MOST_COUNT);
    *items = calloc(n + 1, size);
    *count = (int)n;
    return *items || scene_refuse_memory(parent->reader);
}

static bool read_whole_numbers(const scene_node *parent, const char *key, int below, int **out, int *count)
{
    scene_node node;
    if (!open_list(parent, key, 0, sizeof **out, &node, (void **)out, count)) return false;
    for (int i = 0; i < *count; i++) {
        scene_node element = scene_element(&node, (size_t)i);
        double value = json_number_value(element.value);
        if (!json_is_number(element.value) || !(value >= 0 && value < below) || value != floor(value))
            return scene_refuse(&element, "a whole number from 0 to %d", below - 1);
        (*out)[i] = (int)value;
    }
    return true;
}

/* Reads what the island remembered of its last step into a memory. */
static bool read_factors(const scene_node *node, pinch_step_memory *memory, int **pivot, int **states, double **lu)
{
    enum { MOST_UNKNOWNS = 4096 };
    pinch_step_factors f = {.tag = TAG};
    if (!scene_check_kind(node, &memory_kind, NULL) ||
        !read_whole_numbers(node, "pivot", MOST_UNKNOWNS, pivot, &f.unknowns) ||
        !read_whole_numbers(node, "states", 256, states, &f.element_count))
        return false;
    scene_node places = scene_member(node, "pivot");
    size_t n = (size_t)f.unknowns;
    *lu = calloc(n * n + 1, sizeof **lu);
    unsigned char *bytes = (unsigned char *)*states; /* in place: what is written was read before */
    if (!*lu) return scene_refuse_memory(node->reader);
    if (!read_member(node, "factors", n * n, 0, *lu)) return false;
    for (int i = 0; i < f.element_count; i++) bytes[i] = (unsigned char)(*states)[i];
    f.lu = *lu;
    f.pivot = *pivot;
    f.states = bytes;
    pinch_status status = pinch_step_memory_write(memory, &f);
    if (status == PINCH_OUT_OF_MEMORY) return scene_refuse_memory(node->reader);
    return status == PINCH_OK || scene_refuse(&places, "places below their count");
}

static bool read_memory(const scene_node *problem, pinch_problem *p)
{
    scene_node node = scene_member(problem, "memory");
    int *pivot = NULL, *states = NULL;
    double *lu = NULL;
    if (pinch_step_memory_create(&p->memory) != PINCH_OK) return scene_refuse_memory(problem->reader);
    p->tag = TAG;
    bool good = json_is_null(node.value) || read_factors(&node, p->memory, &pivot, &states, &lu);
    free(pivot);
    free(states);
    free(lu);
    return good;
}

static bool read_problem(const scene_node *root, pinch_problem *p)
{
    scene_node node = scene_member(root, "problem"), list;
    if (!scene_check_kind(&node, &problem_kind, NULL) ||
        !scene_read_number(&node, "step", SCENE_POSITIVE, "s", &p->step) ||
        !scene_read_integer(&node, "faces", 0, SCENE_MAX_FACES, &p->faces) ||
        !open_list(&node, "bodies", 1, sizeof *p->bodies, &list, (void **)&p->bodies, &p->body_count))
        return false;
    for (int i = 0; i < p->body_count; i++) {
        scene_node element = scene_element(&list, (size_t)i);
        if (!read_body(&element, &p->bodies[i])) return false;
    }
    if (!open_list(&node, "contacts", 0, sizeof *p->contacts, &list, (void **)&p->contacts, &p->contact_count))
        return false;
    for (int i = 0; i < p->contact_count; i++) {
        scene_node element = scene_element(&list, (size_t)i);
        if (!read_contact(&element, p->body_count, &p->contacts[i])) return false;
    }
    if (!open_list(&node, "rows", 0, sizeof *p->rows, &list, (void **)&p->rows, &p->row_count)) return false;
    for (int i = 0; i < p->row_count; i++) {
        scene_node element = scene_element(&list, (size_t)i);
        if (!read_row(&element, p->body_count, &p->rows[i])) return false;
    }
    return read_memory(&node, p);
}

static bool read_seed(const scene_node *parent, uint64_t *seed)
{
    scene_node node = scene_member(parent, "seed");
    const char *text = json_string_value(node.value);
    if (!text || !*text || strlen(text) > 20 || text[strspn(text, "0123456789")])
        return scene_refuse(&node, "a whole number as a text");
    *seed = strtoull(text, NULL, 10);
    return true;
}

static bool read_settings(const scene_node *root, pinch_solver_settings *s)
{
    scene_node node = scene_member(root, "solver");
    const char *names[PINCH_SOLVER_COUNT];
    int name;
    for (int i = 0; i < PINCH_SOLVER_COUNT; i++) names[i] = pinch_solver_name((pinch_solver)i);
    *s = pinch_default_solver_settings();
    if (!scene_check_kind(&node, &solver_kind, NULL) ||
        !scene_read_name(&node, "name", names, PINCH_SOLVER_COUNT, &name) ||
        !scene_read_number(&node, "tolerance", SCENE_POSITIVE, "", &s->tolerance) ||
        !scene_read_number(&node, "goal", SCENE_NOT_NEGATIVE, "", &s->goal) ||
        !scene_read_integer(&node, "max_iterations", 1, INT_MAX, &s->max_iterations) ||
        !scene_read_number(&node, "budget", SCENE_NOT_NEGATIVE, "", &s->budget) ||
        !scene_read_integer(&node, "sweeps", 0, INT_MAX, &s->sweeps) ||
        !scene_read_boolean(&node, "sweeps_alone", &s->sweeps_alone) ||
        !scene_read_boolean(&node, "newton_finish", &s->newton_finish) || !read_seed(&node, &s->seed))
        return false;
    s->solver = (pinch_solver)name;
    scene_node goal = scene_member(&node, "goal");
    return s->goal <= s->tolerance || scene_refuse(&goal, "a number not above the tolerance");
}

/* Reads a list with `count` lists of `width` numbers. */
static bool read_table(const scene_node *parent, const char *key, int count, int width, double **out)
{
    scene_node node = scene_member(parent, key);
    if (!json_is_array(node.value) || json_array_size(node.value) != (size_t)count)
        return scene_refuse(&node, "a list of %d", count);
    *out = calloc((size_t)(count * width) + 1, sizeof **out);
    if (!*out) return scene_refuse_memory(parent->reader);
    for (int i = 0; i < count; i++) {
        scene_node element = scene_element(&node, (size_t)i);
        if (!read_list(&element, (size_t)width, NAN, *out + i * width)) return false;
    }
    return true;
}

static bool read_ended(const scene_node *root, island_file *file)
{
    enum { STATUSES = PINCH_SOLVE_UNVERIFIED + 1 };
    scene_node node = scene_member(root, "ended");
    pinch_solver_result *r = &file->ended.solve;
    const pinch_problem *p = &file->problem;
    const char *names[STATUSES];
    int status;
    for (int i = 0; i < STATUSES; i++) names[i] = pinch_solve_status_text((pinch_solve_status)i);
    if (!scene_check_kind(&node, &ended_kind, NULL) || !scene_read_name(&node, "status", names, STATUSES, &status) ||
        !scene_read_integer(&node, "iterations", 0, INT_MAX, &r->iterations) ||
        !scene_read_integer(&node, "newton_steps", 0, INT_MAX, &r->newton_steps) ||
        !read_one(&node, "residual", NAN, &r->residual))
        return false;
    r->status = (pinch_solve_status)status;
    file->row_forces = calloc((size_t)p->row_count + 1, sizeof *file->row_forces);
    if (!file->row_forces) return scene_refuse_memory(root->reader);
    return read_table(&node, "velocities", p->body_count, 6, &file->velocities) &&
           read_table(&node, "contact_forces", p->contact_count, 4, &file->contact_forces) &&
           read_member(&node, "row_forces", (size_t)p->row_count, NAN, file->row_forces);
}

static bool read_island(const scene_node *root, island_file *file)
{
    static const char *const formats[] = {"pinch-island/1"};
    int format, number = 0;
    bool good = scene_check_kind(root, &document_kind, NULL) && scene_read_name(root, "format", formats, 1, &format) &&
                scene_read_integer(root, "step_number", 0, INT_MAX, &number) &&
                scene_read_integer(root, "island", 0, INT_MAX, &file->island) && read_settings(root, &file->settings) &&
                read_problem(root, &file->problem) && read_ended(root, file);
    file->step_number = number;
    return good;
}

scene_status island_file_load(const char *path, island_file **result, scene_error *error)
{
    scene_reader reader = {.file = path, .what = "recorded island", .status = SCENE_OK, .error = error};
    char *text = NULL;
    json_t *document = NULL;
    *result = NULL;
    error->text[0] = '\0';
    island_file *file = calloc(1, sizeof *file);
    bool good = file ? scene_read_document(&reader, &text, &document) : scene_refuse_memory(&reader);
    if (good) {
        scene_node root = {.reader = &reader, .value = document};
        good = read_island(&root, file);
    }
    json_decref(document);
    free(text);
    if (good)
        *result = file;
    else
        island_file_free(file);
    return reader.status;
}

void island_file_free(island_file *file)
{
    if (!file) return;
    pinch_step_memory_destroy(file->problem.memory);
    free(file->problem.bodies);
    free(file->problem.contacts);
    free(file->problem.rows);
    free(file->velocities);
    free(file->contact_forces);
    free(file->row_forces);
    free(file);
}
