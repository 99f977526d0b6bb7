#include "statics/load_step.h"

#include <math.h>
#include <string.h>

static const size_t REST_SIZE = 3 * sizeof(double);

/*
 * The object where even the shortest step finds no equilibrium next to the last one: it moves as it would under the
 * load that goes on growing, as slowly as the tests' slow motions, and where it comes to rest the path goes on. How it
 * moves is not the statics' to say: only what escapes both swinging and creeping has escaped. Where neither motion can
 * be followed, viscous flows decide. *next: where the load has got to.
 */
static pinch_flow_outcome let_go(const pinch_static_phase *p, double done, double *next)
{
    enum { MOTIONS = 2, FLOWS = 4 };
    static const double MASS[MOTIONS] = {0.1, 10.0}, SHRINK[FLOWS] = {0.8, 0.5, 0.8, 0.25};
    const pinch_static_ramp ramp = {p->factor, p->goal, 1.0 / 6000.0, false};
    pinch_static_model *model = p->model;
    double at[6], way[6];
    pinch_flow_outcome outcome = PINCH_FLOW_UNDECIDED, one = PINCH_FLOW_UNDECIDED;
    pinch_static_save(model);
    for (int i = 0; i < MOTIONS && one != PINCH_FLOW_SETTLED; i++) {
        pinch_static_restore(model);
        memcpy(at, p->u, sizeof at);
        *p->factor = p->goal * done;
        one = pinch_static_motion(model, &p->solver, &ramp, MASS[i], at, way, p->total);
        if (one == PINCH_FLOW_ESCAPED && outcome != one)
            memcpy(p->direction, way, (size_t)model->freedoms * sizeof *way);
        if (one != PINCH_FLOW_UNDECIDED) outcome = one;
    }
    if (outcome == PINCH_FLOW_SETTLED && p->goal != 0.0) *next = *p->factor / p->goal;
    *p->factor = p->goal * *next;
    for (int i = 0; i < FLOWS && outcome == PINCH_FLOW_UNDECIDED; i++) {
        pinch_static_restore(model);
        memcpy(at, p->u, sizeof at);
        outcome = pinch_static_flow(model, &p->solver, i == 0, SHRINK[i], at, p->direction, p->total);
    }
    if (outcome == PINCH_FLOW_SETTLED)
        memcpy(p->u, at, sizeof at);
    else
        pinch_static_restore(model);
    return outcome;
}

/*
 * From nothing all loads grow in proportion, and so may the answer: with every force's direction at rest, the slip of
 * the whole way is that of one step from the undeformed state. That state is the path's own, to rounding, if what the
 * object does first leads to it; the slip left behind on the way there would fade only as fast as the load grows.
 */
static bool start_on_ray(const pinch_static_phase *p, double *u)
{
    const double near = 0.1;
    pinch_static_model *model = p->model;
    double at[6], away = 0.0, size = 0.0;
    pinch_static_save(model);
    for (int c = 0; c < model->count; c++) memset(model->contacts[c].rest, 0, REST_SIZE);
    memcpy(at, u, sizeof at);
    bool found = pinch_static_newton(model, &p->solver, PINCH_STATIC_LOAD_NEWTON_STEPS, at, p->total);
    for (int j = 0; j < model->freedoms; j++) {
        away = fmax(away, fabs(at[j] - u[j]));
        size = fmax(size, fabs(u[j]));
    }
    found = found && away <= near * size;
    if (found)
        memcpy(u, at, sizeof at);
    else
        pinch_static_restore(model);
    pinch_static_commit(model, u);
    return found;
}

/*
 * All forces grow from zero in proportion, so what the object does first decides which of several equilibria is
 * followed. It is set in motion by a load that grows from nothing to `part` of the goal and slides to rest there; where
 * that does not end, it settles as through honey. Returns the part reached, 0 for none; *step: how far to go on.
 */
static double start_from_nothing(const pinch_static_phase *p, double part, double *step)
{
    pinch_static_model *model = p->model;
    const pinch_static_ramp ramp = {p->factor, p->goal * part, 1.0 / 300.0, true};
    double at[6], way[6];
    memcpy(at, p->u, sizeof at);
    pinch_static_save(model);
    *p->factor = 0.0;
    bool settled = pinch_static_motion(model, &p->solver, &ramp, 10.0, at, way, p->total) == PINCH_FLOW_SETTLED;
    if (!settled) {
        pinch_static_restore(model);
        memcpy(at, p->u, sizeof at);
        *p->factor = p->goal * part;
        settled = pinch_static_settle(model, &p->solver, at, p->total);
    }
    if (!settled) {
        memset(p->u, 0, sizeof at);
        for (int c = 0; c < model->count; c++) memset(model->contacts[c].rest, 0, REST_SIZE);
        return 0.0;
    }
    bool on_ray = start_on_ray(p, at);
    for (int j = 0; j < 6 && on_ray; j++) p->rate[j] = (at[j] - p->u[j]) / part;
    *step = on_ray ? 4.0 * part : 0.25 * part;
    memcpy(p->u, at, sizeof at);
    return part;
}

/* The next length of a step that was wrong by `error`. */
static double fit_step(const pinch_static_phase *p, double step, double error, double least, double most)
{
    double growth = error > 0.0 ? 0.9 * sqrt(p->tolerance / error) : most;
    return step * fmin(fmax(growth, least), most);
}

