#include "outputs.h"

#include "csv.h"
#include "whole_file.h"

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

command_status outputs_check_first(const options *o, json_t **baseline)
{
    (void)o;
    *baseline = NULL;
    return COMMAND_DONE;
}

command_status outputs_write(const options *o, const json_t *document, bool complete)
{
    (void)complete;
    return o->csv ? write_file(o->csv, document, write_csv) : COMMAND_DONE;
}
