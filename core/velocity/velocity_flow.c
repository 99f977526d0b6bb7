/* Follows the implicit flow, equation (20) of core/README.md, where Newton's method alone cycles. */
#include "solvers/methods.h"
#include "velocity/velocity_system.h"

#include <math.h>
#include <string.h>

enum { FLOW_STEPS = 300, INNER_STEPS = 15, PLAIN_STEPS = 12 };
static const double SHRINK = 0.5, GROW = 4, STRONGEST = 1e6, INNER_TOLERANCE = 1e-9;

static bool prepare(pinch_arena *arena, pinch_velocity_system *vs)
{
    size_t n = (size_t)vs->unknowns;
    if (!vs->sticking) {
        vs->sticking = PINCH_ARENA_ARRAY(arena, double, n *n);
        vs->anchor = PINCH_ARENA_ARRAY(arena, double, 2 * n);
        vs->flow_scratch = PINCH_ARENA_ARRAY(arena, double, n);
        if (arena->failed) return false;
        memset(vs->sticking, 0, n * n * sizeof(double));
        pinch_velocity_sticking(vs, vs->sticking);
    }
    return true;
}

static bool newton(pinch_velocity_system *vs, const pinch_solver_settings *settings, double tolerance, int steps,
                   pinch_solver_result *total)
{
    pinch_system system = pinch_velocity_system_interface(vs);
    pinch_solver_settings inner = *settings;
    pinch_solver_result part;
    inner.solver = PINCH_SOLVER_NEWTON;
    inner.tolerance = tolerance;
    inner.goal = fmin(settings->goal, tolerance);
    inner.max_iterations = steps;
    inner.progress = NULL;
    if (pinch_solve_system(&system, &inner, vs->solver_scratch, vs->x, &part) != PINCH_OK) return false;
    pinch_add_solver_counts(total, &part);
    total->residual = part.residual;
    return part.status == PINCH_SOLVE_CONVERGED;
}

bool pinch_velocity_flow(pinch_arena *arena, pinch_velocity_system *vs, const pinch_solver_settings *settings,
                         pinch_solver_result *result)
{
    size_t bytes = sizeof(double) * (size_t)vs->unknowns;
    if (!prepare(arena, vs)) return false;
    double *here = vs->anchor + vs->unknowns, *x = vs->x, pull = 1;
    memcpy(here, x, bytes);
    result->status = PINCH_SOLVE_MAX_ITERATIONS;
    vs->in_flow = true; /* an idle drive is led back by the flow itself */
    for (int k = 0; k < FLOW_STEPS && pull < STRONGEST; k++) {
        memcpy(x, here, bytes);
        vs->pull = 0;
        if (newton(vs, settings, settings->tolerance, PLAIN_STEPS, result)) {
            result->status = PINCH_SOLVE_CONVERGED;
            result->by_flow = true;
            return true;
        }
        memcpy(vs->anchor, here, bytes);
        memcpy(x, here, bytes);
        vs->pull = pull;
        bool moved = newton(vs, settings, fmax(INNER_TOLERANCE, settings->tolerance), INNER_STEPS, result);
        vs->pull = 0;
        if (moved) memcpy(here, x, bytes);
        pull *= moved ? SHRINK : GROW;
    }
    memcpy(x, here, bytes);
    return true;
}
