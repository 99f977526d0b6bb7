#include "statics/flow.h"

#include <math.h>
#include <string.h>

/* Newton steps that a load step may take before it counts as too long. */
enum { NEWTON_STEPS = 12 };

static const size_t REST_SIZE = 3 * sizeof(double);

/* What a load step does to the state; on refusal the state is as it was. */
typedef enum step_verdict { STEP_GOOD, STEP_TOO_LONG } step_verdict;

/* One phase of the path: closing, or the wrench. */
typedef struct phase {
    pinch_static_model *model;
    pinch_solver_settings solver;
    double tolerance; /* of the tangential springs' forces, per load step */
    double *factor;   /* the model's, taken from 0 to goal */
    double goal;
    double *u, *rate; /* rate: of u along the phase, from the last step */
    double *direction;
    pinch_solver_result *total;
} phase;

static void save(pinch_static_model *model)
{
    for (int c = 0; c < model->count; c++) memcpy(model->contacts[c].saved, model->contacts[c].rest, REST_SIZE);
}

static void restore(pinch_static_model *model)
{
    for (int c = 0; c < model->count; c++) memcpy(model->contacts[c].rest, model->contacts[c].saved, REST_SIZE);
}

/*
 * The equilibrium at `next` with the state at `done` in u: by Newton from where the last step's motion would lead,
 * which keeps to the branch the path is on, from u itself, or where the object settles when it is let go there.
 */
static bool settle_at(const phase *p, double done, double next, bool may_flow, double *u)
{
    double at[6];
    *p->factor = p->goal * next;
    for (int j = 0; j < 6; j++) at[j] = u[j] + p->rate[j] * (next - done);
    bool settled = pinch_static_newton(p->model, &p->solver, NEWTON_STEPS, at, p->total);
    if (!settled) {
        memcpy(at, u, sizeof at);
        settled = pinch_static_newton(p->model, &p->solver, NEWTON_STEPS, at, p->total);
    }
    if (!settled && may_flow)
        settled = pinch_static_flow(p->model, &p->solver, false, 0.5, at, p->direction, p->total) == PINCH_FLOW_SETTLED;
    if (settled) memcpy(u, at, sizeof at);
    return settled;
}

/* By how much the springs' forces differ between the rest now and `coarse`; torsion counts over its lever. */
static double coarse_error(const pinch_static_model *model)
{
    double worst = 0.0;
    for (int c = 0; c < model->count; c++) {
        const pinch_static_contact *contact = &model->contacts[c];
        for (int i = 1; i < contact->rows; i++)
            worst = fmax(worst, contact->k[i] * fabs(contact->rest[i - 1] - contact->coarse[i - 1]));
    }
    return worst;
}

/*
 * The slip of one step of backward Euler is wrong by c h^2 per step, that of two half steps by half as much: their
 * difference is the error of the better one, and adding it once more cancels it. What is reported at the end of a phase
 * is not extrapolated, so that it obeys the friction law to rounding.
 */
static void extrapolate(pinch_static_model *model)
{
    for (int c = 0; c < model->count; c++) {
        pinch_static_contact *contact = &model->contacts[c];
        if (contact->open || contact->coarse_open) continue; /* no slip there: rest follows the object */
        for (int i = 0; i < 3; i++) contact->rest[i] += contact->rest[i] - contact->coarse[i];
    }
}

/*
 * From `done` to `next` in one step and in two halves. Good: u and rest are those of the halves, the slip of the second
 * half committed and extrapolated unless `last`. *error: estimate of the slip's error.
 */
static step_verdict try_step(const phase *p, double done, double next, bool last, double *error)
{
    pinch_static_model *model = p->model;
    double coarse[6], fine[6];
    bool controlled = p->tolerance < INFINITY;
    save(model);
    memcpy(coarse, p->u, sizeof coarse);
    *error = 0.0;
    /* over a long step the flow might settle in another equilibrium than the path leads to */
    bool may_flow = next - done <= 1.0 / 64.0;
    if (!settle_at(p, done, next, may_flow, coarse)) return STEP_TOO_LONG;
    if (!controlled) {
        memcpy(p->u, coarse, sizeof coarse);
        if (!last) pinch_static_commit(model, p->u);
        return STEP_GOOD;
    }
    pinch_static_commit(model, coarse);
    for (int c = 0; c < model->count; c++) {
        memcpy(model->contacts[c].coarse, model->contacts[c].rest, REST_SIZE);
        model->contacts[c].coarse_open = model->contacts[c].open;
    }
    restore(model);

    memcpy(fine, p->u, sizeof fine);
    bool solved = settle_at(p, done, 0.5 * (done + next), may_flow, fine);
    double middle[6];
    if (solved) {
        pinch_static_commit(model, fine);
        memcpy(middle, fine, sizeof middle);
        solved = settle_at(p, 0.5 * (done + next), next, may_flow, fine);
    }
    if (!solved) {
        restore(model);
        return STEP_TOO_LONG;
    }
    /* a second save would lose the first: the middle's rest is found again from its u */
    pinch_static_commit(model, fine);
    *error = coarse_error(model);
    if (*error > p->tolerance) {
        restore(model);
        return STEP_TOO_LONG;
    }
    memcpy(p->u, fine, sizeof fine);
    if (!last) {
        extrapolate(model);
        return STEP_GOOD;
    }
    restore(model);
    *p->factor = p->goal * 0.5 * (done + next);
    pinch_static_commit(model, middle);
    *p->factor = p->goal * next;
    return STEP_GOOD;
}

