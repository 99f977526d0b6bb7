#ifndef PINCH_TEST_COMMAND_H
#define PINCH_TEST_COMMAND_H

#include "support/program.h"

#include <jansson.h>
#include <stdbool.h>

/* Runs the real pinch command and reads its documents. All functions assert that they work. */

#define SCENE(name)         PINCH_SOURCE_DIR "/assets/scenes/" name
#define COMPARE_SCENE(name) SCENE(name)
#define COMPARE_GOLDEN      PINCH_SOURCE_DIR "/assets/reference/compare.json"

/* Runs the command with these words, which end with NULL. `folder` is where it runs; NULL means here. */
program_result command_run(const char *folder, const char *const words[]);
#define PINCH(folder, ...)   command_run(folder, (const char *const[]){__VA_ARGS__, NULL})
#define COMPARE(folder, ...) PINCH(folder, "compare", __VA_ARGS__)
#define EXEC(...)            PINCH(NULL, "exec", __VA_ARGS__)

/* The whole of standard output is one JSON document; the caller releases it. */
json_t *cli_document(const program_result *r);
/* Asserts the exit status, nothing on standard output, and a message that contains `says`. */
void cli_refused(program_result r, int status, const char *says);
/* The member at the end of a path of keys with dots between them; NULL where there is none. */
const json_t *cli_at(const json_t *document, const char *path);
/* The value is an array of `length` numbers. */
bool cli_is_vector(const json_t *value, size_t length);

/* The document of a run that must have ended with `status`; frees the result. */
json_t *compare_document(program_result r, int status);
/* The run of this name in a scene's comparison, and one of its metrics, which is NaN where it is null. */
const json_t *compare_find(const json_t *of_scene, const char *run);
double compare_metric(const json_t *run, const char *key);

/* The path of a program of tests/programs, in a static place that is good for a few calls. */
char *exec_program(const char *name);

/* What a program prints, and what `pinch exec --stats` says of it. */
typedef struct exec_run {
    program_result result;
    json_t *line;  /* the program's line of JSON; NULL where it printed none */
    json_t *stats; /* NULL without Pinch */
} exec_run;

/* Runs a program under `pinch exec` with `options`, or without Pinch where they are NULL. Both lists end with NULL. The
 * statistics must be a JSON document. */
exec_run exec_program_run(char *const *options, char *const *command);
void exec_run_free(exec_run *run);
/* A member, which must be there and a number. */
double exec_number(const json_t *document, const char *key);

#endif
