/* Reading and checking a study. */
#define _POSIX_C_SOURCE 200809L

#include "study.h"

#include "common/utf8.h"
#include "scenes/file/reader.h"
#include "scenes/world/simulation.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const scene_key study_keys[] = {
    {"format", true}, {"name", false},     {"source", false},  {"scene", true},  {"trials", true},  {"vary", false},
    {"table", false}, {"protocol", false}, {"success", false}, {"least", false}, {"record", false},
};
static const scene_key trials_keys[] = {{"samples", false}, {"seed", false}, {"design", false}};
static const scene_key none_keys[] = {{"name", true}};
static const scene_key lift_keys[] = {{"name", true},   {"settle", false}, {"distance", false},
                                      {"speed", false}, {"axis", false},   {"hold", false}};
static const scene_key shake_keys[] = {{"name", true},       {"settle", false}, {"amplitude", false},
                                       {"frequency", false}, {"axes", false},   {"time", false}};
static const scene_key forces_keys[] = {{"name", true}, {"settle", false}, {"force_per_mass", false}, {"hold", false}};
static const scene_key success_keys[] = {{"displacement", false}, {"rotation", false}, {"no_events", false}};

#define KIND(keys)                                                                                                     \
    {                                                                                                                  \
        "", sizeof(keys) / sizeof((keys)[0]), keys                                                                     \
    }
static const scene_kind study_kind = KIND(study_keys), trials_kind = KIND(trials_keys),
                        success_kind = KIND(success_keys);
static const scene_kind protocol_kinds[] = {KIND(none_keys), KIND(lift_keys), KIND(shake_keys), KIND(forces_keys)};
static const char *const protocol_names[] = {"none", "lift", "shake", "six-forces"};

/* ---- Files. ---- */

/* The path of a file that is named relative to the study's. */
static char *beside(const char *file, const char *name)
{
    const char *slash = strrchr(file, '/');
    size_t folder = slash && name[0] != '/' ? (size_t)(slash - file) + 1 : 0;
    char *path = malloc(folder + strlen(name) + 1);
    if (!path) return NULL;
    memcpy(path, file, folder);
    strcpy(path + folder, name);
    return path;
}

/* A scene that is refused is refused with its own message. */
static bool read_scene(const scene_node *root, study *s)
{
    scene_reader reader = {.what = "scene file", .error = root->reader->error};
    scene_node node = scene_member(root, "scene");
    if (!json_is_string(node.value)) return scene_refuse(&node, "the name of a scene file");
    s->scene_file = beside(s->file, json_string_value(node.value));
    if (!s->scene_file) return scene_refuse_memory(root->reader);
    reader.file = s->scene_file;
    scene *base = NULL;
    /* one that is not there is named where the study names it */
    if (access(s->scene_file, R_OK) != 0)
        return scene_refuse(&node, "a scene file that can be read (%s)", strerror(errno));
    if (scene_read_document(&reader, &s->scene_text, &s->scene)) {
        s->scene_length = reader.length;
        reader.status =
            scene_load_document(s->scene_file, s->scene_text, s->scene_length, s->scene, &base, root->reader->error);
    }
    root->reader->status = reader.status;
    if (base) root->reader->dimension = base->dimension;
    scene_free(base);
    return reader.status == SCENE_OK;
}

static bool read_table(const scene_node *root, study *s)
{
    scene_node node = scene_member(root, "table");
    if (!node.value) return true;
    if (!json_is_string(node.value)) return scene_refuse(&node, "the name of a CSV file");
    char *path = beside(s->file, json_string_value(node.value));
    if (!path) return scene_refuse_memory(root->reader);
    root->reader->status = study_table_read(path, &s->table, root->reader->error);
    free(path);
    return root->reader->status == SCENE_OK;
}

/* ---- Trials. ---- */

static bool read_trials(const scene_node *root, study *s)
{
    static const char *const designs[] = {"random", "sobol", "grid", "table"};
    scene_node node = scene_member(root, "trials"), seed = scene_member(&node, "seed");
    int design = STUDY_RANDOM, samples = 0;
    if (!scene_check_kind(&node, &trials_kind, NULL) || !scene_read_name(&node, "design", designs, 4, &design) ||
        !scene_read_integer(&node, "samples", 1, STUDY_MOST_SAMPLES, &samples))
        return false;
    s->design = (study_design)design;
    s->samples = samples;
    double value = seed.value ? json_number_value(seed.value) : 1.0;
    if ((seed.value && !json_is_number(seed.value)) || !(value >= 0.0 && value <= 0x1p53) || value != floor(value))
        return scene_refuse(&seed, "a whole number from 0 to 2^53");
    s->seed = (uint64_t)value;
    scene_node table = scene_member(root, "table");
    if (s->design == STUDY_TABLE && !table.value) return scene_refuse(&table, "a CSV file, for the design \"table\"");
    scene_node missing = scene_member(&node, "samples");
    if (s->design <= STUDY_SOBOL && !missing.value)
        return scene_refuse(&missing, "the number of trials, for the design \"%s\"", designs[design]);
    return true;
}

