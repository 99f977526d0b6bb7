/* The methods by name, and the settings that all of them take. */
#include "solvers/methods.h"

#include <math.h>
#include <string.h>

/* The names are indexed by pinch_solver. */
static const char *const NAMES[PINCH_SOLVER_COUNT] = {"nsnmgk", "nsngrk", "newton", "lemke", "pgs"};

const char *pinch_solver_name(pinch_solver solver)
{
    if ((unsigned)solver >= PINCH_SOLVER_COUNT) return "unknown solver";
    return NAMES[solver];
}

pinch_status pinch_solver_from_name(const char *name, pinch_solver *solver)
{
    for (int i = 0; i < PINCH_SOLVER_COUNT; i++)
        if (strcmp(name, NAMES[i]) == 0) {
            *solver = (pinch_solver)i;
            return PINCH_OK;
        }
    return PINCH_INVALID_ARGUMENT;
}

pinch_solver_settings pinch_default_solver_settings(void)
{
    pinch_solver_settings settings = {
        .solver = PINCH_SOLVER_NSNMGK,
        .tolerance = 1e-10,
        .goal = 1e-14,
        .max_iterations = 20000,
        .newton_finish = true,
        .seed = 1,
    };
    return settings;
}

pinch_status pinch_check_solver_settings(const pinch_solver_settings *settings)
{
    bool valid = (unsigned)settings->solver < PINCH_SOLVER_COUNT && settings->tolerance > 0.0 &&
                 isfinite(settings->tolerance) && settings->goal >= 0.0 && settings->goal <= settings->tolerance &&
                 settings->max_iterations >= 1 && settings->budget >= 0.0 && settings->sweeps >= 0;
    return valid ? PINCH_OK : PINCH_INVALID_ARGUMENT;
}

bool pinch_solver_takes_newton_steps(const pinch_solver_settings *settings)
{
    return settings->solver == PINCH_SOLVER_NEWTON ||
           (settings->solver == PINCH_SOLVER_NSNMGK && settings->newton_finish);
}

pinch_solved_by pinch_solver_solved_by(const pinch_solver_settings *settings, const pinch_solver_result *result)
{
    if (result->by_flow) return PINCH_SOLVED_BY_FLOW;
    if (settings->solver >= PINCH_SOLVER_LEMKE) return PINCH_SOLVED_BY_LCP;
    if (result->projections > 0) return PINCH_SOLVED_BY_PROJECTIONS;
    return result->iterations > 0 ? PINCH_SOLVED_BY_NEWTON : PINCH_SOLVED_BY_START;
}

const char *pinch_solved_by_name(pinch_solved_by by)
{
    static const char *const names[PINCH_SOLVED_BY_COUNT] = {"start", "newton", "projections", "flow", "lcp"};
    return (unsigned)by < PINCH_SOLVED_BY_COUNT ? names[by] : "unknown";
}
