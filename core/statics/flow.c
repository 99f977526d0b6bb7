#include "statics/flow.h"

#include "support/dense.h"
#include "support/random.h"

#include <math.h>
#include <string.h>

bool pinch_static_is_bare(const pinch_solver_settings *settings)
{
    return settings->solver != PINCH_SOLVER_NSNMGK || !settings->newton_finish;
}

bool pinch_static_newton_with_term(pinch_static_model *model, const pinch_solver_settings *settings, double tolerance,
                                   int iterations, double *u, pinch_solver_result *total)
{
    if (model->work_left <= 0) return false;
    pinch_system system = pinch_static_system(model);
    pinch_solver_settings inner = *settings;
    inner.tolerance = tolerance;
    inner.goal = fmin(settings->goal, tolerance);
    inner.max_iterations = iterations;
    inner.progress = NULL;
    double trial[6], scratch[64];
    memcpy(trial, u, (size_t)model->freedoms * sizeof *u);
    pinch_solver_result result;
    pinch_solve_system(&system, &inner, scratch, trial, &result);
    model->work_left -= 1 + result.iterations;
    total->iterations += result.iterations;
    total->newton_steps += result.newton_steps;
    total->projections += result.projections;
    total->residual = result.residual;
    if (result.status != PINCH_SOLVE_CONVERGED) return false;
    memcpy(u, trial, (size_t)model->freedoms * sizeof *u);
    return true;
}

bool pinch_static_newton(pinch_static_model *model, const pinch_solver_settings *settings, int iterations, double *u,
                         pinch_solver_result *total)
{
    model->alpha = 0.0;
    if (pinch_static_is_bare(settings)) iterations = settings->max_iterations;
    return pinch_static_newton_with_term(model, settings, settings->tolerance, iterations, u, total);
}

void pinch_static_stiffness_range(const pinch_static_model *model, double *least, double *largest)
{
    *least = INFINITY;
    *largest = 0.0;
    for (int c = 0; c < model->count; c++)
        for (int i = 0; i < model->contacts[c].rows && i < 3; i++) {
            *least = fmin(*least, model->contacts[c].k[i]);
            *largest = fmax(*largest, model->contacts[c].k[i]);
        }
}

bool pinch_static_follow(pinch_static_model *model, const pinch_solver_settings *settings, const double *start,
                         double *at, pinch_solver_result *total)
{
    enum { ANCHORS = 4 };
    const double tiny = 1e-9;
    int m = model->freedoms, steps = (int)PINCH_STATIC_LOAD_NEWTON_STEPS;
    double softest, stiffest;
    if (pinch_static_is_bare(settings)) steps = settings->max_iterations;
    pinch_static_stiffness_range(model, &softest, &stiffest);
    memcpy(model->anchor, start, (size_t)m * sizeof *start);
    bool balanced = false, found = true;
    for (int i = 0; i < ANCHORS && found && !balanced; i++) {
        model->alpha = tiny * softest;
        model->inertial = true;
        found = pinch_static_newton_with_term(model, settings, settings->tolerance, steps, at, total);
        double carried = 0.0;
        for (int j = 0; j < m; j++) carried = hypot(carried, model->alpha * (at[j] - model->anchor[j]));
        balanced = found && carried <= settings->tolerance;
        memcpy(model->anchor, at, (size_t)m * sizeof *at);
    }
    model->alpha = 0.0;
    model->inertial = false;
    return balanced;
}

/*
 * Takes one implicit step from the anchor. With history every sliding contact starts on its limit, on the kink between
 * stick and slip, where Newton is told nothing about which way it will slide; a guess further along the last step's way
 * is beyond the kink, so that is tried first.
 */
static bool flow_step(pinch_static_model *model, const pinch_solver_settings *settings, double tolerance,
                      const double *guess, double *u, pinch_solver_result *total)
{
    enum { INNER = 12 };
    double at[6];
    if (guess) {
        memcpy(at, guess, sizeof at);
        if (pinch_static_newton_with_term(model, settings, tolerance, INNER, at, total)) {
            memcpy(u, at, (size_t)model->freedoms * sizeof *u);
            return true;
        }
    }
    return pinch_static_newton_with_term(model, settings, tolerance, INNER, u, total);
}

