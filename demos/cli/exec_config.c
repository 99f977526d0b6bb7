/* The configuration file of pinch exec. */
#include "exec_config.h"

#include "command.h"
#include "common/input_file.h"

#include <string.h>

static command_status refuse_key(const char *file, const char *key, const char *expected)
{
    command_error("exec", "%s: $.%s: expected %s", file, key, expected);
    return COMMAND_BAD_INPUT;
}

/* Reads one key of the configuration. The command line goes before it. */
static command_status read_key(const char *file, const char *key, const json_t *value, options *o)
{
    option_id id = options_find(o->command, key);
    if (id == OPTION_COUNT || id == OPTION_CONFIG || id == OPTION_RECORD_ALL)
        return refuse_key(file, key, "a known key (only, kt_ratio, solver, tolerance, max_iterations, stats, record)");
    char number[64], expected[160];
    const char *text = ""; /* no option takes an empty text */
    if (json_is_number(value) && options_is_number(id)) {
        snprintf(number, sizeof number, "%.17g", json_number_value(value));
        text = number;
    } else if (json_is_string(value) && !options_is_number(id)) {
        text = json_string_value(value);
    }
    options read = *o;
    if (!options_store(&read, id, text, expected, sizeof expected)) return refuse_key(file, key, expected);
    read.given[id] = true;
    if (!o->given[id]) *o = read;
    return COMMAND_DONE;
}

command_status exec_config_read(options *o, json_t **document)
{
    json_error_t error;
    char fault[128];
    FILE *stream = input_open_regular(o->config, fault);
    if (!stream) {
        command_error("exec", "%s: cannot be read: %s", o->config, *fault ? fault : "out of memory");
        return *fault ? COMMAND_BAD_INPUT : COMMAND_SYSTEM;
    }
    *document = input_load_json(stream, &error);
    fclose(stream);
    if (!*document) {
        command_error("exec", "%s:%d: expected JSON: %s", o->config, error.line, input_json_fault(&error));
        return COMMAND_BAD_INPUT;
    }
    if (!json_is_object(*document)) {
        command_error("exec", "%s: $: expected an object", o->config);
        return COMMAND_BAD_INPUT;
    }
    const char *key;
    json_t *value;
    command_status status = COMMAND_DONE;
    json_object_foreach(*document, key, value)
    {
        if (status == COMMAND_DONE) status = read_key(o->config, key, value, o);
    }
    return status;
}
