#ifndef PINCH_TEST_CLI_H
#define PINCH_TEST_CLI_H

#include "support/program.h"

#include <jansson.h>
#include <stdbool.h>

/* The real command on shipped scenes, and its documents. */

#define SCENE(name) PINCH_SOURCE_DIR "/assets/scenes/" name

/* Runs the command with up to eleven arguments, NULL ends them. `folder`: where, NULL for here. */
program_result cli_run(const char *folder, const char *const arguments[]);
#define PINCH(folder, ...) cli_run(folder, (const char *const[]){__VA_ARGS__, NULL})

/* The whole of standard output is one JSON document; the caller's to release. */
json_t *cli_document(const program_result *r);
/* Asserts the exit status, nothing on standard output, and a message that contains `says`. */
void cli_refused(program_result r, int status, const char *says);

/* keys with dots between; NULL: there is no such thing */
const json_t *cli_at(const json_t *document, const char *path);
/* so many numbers */
bool cli_is_vector(const json_t *value, size_t length);

#endif
