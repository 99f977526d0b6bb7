#ifndef PINCH_COMPARE_VERDICT_H
#define PINCH_COMPARE_VERDICT_H

#include <jansson.h>
#include <stdio.h>

/* Numbers in plain language. */

typedef enum verdict { VERDICT_EXACT = 0, VERDICT_CLOSE, VERDICT_OFF, VERDICT_DROPPED, VERDICT_UNKNOWN } verdict;

/* exact: forces to 1e-9; close: to 1 %; off: more; dropped; unknown: no step was looked at. */
verdict verdict_of(const json_t *run);
/* "exact", "close", ... */
const char *verdict_word(verdict v);

/* One sentence on a run of the scene, as HTML. */
void verdict_write(const json_t *of_scene, const json_t *run, FILE *stream);

#endif
