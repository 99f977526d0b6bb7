#ifndef PINCH_OPTIONS_H
#define PINCH_OPTIONS_H

#include "scenes/scene.h"
#include "scenes/world/world.h"

#include <stdbool.h>
#include <stdint.h>

/* The options of the command line; each means the same in every command. To add one: an id in `option_id` and a field
 * in `options` here, and a row in the table of options.c. Commands that take it list the id. */

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
    OPTION_RECORD,
    OPTION_RECORD_ALL,
    OPTION_AT,
    OPTION_PACKAGE,
    OPTION_TIME,
    OPTION_AT_END,
    OPTION_NO_RESERVES,
    OPTION_DIRECTIONS,
    OPTION_FAIL_ON,
    OPTION_GLTF,
    OPTION_VIEW,
    OPTION_FPS,
    OPTION_OUT,
    OPTION_TRIAL,
    OPTION_LIMIT,
    OPTION_BESIDE,
    OPTION_REFINE,
    OPTION_STUDY_RESUME, /* --resume of a study, which takes no value */
    OPTION_EXEC_SOLVER,  /* --solver of exec, which has none for the linearized cone */
    OPTION_CHECKPOINT,
    OPTION_EVERY,
    OPTION_RESUME,
    OPTION_COUNT
} option_id;

/* --contacts: whose contact points ODE's own solvers get. */
typedef enum option_contacts {
    OPTION_CONTACTS_ODE = 0, /* default: those of its collider */
    OPTION_CONTACTS_PINCH    /* those of Pinch's persistent manifolds */
} option_contacts;

/* --quickstep-iterations: a list of counts. */
enum { OPTION_MOST_COUNTS = 8 };
typedef struct option_counts {
    int count, values[OPTION_MOST_COUNTS]; /* >= 1, none twice */
} option_counts;

enum { OPTIONS_MOST_THREADS = 64 };

typedef struct command command;

typedef struct options {
    const command *command;
    bool given[OPTION_COUNT]; /* Was the option on the command line? The fields of options that were not are zero or
                                 NULL, unless a default is named. */
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
    const char *gltf;
    const char *view;
    int fps; /* 1 to 1000; default 60 */
    const char *out;
    int trial; /* >= 0 */
    int limit; /* >= 1 */
    const char *beside;
    int refine; /* >= 1 */
    bool study_resume;
    const char *checkpoint;
    int every; /* >= 1 */
    const char *resume;
    int jobs;
    double time; /* s, >= 0 */
    bool at_end;
    bool no_reserves;
    bool directions;
    unsigned fail_on; /* bit i for the simulation_event_type i */
    const char
        *text[OPTION_COUNT]; /* the text of each value on the command line, NULL for flags; it points into argv */
    int min_size, max_size;  /* >= 1 */
    int threads;             /* 1 to OPTIONS_MOST_THREADS */
    double budget;           /* s, > 0 */
    const char *record;      /* a folder */
    bool record_all;
    const char *at;      /* JOINT=POSITION,... */
    const char *package; /* NAME=DIRECTORY,... */
    int argument_count;
    char **arguments; /* arguments that are not options; they are moved to the front of argv */
} options;

typedef enum options_outcome {
    OPTIONS_RUN = 0, /* *o is complete: run the command */
    OPTIONS_HELP,    /* --help */
    OPTIONS_VERSION, /* --version */
    OPTIONS_WRONG    /* the reason is on standard error */
} options_outcome;

/* argv is what follows the command's name. Options are "--name value" or "--name=value"; "--" ends them. */
options_outcome options_parse(const command *c, int argc, char **argv, options *o);

bool options_takes(const command *c, option_id id);
/* The command's option of a configuration's key, which is the option's name with '_' for '-'. OPTION_COUNT where the
 * command has none. */
option_id options_find(const command *c, const char *key);
/* The first option given that is not in the list, which ends with OPTION_COUNT. OPTION_COUNT where all are in it. */
option_id options_beyond(const options *o, const option_id *list);
const char *options_name(option_id id);
/* The option's row in the table (option_values.h), for manuals. */
const struct option_row *options_row(option_id id);
/* The list for messages, such as " --json --quiet --help --version", cut to size. */
void options_list(const option_id *list, char *text, size_t size);
bool options_is_number(option_id id);
/* Is the value the name of a file that is written? */
bool options_is_output(option_id id);
/* Does the option name a file that is read? */
bool options_is_input(option_id id);
/* Sets the option's field. Returns false where `text` is no value of it, and writes to `expected` what is. `text` must
 * outlive the options. */
bool options_store(options *o, option_id id, const char *text, char *expected, size_t size);

/* Prints a word, in quotes where a shell would read it as something else. What a terminal would obey stands as \xNN in
 * $'...', which shells read back. */
void options_print_word(const char *word, FILE *stream);
/* Prints the command line as a shell reads it, with other arguments and without the option `left_out`. */
void options_print(const options *o, option_id left_out, const char *const *arguments, int count, FILE *stream);

/* Prints the options of a command for its --help, a line each. */
void options_describe(const command *c, FILE *stream);

#endif
