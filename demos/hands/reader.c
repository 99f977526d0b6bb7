/* The hand under construction, its lists and texts, and the first error. */

#include "reader.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

bool reader_no_memory(hand_reader *r)
{
    if (r->status != HAND_OK) return false;
    r->status = HAND_NO_MEMORY;
    snprintf(r->error->text, sizeof r->error->text, "%s: out of memory", r->h->file ? r->h->file : "hand");
    return false;
}

/* A list has room for the next power of two of its count. */
void *reader_append(hand_reader *r, void *items, size_t *count, size_t size)
{
    char *list;
    if (r->status != HAND_OK) return NULL;
    memcpy(&list, items, sizeof list);
    if ((*count & (*count - 1)) == 0) {
        char *moved = realloc(list, (*count ? 2 * *count : 1) * size);
        if (!moved) {
            reader_no_memory(r);
            return NULL;
        }
        list = moved;
        memcpy(items, &list, sizeof list);
    }
    return memset(list + (*count)++ * size, 0, size);
}

char *reader_text(hand_reader *r, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(NULL, 0, format, arguments);
    va_end(arguments);
    char **place = reader_append(r, &r->h->texts, &r->h->text_count, sizeof *place);
    if (!place) return NULL;
    *place = length < 0 ? NULL : malloc((size_t)length + 1);
    if (!*place) {
        reader_no_memory(r);
        return NULL;
    }
    va_start(arguments, format);
    vsnprintf(*place, (size_t)length + 1, format, arguments);
    va_end(arguments);
    return *place;
}

/* What an error prints stays on one line, whatever is in the file. */
static void make_plain(char *text)
{
    for (; *text; text++)
        if ((unsigned char)*text < 0x20 || *text == 0x7f) *text = ' ';
}

/* Refuses with what is wrong, after the place of length `used` that the error begins with. */
static bool refuse_there(hand_reader *r, int used, const char *format, va_list arguments)
{
    char *text = r->error->text;
    size_t at = used > 0 ? (size_t)used : 0;
    r->status = HAND_BAD_INPUT;
    vsnprintf(text + at, sizeof r->error->text - at, format, arguments);
    make_plain(text);
    return false;
}

bool reader_refuse(hand_reader *r, const xmlNode *at, const char *format, ...)
{
    if (r->status != HAND_OK) return false;
    char *text = r->error->text;
    size_t size = sizeof r->error->text;
    int n;
    if (at) {
        const char *name = xml_text(at, "name");
        n = snprintf(text, size, "%.300s:%ld: <%.60s%s%.100s%s>: ", xml_file(at), xmlGetLineNo(at),
                     (const char *)at->name, name ? " name=\"" : "", name ? name : "", name ? "\"" : "");
    } else {
        n = snprintf(text, size, "%.300s: ", r->h->file);
    }
    va_list arguments;
    va_start(arguments, format);
    (void)refuse_there(r, n, format, arguments);
    va_end(arguments);
    return false;
}

bool reader_refuse_line(hand_reader *r, int line, const char *format, ...)
{
    if (r->status != HAND_OK) return false;
    int n = snprintf(r->error->text, sizeof r->error->text, "%.300s:%d: ", r->h->file, line);
    va_list arguments;
    va_start(arguments, format);
    (void)refuse_there(r, n, format, arguments);
    va_end(arguments);
    return false;
}

bool reader_refuse_link(hand_reader *r, const hand_link *link, const char *what)
{
    if (r->status != HAND_OK) return false;
    r->status = HAND_BAD_INPUT;
    snprintf(r->error->text, sizeof r->error->text, "%.300s:%d: <%s name=\"%.100s\">: %s", link->file, link->line,
             r->h->is_mjcf ? "body" : "link", link->name, what);
    make_plain(r->error->text);
    return false;
}

bool reader_forgive(hand_reader *r, const xmlNode *at, const char *what)
{
    if (r->status != HAND_BAD_INPUT) return false;
    r->status = HAND_OK;
    /* The remark has a line of its own, so that of the error's text only what is wrong is taken. */
    const char *fault = strstr(r->error->text, ">: ");
    const char *text = reader_text(r, "%s: %s", what, fault ? fault + 3 : r->error->text);
    r->error->text[0] = '\0';
    if (text) reader_ignore(r, at, text);
    return true;
}

char *reader_name(hand_reader *r, const xmlNode *node, const char *kind, size_t index)
{
    const char *given = xml_text(node, "name");
    char *name = given && *given ? reader_text(r, "%s", given) : reader_text(r, "%s_%zu", kind, index);
    if (!name) return NULL;
    if (reader_find(r, kind, name) >= 0) {
        reader_refuse(r, node, "expected a name of its own, but another %s is called \"%.100s\", too", kind, name);
        return NULL;
    }
    if (xmlHashAddEntry2(r->names, (const xmlChar *)name, (const xmlChar *)kind, (void *)(index + 1)) != 0) {
        reader_no_memory(r);
        return NULL;
    }
    return name;
}

int reader_find(hand_reader *r, const char *kind, const char *name)
{
    return (int)(size_t)xmlHashLookup2(r->names, (const xmlChar *)name, (const xmlChar *)kind) - 1;
}

static void remark(hand_reader *r, hand_remark **list, size_t *count, int line, const char *what)
{
    for (size_t i = 0; i < *count; i++)
        if (strcmp((*list)[i].what, what) == 0) {
            (*list)[i].count++;
            return;
        }
    char *text = reader_text(r, "%s", what);
    if (!text) return;
    make_plain(text);
    hand_remark *item = reader_append(r, list, count, sizeof *item);
    if (item) *item = (hand_remark){.what = text, .count = 1, .line = line};
}

void reader_ignore(hand_reader *r, const xmlNode *at, const char *what)
{
    remark(r, &r->h->ignored, &r->h->ignored_count, (int)xmlGetLineNo(at), what);
}

void reader_unmodelled(hand_reader *r, const xmlNode *at, const char *what)
{
    remark(r, &r->h->unmodelled, &r->h->unmodelled_count, (int)xmlGetLineNo(at), what);
}

void reader_unmodelled_link(hand_reader *r, const hand_link *link, const char *what)
{
    remark(r, &r->h->unmodelled, &r->h->unmodelled_count, link->line, what);
}

char *reader_path(hand_reader *r, const char *from, const char *name)
{
    const char *end = strrchr(from, '/');
    if (name[0] == '/' || !end) return reader_text(r, "%s", name);
    return reader_text(r, "%.*s/%s", (int)(end - from), from, name);
}
