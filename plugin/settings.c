#include "plugin.h"

pinch_status pinch_check_settings(const pinch_ode_settings *settings)
{
    if (!settings) return PINCH_INVALID_ARGUMENT;
    const pinch_solver_settings *s = &settings->solver;
    if (!(s->tolerance > 0) || !(s->goal >= 0) || s->goal > s->tolerance || s->max_iterations < 1)
        return PINCH_INVALID_ARGUMENT;
    if (!(settings->merge_distance > 0 && settings->merge_distance <= 0.5) ||
        !(settings->stale_tilt >= 0 && settings->stale_tilt <= 0.5))
        return PINCH_INVALID_ARGUMENT;
    if (settings->manifold_points < 1 || settings->manifold_points > PINCH_MANIFOLD_POINTS)
        return PINCH_INVALID_ARGUMENT;
    if (settings->scope < PINCH_ODE_ALL_CONTACTS || settings->scope > PINCH_ODE_MATERIAL_CONTACTS ||
        !(settings->tangential_ratio > 0 && settings->tangential_ratio <= 10))
        return PINCH_INVALID_ARGUMENT;
    if (settings->threads < 1 || settings->threads > PINCH_ODE_MOST_THREADS) return PINCH_INVALID_ARGUMENT;
    if (settings->faces != 0 && (settings->faces < 2 || settings->faces > 4096)) return PINCH_INVALID_ARGUMENT;
    bool iterative = s->solver >= PINCH_SOLVER_NSNMGK && s->solver <= PINCH_SOLVER_NEWTON;
    if (!iterative && (s->solver < PINCH_SOLVER_NSNMGK || s->solver >= PINCH_SOLVER_COUNT))
        return PINCH_INVALID_ARGUMENT;
    return iterative || settings->faces > 0 ? PINCH_OK : PINCH_UNSUPPORTED;
}
