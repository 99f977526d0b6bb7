#ifndef PINCH_COMMAND_H
#define PINCH_COMMAND_H

#include "options.h"

#include "common/command_status.h"

/* A subcommand of `pinch`. To add one, write a file NAME.c that defines `const command command_NAME`, and add ROW(NAME)
 * to the table in command_table.c. How an option is added, options.h says. */
struct command {
    const char *name;
    const char *arguments; /* as the usage line shows them, for example "SCENE..." */
    const char *summary;   /* one line for --help */
    const char *notes;     /* more of it for --help; NULL for none */
    int min_arguments;     /* the fewest arguments that are not options */
    int max_arguments;     /* the most; INT_MAX: any number */
    bool takes_program; /* the first argument ends the options: what follows is the command line of another program */
    const char *files;  /* endings of the files that it takes as arguments, "urdf xml" for example; NULL: others */
    const char *(*argument_name)(int i); /* where an argument is one of several names: the i-th, NULL after the last */
    const option_id *options; /* those it takes, OPTION_COUNT at the end; all commands take --help and --version */
    /* Runs the command. The caller flushes and checks standard output. */
    command_status (*run)(const options *o);
};

/* All subcommands, in the order of the help; NULL is the last. */
extern const command *const command_table[];

/* What all commands say that load scenes. */
#define COMMAND_SCENE_NOTE                                                                                             \
    "A scene is a file, or - for standard input; names of files in it then start from the working directory."

/* Loads the scene. Options given on the command line override its solver, formulation, tolerance, iterations, faces,
 * step and duration. On failure the reason is on standard error, *s is NULL, and the command returns the status. */
command_status command_load_scene(const options *o, const char *file, scene **s);

/* Options that do nothing without another one are refused. On failure the reason is on standard error. */
command_status command_check_needs(const options *o);
/* Refuses the first option of a list, with OPTION_COUNT at its end, that was given; `why` says what was expected. */
command_status command_refuse_given(const options *o, const option_id *list, const char *why);

/* A file that is written must not be one that is read, nor be written twice. On failure the reason is on standard
 * error. */
command_status command_check_outputs(const options *o);
/* The same for one more file that is read, and for those that a scene refers to. */
command_status command_check_file(const options *o, const char *path);
command_status command_check_scene_files(const options *o, const scene *s);

/* pinch_run.c: runs a scene and shows or writes what the options ask for, as `pinch run` does. */
command_status command_run_scene(const options *o, const scene *s);

/* The status of a command that could not write, by errno: COMMAND_SYSTEM where memory or the disk has failed, otherwise
 * COMMAND_BAD_INPUT, as the place was given. */
command_status command_status_of(int error);

/* --record writes at most this many islands. */
enum { COMMAND_MOST_RECORDINGS = 100 };

/* Makes the folder of --record where it is not there, and writes its absolute name to `path`. On failure the reason is
 * on standard error. */
command_status command_make_folder(const char *name, const char *folder, char *path, size_t size);

/* Refuses a scene whose solver does not do its formulation in the statics. */
command_status command_check_statics(const char *name, const scene *s);
/* Refuses a scene that Pinch cannot run with its solver, and one whose steps, which options may have changed, do not
 * fit its duration. */
command_status command_check_run(const char *name, const scene *s);

#endif