/* A grid and a table have as many trials as combinations; `samples` may take the first of them. */
static bool count_trials(const scene_node *root, study *s)
{
    double count = s->table.row_count > 0 ? (double)s->table.row_count : 1.0;
    if (s->design == STUDY_GRID)
        for (size_t i = 0; i < s->variation_count; i++) {
            const study_variation *v = &s->variations[i];
            if (v->type == STUDY_VALUES)
                count *= pow((double)json_array_size(v->values), v->common ? 1.0 : (double)v->place_count);
        }
    if (s->design <= STUDY_SOBOL) return true;
    scene_node trials = scene_member(root, "trials"), samples = scene_member(&trials, "samples");
    if (!samples.value && count > STUDY_MOST_SAMPLES)
        return scene_refuse_plainly(&trials, "at most %d trials, got %g", STUDY_MOST_SAMPLES, count);
    if (samples.value && (double)s->samples > count)
        return scene_refuse(&samples, "at most %g, all that there are", count);
    if (!samples.value) s->samples = (long)count;
    return true;
}

/* ---- The rest. ---- */

static bool read_axes(const scene_node *node, bool axes[3])
{
    scene_node list = scene_member(node, "axes");
    if (!list.value) return true;
    if (json_array_size(list.value) == 0) return scene_refuse(&list, "a list of x, y and z");
    axes[0] = axes[1] = axes[2] = false;
    for (size_t i = 0; i < json_array_size(list.value); i++) {
        scene_node element = scene_element(&list, i);
        const char *name = json_string_value(element.value);
        if (!name || strlen(name) != 1 || *name < 'x' || *name > 'z') return scene_refuse(&element, "x, y or z");
        if (*name == 'z' && node->reader->dimension == 2) return scene_refuse(&element, "x or y, in dimension 2");
        axes[*name - 'x'] = true;
    }
    return true;
}

static bool read_protocol(const scene_node *root, study_protocol *p)
{
    scene_node node = scene_member(root, "protocol");
    bool flat = root->reader->dimension == 2;
    int type = STUDY_NO_PROTOCOL;
    *p = (study_protocol){.distance = 0.2,
                          .speed = 0.2,
                          .axis = {0, flat, !flat},
                          .amplitude = 0.02,
                          .frequency = 3,
                          .axes = {true, true, !flat},
                          .time = 2,
                          .force_per_mass = 10};
    if (!node.value) return true;
    if (!json_is_object(node.value)) return scene_refuse(&node, "an object");
    if (!scene_read_name(&node, "name", protocol_names, 4, &type) ||
        !scene_check_kind(&node, &protocol_kinds[type], NULL))
        return false;
    p->type = (study_protocol_type)type;
    p->settle = type == STUDY_NO_PROTOCOL ? 0 : 0.5;
    p->hold = type == STUDY_LIFT ? 1 : 2;
    return scene_read_number(&node, "settle", SCENE_NOT_NEGATIVE, "s", &p->settle) &&
           scene_read_number(&node, "distance", SCENE_POSITIVE, "m", &p->distance) &&
           scene_read_number(&node, "speed", SCENE_POSITIVE, "m/s", &p->speed) &&
           scene_read_unit_vector(&node, "axis", SCENE_POLAR, p->axis) &&
           scene_read_number(&node, "hold", SCENE_NOT_NEGATIVE, "s", &p->hold) &&
           scene_read_number(&node, "amplitude", SCENE_POSITIVE, "m", &p->amplitude) &&
           scene_read_number(&node, "frequency", SCENE_POSITIVE, "Hz", &p->frequency) && read_axes(&node, p->axes) &&
           scene_read_number(&node, "time", SCENE_POSITIVE, "s", &p->time) &&
           scene_read_number(&node, "force_per_mass", SCENE_POSITIVE, "m/s^2", &p->force_per_mass);
}

static bool read_events(const scene_node *node, unsigned *set)
{
    scene_node list = scene_member(node, "no_events");
    if (!list.value) return true;
    if (!scene_check_array(&list, "events")) return false;
    *set = 0;
    for (size_t i = 0; i < json_array_size(list.value); i++) {
        scene_node element = scene_element(&list, i);
        const char *name = json_string_value(element.value);
        int event = 0;
        while (event < EVENT_COUNT && !(name && strcmp(name, simulation_event_name((simulation_event_type)event)) == 0))
            event++;
        if (event == EVENT_COUNT) return scene_refuse(&element, "crush, slip, dropped or limit");
        *set |= 1u << event;
    }
    return true;
}

static bool read_success(const scene_node *root, study_success *success)
{
    scene_node node = scene_member(root, "success");
    *success = (study_success){INFINITY, INFINITY, 1u << EVENT_DROPPED};
    return !node.value || (scene_check_kind(&node, &success_kind, NULL) &&
                           scene_read_number(&node, "displacement", SCENE_NOT_NEGATIVE, "m", &success->displacement) &&
                           scene_read_number(&node, "rotation", SCENE_NOT_NEGATIVE, "rad", &success->rotation) &&
                           read_events(&node, &success->no_events));
}

