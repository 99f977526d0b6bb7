#ifndef PINCH_OPTIONS_H
#define PINCH_OPTIONS_H

#include "scenes/scene.h"
#include "scenes/world/world.h"

#include <stdbool.h>
#include <stdint.h>

/*
 * The command line's options, with one meaning for all commands. To add one: an id here, a field in `options`, one line
 * in the table of options.c; then commands list the id among theirs.
 */

typedef enum option_id {
    OPTION_SOLVER = 0,
    OPTION_FORMULATION,
    OPTION_TOLERANCE,
    OPTION_MAX_ITERATIONS,
    OPTION_FACES,
    OPTION_SEED,
    OPTION_DURATION,
    OPTION_STEP,
    OPTION_CONTACT_SOLVER,
    OPTION_NO_NEWTON,
    OPTION_FAITHFUL,
    OPTION_UNIT,
    OPTION_ONE_STEP,
    OPTION_INSCRIBED,
    OPTION_PRINT,
    OPTION_JSON,
    OPTION_CSV,
    OPTION_PLOT,
    OPTION_QUIET,
    OPTION_ONLY,
    OPTION_KT_RATIO,
    OPTION_CONFIG,
    OPTION_STATS,
    OPTION_QUICKSTEP_ITERATIONS,
    OPTION_CONTACTS,
    OPTION_POINTS,
    OPTION_COLD_START,
    OPTION_SAMPLES,
    OPTION_SAVE,
    OPTION_CHECK,
    OPTION_REPORT,
    OPTION_PICTURE,
    OPTION_JOBS,
    OPTION_MIN_SIZE,
    OPTION_MAX_SIZE,
    OPTION_THREADS,
    OPTION_BUDGET,
    OPTION_COUNT
} option_id;

/* Whose contact points ODE's own solvers get: --contacts. */
typedef enum option_contacts {
    OPTION_CONTACTS_ODE = 0, /* default: those of the collider */
    OPTION_CONTACTS_PINCH    /* those of Pinch's persistent manifolds */
} option_contacts;

/* A list of counts: --quickstep-iterations. */
enum { OPTION_MOST_COUNTS = 8 };
typedef struct option_counts {
    int count, values[OPTION_MOST_COUNTS]; /* >= 1, none twice */
} option_counts;

enum { OPTIONS_MOST_THREADS = 64 };

typedef struct command command;

typedef struct options {
    const command *command;
    bool given[OPTION_COUNT]; /* was it on the command line? Fields of options that were not are zero or NULL */
    pinch_solver solver;
    scene_formulation formulation;
    double tolerance;            /* > 0 */
    int max_iterations;          /* >= 1 */
    int faces;                   /* SCENE_MIN_FACES to SCENE_MAX_FACES */
    uint64_t seed;               /* default 1 */
    double duration;             /* s, >= 0 */
    double step;                 /* s, > 0 */
    world_solver contact_solver; /* default WORLD_PINCH */
    bool no_newton;
    bool faithful;
    bool unit;
    bool one_step;
    bool inscribed;
    bool print;
    bool json;
    const char *csv; /* file names point into argv */
    const char *plot;
    bool quiet;
    pinch_ode_scope only; /* which contacts of another program Pinch solves */
    double kt_ratio;      /* > 0, <= 10 */
    const char *config;
    const char *stats;
    option_counts quickstep_iterations;
    option_contacts contacts;
    int points;
    bool cold_start;
    int samples;
    const char *save;
    const char *check;
    const char *report;
    const char *picture;
    int jobs;
    const char *text[OPTION_COUNT]; /* of the values given on the command line, NULL for flags; they point into argv */
    int min_size, max_size;         /* >= 1 */
    int threads;                    /* 1 to OPTIONS_MOST_THREADS */
    double budget;                  /* s, > 0 */
    int argument_count;
    char **arguments; /* what is not an option; in argv, reordered */
} options;

typedef enum options_outcome {
    OPTIONS_RUN = 0, /* *o is complete: run the command */
    OPTIONS_HELP,    /* --help */
    OPTIONS_VERSION, /* --version */
    OPTIONS_WRONG    /* the reason is on standard error */
} options_outcome;

/* argv: what follows the command's name. "--name value" and "--name=value"; "--" ends the options. */
options_outcome options_parse(const command *c, int argc, char **argv, options *o);

/* The same from a configuration, whose keys are the options' names with '_' for '-'. OPTION_COUNT: there is none. */
option_id options_find(const char *key);
bool options_takes(const command *c, option_id id);
/* Of those given, the first that is not in the list, which ends with OPTION_COUNT; OPTION_COUNT: all are. */
option_id options_beyond(const options *o, const option_id *list);
const char *options_name(option_id id);
/* " --json --quiet --help --version": the list for messages, cut to size */
void options_list(const option_id *list, char *text, size_t size);
bool options_is_number(option_id id);
/* Sets the option's field; false where `text` is not what it should be, with that in `expected`. `text` must stay. */
bool options_store(options *o, option_id id, const char *text, char *expected, size_t size);

/* The command line again as a shell takes it, with other arguments, without the option `left_out`. */
void options_print(const options *o, option_id left_out, const char *const *arguments, int count, FILE *stream);

/* The options a command takes, a line each, for its --help. */
void options_describe(const command *c, FILE *stream);

#endif
