/*
 * The tolerances are about what a change means, not about bits: another compiler or a faster solver moves the last
 * digits of everything and, in long runs, some more; a stiffness that is 1 % off moves displacements by 1 %, a friction
 * coefficient the slip margin, a lost manifold point the number of points, a lost warm start where solves start. Cost
 * is never checked.
 */
#include "tolerances.h"

#include <stddef.h>

typedef struct entry {
    metric m;
    tolerance t;
} entry;

static const entry pinch[] = {
    {METRIC_FORCE_ERROR_MAX, {1e-9, 0}},    /* what Pinch promises */
    {METRIC_FORCE_ERROR_MEDIAN, {1e-9, 0}}, /* likewise */
    {METRIC_FORCE_JITTER, {1e-6, 0.1}},
    {METRIC_CREEP, {1e-9, 0.02}},         /* a nanometre in a second */
    {METRIC_CREEP_ANGULAR, {1e-7, 0.02}}, /* the same at a lever of a centimetre */
    {METRIC_DISPLACEMENT, {1e-8, 2e-3}},
    {METRIC_ROTATION, {1e-6, 5e-3}},
    {METRIC_GRIP_FORCE, {1e-6, 1e-3}},
    {METRIC_SLIP, {1e-8, 0.02}},
    {METRIC_SLIP_MARGIN, {1e-3, 0}},
    {METRIC_PENETRATION, {1e-8, 2e-3}},
    {METRIC_POINTS, {0.02, 0.005}},
    {METRIC_MOMENTUM_ERROR, {1e-8, 0}},
    {METRIC_ANGULAR_MOMENTUM_ERROR, {1e-8, 0.5}}, /* of moving bodies it is the step's own second order */
    {METRIC_ENERGY_CLOSURE_RELATIVE, {1e-5, 0.2}},
    {METRIC_CONSTRAINT_ERROR, {1e-8, 0.1}},
    {METRIC_CONSTRAINT_ERROR_ANGULAR, {1e-7, 0.1}},
    {METRIC_DETERMINISTIC, {0, 0}},
    {METRIC_VERIFIED, {0, 0}},
    {METRIC_DROPPED, {0, 0}},
    {METRIC_UNCONVERGED_STEPS, {2, 0.5}},
    {METRIC_ITERATIONS_MEAN, {0.2, 0.3}}, /* half of the steps at rest need none, as rounding has it */
    {METRIC_ITERATIONS_MAX, {6, 0.5}},
    {METRIC_START_RESIDUAL, {0.05, 0}}, /* a warm start is below 0.02, a cold one 0.1 to 1 */
};

/* The peers are there to be seen beside Pinch; what they do is ODE's. */
static const entry ode[] = {
    {METRIC_FORCE_ERROR_MEDIAN, {5e-3, 0.5}},
    {METRIC_DETERMINISTIC, {0, 0}},
};

tolerance tolerance_default(metric m, bool of_ode)
{
    const tolerance none = {-1, 0};
    const entry *list = of_ode ? ode : pinch;
    size_t count = of_ode ? sizeof ode / sizeof *ode : sizeof pinch / sizeof *pinch;
    for (size_t i = 0; i < count; i++)
        if (list[i].m == m) return list[i].t;
    return none;
}
