#include "reader.h"

#include "common/output.h"
#include "common/vector.h"
#include "locate.h"

#include <float.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

scene_node scene_member(const scene_node *parent, const char *key)
{
    return (scene_node){parent->reader, parent, key, 0, json_object_get(parent->value, key)};
}

scene_node scene_element(const scene_node *parent, size_t index)
{
    return (scene_node){parent->reader, parent, NULL, index, json_array_get(parent->value, index)};
}

bool scene_has(const scene_node *parent, const char *key)
{
    return json_object_get(parent->value, key) != NULL;
}

enum { MAX_STEPS = 16, MAX_KEY = 60 };

static size_t path_steps(const scene_node *node, scene_step steps[MAX_STEPS])
{
    size_t depth = 0;
    for (const scene_node *n = node; n->parent; n = n->parent) depth++;
    if (depth > MAX_STEPS) depth = MAX_STEPS;
    size_t i = depth;
    for (const scene_node *n = node; n->parent && i > 0; n = n->parent) steps[--i] = (scene_step){n->key, n->index};
    return depth;
}

static void path_text(const scene_step *steps, size_t depth, char *text, size_t size)
{
    snprintf(text, size, "%s", depth ? "" : "(top level)");
    size_t used = 0;
    for (size_t i = 0; i < depth && used < size; i++) {
        int n = steps[i].key ? snprintf(text + used, size - used, "%s%.*s", i ? "." : "", (int)MAX_KEY, steps[i].key)
                             : snprintf(text + used, size - used, "[%zu]", steps[i].index);
        used += n > 0 ? (size_t)n : 0;
    }
}

static void describe(const json_t *value, char *text, size_t size)
{
    char number[32];
    if (!value) {
        snprintf(text, size, ", but the key is missing");
    } else if (json_is_number(value)) {
        json_number_text(json_number_value(value), number);
        snprintf(text, size, ", got %s", number);
    } else if (json_is_string(value)) {
        snprintf(text, size, ", got \"%.*s\"", (int)MAX_KEY, json_string_value(value));
    } else if (json_is_boolean(value)) {
        snprintf(text, size, ", got %s", json_is_true(value) ? "true" : "false");
    } else if (json_is_array(value)) {
        snprintf(text, size, ", got a list of %zu", json_array_size(value));
    } else {
        snprintf(text, size, ", got %s", json_is_object(value) ? "an object" : "null");
    }
}

/* Names and texts of the file may hold anything, but the message must be one line. */
static bool finish(scene_reader *reader)
{
    for (char *c = reader->error->text; *c; c++)
        if ((unsigned char)*c < ' ' || *c == 127) *c = '?';
    reader->status = SCENE_BAD_INPUT;
    return false;
}

static bool refuse(const scene_node *node, const char *got, const char *format, va_list arguments)
{
    scene_reader *reader = node->reader;
    scene_step steps[MAX_STEPS];
    size_t depth = path_steps(node, steps);
    char path[256], expected[1536];
    path_text(steps, depth, path, sizeof path);
    vsnprintf(expected, sizeof expected, format, arguments);
    /* A key that is missing has the line of the object that should have it. */
    int line = scene_locate_line(reader->text, reader->length, steps, node->value ? depth : depth - 1);
    snprintf(reader->error->text, sizeof reader->error->text, "%.4096s:%d: %s: expected %s%s", reader->file, line, path,
             expected, got);
    return finish(reader);
}

bool scene_refuse(const scene_node *node, const char *format, ...)
{
    char got[160];
    describe(node->value, got, sizeof got);
    va_list arguments;
    va_start(arguments, format);
    refuse(node, got, format, arguments);
    va_end(arguments);
    return false;
}

bool scene_refuse_plainly(const scene_node *node, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    refuse(node, "", format, arguments);
    va_end(arguments);
    return false;
}

bool scene_refuse_file(scene_reader *reader, const char *format, ...)
{
    char message[768];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    snprintf(reader->error->text, sizeof reader->error->text, "%.4096s:%s", reader->file, message);
    return finish(reader);
}

bool scene_refuse_memory(scene_reader *reader)
{
    snprintf(reader->error->text, sizeof reader->error->text, "%.4096s: out of memory", reader->file);
    finish(reader);
    reader->status = SCENE_NO_MEMORY;
    return false;
}

/* "a, b or c" */
static void list_names(const char *const *names, size_t count, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (size_t i = 0; i < count && used < size; i++) {
        const char *separator = i == 0 ? "" : i + 1 == count ? " or " : ", ";
        int n = snprintf(text + used, size - used, "%s%s", separator, names[i]);
        used += n > 0 ? (size_t)n : 0;
    }
}