static bool read_records(const scene_node *root, study *s)
{
    scene_node list = scene_member(root, "record");
    if (list.value && !scene_check_array(&list, "names of results")) return false;
    s->record_count = json_array_size(list.value);
    s->records = calloc(s->record_count + 1, sizeof *s->records);
    if (!s->records) return scene_refuse_memory(root->reader);
    for (size_t i = 0; i < s->record_count; i++) {
        scene_node element = scene_element(&list, i);
        s->records[i] = json_string_value(element.value);
        if (!s->records[i] || !*s->records[i])
            return scene_refuse(&element, "the name of a result, as \"object.creep\"");
    }
    return true;
}

/* The scene's document with every default filled in. */
static json_t *full_scene(const study *s)
{
    scene_error error;
    scene *base;
    char *text = NULL;
    size_t length = 0;
    if (scene_load_document(s->scene_file, s->scene_text, s->scene_length, s->scene, &base, &error) != SCENE_OK)
        return NULL;
    FILE *stream = open_memstream(&text, &length);
    bool good = stream && scene_print(base, stream) == SCENE_OK;
    if (stream) good = fclose(stream) == 0 && good;
    json_t *full = good ? json_loadb(text, length, JSON_DECODE_INT_AS_REAL, NULL) : NULL;
    free(text);
    scene_free(base);
    return full;
}

static char *name_of_file(const char *file)
{
    const char *slash = strrchr(file, '/');
    char *name = utf8_copy(slash ? slash + 1 : file), *suffix = name ? strrchr(name, '.') : NULL;
    if (suffix && suffix != name && strcmp(suffix, ".json") == 0) *suffix = '\0';
    return name;
}

static bool read_study(const scene_node *root, study *s)
{
    static const char *const formats[] = {"pinch-study/1"};
    int format;
    char *source = NULL;
    s->name = name_of_file(s->file);
    if (!s->name) return scene_refuse_memory(root->reader);
    bool good = scene_check_kind(root, &study_kind, NULL) && scene_read_name(root, "format", formats, 1, &format) &&
                scene_read_string(root, "name", false, &s->name) && scene_read_string(root, "source", true, &source) &&
                read_scene(root, s) && read_table(root, s) && read_trials(root, s);
    free(source);
    if (good && !(s->full_scene = full_scene(s))) good = scene_refuse_memory(root->reader);
    return good && study_read_variations(root, s) && count_trials(root, s) && read_protocol(root, &s->protocol) &&
           read_success(root, &s->success) && study_read_least(root, s) && read_records(root, s);
}

scene_status study_load(const char *path, study **result, scene_error *error)
{
    scene_reader reader = {.file = path, .what = "study", .status = SCENE_OK, .error = error};
    *result = NULL;
    error->text[0] = '\0';
    study *s = calloc(1, sizeof *s);
    bool good = s && (s->file = strdup(path)) != NULL;
    if (!good) {
        (void)scene_refuse_memory(&reader);
    } else {
        good = scene_read_document(&reader, &s->text, &s->document);
        s->length = reader.length;
    }
    if (good) {
        scene_node root = {.reader = &reader, .value = s->document};
        good = read_study(&root, s);
    }
    if (good) {
        reader.status = study_read_files(s, error);
        good = reader.status == SCENE_OK;
    }
    if (good)
        *result = s;
    else
        study_free(s);
    return good ? SCENE_OK : reader.status;
}

void study_free(study *s)
{
    if (!s) return;
    for (size_t i = 0; i < s->variation_count; i++) {
        study_variation *v = &s->variations[i];
        for (size_t k = 0; k < v->place_count; k++) free(v->places[k]);
        free(v->places);
        free(v->columns);
    }
    for (size_t k = 0; k < s->least.place_count; k++) free(s->least.places[k]);
    free(s->least.places);
    free(s->variations);
    free(s->records);
    study_table_free(&s->table);
    json_decref(s->document);
    json_decref(s->scene);
    json_decref(s->full_scene);
    for (size_t i = 0; i < s->file_count; i++) free(s->file_names[i]);
    free(s->file_names);
    free(s->scene_file);
    free(s->scene_text);
    free(s->name);
    free(s->text);
    free(s->file);
    free(s);
}

scene_status study_refuse_record(const study *s, size_t index, scene_error *error)
{
    scene_reader reader = {.file = s->file, .text = s->text, .length = s->length, .error = error};
    scene_node root = {.reader = &reader, .value = s->document};
    scene_node list = scene_member(&root, "record"), element = scene_element(&list, index);
    (void)scene_refuse(&element,
                       "a result of `pinch run --json`, as \"object.creep\" or \"fingers.*.slip_total\", or one of "
                       "grasp.smallest_friction, largest_load_factor, least_closing, epsilon, epsilon_upper and "
                       "volume");
    return reader.status;
}
