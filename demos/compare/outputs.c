#define _POSIX_C_SOURCE 200809L

#include "outputs.h"

#include "access.h"
#include "baseline.h"
#include "common/json_output.h"
#include "common/whole_file.h"
#include "compare/report/report.h"
#include "csv.h"

#include <stdlib.h>

static command_status write_file(const char *path, const json_t *document,
                                 void (*write)(const json_t *document, FILE *stream))
{
    whole_file file;
    if (whole_file_open(&file, path)) {
        write(document, file.stream);
        if (whole_file_close(&file, true)) return COMMAND_DONE;
    }
    command_error("compare", "%s: cannot be written", path);
    return COMMAND_SYSTEM;
}

static void write_csv(const json_t *document, FILE *stream)
{
    csv_write(json_object_get(document, "scenes"), stream);
}

static void write_json(const json_t *document, FILE *stream)
{
    json_print((json_t *)document, stream);
}

static command_status save(const options *o, const json_t *document)
{
    char *made = NULL;
    size_t size;
    FILE *text = open_memstream(&made, &size);
    if (!text) return COMMAND_SYSTEM;
    options_print(o, OPTION_COUNT, (const char *const *)o->arguments, o->argument_count, text);
    json_t *baseline = fclose(text) == 0 ? baseline_document(document, made) : NULL;
    command_status status = baseline ? write_file(o->save, baseline, write_json) : COMMAND_SYSTEM;
    json_decref(baseline);
    free(made);
    return status;
}

command_status outputs_write(const options *o, const json_t *document, bool complete)
{
    command_status worst = COMMAND_DONE, status = o->csv ? write_file(o->csv, document, write_csv) : COMMAND_DONE;
    if (status > worst) worst = status;
    status = o->report ? write_file(o->report, document, report_write) : COMMAND_DONE;
    if (status > worst) worst = status;
    if (o->save && !complete)
        command_error("compare", "%s: not written: a baseline needs all scenes, verified", o->save);
    status = o->save && complete ? save(o, document) : COMMAND_DONE;
    return status > worst ? status : worst;
}

static void put_value(const json_t *move, const char *key, char text[48])
{
    double value = access_number(move, key);
    const char *unit = access_text(move, "unit");
    if (isnan(value))
        snprintf(text, 48, "nothing");
    else if (!*unit)
        snprintf(text, 48, "%s", value != 0 ? "yes" : "no");
    else
        snprintf(text, 48, "%.6g%s%s", value, strcmp(unit, "1") == 0 ? "" : " ", strcmp(unit, "1") == 0 ? "" : unit);
}

static void say(const json_t *move)
{
    char from[48], to[48], by[48] = "", limit[48];
    put_value(move, "from", from);
    put_value(move, "to", to);
    bool number = *access_text(move, "unit") && !isnan(access_number(move, "by"));
    if (number) put_value(move, "by", by);
    put_value(move, "limit", limit);
    command_error("compare", "%s, %s: %s moved from %s to %s%s%s%s%s", access_text(move, "scene"),
                  access_text(move, "run"), access_text(move, "metric"), from, to, number ? ", by " : "", by,
                  number ? "; the limit is " : "", number ? limit : "");
}

command_status outputs_check(const options *o, const json_t *baseline, json_t *document)
{
    if (!baseline) return COMMAND_DONE;
    json_t *moves = baseline_check(baseline, document);
    size_t count = json_array_size(moves);
    for (size_t i = 0; i < count; i++) say(json_array_get(moves, i));
    json_t *check = json_pack("{s:s, s:b, s:o}", "baseline", o->check, "passed", count == 0, "moved", moves);
    if (!check || json_object_set_new(document, "check", check)) return COMMAND_SYSTEM;
    return count == 0 ? COMMAND_DONE : COMMAND_FAILED;
}
