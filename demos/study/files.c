/* The hash of a study: over its own text, and over all files that its trials are made from. */
#define _POSIX_C_SOURCE 200809L

#include "study.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* FNV-1a */
static const uint64_t HASH_START = 0xcbf29ce484222325u;

static uint64_t hash_byte(uint64_t hash, unsigned byte)
{
    return (hash ^ byte) * 0x100000001b3u;
}

/* An end follows, so that texts do not run into each other. */
static uint64_t hash_bytes(uint64_t hash, const void *bytes, size_t length)
{
    const unsigned char *b = bytes;
    for (size_t i = 0; i < length; i++) hash = hash_byte(hash, b[i]);
    return hash_byte(hash, 0xff);
}

/* The files that have been hashed, each once. */
typedef struct file_list {
    uint64_t hash;
    size_t count;
    char **names;
    scene_status status;
    scene_error *error;
} file_list;

static bool hash_file(file_list *l, const char *path)
{
    unsigned char buffer[65536];
    size_t got;
    FILE *stream = fopen(path, "rb");
    if (stream) {
        while ((got = fread(buffer, 1, sizeof buffer, stream)) > 0) l->hash = hash_bytes(l->hash, buffer, got);
        if (!ferror(stream)) return fclose(stream) == 0;
        fclose(stream);
    }
    snprintf(l->error->text, sizeof l->error->text, "%.4096s: cannot be read: %s", path, strerror(errno));
    l->status = SCENE_BAD_INPUT;
    return false;
}

static bool take_file(void *context, const char *path)
{
    file_list *l = context;
    for (size_t i = 0; i < l->count; i++)
        if (strcmp(l->names[i], path) == 0) return true;
    char **more = realloc(l->names, (l->count + 1) * sizeof *more), *name = strdup(path);
    if (more) l->names = more;
    if (!more || !name) {
        free(name);
        snprintf(l->error->text, sizeof l->error->text, "out of memory");
        l->status = SCENE_NO_MEMORY;
        return false;
    }
    l->names[l->count++] = name;
    return hash_file(l, path);
}

/* Has the value a member that names a file? */
static bool names_file(const json_t *value)
{
    const char *key;
    json_t *part;
    size_t i;
    json_object_foreach((json_t *)value, key, part) if (strcmp(key, "file") == 0 || names_file(part)) return true;
    json_array_foreach(value, i, part) if (names_file(part)) return true;
    return false;
}

/* The scene with one of the variation's values in place. A value that makes no legal scene brings no files. */
static void take_value(const study *s, const study_variation *v, const json_t *value, file_list *l)
{
    json_t *document = json_deep_copy(s->scene);
    scene_error ignored;
    scene *varied = NULL;
    bool set = document != NULL;
    for (size_t i = 0; i < v->place_count && set; i++)
        set = pointer_set(document, v->places[i], json_deep_copy(value), s->full_scene);
    if (set &&
        scene_load_document(s->scene_file, s->scene_text, s->scene_length, document, &varied, &ignored) == SCENE_OK)
        (void)scene_each_file(varied, take_file, l);
    scene_free(varied);
    json_decref(document);
}

static void take_values(const study *s, const study_variation *v, file_list *l)
{
    const char *part = strrchr(v->path, '/');
    bool is_file = part && strcmp(part, "/file") == 0;
    for (size_t i = 0; i < json_array_size(v->values) && l->status == SCENE_OK; i++) {
        const json_t *value = json_array_get(v->values, i);
        if (is_file || names_file(value)) take_value(s, v, value, l);
    }
}

scene_status study_read_files(study *s, scene_error *error)
{
    file_list l = {.hash = HASH_START, .error = error};
    scene *base;
    l.status = scene_load_document(s->scene_file, s->scene_text, s->scene_length, s->scene, &base, error);
    if (l.status != SCENE_OK) return l.status;
    (void)scene_each_file(base, take_file, &l);
    scene_free(base);
    for (size_t i = 0; i < s->variation_count; i++)
        if (s->variations[i].type == STUDY_VALUES) take_values(s, &s->variations[i], &l);
    s->files = l.count > 0 ? l.hash : 0;
    s->file_names = l.names;
    s->file_count = l.count;
    return l.status;
}

uint64_t study_hash(const study *s)
{
    uint64_t hash = hash_bytes(HASH_START, s->text, s->length);
    int solver = (int)s->contact_solver;
    hash = hash_bytes(hash, s->scene_text, s->scene_length);
    if (s->table.text) hash = hash_bytes(hash, s->table.text, strlen(s->table.text));
    if (s->files) hash = hash_bytes(hash, &s->files, sizeof s->files);
    hash = hash_bytes(hash, &solver, sizeof solver);
    return hash_bytes(hash, &s->step, sizeof s->step);
}
