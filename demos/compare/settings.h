#ifndef PINCH_COMPARE_SETTINGS_H
#define PINCH_COMPARE_SETTINGS_H

#include <stdbool.h>

enum { COMPARE_MOST_COUNTS = 8, COMPARE_MOST_SAMPLES = 256 };

/* What `pinch compare` compares, from its options. */
typedef struct compare_settings {
    int count_count, counts[COMPARE_MOST_COUNTS]; /* quickstep's numbers of iterations */
    bool quickstep, worldstep;                    /* which of ODE's solvers run beside Pinch */
    bool manifolds;                               /* they get the points of Pinch's manifolds, not their collider's */
    int points;                                   /* at most so many points of a pair in Pinch's manifolds, 1 to 8 */
    bool cold_start;                              /* Pinch without its warm start */
    int samples; /* steps that are compared with the exact answer, at most COMPARE_MOST_SAMPLES */
} compare_settings;

#endif
