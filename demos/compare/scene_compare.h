#ifndef PINCH_COMPARE_SCENE_COMPARE_H
#define PINCH_COMPARE_SCENE_COMPARE_H

#include "sample.h"
#include "solver_run.h"

#include "common/command_status.h"

#include <jansson.h>

enum { COMPARE_MOST_COUNTS = 8, COMPARE_MOST_SAMPLES = 256, COMPARE_MOST_RUNS = 2 + COMPARE_MOST_COUNTS };

/* What `pinch compare` compares, from its options. */
typedef struct compare_settings {
    int count_count, counts[COMPARE_MOST_COUNTS]; /* quickstep's numbers of iterations */
    bool quickstep, worldstep;                    /* which of ODE's solvers run beside Pinch */
    bool manifolds;                               /* they get the points of Pinch's manifolds, not their collider's */
    int points;                                   /* at most so many points of a pair in Pinch's manifolds, 1 to 8 */
    bool cold_start;                              /* Pinch without its warm start */
    int samples; /* steps that are compared with the exact answer, at most COMPARE_MOST_SAMPLES */
} compare_settings;

/*
 * Compares one scene; ODE must have been initialized. COMMAND_DONE or, where Pinch's answers were not verified or
 * differ from the exact ones, COMMAND_FAILED; messages go to standard error. *document is NULL only where there is no
 * result.
 */
command_status scene_compare(const scene *s, const compare_settings *settings, json_t **document);

/* The finished comparison of one scene. */
typedef struct scene_comparison {
    const scene *s;
    const compare_settings *settings;
    int run_count;
    solver_run *runs;
    int sample_count;
    sample *samples;
} scene_comparison;

/* document.c: as an entry of the JSON document's "scenes"; assets/schema/pinch-compare-1.json describes it. NULL: no
 * memory. */
json_t *scene_comparison_document(const scene_comparison *c);

#endif
