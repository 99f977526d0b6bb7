/* Reading what varies, and the search for the least value. */
#include "study.h"

#include "scenes/file/reader.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const scene_key vary_keys[] = {
    {"path", true},     {"uniform", false},  {"log_uniform", false}, {"normal", false}, {"values", false},
    {"columns", false}, {"at_least", false}, {"at_most", false},     {"common", false},
};
static const scene_key least_keys[] = {{"path", true}, {"from", true}, {"to", true}, {"precision", false}};

#define KIND(keys)                                                                                                     \
    {                                                                                                                  \
        "", sizeof(keys) / sizeof((keys)[0]), keys                                                                     \
    }
static const scene_kind vary_kind = KIND(vary_keys), least_kind = KIND(least_keys);

/* ---- Distributions. ---- */

static bool read_pair(const scene_node *node, const char *key, study_variation *v)
{
    double pair[2];
    scene_node list = scene_member(node, key);
    if (!scene_read_numbers(&list, 2, SCENE_ANY_NUMBER, "", pair)) return false;
    v->low = pair[0];
    v->high = pair[1];
    if (v->type == STUDY_NORMAL)
        return v->high > 0.0 || scene_refuse_plainly(&list, "a mean and a standard deviation > 0");
    if (!(v->low < v->high)) return scene_refuse_plainly(&list, "two numbers, the first the smaller one");
    return v->type != STUDY_LOG_UNIFORM || v->low > 0.0 || scene_refuse_plainly(&list, "two numbers > 0");
}

/* A normal distribution whose bounds cut off all of it has no values. */
static bool read_bounds(const scene_node *node, study_variation *v)
{
    scene_node least = scene_member(node, "at_least"), most = scene_member(node, "at_most");
    const scene_node *given = least.value ? &least : most.value ? &most : NULL;
    if (given && v->type != STUDY_NORMAL)
        return scene_refuse_plainly(given, "no such key beside other distributions than normal");
    if (!scene_read_number(node, "at_least", SCENE_ANY_NUMBER, "", &v->at_least) ||
        !scene_read_number(node, "at_most", SCENE_ANY_NUMBER, "", &v->at_most))
        return false;
    double nearest = fmax(v->at_least - v->low, fmax(v->low - v->at_most, 0.0));
    if (given && (!(v->at_least < v->at_most) || nearest > 30.0 * v->high))
        return scene_refuse_plainly(given, "bounds with some of the distribution between them");
    return true;
}

static bool find_column(const scene_node *node, const study_table *table, size_t *column)
{
    for (size_t i = 0; i < table->column_count; i++)
        if (json_is_string(node->value) && strcmp(table->names[i], json_string_value(node->value)) == 0) {
            *column = i;
            return true;
        }
    return scene_refuse(node, "a column of %.200s", table->file ? table->file : "the key \"table\", which is missing");
}

static bool read_columns(const scene_node *node, const study_table *table, study_variation *v)
{
    scene_node list = scene_member(node, "columns");
    v->column_count = json_array_size(list.value);
    if (v->column_count == 0) return scene_refuse(&list, "a list of columns");
    v->columns = calloc(v->column_count, sizeof *v->columns);
    if (!v->columns) return scene_refuse_memory(node->reader);
    for (size_t i = 0; i < v->column_count; i++) {
        scene_node name = scene_element(&list, i);
        if (!find_column(&name, table, &v->columns[i])) return false;
    }
    return true;
}

static bool read_distribution(const scene_node *node, const study *s, study_variation *v)
{
    static const char *const keys[] = {"uniform", "log_uniform", "normal", "values", "columns"};
    int found = 0;
    for (int i = 0; i < 5; i++)
        if (scene_has(node, keys[i])) {
            v->type = (study_distribution)i;
            found++;
        }
    if (found != 1)
        return scene_refuse_plainly(node, "one of uniform, log_uniform, normal, values or columns, got %d", found);
    if (s->design == STUDY_GRID && v->type < STUDY_VALUES)
        return scene_refuse_plainly(node, "values or columns, for the design \"grid\", got %s", keys[v->type]);
    if (v->type < STUDY_VALUES && !read_pair(node, keys[v->type], v)) return false;
    if (!read_bounds(node, v)) return false;
    if (v->type == STUDY_COLUMNS) return read_columns(node, &s->table, v);
    if (v->type < STUDY_VALUES) return true;
    scene_node list = scene_member(node, "values");
    v->values = list.value;
    return json_array_size(list.value) > 0 || scene_refuse(&list, "a list of values, not empty");
}

/* ---- Places. ---- */

/* Can a value stand at the place, which the scene leaves to its default? */
static bool has_room(const study *s, const char *place)
{
    json_t *copy = json_deep_copy(s->scene);
    bool set = copy && pointer_set(copy, place, json_null(), s->full_scene);
    json_decref(copy);
    return set;
}

/* The places that a path names: of the scene's document, or, for keys that it leaves out, of the same scene with every
 * default filled in. */
