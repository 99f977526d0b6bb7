#ifndef PINCH_COMPARE_METRICS_H
#define PINCH_COMPARE_METRICS_H

#include <stdbool.h>

/* The metrics of a run. JSON, CSV, baselines and the report all go by this one table. A metric that a run does not have
 * is NaN. */

typedef enum metric {
    METRIC_FORCE_ERROR_MAX = 0,
    METRIC_FORCE_ERROR_MEDIAN,
    METRIC_FORCE_JITTER,
    METRIC_CREEP,
    METRIC_CREEP_ANGULAR,
    METRIC_CREEP_IN_HAND,
    METRIC_CREEP_IN_HAND_ANGULAR,
    METRIC_DISPLACEMENT,
    METRIC_ROTATION,
    METRIC_GRIP_FORCE,
    METRIC_SLIP,
    METRIC_SLIP_MARGIN,
    METRIC_PENETRATION,
    METRIC_POINTS,
    METRIC_MOMENTUM_ERROR,
    METRIC_ANGULAR_MOMENTUM_ERROR,
    METRIC_ENERGY_CLOSURE,
    METRIC_ENERGY_CLOSURE_RELATIVE,
    METRIC_CONSTRAINT_ERROR,
    METRIC_CONSTRAINT_ERROR_ANGULAR,
    METRIC_DETERMINISTIC,
    METRIC_VERIFIED,
    METRIC_DROPPED,
    METRIC_UNCONVERGED_STEPS,
    METRIC_ITERATIONS_MEAN,
    METRIC_ITERATIONS_MAX,
    METRIC_START_RESIDUAL,
    METRIC_DIVERGENCE_MAX,
    METRIC_DIVERGENCE_END,
    METRIC_DIVERGES_1UM,
    METRIC_DIVERGES_10UM,
    METRIC_DIVERGES_100UM,
    METRIC_DIVERGES_1MM,
    METRIC_DIVERGES_10MM,
    METRIC_COST,
    METRIC_COUNT
} metric;

enum { METRIC_THRESHOLDS = METRIC_DIVERGES_10MM - METRIC_DIVERGES_1UM + 1 };

typedef struct metric_info {
    const char *key;   /* as in the JSON document */
    const char *unit;  /* "1" for a ratio, "" for yes and no */
    const char *label; /* for people */
    const char *about; /* one sentence */
} metric_info;

const metric_info *metric_about(metric m);
/* METRIC_COUNT where there is no such metric. */
metric metric_of_key(const char *key);
/* Distances from Pinch's trajectory, in m. The time at which a run first exceeds each of them is a metric. */
extern const double metric_thresholds[METRIC_THRESHOLDS];

/* How far a metric may move before a baseline calls it moved: absolute + relative |value|. absolute < 0 means that it
 * is not checked. */
typedef struct tolerance {
    double absolute, relative;
} tolerance;

/* The defaults that a new baseline starts with. `ode` asks for those of ODE's solvers. */
tolerance tolerance_default(metric m, bool ode);

#endif
