/*
 * Approximates the forces of an island of free bodies. In tall piles, which sweeps do not hold, steps of (74) bring
 * them near their laws, at a floor that answers have as well, and sweeps bring them closer. Where they are close,
 * Newton's method is tried: in most steps from the forces of the last, so that what is solved comes to rest. Heaps are
 * swept alone, at a floor at which sweeps bring them to rest.
 */
#include "force/force_system.h"

#include <math.h>
#include <string.h>

/* Sweeps at this floor bring heaps of boxes and of balls to rest; at a tenth of it these tremble by centimetres a
 * second. */
static const double SWEPT_FLOOR = 8e-3;

/* Forces whose merit is less are close to their laws. */
static const double CLOSE = 1e-5;

/* Makes an answer of forces that are close to their laws, if some of Newton's steps lead to one. Otherwise they stay
 * as they are. Returns false when memory ran out. */
static bool finish(pinch_arena *arena, pinch_force_system *s, const pinch_solver_settings *settings,
                   pinch_step_result *result)
{
    enum { LIMIT = 15 };
    pinch_solver_result part;
    pinch_force_answer swept;
    if (result->solve.residual > CLOSE) return true;
    if (!pinch_force_make_room(arena, s, &swept)) return false;
    pinch_force_keep(s, &swept, false);
    if (!pinch_force_newton(arena, s, settings, LIMIT, &part)) return false;
    result->swept = part.status != PINCH_SOLVE_CONVERGED;
    if (result->swept) {
        pinch_force_keep(s, &swept, true);
        part.residual = pinch_force_evaluate(s);
    }
    result->solve.iterations += part.iterations;
    result->solve.newton_steps += part.newton_steps;
    result->solve.residual = part.residual;
    return true;
}

/* Goes from the floor of the last step to another one, little by little where the two are not far apart: what lies on
 * contacts that soften all at once falls onto them. */
static double next_floor(double last, double wanted)
{
    static const double NEAR = 8;
    if (last >= wanted) return fmax(PINCH_FORCE_LOWERED * last, wanted);
    return last * NEAR > wanted ? fmin(last / PINCH_FORCE_LOWERED, wanted) : wanted;
}

bool pinch_force_approximate(pinch_arena *arena, pinch_force_system *s, const pinch_problem *problem,
                             const pinch_solver_settings *settings, double *floor, pinch_step_result *result)
{
    pinch_solver_result *total = &result->solve;
    bool split = s->split_products > 0;
    *total = (pinch_solver_result){.iterations = total->iterations, .newton_steps = total->newton_steps};
    result->swept = true;
    s->budget = INFINITY;
    *floor = next_floor(*floor, split ? PINCH_FORCE_FIRST_FLOOR : SWEPT_FLOOR);
    pinch_force_warm_start(s, problem);
    pinch_force_set_floor(s, *floor);
    if (split) {
        total->residual = pinch_force_evaluate(s);
        total->status = PINCH_SOLVE_CONVERGED;
        if (!finish(arena, s, settings, result)) return false;
        if (!result->swept) return true;
        if (total->residual > CLOSE && !pinch_force_split(arena, s, &split)) return false;
        if (!split) pinch_force_warm_start(s, problem);
    }
    if (!pinch_force_sweep_alone(arena, s, settings->sweeps, &total->residual)) return false;
    total->iterations += settings->sweeps;
    total->status = isfinite(total->residual) ? PINCH_SOLVE_CONVERGED : PINCH_SOLVE_DIVERGED;
    return !split || settings->sweeps_alone || finish(arena, s, settings, result);
}
