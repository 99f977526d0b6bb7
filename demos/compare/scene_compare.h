#ifndef PINCH_COMPARE_SCENE_COMPARE_H
#define PINCH_COMPARE_SCENE_COMPARE_H

#include "sample.h"
#include "solver_run.h"

#include "common/command_status.h"
#include "common/jobs.h"

#include <jansson.h>

enum { COMPARE_MOST_COUNTS = 8, COMPARE_MOST_SAMPLES = 256, COMPARE_MOST_RUNS = 2 + COMPARE_MOST_COUNTS };

/* What `pinch compare` compares, from its options. */
typedef struct compare_settings {
    int count_count, counts[COMPARE_MOST_COUNTS]; /* quickstep's numbers of iterations; there is a run for each */
    bool quickstep, worldstep;                    /* which of ODE's solvers run beside Pinch */
    bool manifolds;   /* ODE's solvers get the points of Pinch's manifolds, not their collider's */
    int points;       /* the most points of a pair in Pinch's manifolds, 1 to 8 */
    bool cold_start;  /* Pinch without its warm start */
    bool films;       /* does the document get films of Pinch's run, the first of quickstep's and worldstep's? */
    int samples;      /* number of steps that are compared with the exact answer, at most COMPARE_MOST_SAMPLES */
    job_share *share; /* where the steps that are done are counted */
} compare_settings;

/* Compares one scene. ODE must have been initialized. Returns COMMAND_FAILED where Pinch's answers were not verified or
 * differ from the exact ones; messages go to standard error. *document is NULL only where there is no result. */
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

/* document.c: the comparison as an entry of the JSON document's "scenes", which assets/schema/pinch-compare-1.json
 * describes, and with settings.films the list "films" of what page_film gives, and "thumb", Pinch's run as a small SVG
 * element. NULL when memory runs out. */
json_t *scene_comparison_document(const scene_comparison *c);

#endif
