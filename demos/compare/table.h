#ifndef PINCH_COMPARE_TABLE_H
#define PINCH_COMPARE_TABLE_H

#include <jansson.h>
#include <stdio.h>

/* What a person reads on a terminal, from the JSON document's entries. */

/* One scene: fingers, then the runs. */
void table_scene(const json_t *scene, FILE *stream);
/* All scenes by all runs: force errors, and what was dropped. */
void table_summary(const json_t *scenes, FILE *stream);

#endif
