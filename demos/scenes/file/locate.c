/* A scanner over JSON text that knows the path of every value that it reaches. */

#include "locate.h"

#include <jansson.h>
#include <stdio.h>
#include <string.h>

/* No scene is deeper. Values below it are scanned, but have no path of their own. */
enum { SCENE_DEPTH = 32 };

typedef struct level {
    bool is_array;
    size_t index;    /* index of the array's current value */
    const char *key; /* raw, between the quotes; NULL before the first */
    size_t key_length;
} level;

typedef struct scanner {
    const char *text;
    size_t length;
    size_t at;
    int line;
    size_t depth;
    level levels[SCENE_DEPTH];
    bool expects_key;
} scanner;

static level *innermost(scanner *s)
{
    return s->depth > 0 && s->depth <= SCENE_DEPTH ? &s->levels[s->depth - 1] : NULL;
}

static void open_level(scanner *s, bool is_array)
{
    s->depth++;
    s->expects_key = !is_array;
    if (innermost(s)) *innermost(s) = (level){.is_array = is_array};
}

/* Goes from behind the opening quote to behind the closing one. */
static void skip_string(scanner *s)
{
    while (s->at < s->length && s->text[s->at] != '"') s->at += s->text[s->at] == '\\' ? 2 : 1;
    s->at = s->at < s->length ? s->at + 1 : s->length;
}

static void skip_scalar(scanner *s)
{
    size_t start = s->at;
    while (s->at < s->length && !strchr(" \t\r\n,:[]{}\"", s->text[s->at])) s->at++;
    if (s->at == start) s->at++;
}

static void read_key(scanner *s)
{
    const char *start = s->text + s->at + 1;
    s->at++;
    skip_string(s);
    if (innermost(s)) {
        innermost(s)->key = start;
        innermost(s)->key_length = (size_t)(s->text + s->at - start) - 1;
    }
    s->expects_key = false;
}

/* Goes to the next value and stops in front of it, or at `limit`. Returns false at the end of the text. */
static bool next_value(scanner *s, size_t limit)
{
    while (s->at < s->length && s->at < limit) {
        char c = s->text[s->at];
        if (c == '\n') s->line++;
        if (c == '}' || c == ']') {
            if (s->depth > 0) s->depth--;
            s->expects_key = false;
        } else if (c == ',') {
            level *inner = innermost(s);
            if (inner && inner->is_array) inner->index++;
            s->expects_key = inner && !inner->is_array;
        } else if (c == '"' && s->expects_key) {
            read_key(s);
            continue;
        } else if (!strchr(" \t\r\n:", c)) {
            return true;
        }
        s->at++;
    }
    return false;
}

static void enter_value(scanner *s)
{
    char c = s->text[s->at];
    if (c == '{' || c == '[') {
        open_level(s, c == '[');
        s->at++;
    } else if (c == '"') {
        s->at++;
        skip_string(s);
    } else {
        skip_scalar(s);
    }
}

static bool key_matches(const level *l, const char *key)
{
    if (!l->key) return false;
    if (!memchr(l->key, '\\', l->key_length))
        return strlen(key) == l->key_length && memcmp(l->key, key, l->key_length) == 0;
    json_t *decoded = json_loadb(l->key - 1, l->key_length + 2, JSON_DECODE_ANY, NULL);
    bool same = decoded && strcmp(json_string_value(decoded), key) == 0;
    json_decref(decoded);
    return same;
}

static bool stands_at(const scanner *s, const scene_step *path, size_t depth)
{
    if (s->depth != depth || depth > SCENE_DEPTH) return false;
    for (size_t i = 0; i < depth; i++) {
        const level *l = &s->levels[i];
        if (l->is_array != (path[i].key == NULL)) return false;
        if (l->is_array ? l->index != path[i].index : !key_matches(l, path[i].key)) return false;
    }
    return true;
}

int scene_locate_line(const char *text, size_t length, const scene_step *path, size_t depth)
{
    scanner s = {.text = text, .length = length, .line = 1};
    while (next_value(&s, length)) {
        if (stands_at(&s, path, depth)) return s.line;
        enter_value(&s);
    }
    return 1;
}

void scene_locate_path(const char *text, size_t length, size_t offset, char *path, size_t size)
{
    scanner s = {.text = text, .length = length, .line = 1};
    while (next_value(&s, offset)) enter_value(&s);
    size_t used = 0;
    path[0] = '\0';
    for (size_t i = 0; i < s.depth && i < SCENE_DEPTH && used < size; i++) {
        const level *l = &s.levels[i];
        int n = 0;
        if (l->is_array)
            n = snprintf(path + used, size - used, "[%zu]", l->index);
        else if (l->key)
            n = snprintf(path + used, size - used, "%s%.*s", i ? "." : "",
                         (int)(l->key_length < 60 ? l->key_length : 60), l->key);
        used += n > 0 ? (size_t)n : 0;
    }
}
