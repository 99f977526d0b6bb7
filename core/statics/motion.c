#include "statics/flow.h"

#include "support/dense.h"

#include <math.h>
#include <string.h>

typedef struct motion {
    pinch_static_model *model;
    const pinch_solver_settings *settings;
    double softest, stiffest;
    double mass;        /* over the time step squared, of a whole step */
    double part;        /* of the time step: less while the solver finds whole ones too long */
    double velocity[6]; /* per step, of the present length */
    double most;        /* the largest imbalance so far */
    pinch_solver_result *total;
} motion;

/* Takes one step. Returns false when it is too long; u is then as it was. */
static bool step(motion *m, double *u)
{
    enum { NEWTON_STEPS = 12 };
    pinch_static_model *model = m->model;
    int n = model->freedoms;
    double at[6], tolerance = 0.1 * m->settings->tolerance + 1e-13 * m->stiffest * pinch_norm(u, n);
    model->alpha = m->mass / (m->part * m->part);
    model->inertial = true;
    for (int j = 0; j < n; j++) at[j] = model->anchor[j] = u[j] + m->velocity[j];
    bool solved = pinch_static_newton_with_term(model, m->settings, tolerance, NEWTON_STEPS, at, m->total);
    if (!solved) {
        memcpy(at, u, (size_t)n * sizeof *u);
        solved = pinch_static_newton_with_term(model, m->settings, tolerance, NEWTON_STEPS, at, m->total);
    }
    model->inertial = false;
    if (!solved) return false;
    for (int j = 0; j < n; j++) m->velocity[j] = at[j] - u[j];
    memcpy(u, at, (size_t)n * sizeof *u);
    pinch_static_commit(model, u);
    return true;
}

static void change_step(motion *m, double factor)
{
    m->part *= factor;
    for (int j = 0; j < m->model->freedoms; j++) m->velocity[j] *= factor;
}

/* Finds how far the equilibrium at u moves in one step of the load. Returns false when it does not go on from there. */
static bool find_drift(motion *m, const pinch_static_ramp *ramp, const double *u, double *drift)
{
    int n = m->model->freedoms;
    double now = *ramp->factor, after = now + ramp->per_step * ramp->goal, at[6];
    memcpy(at, u, (size_t)n * sizeof *u);
    *ramp->factor = fabs(after) < fabs(ramp->goal) ? after : ramp->goal;
    bool found = pinch_static_follow(m->model, m->settings, u, at, m->total);
    *ramp->factor = now;
    for (int j = 0; j < n; j++) drift[j] = at[j] - u[j];
    return found;
}

/*
 * Has the object come to rest? Then the forces balance but for little of what they did on the way, and it moves as the
 * load moves it; an object that glides through nothing is in balance, too. u is refined by Newton, which must find the
 * equilibrium where the object is.
 */
static bool is_at_rest(motion *m, const pinch_static_ramp *ramp, double *u)
{
    enum { TRIES = 8 };
    const double little = 1e-3, near = 10.0, alike = 0.1;
    pinch_static_model *model = m->model;
    int n = model->freedoms;
    double equilibrium[6], at[6], away[6];
    pinch_static_equilibrium(model, u, equilibrium);
    double force = pinch_norm(equilibrium, n), speed = m->softest * pinch_norm(m->velocity, n);
    m->most = fmax(m->most, force);
    if (force > little * m->most || (ramp->whole && *ramp->factor != ramp->goal)) return false;
    memcpy(at, u, (size_t)n * sizeof *u);
    if (!pinch_static_newton(model, m->settings, TRIES, at, m->total)) return false;
    for (int j = 0; j < n; j++) away[j] = at[j] - u[j];
    if (m->softest * pinch_norm(away, n) > near * force) return false;
    if (!ramp->whole && speed > fmax(little * m->most, ramp->per_step)) {
        if (!find_drift(m, ramp, at, away)) return false;
        for (int j = 0; j < n; j++) away[j] -= m->velocity[j] / m->part;
        if (m->softest * pinch_norm(away, n) > alike * speed) return false;
    }
    memcpy(u, at, (size_t)n * sizeof *u);
    return true;
}

/* Returns the load's factor one step later, of which `part` is taken. From nothing it grows with the square of time, as
 * the ramps of a run begin: what begins at once kicks an object away from its fingers. */
static double factor_after(const pinch_static_ramp *ramp, double part)
{
    double now = *ramp->factor, growth = part * ramp->per_step;
    if (!ramp->whole) return now + growth * ramp->goal;
    double root = sqrt(now / ramp->goal) + growth;
    return root * root * ramp->goal;
}

pinch_flow_outcome pinch_static_motion(pinch_static_model *model, const pinch_solver_settings *settings,
                                       const pinch_static_ramp *ramp, double mass, double *u, double *direction,
                                       pinch_solver_result *total)
{
    /* the steps under the full load, and then more of growing length: just beyond its limit a grasp gives way ever so
     * slowly */
    enum { STEPS = 3000, LONGER = 400, DOUBLING = 10 };
    int n = model->freedoms;
    motion m = {.model = model, .settings = settings, .part = 1.0, .total = total};
    memset(direction, 0, (size_t)n * sizeof *direction);
    if (pinch_static_is_bare(settings)) return PINCH_FLOW_UNDECIDED;
    pinch_static_stiffness_range(model, &m.softest, &m.stiffest);
    m.mass = mass * m.softest;
    double far_away = 1e4 / m.softest; /* as for the flow */
    for (int left = STEPS + LONGER; left > 0 && m.part > 1e-6;) {
        double before = *ramp->factor, after = factor_after(ramp, m.part);
        bool full = !(fabs(after) < fabs(ramp->goal));
        *ramp->factor = full ? ramp->goal : after;
        left -= full;
        if (!step(&m, u)) {
            *ramp->factor = before;
            change_step(&m, 0.5);
            continue;
        }
        if (pinch_norm(u, n) > far_away) {
            memcpy(direction, m.velocity, (size_t)n * sizeof *direction);
            return PINCH_FLOW_ESCAPED;
        }
        if (m.part < 1.0 || (left < LONGER && left % DOUBLING == 0)) change_step(&m, 2.0);
        if (is_at_rest(&m, ramp, u)) return PINCH_FLOW_SETTLED;
    }
    return PINCH_FLOW_UNDECIDED;
}
