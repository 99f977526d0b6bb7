/* pinch validate: checks scenes and says how they were read. */

#include "command.h"
#include "common/output.h"
#include "common/terminal.h"

#include <limits.h>

static bool is_moved(const double shift[3])
{
    return shift[0] != 0.0 || shift[1] != 0.0 || shift[2] != 0.0;
}

static void report_shift(const scene *s, const char *what, const char *name, const scene_shape *shape)
{
    const double *d = shape->shift;
    if (is_moved(d))
        terminal_print(stderr, "%s: %s%s: vertices moved by (%g, %g, %g) m: the centre of mass is the origin\n",
                       s->file, what, name, -d[0], -d[1], -d[2]);
}

static void report_shifts(const scene *s)
{
    report_shift(s, "object", "", &s->objects[0].shape);
    for (size_t i = 0; i < s->finger_count; i++) report_shift(s, "tip of ", s->fingers[i].name, &s->fingers[i].tip);
    for (size_t i = 0; i < s->environment_count; i++)
        report_shift(s, "environment ", s->environment[i].name, &s->environment[i].shape);
}

static json_t *verdict(const scene *s)
{
    return json_pack("{s:o, s:b, s:s, s:o}", "scene", json_text(s->file), "valid", 1, "name", s->name, "shift",
                     json_numbers(s->objects[0].shape.shift, 3));
}

/* The verdict of one scene stands at the top level; several make a list. */
static command_status print_verdicts(json_t *verdicts)
{
    json_t *document = json_object();
    int failed = json_object_set_new(document, "command", json_string("validate"));
    if (json_array_size(verdicts) == 1)
        failed |= json_object_update(document, json_array_get(verdicts, 0));
    else
        failed |= json_object_set(document, "scenes", verdicts);
    if (!failed) json_print(document, stdout);
    json_decref(document);
    return failed ? COMMAND_SYSTEM : COMMAND_DONE;
}

static command_status validate_one(const options *o, const char *file, json_t *verdicts)
{
    scene *s;
    command_status status = command_load_scene(o, file, &s);
    if (status != COMMAND_DONE) return status;
    status = command_check_run("validate", s);
    if (status != COMMAND_DONE) {
        scene_free(s);
        return status;
    }
    if (!o->quiet) report_shifts(s);
    if (o->print) {
        if (scene_print(s, stdout) != SCENE_OK) status = COMMAND_SYSTEM;
    } else if (o->json) {
        if (json_array_append_new(verdicts, verdict(s))) status = COMMAND_SYSTEM;
    } else if (!o->quiet) {
        terminal_print(stdout, "%s: valid\n", file);
    }
    scene_free(s);
    return status;
}

static command_status run_validate(const options *o)
{
    if (o->print && o->json) {
        command_error("validate", "--print and --json both want standard output: choose one");
        return COMMAND_BAD_INPUT;
    }
    json_t *verdicts = json_array();
    command_status worst = COMMAND_DONE;
    for (int i = 0; i < o->argument_count; i++) {
        command_status status = validate_one(o, o->arguments[i], verdicts);
        if (status > worst) worst = status;
    }
    if (o->json && worst == COMMAND_DONE) worst = print_verdicts(verdicts);
    json_decref(verdicts);
    if (worst == COMMAND_SYSTEM) command_error("validate", "out of memory");
    return worst;
}

static const option_id validate_options[] = {OPTION_PRINT, OPTION_JSON, OPTION_QUIET, OPTION_COUNT};

const command command_validate = {
    .name = "validate",
    .arguments = "SCENE...",
    .summary = "checks scene files; --print shows a scene with every default filled in",
    .notes = COMMAND_SCENE_NOTE,
    .min_arguments = 1,
    .max_arguments = INT_MAX,
    .files = "json",
    .options = validate_options,
    .run = run_validate,
};
