/* Iterates on a non-smooth system with the chosen method, one outer iteration after the other. */
#include "solvers/methods.h"
#include "support/dense.h"

#include <math.h>
#include <string.h>

size_t pinch_solver_scratch(int size)
{
    return (size_t)PINCH_ITERATE_ARRAYS * (size_t)size;
}

static pinch_iterate lay_out(const pinch_system *system, double *scratch, double *x)
{
    size_t n = (size_t)system->size;
    pinch_iterate it = {
        .system = system,
        .x = x,
        .f = scratch,
        .x_trial = scratch + n,
        .f_trial = scratch + 2 * n,
        .direction = scratch + 3 * n,
        .row_norm2 = scratch + 4 * n,
        .rate = INFINITY,
    };
    return it;
}

typedef enum step_outcome { STEP_TAKEN, STEP_STUCK, STEP_NOT_FINITE } step_outcome;

/* Makes one Kaczmarz iteration. Unlike Newton's steps it is taken whether or not ||F|| falls. */
static step_outcome kaczmarz_iteration(pinch_iterate *it, pinch_random *random, pinch_solver_result *result)
{
    double norm;
    int projections = random ? pinch_nsngrk_draw(it, random, &norm) : pinch_nsnmgk_sweep(it, &norm);
    result->projections += projections;
    if (projections == 0) return STEP_STUCK;
    if (!isfinite(norm)) return STEP_NOT_FINITE;
    pinch_iterate_accept(it, norm);
    return STEP_TAKEN;
}

/* Makes one outer iteration of the chosen method. */
static step_outcome iterate_once(const pinch_solver_settings *settings, pinch_iterate *it, pinch_random *random,
                                 pinch_solver_result *result)
{
    it->system->linearize(it->system->self, it->x);
    if (pinch_solver_takes_newton_steps(settings) && pinch_newton_step(it)) {
        result->newton_steps++;
        return STEP_TAKEN;
    }
    if (settings->solver == PINCH_SOLVER_NEWTON) return pinch_gradient_step(it) ? STEP_TAKEN : STEP_STUCK;
    return kaczmarz_iteration(it, settings->solver == PINCH_SOLVER_NSNGRK ? random : NULL, result);
}

static void run(const pinch_solver_settings *settings, pinch_iterate *it, pinch_solver_result *result)
{
    pinch_random random;
    if (settings->solver == PINCH_SOLVER_NSNGRK) pinch_random_seed(&random, settings->seed);

    for (;;) {
        if (settings->progress) settings->progress(settings->progress_context, result->iterations, it->norm);
        if (it->norm <= settings->tolerance) {
            result->status = PINCH_SOLVE_CONVERGED;
            break;
        }
        if (result->iterations == settings->max_iterations) break;
        step_outcome outcome = iterate_once(settings, it, &random, result);
        if (outcome != STEP_TAKEN) {
            if (outcome == STEP_NOT_FINITE) result->status = PINCH_SOLVE_DIVERGED;
            break;
        }
        result->iterations++;
    }

    if (result->status == PINCH_SOLVE_CONVERGED && pinch_solver_takes_newton_steps(settings)) {
        int steps = pinch_newton_polish(it, settings->goal, settings->max_iterations - result->iterations);
        result->newton_steps += steps;
        result->iterations += steps;
    }
}

pinch_status pinch_solve_system(const pinch_system *system, const pinch_solver_settings *settings, double *scratch,
                                double *x, pinch_solver_result *result)
{
    if (system->size < 1 || pinch_check_solver_settings(settings) != PINCH_OK) return PINCH_INVALID_ARGUMENT;
    if (settings->solver >= PINCH_SOLVER_LEMKE) return PINCH_UNSUPPORTED;

    pinch_solver_result fresh = {.status = PINCH_SOLVE_MAX_ITERATIONS};
    *result = fresh;
    pinch_iterate it = lay_out(system, scratch, x);
    system->residual(system->self, it.x, it.f);
    it.norm = pinch_norm(it.f, system->size);
    if (isfinite(it.norm))
        run(settings, &it, result);
    else
        result->status = PINCH_SOLVE_DIVERGED;
    if (it.x != x) memcpy(x, it.x, (size_t)system->size * sizeof *x);
    result->residual = it.norm;
    return PINCH_OK;
}
