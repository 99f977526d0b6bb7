/* The trials as a table with a column for each input and each recorded value. */
#define _POSIX_C_SOURCE 200809L

#include "results.h"

#include <stdlib.h>
#include <string.h>

/* SQL with all names quoted. A path in SQLite's JSON cannot name a key with a quotation mark, which is looked for among
 * all. */
typedef struct view_text {
    FILE *stream;
    const char *source; /* inputs or recorded */
} view_text;

static void put_quoted(const char *text, char quote, FILE *stream)
{
    fputc(quote, stream);
    for (; *text; text++) {
        if (*text == quote) fputc(quote, stream);
        fputc(*text, stream);
    }
    fputc(quote, stream);
}

static bool put_column(void *context, const json_t *names, json_t *row)
{
    (void)names;
    const view_text *v = context;
    const char *key = json_string_value(json_array_get(row, 0));
    char path[1100];
    if (!key) return true;
    bool has_path = !strchr(key, '"') && snprintf(path, sizeof path, "$.\"%s\"", key) < (int)sizeof path;
    if (has_path) {
        fprintf(v->stream, ", json_extract(%s, ", v->source);
        put_quoted(path, '\'', v->stream);
        fputs(") AS ", v->stream);
    } else {
        fprintf(v->stream, ", (SELECT value FROM json_each(%s) WHERE key = ", v->source);
        put_quoted(key, '\'', v->stream);
        fputs(") AS ", v->stream);
    }
    put_quoted(key, '"', v->stream);
    return true;
}

bool results_make_view(results *r, results_error *error)
{
    char *text = NULL;
    size_t length;
    view_text v = {open_memstream(&text, &length), "inputs"};
    if (!v.stream) {
        *error = (results_error){.status = COMMAND_SYSTEM, .text = "out of memory"};
        return false;
    }
    fputs("CREATE TEMP VIEW results AS SELECT \"index\" AS trial, status, success, "
          "exit,"
          " wall_time, hash",
          v.stream);
    bool good = results_query(r, "DROP VIEW IF EXISTS temp.results", put_column, &v, error) &&
                results_query(r, "SELECT DISTINCT key FROM trials, json_each(inputs)", put_column, &v, error);
    v.source = "recorded";
    good = good &&
           results_query(r, "SELECT DISTINCT key FROM trials, json_each(recorded) ORDER BY key", put_column, &v, error);
    fputs(" FROM trials", v.stream);
    good = fclose(v.stream) == 0 && good && results_query(r, text, put_column, &v, error);
    free(text);
    return good;
}
