#ifndef PINCH_COMPARE_CONTENDER_H
#define PINCH_COMPARE_CONTENDER_H

#include "recorder.h"
#include "settings.h"

#include "scenes/world/simulation.h"

/* One run of a scene by one solver. ODE's quickstep shuffles with ODE's random numbers: each contender has a stream of
 * its own, so that its run does not depend on who else runs. */
typedef struct contender {
    char name[32]; /* "pinch", "quickstep-20", "worldstep" */
    world_settings settings;
    world *w;
    simulation *simulation;
    simulation_result result;
    recorder record;
    double *step_s; /* wall time of every step, s; sorted by contender_finish */
    unsigned long random;
    uint64_t hash; /* of the finished run */
    double metrics[METRIC_COUNT];
} contender;

enum { CONTENDER_MOST = 2 + COMPARE_MOST_COUNTS };

/* Names and world settings of the runs that the settings ask for, Pinch's first; how many there are. */
int contender_list(const compare_settings *settings, const scene *s, contender contenders[CONTENDER_MOST]);

/* WORLD_NO_MEMORY: contender_free takes what there is. */
world_status contender_start(contender *c, const scene *s);
/* One step; peer: Pinch's contender, which has made the same step, or NULL. */
world_status contender_step(contender *c, const contender *peer);
/* Ends the run and fills in hash and metrics. */
void contender_finish(contender *c);
void contender_free(contender *c);

/* The bits in which a run of its own ends: WORLD_OK, and *hash. */
world_status contender_hash(const contender *c, const scene *s, uint64_t *hash);

#endif