/* Takes the phase's factor from 0 to its goal in at least `steps` steps. *reached: part of the goal. */
static pinch_flow_outcome load(const pinch_static_phase *p, int steps, bool from_nothing, double *reached)
{
    /* the shortest step: there a failed Newton means a limit point, and slip that still changes from halving to halving
     * is taken as it comes */
    const double first_step = 1e-3, finest = 1e-6;
    double longest = 1.0 / steps, step = longest, done = 0.0, error, before[6];
    memset(p->rate, 0, 6 * sizeof *p->rate);
    if (from_nothing) done = start_from_nothing(p, first_step, &step);
    *reached = done;
    while (done < 1.0) {
        double next = done + step >= 1.0 - finest ? 1.0 : done + step;
        memcpy(before, p->u, sizeof before);
        pinch_static_phase attempt = *p;
        if (step <= finest) attempt.tolerance = INFINITY;
        if (pinch_static_load_step(&attempt, done, next, next == 1.0, &error)) {
            for (int j = 0; j < 6; j++) p->rate[j] = (p->u[j] - before[j]) / (next - done);
            *reached = done = next;
            step = fmin(fit_step(p, step, error, 0.25, 4.0), longest);
            continue;
        }
        if (error > p->tolerance) {
            step = fmax(fit_step(p, step, error, 0.1, 0.5), finest);
            continue;
        }
        if (step > finest) {
            step = fmax(0.25 * step, finest);
            continue;
        }
        if (p->model->work_left <= 0) return PINCH_FLOW_UNDECIDED;
        pinch_flow_outcome outcome = let_go(p, done, &next);
        if (outcome != PINCH_FLOW_SETTLED) return outcome;
        memset(p->rate, 0, 6 * sizeof *p->rate); /* a jump leads nowhere further */
        *reached = done = next;
        if (done < 1.0) pinch_static_commit(p->model, p->u);
    }
    return PINCH_FLOW_SETTLED;
}

static bool has_wrench(const pinch_static_model *model)
{
    for (int j = 0; j < model->freedoms; j++)
        if (model->wrench[j] != 0.0) return true;
    return false;
}

static bool has_closing(const pinch_static_model *model)
{
    for (int c = 0; c < model->count; c++)
        if (model->contacts[c].controlled ? model->contacts[c].normal_force > 0.0 : model->contacts[c].closing != 0.0)
            return true;
    return false;
}

pinch_flow_outcome pinch_static_path(pinch_static_model *model, const pinch_statics_settings *settings,
                                     double wrench_goal, double *u, double *fraction, double *direction,
                                     pinch_solver_result *total)
{
    double rate[6];
    pinch_static_phase p = {.model = model,
                            .solver = settings->solver,
                            .tolerance = settings->path_tolerance,
                            .u = u,
                            .rate = rate,
                            .direction = direction,
                            .total = total};
    /* between load steps the tolerance is enough; the last state is refined by the caller */
    p.solver.tolerance = fmax(settings->solver.tolerance, 1e-10);
    p.solver.goal = p.solver.tolerance;
    memset(u, 0, 6 * sizeof *u);
    for (int c = 0; c < model->count; c++) memset(model->contacts[c].rest, 0, REST_SIZE);
    model->closing_factor = 1.0;
    model->wrench_factor = 0.0;
    *fraction = 0.0;
    if (has_closing(model)) {
        double closed;
        p.factor = &model->closing_factor;
        p.goal = 1.0;
        pinch_flow_outcome outcome = load(&p, settings->path_steps, true, &closed);
        if (outcome != PINCH_FLOW_SETTLED) return outcome;
        pinch_static_commit(model, u);
    }
    p.factor = &model->wrench_factor;
    p.goal = wrench_goal;
    return load(&p, has_wrench(model) && wrench_goal != 0.0 ? settings->path_steps : 1, !has_closing(model), fraction);
}

bool pinch_static_uses_displacements(const pinch_statics_settings *settings)
{
    if (settings->formulation == PINCH_FORMULATION_COULOMB) return true;
    return settings->solver.solver == PINCH_SOLVER_NSNMGK && settings->solver.newton_finish && !settings->faithful;
}

pinch_flow_outcome pinch_static_search(pinch_static_model *model, const pinch_statics_settings *settings,
                                       double wrench_goal, bool thorough, double *u, double *fraction, double *escape,
                                       pinch_solver_result *total)
{
    bool path = settings->formulation == PINCH_FORMULATION_COULOMB && !settings->one_step;
    pinch_flow_outcome outcome;
    if (path) {
        outcome = pinch_static_path(model, settings, wrench_goal, u, fraction, escape, total);
    } else {
        model->closing_factor = 1.0;
        model->wrench_factor = wrench_goal;
        outcome = pinch_static_one_step(model, &settings->solver, u, thorough, escape, total);
        *fraction = outcome == PINCH_FLOW_SETTLED ? 1.0 : NAN;
    }
    /* what has escaped one way might have settled another that was not tried to its end */
    if (outcome == PINCH_FLOW_ESCAPED && model->work_left <= 0) outcome = PINCH_FLOW_UNDECIDED;
    return outcome;
}
