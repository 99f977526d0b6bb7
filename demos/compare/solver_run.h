#ifndef PINCH_COMPARE_SOLVER_RUN_H
#define PINCH_COMPARE_SOLVER_RUN_H

#include "metrics.h"

#include "scenes/world/simulation.h"

/* Measures a run as it goes, and keeps curves of it with as many points as a plot can show. */

enum { RECORDER_POINTS = 160 }; /* of a curve */

/* One curve point's numbers: time, then what recorder_columns counts. */
enum {
    RECORDER_TIME = 0,
    RECORDER_POSITION,                         /* x, y, z from the start, m */
    RECORDER_ROTATION = RECORDER_POSITION + 3, /* rad, from the start */
    RECORDER_DIVERGENCE,                       /* m */
    RECORDER_BALANCE,                          /* N: momentum error of the step */
    RECORDER_FINGERS,                          /* from here on RECORDER_PER_FINGER each */
    RECORDER_NORMAL = 0,                       /* N */
    RECORDER_TANGENTIAL,                       /* N */
    RECORDER_SLIP,                             /* m, path length */
    RECORDER_PER_FINGER
};

typedef struct recorder {
    const world *w;
    long steps, stride;                      /* of the whole run; steps between curve points */
    double start[7];                         /* the object's position and orientation */
    double before[6], inertia[9], centre[3]; /* of the object at the start of the step */
    double *history;                         /* per finger: its force in the two steps before */
    double *noise; /* per finger: sum of squares of its force's second difference over the second half */
    long noisy;    /* terms in it */
    double points; /* loaded contact points of the fingers, summed over steps */
    double momentum, angular_momentum; /* N, N m: largest errors */
    double constraint, constraint_angular;
    double divergence, divergence_max, passed[METRIC_THRESHOLDS]; /* m; s, NaN: not passed */
    double balance;                                               /* N, of the step just done */
    int columns, rows;
    double *curve; /* rows x columns */
} recorder;

/* false: no memory. Free it in either case. */
bool recorder_start(recorder *r, const world *w, long steps);
void recorder_free(recorder *r);
void recorder_before_step(recorder *r);
/* After the step. peer: the world of Pinch's run after the same step, NULL where there is none. */
void recorder_after_step(recorder *r, const world *peer);
/* Fills in what the recorder knows of the finished run. */
void recorder_metrics(const recorder *r, double metrics[METRIC_COUNT]);

/* One run of a scene by one solver. ODE's quickstep shuffles with ODE's random numbers: each solver_run has a stream of
 * its own, so that its run does not depend on who else runs. */
typedef struct solver_run {
    char name[32]; /* "pinch", "quickstep-20", "worldstep" */
    world_settings settings;
    world *w;
    simulation *simulation;
    simulation_result result;
    recorder record;
    double *step_s; /* wall time of every step, s; sorted by solver_run_finish */
    unsigned long random;
    uint64_t hash; /* of the finished run */
    double metrics[METRIC_COUNT];
} solver_run;

/* WORLD_NO_MEMORY: solver_run_free takes what there is. */
world_status solver_run_start(solver_run *c, const scene *s);
/* One step; peer: Pinch's solver_run, which has made the same step, or NULL. */
world_status solver_run_step(solver_run *c, const solver_run *peer);
/* Ends the run and fills in hash and metrics. */
void solver_run_finish(solver_run *c);
void solver_run_free(solver_run *c);

/* The bits in which a run of its own ends: WORLD_OK, and *hash. */
world_status solver_run_hash(const solver_run *c, const scene *s, uint64_t *hash);

#endif
