#ifndef PINCH_COMMAND_H
#define PINCH_COMMAND_H

#include "options.h"

#include "common/command_status.h"

/*
 * A subcommand of `pinch`. To add one: a file that defines `const command command_NAME`, its declaration at the end of
 * this header, and one line in main.c's table. Options it needs that nobody had before: see options.h.
 */

struct command {
    const char *name;
    const char *arguments;    /* as the usage line shows them, e.g. "SCENE..." */
    const char *summary;      /* one line for --help */
    const char *notes;        /* more of it for --help; NULL for none */
    int min_arguments;        /* what is not an option, counted */
    int max_arguments;        /* INT_MAX: any number */
    bool takes_program;       /* the first argument ends the options: the rest is another program's command line */
    const option_id *options; /* which options it takes, OPTION_COUNT at the end; --help and --version always */
    /* Standard output is flushed and checked by the caller. */
    command_status (*run)(const options *o);
};

/*
 * Loads the scene and lets the options given on the command line override what it says (solver, formulation, tolerance,
 * iterations, faces, step, duration). On failure the reason is on standard error, *s is NULL, and the status is the
 * command's to return.
 */
command_status command_load_scene(const options *o, const char *file, scene **s);

/*
 * COMMAND_BAD_INPUT, after a message on standard error that lists the pairs that exist, when `solver` does not do
 * `formulation` in this use; COMMAND_DONE otherwise.
 */
typedef enum command_use {
    COMMAND_STATIC = 0, /* solve, lcp, bench paper */
    COMMAND_RUN         /* run, compare */
} command_use;
bool command_pair_exists(command_use use, pinch_solver solver, scene_formulation formulation);
command_status command_check_pair(const char *name, command_use use, pinch_solver solver,
                                  scene_formulation formulation);

/* The same for a scene in a run; Lemke's method and PGS have no place for force control, whose base is an unknown. */
command_status command_check_run(const char *name, const scene *s);

#endif
