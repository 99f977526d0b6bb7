#ifndef PINCH_TEST_EXEC_H
#define PINCH_TEST_EXEC_H

#include "support/program.h"

#include <jansson.h>

/* Runs the programs of tests/programs, plainly and under `pinch exec`. Lists of words end with NULL. */

/* Path of a program of tests/programs; a static place, good for a few calls. */
char *exec_program(const char *name);

/* pinch exec, with these words after it */
program_result exec_pinch(char *const *words);
#define EXEC(...) exec_pinch((char *[]){__VA_ARGS__, NULL})

/* What a program prints, and what `pinch exec --stats` says of it. */
typedef struct exec_run {
    program_result result;
    json_t *line;  /* the program's line of JSON; NULL where it printed none */
    json_t *stats; /* NULL without Pinch */
} exec_run;

/* `options` of pinch exec; NULL: the program runs without Pinch. Fails the test where the statistics are no JSON. */
exec_run exec_program_run(char *const *options, char *const *command);
void exec_run_free(exec_run *run);

/* A member, which must be there and a number. */
double exec_number(const json_t *document, const char *key);

#endif
