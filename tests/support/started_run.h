#ifndef PINCH_TEST_STARTED_RUN_H
#define PINCH_TEST_STARTED_RUN_H

#include "scenes/world/simulation.h"

#include <stddef.h>

/* A scene's world and its run, which is stepped by hand. */
typedef struct started_run {
    world *w;
    simulation *s;
} started_run;

/* s is NULL where it cannot be started; w then is nobody's to free. */
static inline started_run run_start(const scene *of)
{
    char error[1024];
    started_run r = {NULL, NULL};
    world_settings settings = world_default_settings(of);
    if (world_create(of, &settings, &r.w, error) == WORLD_OK) r.s = simulation_start(r.w);
    return r;
}

static inline void run_end(started_run *r)
{
    simulation_result result;
    simulation_finish(r->s, &result);
    simulation_free(&result);
    world_free(r->w);
}

#endif
