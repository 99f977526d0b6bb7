#define _XOPEN_SOURCE 700

#include "command.h"

#include "common/terminal.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static void override(const options *o, scene *s)
{
    if (o->given[OPTION_SOLVER]) s->solver.name = o->solver;
    if (o->given[OPTION_FORMULATION]) s->solver.formulation = o->formulation;
    if (o->given[OPTION_TOLERANCE]) s->solver.tolerance = o->tolerance;
    if (o->given[OPTION_MAX_ITERATIONS]) s->solver.max_iterations = o->max_iterations;
    if (o->given[OPTION_FACES]) s->solver.pyramid_faces = o->faces;
    if (o->given[OPTION_STEP]) s->step = o->step;
    if (o->given[OPTION_DURATION]) s->duration = o->duration;
}

command_status command_load_scene(const options *o, const char *file, scene **s)
{
    scene_error error;
    switch (scene_load(file, s, &error)) {
    case SCENE_OK:
        override(o, *s);
        if (command_check_scene_files(o, *s) == COMMAND_DONE) return COMMAND_DONE;
        scene_free(*s);
        *s = NULL;
        return COMMAND_BAD_INPUT;
    case SCENE_NO_MEMORY:
        terminal_text(error.text, stderr);
        fputc('\n', stderr);
        return COMMAND_SYSTEM;
    default:
        terminal_text(error.text, stderr);
        fputc('\n', stderr);
        return COMMAND_BAD_INPUT;
    }
}

command_status command_check_statics(const char *name, const scene *s)
{
    char text[SCENE_SOLVER_TEXT];
    if (scene_check_pair(SCENE_FOR_STATICS, &s->solver, text)) return COMMAND_DONE;
    command_error(name, "%s: %s", s->file, text);
    return COMMAND_BAD_INPUT;
}

command_status command_check_run(const char *name, const scene *s)
{
    char text[SCENE_SOLVER_TEXT];
    if (!scene_check_solver(s, text)) {
        command_error(name, "%s: %s", s->file, text);
        return COMMAND_BAD_INPUT;
    }
    /* The scene's own values were checked when it was read, but options may have replaced them. */
    if (scene_steps_fit(s->duration, s->step)) return COMMAND_DONE;
    command_error(name, "%s: a duration of %g s is %g steps of %g s; expected at least half a step and at most %g",
                  s->file, s->duration, s->duration / s->step, s->step, SCENE_MOST_STEPS);
    return COMMAND_BAD_INPUT;
}

static bool same_file(const char *one, const char *other)
{
    struct stat a, b;
    return stat(one, &a) == 0 && stat(other, &b) == 0 && S_ISREG(a.st_mode) && a.st_dev == b.st_dev &&
           a.st_ino == b.st_ino;
}

/* Refuses an output that is a file which is read. */
static command_status check_input(const options *o, int output, const char *input)
{
    if (!same_file(o->text[output], input)) return COMMAND_DONE;
    command_error(o->command->name, "--%s: %s is the file that is read; expected another name",
                  options_name((option_id)output), o->text[output]);
    return COMMAND_BAD_INPUT;
}

/* A checkpoint may take the place of the one that the run goes on from, and a baseline that of the one it was compared
 * with: both have been read then, and the new file is of the same kind. */
static bool may_replace(int output, int input)
{
    return (output == OPTION_CHECKPOINT && input == OPTION_RESUME) || (output == OPTION_SAVE && input == OPTION_CHECK);
}

static command_status check_against_inputs(const options *o, int output)
{
    command_status status = COMMAND_DONE;
    for (int k = 0; k < o->argument_count && status == COMMAND_DONE; k++)
        status = check_input(o, output, o->arguments[k]);
    for (int k = 0; k < OPTION_COUNT && status == COMMAND_DONE; k++)
        if (o->given[k] && options_is_input((option_id)k) && !may_replace(output, k))
            status = check_input(o, output, o->text[k]);
    return status;
}

/* Two outputs that do not exist yet are one file where their names are equal. */
static bool outputs_clash(const options *o, int i, int k)
{
    bool both = o->given[k] && options_is_output((option_id)k);
    return both && (same_file(o->text[i], o->text[k]) ||
                    (strcmp(o->text[i], o->text[k]) == 0 && access(o->text[i], F_OK) != 0));
}

command_status command_check_outputs(const options *o)
{
    for (int i = 0; i < OPTION_COUNT; i++) {
        if (!o->given[i] || !options_is_output((option_id)i)) continue;
        if (check_against_inputs(o, i) != COMMAND_DONE) return COMMAND_BAD_INPUT;
        for (int k = 0; k < i; k++)
            if (outputs_clash(o, i, k)) {
                command_error(o->command->name, "--%s and --%s: both name %s; expected two files",
                              options_name((option_id)k), options_name((option_id)i), o->text[i]);
                return COMMAND_BAD_INPUT;
            }
    }
    return COMMAND_DONE;
}

/* Stops at the first file that one of the outputs would replace. */
static bool is_apart(void *context, const char *path)
{
    const options *o = context;
    for (int i = 0; i < OPTION_COUNT; i++)
        if (o->given[i] && options_is_output((option_id)i) && check_input(o, i, path) != COMMAND_DONE) return false;
    return true;
}

command_status command_check_scene_files(const options *o, const scene *s)
{
    return scene_each_file(s, is_apart, (void *)o) ? COMMAND_DONE : COMMAND_BAD_INPUT;
}

command_status command_check_file(const options *o, const char *path)
{
    return is_apart((void *)o, path) ? COMMAND_DONE : COMMAND_BAD_INPUT;
}

command_status command_status_of(int error)
{
    bool system = error == ENOMEM || error == ENOSPC || error == EDQUOT || error == EFBIG || error == EIO;
    return system ? COMMAND_SYSTEM : COMMAND_BAD_INPUT;
}

command_status command_make_folder(const char *name, const char *folder, char *path, size_t size)
{
    struct stat status;
    int error = mkdir(folder, 0777) == 0 || errno == EEXIST ? 0 : errno;
    if (!error && stat(folder, &status) == 0 && !S_ISDIR(status.st_mode)) error = ENOTDIR;
    if (!error && access(folder, W_OK | X_OK) != 0) error = errno;
    char *real = error ? NULL : realpath(folder, NULL);
    if (!error && !real) error = errno;
    if (!error && strlen(real) >= size) error = ENAMETOOLONG;
    if (!error) strcpy(path, real);
    free(real);
    if (!error) return COMMAND_DONE;
    command_error(name, "--record: expected a folder that can be written, got %s: %s", folder, strerror(error));
    return command_status_of(error);
}
