/* JSON pointers with wildcards. */
#include "study.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_PART = 256, MOST_PLACE = 1024 };

/* Reads the next part of the pointer, with ~1 for / and ~0 for ~. Returns what follows; NULL where it is too long. */
static const char *next_part(const char *pointer, char part[MOST_PART])
{
    size_t used = 0;
    pointer++; /* the slash */
    for (; *pointer && *pointer != '/'; pointer++) {
        char c = *pointer;
        if (c == '~' && (pointer[1] == '0' || pointer[1] == '1')) c = *++pointer == '1' ? '/' : '~';
        if (used + 1 >= MOST_PART) return NULL;
        part[used++] = c;
    }
    part[used] = '\0';
    return pointer;
}

/* An array's index is digits alone, without zeros before them. */
static bool index_of(const char *part, size_t *index)
{
    if (!*part || strlen(part) > 9 || part[strspn(part, "0123456789")]) return false;
    if (part[0] == '0' && part[1]) return false;
    *index = (size_t)strtoul(part, NULL, 10);
    return true;
}

static json_t *child(const json_t *value, const char *part)
{
    size_t index;
    if (json_is_array(value)) return index_of(part, &index) ? json_array_get(value, index) : NULL;
    return json_object_get(value, part);
}

json_t *pointer_get(const json_t *document, const char *place)
{
    char part[MOST_PART];
    json_t *value = (json_t *)document;
    while (place && *place && value) {
        place = next_part(place, part);
        value = place ? child(value, part) : NULL;
    }
    return place ? value : NULL;
}

static bool put(json_t *parent, const char *part, json_t *value)
{
    size_t index;
    if (json_is_object(parent)) return json_object_set_new(parent, part, value) == 0;
    if (index_of(part, &index) && index < json_array_size(parent)) return json_array_set_new(parent, index, value) == 0;
    json_decref(value);
    return false;
}

static bool is_list_of_numbers(const json_t *value)
{
    for (size_t i = 0; i < json_array_size(value); i++)
        if (!json_is_number(json_array_get(value, i))) return false;
    return json_is_array(value);
}

/* What stands for a member that is left out, so that a part of it can be set: a vector is the default one, and an
 * object is empty, which leaves its other members to their defaults. A list of other things would come to be given as a
 * whole, with what its defaults depend on. NULL: nothing does. */
static json_t *stand_in(const json_t *full)
{
    if (full && json_is_array(full)) return is_list_of_numbers(full) ? json_deep_copy(full) : NULL;
    return json_object();
}

bool pointer_set(json_t *document, const char *place, json_t *value, const json_t *full)
{
    char part[MOST_PART];
    json_t *parent = document;
    for (;;) {
        place = *place == '/' ? next_part(place, part) : NULL;
        if (!place) {
            json_decref(value);
            return false;
        }
        if (!*place) return put(parent, part, value);
        json_t *next = child(parent, part);
        full = child(full, part);
        if (!next && json_is_object(parent)) {
            json_object_set_new(parent, part, stand_in(full));
            next = json_object_get(parent, part);
        }
        parent = next;
    }
}

bool pointer_is_within(const char *place, const char *other)
{
    size_t length = strlen(other);
    return strncmp(place, other, length) == 0 && (place[length] == '/' || place[length] == '\0');
}

/* ---- Wildcards. ---- */

typedef struct expansion {
    char **places;
    long count;
    bool failed;
} expansion;

static void add_place(expansion *e, const char *place)
{
    char **more = realloc(e->places, (size_t)(e->count + 1) * sizeof *more);
    char *copy = malloc(strlen(place) + 1);
    if (more) e->places = more;
    if (!more || !copy) {
        free(copy);
        e->failed = true;
        return;
    }
    e->places[e->count++] = strcpy(copy, place);
}

/* Appends a part to the place, escaped. Returns the length before; more than MOST_PLACE where there is no room. */
static size_t append(char place[MOST_PLACE], const char *part)
{
    size_t before = strlen(place), at = before;
    if (at + 1 < MOST_PLACE) place[at++] = '/';
    for (; *part && at + 2 < MOST_PLACE; part++) {
        if (*part == '~' || *part == '/') {
            place[at++] = '~';
            place[at++] = *part == '/' ? '1' : '0';
        } else {
            place[at++] = *part;
        }
    }
    place[at] = '\0';
    return *part ? MOST_PLACE + 1 : before;
}

static void walk(expansion *e, const json_t *value, const char *rest, char place[MOST_PLACE]);

static void enter(expansion *e, const json_t *value, const char *part, const char *rest, char place[MOST_PLACE])
{
    size_t before = append(place, part);
    if (before < MOST_PLACE && value) walk(e, value, rest, place);
    place[before < MOST_PLACE ? before : 0] = '\0';
}

static void walk(expansion *e, const json_t *value, const char *rest, char place[MOST_PLACE])
{
    char part[MOST_PART];
    if (!*rest) {
        add_place(e, place);
        return;
    }
    rest = *rest == '/' ? next_part(rest, part) : NULL;
    if (!rest || e->failed) return;
    if (strcmp(part, "*") != 0) {
        enter(e, child(value, part), part, rest, place);
        return;
    }
    const char *key;
    json_t *member;
    json_object_foreach((json_t *)value, key, member)
    {
        enter(e, member, key, rest, place);
    }
    for (size_t i = 0; i < json_array_size(value); i++) {
        char index[24];
        snprintf(index, sizeof index, "%zu", i);
        enter(e, json_array_get(value, i), index, rest, place);
    }
}

long pointer_expand(const json_t *document, const char *path, char ***places)
{
    expansion e = {.places = NULL};
    char place[MOST_PLACE] = "";
    walk(&e, document, path, place);
    *places = e.places;
    if (!e.failed) return e.count;
    for (long i = 0; i < e.count; i++) free(e.places[i]);
    free(e.places);
    *places = NULL;
    return -1;
}