pinch_flow_outcome pinch_static_flow(pinch_static_model *model, const pinch_solver_settings *settings, bool history,
                                     double shrink, double *u, double *direction, pinch_solver_result *total)
{
    enum { STEPS = 300, TRIES = 8 };
    int m = model->freedoms;
    double softest, stiffest, alpha = 1.0, last_alpha = 0.0, last[6] = {0}, guess[6] = {0};
    memset(direction, 0, (size_t)m * sizeof *direction);
    if (pinch_static_is_bare(settings)) return PINCH_FLOW_UNDECIDED;
    pinch_static_build_reference(model);
    /* ten thousand times what the softest spring gives under the unit force is gone, whatever the linearized grasp says
     */
    pinch_static_stiffness_range(model, &softest, &stiffest);
    double far_away = 1e4 / softest;
    for (int step = 0; step < STEPS && alpha < 1e12; step++) {
        memcpy(model->anchor, u, (size_t)m * sizeof *u);
        model->alpha = alpha;
        /* tighter than what counts as settled, or the flow would stand still before that; rounding sets the limit */
        double tolerance = 0.1 * settings->tolerance + 1e-13 * stiffest * pinch_norm(u, m);
        bool guessed = history && last_alpha > 0.0;
        for (int j = 0; guessed && j < m; j++) guess[j] = u[j] + last_alpha / alpha * last[j];
        if (!flow_step(model, settings, tolerance, guessed ? guess : NULL, u, total)) {
            alpha *= 4.0;
            continue;
        }
        for (int j = 0; j < m; j++) last[j] = u[j] - model->anchor[j];
        last_alpha = alpha;
        if (history) pinch_static_commit(model, u);
        alpha *= shrink;
        memcpy(direction, last, (size_t)m * sizeof *direction);
        if (pinch_norm(u, m) > far_away) return PINCH_FLOW_ESCAPED;
        if (pinch_static_newton(model, settings, TRIES, u, total)) {
            total->by_flow = true;
            return PINCH_FLOW_SETTLED;
        }
    }
    return PINCH_FLOW_UNDECIDED;
}

bool pinch_static_settle(pinch_static_model *model, const pinch_solver_settings *settings, double *u,
                         pinch_solver_result *total)
{
    enum { STEPS = 80, TRIES = 8 };
    const double shrink = 0.8, at_rest = 1e-3;
    int m = model->freedoms;
    double equilibrium[6], alpha = 1.0;
    if (pinch_static_is_bare(settings)) return false;
    pinch_static_build_reference(model);
    pinch_static_equilibrium(model, u, equilibrium);
    double start = pinch_norm(equilibrium, m);
    for (int step = 0; step < STEPS && alpha < 1e6; step++) {
        memcpy(model->anchor, u, (size_t)m * sizeof *u);
        model->alpha = alpha;
        if (!pinch_static_newton_with_term(model, settings, settings->tolerance, 12, u, total)) {
            alpha *= 4.0;
            continue;
        }
        pinch_static_commit(model, u);
        pinch_static_equilibrium(model, u, equilibrium);
        if (pinch_norm(equilibrium, m) <= at_rest * start) break;
        alpha *= shrink;
    }
    return pinch_static_newton(model, settings, TRIES, u, total);
}

/* A start about as far from the undeformed state as the springs give under the unit force. */
static void draw_start(const pinch_static_model *model, pinch_random *random, double *u)
{
    double softest, stiffest;
    pinch_static_stiffness_range(model, &softest, &stiffest);
    double scale = exp((2.0 * pinch_random_uniform(random) - 1.0) * 3.0) / sqrt(softest);
    for (int j = 0; j < model->freedoms; j++) u[j] = scale * (2.0 * pinch_random_uniform(random) - 1.0);
}

pinch_flow_outcome pinch_static_one_step(pinch_static_model *model, const pinch_solver_settings *settings, double *u,
                                         bool thorough, double *direction, pinch_solver_result *total)
{
    static const double SHRINK[] = {0.5, 0.8, 0.25, 0.1};
    enum { SHRINKS = sizeof SHRINK / sizeof *SHRINK, STARTS = 12, NEWTON_STEPS = 15 };
    int m = model->freedoms;
    memset(u, 0, (size_t)m * sizeof *u);
    if (pinch_static_newton(model, settings, NEWTON_STEPS, u, total)) return PINCH_FLOW_SETTLED;

    /* the first flow's verdict stands unless some other way reaches an equilibrium */
    double escape[6], at[6];
    pinch_flow_outcome first = PINCH_FLOW_UNDECIDED, outcome;
    for (int i = 0; i < (thorough ? SHRINKS : 1); i++) {
        memset(at, 0, sizeof at);
        outcome = pinch_static_flow(model, settings, false, SHRINK[i], at, escape, total);
        if (outcome == PINCH_FLOW_SETTLED) {
            memcpy(u, at, (size_t)m * sizeof *u);
            return outcome;
        }
        if (i == 0 || first == PINCH_FLOW_UNDECIDED) {
            first = outcome;
            memcpy(direction, escape, (size_t)m * sizeof *escape);
        }
    }
    if (!thorough || pinch_static_is_bare(settings)) return first;
    pinch_random random;
    pinch_random_seed(&random, settings->seed);
    for (int i = 0; i < STARTS; i++) {
        draw_start(model, &random, at);
        if (pinch_static_newton(model, settings, NEWTON_STEPS, at, total) ||
            pinch_static_flow(model, settings, false, 0.5, at, escape, total) == PINCH_FLOW_SETTLED) {
            memcpy(u, at, (size_t)m * sizeof *u);
            return PINCH_FLOW_SETTLED;
        }
    }
    return first;
}
