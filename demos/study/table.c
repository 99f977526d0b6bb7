/* A CSV file of numbers with a header. */
#define _POSIX_C_SOURCE 200809L

#include "study.h"

#include "common/input_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void study_table_free(study_table *t)
{
    for (size_t i = 0; i < t->column_count; i++) free(t->names[i]);
    free(t->names);
    free(t->cells);
    free(t->file);
    free(t->text);
    memset(t, 0, sizeof *t);
}

static scene_status refuse(scene_error *error, const char *file, size_t line, const char *what)
{
    snprintf(error->text, sizeof error->text, "%.4096s:%zu: %s", file, line, what);
    for (char *c = error->text; *c; c++)
        if ((unsigned char)*c < ' ' || *c == 127) *c = '?';
    return SCENE_BAD_INPUT;
}

static scene_status out_of_memory(scene_error *error, const char *file)
{
    snprintf(error->text, sizeof error->text, "%.4096s: out of memory", file);
    return SCENE_NO_MEMORY;
}

static scene_status read_text(const char *path, study_table *t, scene_error *error)
{
    char fault[128];
    FILE *stream = input_open_regular(path, fault);
    if (!stream && !*fault) return out_of_memory(error, path);
    if (!stream) {
        snprintf(error->text, sizeof error->text, "%.4096s: expected a readable table: %s", path, fault);
        return SCENE_BAD_INPUT;
    }
    size_t length = 0, got = 0;
    ssize_t all = getdelim(&t->text, &length, '\0', stream);
    got = all > 0 ? (size_t)all : 0;
    bool failed = ferror(stream) != 0;
    fclose(stream);
    if (failed) return refuse(error, path, 1, "the table cannot be read");
    if (got == 0 || strlen(t->text) != got) return refuse(error, path, 1, "expected a table: text with a header line");
    static const char BYTE_ORDER_MARK[] = "\xEF\xBB\xBF"; /* spreadsheets begin a CSV file in UTF-8 with it */
    size_t mark = sizeof BYTE_ORDER_MARK - 1;
    if (strncmp(t->text, BYTE_ORDER_MARK, mark) == 0) memmove(t->text, t->text + mark, got - mark + 1);
    return SCENE_OK;
}

/* Copies the next field of the line to `field`, without blanks around it and without the quotes of RFC 4180. Returns
 * what follows its comma; NULL where it was the last one. *whole becomes false where its quotes do not end with it. */
static const char *next_field(const char *line, char *field, bool *whole)
{
    char *out = field;
    while (*line == ' ' || *line == '\t') line++;
    if (*line == '"') {
        for (line++; *line && !(*line == '"' && line[1] != '"'); line++) {
            if (*line == '"') line++;
            *out++ = *line;
        }
        if (*line)
            line++;
        else
            *whole = false;
        line += strspn(line, " \t");
        if (*line && *line != ',') *whole = false;
        while (*line && *line != ',') line++;
    } else {
        while (*line && *line != ',') *out++ = *line++;
        while (out > field && (out[-1] == ' ' || out[-1] == '\t')) out--;
    }
    *out = '\0';
    return *line == ',' ? line + 1 : NULL;
}

static size_t count_fields(const char *line, char *field, bool *whole)
{
    size_t count = 0;
    *whole = true;
    while (line) {
        line = next_field(line, field, whole);
        count++;
    }
    return count;
}

static const char BROKEN_QUOTES[] = "expected quotation marks that begin and end a field";

static scene_status read_names(study_table *t, const char *line, char *field, scene_error *error)
{
    bool whole;
    t->names = calloc(count_fields(line, field, &whole), sizeof *t->names);
    if (!whole) return refuse(error, t->file, 1, BROKEN_QUOTES);
    while (t->names && line) {
        line = next_field(line, field, &whole);
        t->names[t->column_count] = strdup(field);
        if (!t->names[t->column_count++]) return out_of_memory(error, t->file);
    }
    return t->names ? SCENE_OK : out_of_memory(error, t->file);
}

/* A name that stands twice could be either column. */
static scene_status check_names(const study_table *t, scene_error *error)
{
    char what[512];
    for (size_t i = 1; i < t->column_count; i++)
        for (size_t k = 0; k < i; k++)
            if (strcmp(t->names[k], t->names[i]) == 0) {
                snprintf(what, sizeof what, "expected each column once, got \"%.100s\" as columns %zu and %zu",
                         t->names[i], k + 1, i + 1);
                return refuse(error, t->file, 1, what);
            }
    return SCENE_OK;
}

static scene_status read_header(study_table *t, const char *line, char *field, scene_error *error)
{
    scene_status status = read_names(t, line, field, error);
    return status == SCENE_OK ? check_names(t, error) : status;
}

/* Decimal numbers alone: strtod reads hexadecimal ones, too. */
static bool read_decimal(const char *field, double *value)
{
    char *end;
    *value = strtod(field, &end);
    return *field && !*end && isfinite(*value) && !field[strspn(field, "+-.0123456789eE")];
}

static scene_status read_row(study_table *t, const char *line, size_t number, char *field, scene_error *error)
{
    char what[512];
    bool whole;
    size_t count = count_fields(line, field, &whole);
    if (!whole) return refuse(error, t->file, number, BROKEN_QUOTES);
    if (count != t->column_count) {
        snprintf(what, sizeof what, "expected %zu fields, as the header has, got %zu", t->column_count, count);
        return refuse(error, t->file, number, what);
    }
    double *more = realloc(t->cells, (t->row_count + 1) * t->column_count * sizeof *more);
    if (!more) return out_of_memory(error, t->file);
    t->cells = more;
    for (size_t i = 0; i < count; i++) {
        double value;
        line = next_field(line, field, &whole);
        if (!read_decimal(field, &value)) {
            snprintf(what, sizeof what, "column %.100s: expected a number, got \"%.100s\"", t->names[i], field);
            return refuse(error, t->file, number, what);
        }
        t->cells[t->row_count * t->column_count + i] = value;
    }
    t->row_count++;
    return SCENE_OK;
}

static scene_status read_lines(study_table *t, char *text, char *field, scene_error *error)
{
    scene_status status = SCENE_OK;
    size_t number = 0;
    char *rest;
    for (char *line = text; line && status == SCENE_OK; line = rest) {
        rest = strchr(line, '\n');
        if (rest) *rest++ = '\0';
        size_t length = strlen(line);
        if (length > 0 && line[length - 1] == '\r') line[length - 1] = '\0';
        number++;
        if (!line[strspn(line, " \t")] && (number > 1 || !rest)) continue;
        if (number > 1)
            status = read_row(t, line, number, field, error);
        else
            status = read_header(t, line, field, error);
    }
    if (status == SCENE_OK && t->row_count == 0) status = refuse(error, t->file, number, "expected at least one row");
    return status;
}

scene_status study_table_read(const char *path, study_table *t, scene_error *error)
{
    memset(t, 0, sizeof *t);
    t->file = strdup(path);
    if (!t->file) return out_of_memory(error, path);
    scene_status status = read_text(path, t, error);
    if (status == SCENE_OK) {
        char *copy = strdup(t->text), *field = malloc(strlen(t->text) + 1);
        status = copy && field ? read_lines(t, copy, field, error) : out_of_memory(error, path);
        free(copy);
        free(field);
    }
    if (status != SCENE_OK) study_table_free(t);
    return status;
}