/*
 * Where even a short step finds no equilibrium next to the last one: what does the object do when it is let go there?
 * It slides on with the slip of every moment kept; where that motion cannot be followed, the flow that counts all slip
 * at once decides.
 */
static pinch_flow_outcome let_go(const phase *p, double next)
{
    enum { FLOWS = 4 };
    static const double SHRINK[FLOWS] = {0.8, 0.5, 0.8, 0.25};
    pinch_static_model *model = p->model;
    double at[6];
    save(model);
    *p->factor = p->goal * next;
    pinch_flow_outcome outcome = PINCH_FLOW_UNDECIDED;
    for (int i = 0; i < FLOWS && outcome == PINCH_FLOW_UNDECIDED; i++) {
        restore(model);
        memcpy(at, p->u, sizeof at);
        outcome = pinch_static_flow(model, &p->solver, i == 0, SHRINK[i], at, p->direction, p->total);
    }
    if (outcome == PINCH_FLOW_SETTLED)
        memcpy(p->u, at, sizeof at);
    else
        restore(model);
    return outcome;
}

/* Takes the phase's factor from 0 to its goal in at least `steps` steps. *reached: part of the goal. */
static pinch_flow_outcome load(const phase *p, int steps, bool from_nothing, double *reached)
{
    /* below the first a failed Newton means a limit point; below the second nothing new is learnt about where it is,
     * and slip that still changes from halving to halving is taken as it comes */
    const double short_step = 1e-3, shortest = 1e-4;
    double longest = 1.0 / steps, step = longest, done = 0.0, error, before[6];
    *reached = 0.0;
    memset(p->rate, 0, 6 * sizeof *p->rate);
    if (from_nothing) {
        /* all forces grow from zero in proportion, so the first step decides which of several equilibria is followed;
         * it is short, lest the way into equilibrium leave its slip behind */
        double at[6];
        memcpy(at, p->u, sizeof at);
        save(p->model);
        *p->factor = p->goal * short_step;
        if (pinch_static_settle(p->model, &p->solver, at, p->total)) {
            for (int j = 0; j < 6; j++) p->rate[j] = (at[j] - p->u[j]) / short_step;
            memcpy(p->u, at, sizeof at);
            pinch_static_commit(p->model, p->u);
            done = short_step;
            step = 4.0 * short_step;
        } else {
            restore(p->model);
        }
    }
    while (done < 1.0) {
        double next = done + step >= 1.0 - 0.5 * shortest ? 1.0 : done + step;
        bool last = next == 1.0;
        memcpy(before, p->u, sizeof before);
        phase attempt = *p;
        if (step <= short_step) attempt.tolerance = INFINITY;
        if (try_step(&attempt, done, next, last, &error) == STEP_GOOD) {
            for (int j = 0; j < 6; j++) p->rate[j] = (p->u[j] - before[j]) / (next - done);
            *reached = done = next;
            double growth = error > 0.0 ? 0.9 * sqrt(p->tolerance / error) : 4.0;
            step = fmin(step * fmin(fmax(growth, 0.25), 4.0), longest);
            continue;
        }
        bool inaccurate = error > p->tolerance;
        if (inaccurate || step > short_step) {
            double growth = inaccurate ? 0.9 * sqrt(p->tolerance / error) : 0.25;
            step = fmax(step * fmin(fmax(growth, 0.1), 0.5), short_step);
            continue;
        }
        pinch_flow_outcome outcome = let_go(p, next);
        if (outcome == PINCH_FLOW_SETTLED) {
            memset(p->rate, 0, 6 * sizeof *p->rate); /* a jump leads nowhere further */
            *reached = done = next;
            if (!last) pinch_static_commit(p->model, p->u);
            continue;
        }
        if (step <= shortest) return outcome;
        step *= 0.25;
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
    phase p = {.model = model,
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
    if (settings->formulation == PINCH_FORMULATION_COULOMB && !settings->one_step)
        return pinch_static_path(model, settings, wrench_goal, u, fraction, escape, total);
    model->closing_factor = 1.0;
    model->wrench_factor = wrench_goal;
    pinch_flow_outcome outcome = pinch_static_one_step(model, &settings->solver, u, thorough, escape, total);
    *fraction = outcome == PINCH_FLOW_SETTLED ? 1.0 : NAN;
    return outcome;
}