static bool refuse_unknown_key(const scene_node *node, const char *key, const scene_kind *kind)
{
    const char *names[40];
    char list[400];
    for (size_t i = 0; i < kind->count; i++) names[i] = kind->keys[i].name;
    list_names(names, kind->count, list, sizeof list);
    scene_node member = scene_member(node, key);
    return scene_refuse_plainly(&member, "a known key (%s)", list);
}

bool scene_check_object(const scene_node *node, const char *kind, const char *extra)
{
    return scene_check_kind(node, scene_kind_named(kind), extra);
}

bool scene_check_kind(const scene_node *node, const scene_kind *kind, const char *extra)
{
    if (!json_is_object(node->value)) return scene_refuse(node, "an object");
    const char *key;
    json_t *value;
    json_object_foreach(node->value, key, value)
    {
        size_t i = 0;
        while (i < kind->count && strcmp(kind->keys[i].name, key) != 0) i++;
        if (i == kind->count && (!extra || strcmp(extra, key) != 0)) return refuse_unknown_key(node, key, kind);
    }
    for (size_t i = 0; i < kind->count; i++)
        if (kind->keys[i].required && !scene_has(node, kind->keys[i].name)) {
            scene_node member = scene_member(node, kind->keys[i].name);
            return scene_refuse(&member, "this key");
        }
    return true;
}

bool scene_check_array(const scene_node *node, const char *what)
{
    return json_is_array(node->value) || scene_refuse(node, "a list of %s", what);
}

/* Within these magnitudes a step stays far from the ends of double precision, and no hand or object is outside them. A
 * positive number is at least `least`. Numbers of other units have none but their sign, and times are judged together,
 * by the number of steps. */
static const struct {
    const char *unit;
    double least, most;
} magnitudes[] = {
    {"", 0, 1e15},
    {"m", 1e-9, 1e6},
    {"kg", 1e-12, 1e9},
    {"N", 1e-12, 1e12},
    {"N m", 1e-12, 1e12},
    {"N/m", 1e-6, 1e15},
    {"N m/rad", 1e-12, 1e15},
    {"N s/m", 0, 1e15},
    {"Pa", 1e-3, 1e18},
    {"N m s/rad", 0, 1e15},
    {"m/s^2", 0, 1e9},
    {"rad", 0, 1e6},
    {"Hz", 0, 1e9},
    {"N m/rad or N/m", 0, 1e15},
    {"N m s/rad or N s/m", 0, 1e15},
    {"N m or N", 1e-12, 1e12},
};

static bool read_number(const scene_node *node, scene_range range, const char *unit, double *out)
{
    static const char *const limits[] = {"", " > 0", " >= 0"};
    double value = json_number_value(node->value), least = 0, most = INFINITY;
    bool right_sign = range == SCENE_ANY_NUMBER || (range == SCENE_POSITIVE ? value > 0.0 : value >= 0.0);
    if (!json_is_number(node->value) || !isfinite(value) || !right_sign)
        return *unit ? scene_refuse(node, "a number%s (%s)", limits[range], unit)
                     : scene_refuse(node, "a number%s", limits[range]);
    for (size_t i = 0; i < sizeof magnitudes / sizeof *magnitudes; i++) {
        if (strcmp(unit, magnitudes[i].unit) != 0) continue;
        least = range == SCENE_POSITIVE ? magnitudes[i].least : 0;
        most = magnitudes[i].most;
    }
    if (fabs(value) > most || fabs(value) < least)
        return scene_refuse(node, "a number from %g to %g%s%s%s", range == SCENE_ANY_NUMBER ? -most : least, most,
                            *unit ? " (" : "", unit, *unit ? ")" : "");
    *out = value;
    return true;
}

bool scene_read_number(const scene_node *parent, const char *key, scene_range range, const char *unit, double *out)
{
    scene_node node = scene_member(parent, key);
    return !node.value || read_number(&node, range, unit, out);
}

bool scene_read_integer(const scene_node *parent, const char *key, int minimum, int maximum, int *out)
{
    scene_node node = scene_member(parent, key);
    if (!node.value) return true;
    double value = json_number_value(node.value);
    if (!json_is_number(node.value) || !(value >= minimum && value <= maximum) || value != floor(value))
        return scene_refuse(&node, "a whole number from %d to %d", minimum, maximum);
    *out = (int)value;
    return true;
}

bool scene_read_boolean(const scene_node *parent, const char *key, bool *out)
{
    scene_node node = scene_member(parent, key);
    if (!node.value) return true;
    if (!json_is_boolean(node.value)) return scene_refuse(&node, "true or false");
    *out = json_is_true(node.value);
    return true;
}