static bool find_places(const scene_node *node, const study *s, char ***places, size_t *count)
{
    const char *path = json_string_value(node->value);
    if (!path || path[0] != '/') return scene_refuse(node, "a JSON pointer into the scene, as \"/object/mass\"");
    long found = pointer_expand(s->scene, path, places);
    bool left_out = found == 0;
    if (left_out) {
        free(*places);
        found = pointer_expand(s->full_scene, path, places);
    }
    *count = found > 0 ? (size_t)found : 0;
    if (found < 0) return scene_refuse_memory(node->reader);
    if (found == 0) {
        free(*places);
        *places = NULL;
        return scene_refuse(node, "a path that the scene has");
    }
    for (size_t i = 0; left_out && i < *count; i++)
        if (!has_room(s, (*places)[i]))
            return scene_refuse_plainly(
                node,
                "a path that the scene has; the list that %.200s lies in is left to its default, so write it out "
                "in the scene",
                (*places)[i]);
    return true;
}

/* Is all of what a variation draws set again by one that comes later and has the place `later`? A value that is an
 * object keeps its other members, and may be varied in parts; a number has none, and of a list a component that is
 * set again would be recorded without having had an effect. */
static bool is_overwritten(const study_variation *v, const char *place, const char *later)
{
    if (pointer_is_within(place, later)) return true;
    if (!pointer_is_within(later, place)) return false;
    for (size_t i = 0; i < json_array_size(v->values); i++)
        if (!json_is_object(json_array_get(v->values, i))) return true;
    return v->type != STUDY_VALUES;
}

/* What is set at a place must not be set again: it would be recorded as an input, and have had no effect. Looks through
 * the first `count` variations. */
static bool places_are_new(const scene_node *node, const study *s, size_t count, char **places, size_t place_count)
{
    for (const study_variation *other = s->variations; other < s->variations + count; other++)
        for (size_t i = 0; i < other->place_count; i++)
            for (size_t k = 0; k < place_count; k++) {
                if (!is_overwritten(other, other->places[i], places[k])) continue;
                if (strcmp(other->places[i], places[k]) == 0)
                    return scene_refuse_plainly(node, "a path that does not vary already, got %.200s twice", places[k]);
                return scene_refuse_plainly(node,
                                            "a path that sets nothing again, got %.200s, and %.200s varies already",
                                            places[k], other->places[i]);
            }
    return true;
}

/* ---- Variations. ---- */

static bool read_variation(const scene_node *node, study *s, study_variation *v)
{
    scene_node path = scene_member(node, "path");
    v->at_least = -INFINITY;
    v->at_most = INFINITY;
    if (!scene_check_kind(node, &vary_kind, NULL) || !scene_read_boolean(node, "common", &v->common) ||
        !find_places(&path, s, &v->places, &v->place_count) ||
        !places_are_new(&path, s, (size_t)(v - s->variations), v->places, v->place_count) ||
        !read_distribution(node, s, v))
        return false;
    v->path = json_string_value(path.value);
    v->first_draw = s->draw_count;
    s->draw_count += v->type == STUDY_COLUMNS ? 0 : v->common ? 1 : v->place_count;
    return true;
}

bool study_read_variations(const scene_node *root, study *s)
{
    scene_node list = scene_member(root, "vary");
    if (list.value && !scene_check_array(&list, "quantities that vary")) return false;
    size_t count = json_array_size(list.value);
    s->variations = calloc(count + 1, sizeof *s->variations);
    if (!s->variations) return scene_refuse_memory(root->reader);
    for (size_t i = 0; i < count; i++) {
        scene_node node = scene_element(&list, i);
        s->variation_count++;
        if (!read_variation(&node, s, &s->variations[i])) return false;
    }
    s->row_draw = s->draw_count;
    if (s->table.row_count > 0) s->draw_count++;
    if (s->design == STUDY_SOBOL && s->draw_count > STUDY_MOST_SOBOL)
        return scene_refuse_plainly(&list, "at most %d draws in a trial, for the design \"sobol\", got %zu",
                                    STUDY_MOST_SOBOL, s->draw_count);
    return true;
}

/* ---- The least value. ---- */

bool study_read_least(const scene_node *root, study *s)
{
    scene_node node = scene_member(root, "least"), path = scene_member(&node, "path"), to = scene_member(&node, "to");
    study_least *l = &s->least;
    l->precision = 1e-3;
    if (!node.value) return true;
    if (!scene_check_kind(&node, &least_kind, NULL) || !find_places(&path, s, &l->places, &l->place_count) ||
        !places_are_new(&path, s, s->variation_count, l->places, l->place_count) ||
        !scene_read_number(&node, "from", SCENE_NOT_NEGATIVE, "", &l->from) ||
        !scene_read_number(&node, "to", SCENE_POSITIVE, "", &l->to) ||
        !scene_read_number(&node, "precision", SCENE_POSITIVE, "", &l->precision))
        return false;
    l->path = json_string_value(path.value);
    return l->from < l->to || scene_refuse(&to, "more than from");
}
