#ifndef PINCH_COMPARE_TOLERANCES_H
#define PINCH_COMPARE_TOLERANCES_H

#include "metrics.h"

#include <stdbool.h>

/* How far a metric may move before a baseline calls it moved: absolute + relative |value|. absolute < 0: not checked.
 */
typedef struct tolerance {
    double absolute, relative;
} tolerance;

/* The defaults that a new baseline starts with. ode: for the runs of ODE's solvers. */
tolerance tolerance_default(metric m, bool ode);

#endif
