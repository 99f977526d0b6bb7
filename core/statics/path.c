#include "statics/flow.h"

#include <math.h>
#include <string.h>

/* The state a load step starts from, to come back to when the step is too long. */
static void save(pinch_static_model *model)
{
    for (int c = 0; c < model->count; c++)
        memcpy(model->contacts[c].saved, model->contacts[c].rest, sizeof model->contacts[c].rest);
}

static void restore(pinch_static_model *model)
{
    for (int c = 0; c < model->count; c++)
        memcpy(model->contacts[c].rest, model->contacts[c].saved, sizeof model->contacts[c].rest);
}

/*
 * One load step at the model's factors: Newton from the last state; otherwise the flow from there, which counts all
 * slip of the step at once as the load step does; and where that cannot tell, the flow that keeps the slip of each of
 * its steps.
 */
static pinch_flow_outcome load_step(pinch_static_model *model, const pinch_solver_settings *settings, double *u,
                                    double *direction, pinch_solver_result *total)
{
    enum { NEWTON_STEPS = 12, FLOWS = 3 };
    static const double SHRINK[FLOWS] = {0.5, 0.8, 0.25};
    if (pinch_static_newton(model, settings, NEWTON_STEPS, u, total)) return PINCH_FLOW_SETTLED;
    double at[6];
    for (int i = 0; i < FLOWS; i++) {
        memcpy(at, u, sizeof at);
        pinch_flow_outcome outcome = pinch_static_flow(model, settings, false, SHRINK[i], at, direction, total);
        if (outcome == PINCH_FLOW_UNDECIDED) continue;
        memcpy(u, at, sizeof at);
        return outcome;
    }
    return pinch_static_flow(model, settings, true, 0.5, u, direction, total);
}

/*
 * Takes *factor (of the model: closing or wrench) from 0 to goal. The slip of a step is committed before the next one
 * starts; the last step's is left to the caller, who still has to refine and read it. *reached: part of the goal.
 */
static pinch_flow_outcome load(pinch_static_model *model, const pinch_solver_settings *settings, int steps,
                               double *factor, double goal, double *u, double *reached, double *direction,
                               pinch_solver_result *total)
{
    /* shorter load steps than this tell nothing new about where the object is lost */
    const double shortest = 1e-4;
    double longest = 1.0 / steps, step = longest, done = 0.0;
    while (done < 1.0) {
        double at[6], next = done + step >= 1.0 - 0.5 * shortest ? 1.0 : done + step;
        memcpy(at, u, sizeof at);
        *factor = goal * next;
        save(model);
        pinch_flow_outcome outcome = load_step(model, settings, at, direction, total);
        if (outcome == PINCH_FLOW_SETTLED) {
            memcpy(u, at, sizeof at);
            done = next;
            step = fmin(2.0 * step, longest);
            if (done < 1.0) pinch_static_commit(model, u);
            continue;
        }
        restore(model);
        *reached = done;
        step *= 0.5;
        if (step < shortest) return outcome;
    }
    *reached = 1.0;
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

pinch_flow_outcome pinch_static_path(pinch_static_model *model, const pinch_solver_settings *settings, int steps,
                                     double wrench_goal, double *u, double *fraction, double *direction,
                                     pinch_solver_result *total)
{
    /* between load steps the tolerance is enough; the last state is refined by the caller */
    pinch_solver_settings inner = *settings;
    inner.tolerance = fmax(settings->tolerance, 1e-10);
    inner.goal = inner.tolerance;
    memset(u, 0, 6 * sizeof *u);
    for (int c = 0; c < model->count; c++) memset(model->contacts[c].rest, 0, sizeof model->contacts[c].rest);
    model->closing_factor = 1.0;
    model->wrench_factor = 0.0;
    *fraction = 0.0;
    if (has_closing(model)) {
        double closed;
        pinch_flow_outcome outcome =
            load(model, &inner, steps, &model->closing_factor, 1.0, u, &closed, direction, total);
        if (outcome != PINCH_FLOW_SETTLED) return outcome;
        pinch_static_commit(model, u);
    }
    if (!has_wrench(model)) steps = 1;
    return load(model, &inner, steps, &model->wrench_factor, wrench_goal, u, fraction, direction, total);
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
        return pinch_static_path(model, &settings->solver, settings->path_steps, wrench_goal, u, fraction, escape,
                                 total);
    model->closing_factor = 1.0;
    model->wrench_factor = wrench_goal;
    pinch_flow_outcome outcome = pinch_static_one_step(model, &settings->solver, u, thorough, escape, total);
    *fraction = outcome == PINCH_FLOW_SETTLED ? 1.0 : NAN;
    return outcome;
}
