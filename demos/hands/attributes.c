/* Attributes as texts, numbers and references; what is wrong with them. */

#include "reader.h"

#include <stdlib.h>

const char *reader_required(hand_reader *r, const xmlNode *node, const char *name)
{
    const char *text = xml_text(node, name);
    if (text && *text) return text;
    reader_refuse(r, node, "expected an attribute %s", name);
    return NULL;
}

int reader_refer(hand_reader *r, const xmlNode *node, const char *attribute, const char *kind)
{
    const char *name = r->status == HAND_OK ? reader_required(r, node, attribute) : NULL;
    if (!name) return -1;
    int index = reader_find(r, kind, name);
    if (index < 0) reader_refuse(r, node, "expected the name of a %s in %s, not \"%.100s\"", kind, attribute, name);
    return index;
}

/* strtod also reads hexadecimal numbers, inf and nan, none of which is meant here. */
static const char *read_number(const char *text, double *value)
{
    char *end;
    *value = strtod(text, &end);
    bool plain = end > text && strspn(text, "0123456789+-.eE") >= (size_t)(end - text);
    return plain && isfinite(*value) && (!*end || strchr(" \t\r\n", *end)) ? end : NULL;
}

size_t reader_numbers(hand_reader *r, const xmlNode *node, const char *name, double *values, size_t least, size_t most)
{
    const char *text = r->status == HAND_OK ? xml_text(node, name) : NULL;
    size_t count = 0;
    if (!text) return 0;
    const char *at = text + strspn(text, " \t\r\n");
    while (*at && count < most) {
        at = read_number(at, &values[count]);
        if (!at) break;
        count++;
        at += strspn(at, " \t\r\n");
    }
    if (at && !*at && count >= least) return count;
    if (least == most)
        reader_refuse(r, node, "expected %zu number%s in %s, not \"%.100s\"", most, most == 1 ? "" : "s", name, text);
    else
        reader_refuse(r, node, "expected %zu to %zu numbers in %s, not \"%.100s\"", least, most, name, text);
    return 0;
}

bool reader_number(hand_reader *r, const xmlNode *node, const char *name, double *value)
{
    double number;
    if (reader_numbers(r, node, name, &number, 1, 1) != 1) return false;
    *value = number;
    return true;
}

bool reader_only(hand_reader *r, const xmlNode *node, const char *list)
{
    for (const xmlAttr *a = node->properties; a && r->status == HAND_OK; a = a->next)
        if (!xml_listed(list, (const char *)a->name))
            return reader_refuse(r, node, "unknown attribute %.60s; there are %s", (const char *)a->name, list);
    return r->status == HAND_OK;
}
