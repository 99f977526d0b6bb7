#ifndef PINCH_TEST_COMPARE_H
#define PINCH_TEST_COMPARE_H

#include "support/program.h"

#include <jansson.h>

/* `pinch compare`, for tests. All assert that they work. */

#define COMPARE_SCENE(name) PINCH_SOURCE_DIR "/assets/scenes/" name
#define COMPARE_GOLDEN      PINCH_SOURCE_DIR "/assets/reference/compare.json"

/* arguments end with NULL; `folder`: where it runs, NULL for here */
program_result compare_run(const char *folder, const char *const arguments[]);
#define COMPARE(folder, ...) compare_run(folder, (const char *const[]){__VA_ARGS__, NULL})

/* Standard output as the JSON document that it is; frees the result, which must have ended with `status`. */
json_t *compare_document(program_result r, int status);

/* The run of this name; its metric (NaN: null). */
const json_t *compare_find(const json_t *of_scene, const char *run);
double compare_metric(const json_t *run, const char *key);

/* Paths of all shipped scenes in the order of their names, NULL at the end. */
const char *const *compare_shipped(void);

#endif
