#ifndef PINCH_COMPARE_SOLVER_RUN_H
#define PINCH_COMPARE_SOLVER_RUN_H

#include "metrics.h"

#include "common/jobs.h"
#include "scenes/world/simulation.h"
#include "view/film.h"

/* The observer measures a run as it goes. It keeps curves with as many points as a plot can show. */

enum { OBSERVER_POINTS = 160 }; /* points of a curve */

/* The numbers of a curve's point. */
enum {
    OBSERVER_TIME = 0,
    OBSERVER_POSITION,                         /* x, y, z from the start, m */
    OBSERVER_ROTATION = OBSERVER_POSITION + 3, /* rad, from the start */
    OBSERVER_DIVERGENCE,                       /* m */
    OBSERVER_BALANCE,                          /* N: momentum error of the step */
    OBSERVER_FINGERS,                          /* from here on OBSERVER_PER_FINGER numbers for each finger */
    OBSERVER_NORMAL = 0,                       /* N */
    OBSERVER_TANGENTIAL,                       /* N */
    OBSERVER_SLIP,                             /* m, path length */
    OBSERVER_PER_FINGER
};

typedef struct observer {
    const world *w;
    long steps, stride;                      /* of the whole run; between two points of a curve */
    double start[7];                         /* the object's position and orientation */
    double before[6], inertia[9], centre[3]; /* of the object at the start of the step */
    double *history;                         /* per finger: its force in the two steps before */
    double *noise; /* per finger: the sum of squares of its force's second difference over the second half */
    long noisy;    /* number of terms in that sum */
    double points; /* loaded contact points of the fingers, summed over steps */
    double momentum, angular_momentum; /* N, N m: largest errors */
    double constraint, constraint_angular;
    double divergence, divergence_max, passed[METRIC_THRESHOLDS]; /* m; s, NaN: not passed */
    double balance;                                               /* N, of the step just done */
    int columns, rows;
    double *curve;      /* rows x columns */
    double (*poses)[7]; /* of the object after each step */
} observer;

/* Returns false when memory runs out. Free it in either case. */
bool observer_start(observer *r, const world *w, long steps);
void observer_free(observer *r);
void observer_before_step(observer *r);
/* `peer` is the observer of Pinch's run, which has seen the same step, or NULL. */
void observer_after_step(observer *r, const observer *peer);
/* Fills in the metrics that the observer knows of the finished run. */
void observer_metrics(const observer *r, double metrics[METRIC_COUNT]);

/* One run of a scene by one solver. quickstep shuffles its rows with ODE's random numbers. Each run has a stream of its
 * own, so that it does not depend on which others take part. */
typedef struct solver_run {
    char name[32]; /* "pinch", "quickstep-20", "worldstep" */
    world_settings settings;
    world *w;
    simulation *simulation;
    simulation_result result;
    observer observer;
    double *step_s; /* wall time of every step, s; sorted by solver_run_finish */
    unsigned long random;
    uint64_t hash; /* of the finished run */
    double metrics[METRIC_COUNT];
    double film_rate; /* pictures a second; 0: no film */
    film *pictures;   /* of the run; NULL: none */
} solver_run;

/* Builds the world. After WORLD_NO_MEMORY solver_run_free still takes what there is. */
world_status solver_run_start(solver_run *c, const scene *s);
/* Makes one step. `peer` is Pinch's run, which has made the same step, or NULL. */
world_status solver_run_step(solver_run *c, const solver_run *peer);
/* Ends the run and fills in its hash and its metrics. */
void solver_run_finish(solver_run *c);
void solver_run_free(solver_run *c);

/* Runs the scene once more by itself. *hash is the hash of the state in which it ends. */
world_status solver_run_hash(const solver_run *c, const scene *s, job_share *share, uint64_t *hash);

#endif