char *scene_copy_text(const char *text)
{
    size_t size = strlen(text) + 1;
    char *copy = malloc(size);
    return copy ? memcpy(copy, text, size) : NULL;
}

bool scene_read_string(const scene_node *parent, const char *key, bool may_be_empty, char **out)
{
    scene_node node = scene_member(parent, key);
    if (!node.value) return true;
    const char *text = json_string_value(node.value);
    if (!text || (!*text && !may_be_empty)) return scene_refuse(&node, may_be_empty ? "a text" : "a text, not empty");
    char *copy = scene_copy_text(text);
    if (!copy) return scene_refuse_memory(parent->reader);
    free(*out);
    *out = copy;
    return true;
}

bool scene_read_numbers(const scene_node *node, size_t count, scene_range range, const char *unit, double *out)
{
    if (!json_is_array(node->value) || json_array_size(node->value) != count) {
        return *unit ? scene_refuse(node, "a list of %zu numbers (%s)", count, unit)
                     : scene_refuse(node, "a list of %zu numbers", count);
    }
    for (size_t i = 0; i < count; i++) {
        scene_node element = scene_element(node, i);
        if (!read_number(&element, range, unit, out + i)) return false;
    }
    return true;
}

/* A component that is this much smaller than the vector is rounding of whoever wrote the file. */
static const double PLANE_ROUNDING = 1e-9;

static bool fit_to_plane(const scene_node *node, scene_vector_kind kind, double v[3])
{
    if (node->reader->dimension != 2 || kind == SCENE_FREE) return true;
    double limit = PLANE_ROUNDING * scene_norm(v);
    for (int i = 0; i < 3; i++) {
        bool off_plane = kind == SCENE_POLAR ? i == 2 : i < 2;
        if (!off_plane) continue;
        if (fabs(v[i]) > limit) {
            return kind == SCENE_POLAR
                       ? scene_refuse_plainly(node, "a vector in the plane (dimension 2: z = 0), got z = %g", v[2])
                       : scene_refuse_plainly(node, "a vector about z (dimension 2: x = y = 0), got x = %g, y = %g",
                                              v[0], v[1]);
        }
        v[i] = 0.0;
    }
    return true;
}

bool scene_read_vector(const scene_node *parent, const char *key, scene_vector_kind kind, const char *unit,
                       double out[3])
{
    scene_node node = scene_member(parent, key);
    return !node.value || (scene_read_numbers(&node, 3, SCENE_ANY_NUMBER, unit, out) && fit_to_plane(&node, kind, out));
}

void scene_normalise(double *v, int count)
{
    double square = 0.0, largest = 0.0;
    for (int i = 0; i < count; i++) {
        square += v[i] * v[i];
        largest = fmax(largest, fabs(v[i]));
    }
    if (fabs(square - 1.0) <= 8.0 * DBL_EPSILON) return;
    double length = 0.0;
    for (int i = 0; i < count; i++) {
        v[i] /= largest;
        length += v[i] * v[i];
    }
    length = sqrt(length);
    for (int i = 0; i < count; i++) v[i] /= length;
}

bool scene_read_unit_vector(const scene_node *parent, const char *key, scene_vector_kind kind, double out[3])
{
    if (!scene_read_vector(parent, key, kind, "", out)) return false;
    scene_node node = scene_member(parent, key);
    if (node.value && !(scene_norm(out) > 0.0)) return scene_refuse_plainly(&node, "a vector that is not zero");
    if (node.value) scene_normalise(out, 3);
    return true;
}

bool scene_read_quaternion(const scene_node *parent, const char *key, double out[4])
{
    scene_node node = scene_member(parent, key);
    if (!node.value) return true;
    if (!scene_read_numbers(&node, 4, SCENE_ANY_NUMBER, "", out)) return false;
    if (out[0] == 0.0 && out[1] == 0.0 && out[2] == 0.0 && out[3] == 0.0)
        return scene_refuse_plainly(&node, "a quaternion (w, x, y, z) that is not zero");
    scene_normalise(out, 4);
    return true;
}

bool scene_read_name(const scene_node *parent, const char *key, const char *const *names, int count, int *out)
{
    scene_node node = scene_member(parent, key);
    if (!node.value) return true;
    const char *name = json_string_value(node.value);
    for (int i = 0; name && i < count; i++)
        if (strcmp(names[i], name) == 0) {
            *out = i;
            return true;
        }
    char list[256];
    list_names(names, (size_t)count, list, sizeof list);
    return scene_refuse(&node, "%s", list);
}
