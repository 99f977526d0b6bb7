#include "output.h"

#include "utf8.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

json_t *json_number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

json_t *json_text(const char *text)
{
    char *copy = text ? utf8_copy(text) : NULL;
    json_t *made = copy ? json_string(copy) : NULL;
    free(copy);
    return made;
}

json_t *json_numbers(const double *values, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        if (json_array_append_new(list, json_number(values[i]))) {
            json_decref(list);
            return NULL;
        }
    return list;
}

void json_number_text(double value, char text[32])
{
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, 32, "%.*g", digits, value);
        if (strtod(text, NULL) == value) return;
    }
}

/* As jansson writes it, but without an allocation: a document whose printing has begun is printed to its end. It may be
 * printed on a terminal, which would obey control characters; in UTF-8 those from U+0080 on are two bytes, the first of
 * them 0xc2. */
static void print_text(const char *text, size_t length, FILE *stream)
{
    static const char letters[] = "\"\\\b\f\n\r\t", escapes[] = "\"\\bfnrt";
    fputc('"', stream);
    for (size_t i = 0; i < length; i++) {
        unsigned char c = (unsigned char)text[i];
        const char *letter = c ? strchr(letters, c) : NULL;
        if (letter)
            fprintf(stream, "\\%c", escapes[letter - letters]);
        else if (c < 0x20 || c == 0x7f)
            fprintf(stream, "\\u%04X", c);
        else if (c == 0xc2 && i + 1 < length && (unsigned char)text[i + 1] < 0xa0)
            fprintf(stream, "\\u%04X", (unsigned char)text[++i]);
        else
            fputc(c, stream);
    }
    fputc('"', stream);
}

/* Empty lists and objects are scalars here. */
static void print_scalar(const json_t *value, FILE *stream)
{
    char text[32];
    switch (json_typeof(value)) {
    case JSON_STRING:
        print_text(json_string_value(value), json_string_length(value), stream);
        break;
    case JSON_INTEGER:
        fprintf(stream, "%" JSON_INTEGER_FORMAT, json_integer_value(value));
        break;
    case JSON_REAL:
        json_number_text(json_real_value(value), text);
        fputs(text, stream);
        break;
    case JSON_TRUE:
        fputs("true", stream);
        break;
    case JSON_FALSE:
        fputs("false", stream);
        break;
    case JSON_NULL:
        fputs("null", stream);
        break;
    case JSON_ARRAY:
        fputs("[]", stream);
        break;
    case JSON_OBJECT:
        fputs("{}", stream);
        break;
    }
}

static bool is_container(const json_t *value)
{
    return (json_is_array(value) && json_array_size(value)) || (json_is_object(value) && json_object_size(value));
}

static bool has_container(const json_t *list)
{
    for (size_t i = 0; i < json_array_size(list); i++)
        if (is_container(json_array_get(list, i))) return true;
    return false;
}

static void break_line(int indent, FILE *stream)
{
    fprintf(stream, "\n%*s", 2 * indent, "");
}

static void print_value(json_t *value, int indent, FILE *stream)
{
    if (!is_container(value)) {
        print_scalar(value, stream);
    } else if (json_is_array(value)) {
        bool lines = has_container(value);
        fputc('[', stream);
        for (size_t i = 0; i < json_array_size(value); i++) {
            if (i) fputs(lines ? "," : ", ", stream);
            if (lines) break_line(indent + 1, stream);
            print_value(json_array_get(value, i), indent + 1, stream);
        }
        if (lines) break_line(indent, stream);
        fputc(']', stream);
    } else {
        const char *separator = "{";
        const char *key;
        json_t *member;
        json_object_foreach(value, key, member)
        {
            fputs(separator, stream);
            separator = ",";
            break_line(indent + 1, stream);
            print_text(key, strlen(key), stream);
            fputs(": ", stream);
            print_value(member, indent + 1, stream);
        }
        break_line(indent, stream);
        fputc('}', stream);
    }
}

void json_print(json_t *document, FILE *stream)
{
    print_value(document, 0, stream);
    fputc('\n', stream);
}

bool json_print_new(json_t *document, FILE *stream)
{
    if (!document) return false;
    json_print(document, stream);
    json_decref(document);
    return true;
}

void json_append_text(void *list, const char *text)
{
    (void)json_array_append_new(list, json_string(text));
}

void csv_text(const char *text, const char *suffix, FILE *stream)
{
    if (!strpbrk(text, ",\"\r\n")) {
        fprintf(stream, "%s%s", text, suffix);
        return;
    }
    fputc('"', stream);
    for (; *text; text++) {
        if (*text == '"') fputc('"', stream);
        fputc(*text, stream);
    }
    fprintf(stream, "%s\"", suffix);
}

void csv_numbers(FILE *stream, const double *values, int count)
{
    for (int i = 0; i < count; i++) {
        char text[32];
        json_number_text(values[i], text);
        fprintf(stream, ",%s", text);
    }
}

const char *number_for_people(const char *format, double value, char text[48])
{
    if (isfinite(value))
        snprintf(text, 48, format, value);
    else
        snprintf(text, 48, "%*s", atoi(format + 1), isnan(value) ? "-" : value > 0 ? "unlimited" : "-unlimited");
    return text;
}
