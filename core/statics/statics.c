/* Solves the static grasp, and keeps the memory for it. */
#include "statics/feasibility.h"
#include "statics/flow.h"
#include "statics/results.h"
#include "statics/workspace.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

pinch_statics_settings pinch_default_statics_settings(void)
{
    return (pinch_statics_settings){
        .solver = pinch_default_solver_settings(), .faces = 8, .path_steps = 8, .path_tolerance = 1e-4};
}

static bool create_lcp(pinch_statics *s)
{
    /* per finger: normal force, facets (a soft finger's two more), force limit; and u, split */
    size_t n = (size_t)s->fingers * (size_t)(s->faces + 4) + 12;
    if (n > 10000) return false;
    s->unknowns = (int)n;
    s->mixed = malloc((2 * n * n + 4 * n + 6 * (n + 1)) * sizeof(double));
    s->free = malloc(n * sizeof *s->free);
    if (!s->mixed || !s->free || pinch_lcp_workspace_create(s->unknowns, &s->lcp) != PINCH_OK) return false;
    s->m = s->mixed + n * n;
    s->mixed_q = s->m + n * n;
    s->q = s->mixed_q + n;
    s->z = s->q + n;
    s->w = s->z + n;
    s->back = s->w + n;
    return true;
}

pinch_status pinch_statics_create(int fingers, int faces, pinch_statics **statics)
{
    if (!statics) return PINCH_INVALID_ARGUMENT;
    *statics = NULL;
    if (fingers < 1 || faces < 0 || faces > 4096) return PINCH_INVALID_ARGUMENT;
    pinch_statics *s = calloc(1, sizeof *s);
    if (!s) return PINCH_OUT_OF_MEMORY;
    s->fingers = fingers;
    s->faces = faces;
    s->contacts = malloc((size_t)fingers * sizeof *s->contacts);
    s->scaled = malloc((size_t)fingers * sizeof *s->scaled);
    s->results = malloc((size_t)fingers * sizeof *s->results);
    if (!s->contacts || !s->scaled || !s->results || (faces > 0 && !create_lcp(s))) {
        pinch_statics_destroy(s);
        return PINCH_OUT_OF_MEMORY;
    }
    *statics = s;
    return PINCH_OK;
}

void pinch_statics_destroy(pinch_statics *statics)
{
    if (!statics) return;
    pinch_lcp_workspace_destroy(statics->lcp);
    free(statics->contacts);
    free(statics->scaled);
    free(statics->results);
    free(statics->mixed);
    free(statics->free);
    free(statics);
}

/* Why does nothing hold the object? Sets status and twist; `outcome` and `escape` tell how the search ended. */
static void explain_failure(pinch_static_model *model, const pinch_grasp *grasp, const pinch_statics_settings *settings,
                            pinch_flow_outcome outcome, const double *escape, pinch_statics_result *result)
{
    model->closing_factor = model->wrench_factor = 1.0;
    pinch_feasibility feasible = pinch_static_feasibility(model, grasp, settings, result->twist);
    if (feasible == PINCH_INFEASIBLE) result->solve.status = PINCH_SOLVE_INFEASIBLE;
    if (feasible == PINCH_FEASIBLE && outcome == PINCH_FLOW_ESCAPED) {
        pinch_static_twist(model, grasp, escape, result->twist);
        result->solve.status = PINCH_SOLVE_UNSTABLE;
    }
}

/* The work is counted as iterations times fingers and comes to some seconds, a hundred times what a hard grasp takes. A
 * bare method has its own limit. */
static void allow_work(pinch_static_model *model, const pinch_statics_settings *settings)
{
    const long work = 10000000, least = 100000;
    if (!pinch_static_is_bare(&settings->solver)) model->work_left = work / model->count + least;
}

/*
 * Refines u in twice the precision. Where fingers are between sticking and slipping, as they may stay while all forces
 * grow in proportion, it may lead no further; there the solver takes what the search has left, which is as little as
 * rounding lets it. Returns the residual.
 */
static double refine(pinch_static_model *model, const pinch_solver_settings *settings, const double *u,
                     pinch_double_double exact[6], pinch_solver_result *total)
{
    const double little = 1e-13;
    double at[6];
    for (int j = 0; j < 6; j++) exact[j] = (pinch_double_double){at[j] = u[j], 0};
    model->alpha = 0.0;
    double residual = pinch_static_refine(model, exact, PINCH_STATIC_REFINEMENTS);
    if (residual <= little) return residual;
    pinch_solver_settings closer = *settings;
    closer.tolerance = closer.goal = little;
    if (!pinch_static_newton(model, &closer, PINCH_STATIC_LOAD_NEWTON_STEPS, at, total)) return residual;
    pinch_double_double other[6];
    for (int j = 0; j < 6; j++) other[j] = (pinch_double_double){at[j], 0};
    double left = pinch_static_refine(model, other, PINCH_STATIC_REFINEMENTS);
    if (!(left < residual)) return residual;
    memcpy(exact, other, sizeof other);
    return left;
}

static void solve_displacements(pinch_static_model *model, const pinch_grasp *grasp,
                                const pinch_statics_settings *settings, pinch_finger_result *fingers,
                                pinch_statics_result *result)
{
    double u[6] = {0}, escape[6] = {0};
    pinch_double_double exact[6];
    result->size = model->freedoms;
    allow_work(model, settings);
    pinch_flow_outcome outcome =
        pinch_static_search(model, settings, true, u, &result->load_fraction, escape, &result->solve);
    if (outcome != PINCH_FLOW_SETTLED) {
        result->solve.status = PINCH_SOLVE_MAX_ITERATIONS;
        explain_failure(model, grasp, settings, outcome, escape, result);
        if (isnan(result->load_fraction)) {
            /* how far the wrench gets is a question of the load path, whatever the formulation */
            pinch_solver_result uncounted = {0};
            allow_work(model, settings);
            if (pinch_static_path(model, settings, u, &result->load_fraction, escape, &uncounted) == PINCH_FLOW_SETTLED)
                result->load_fraction = NAN;
        }
        return;
    }
    result->solve.residual = refine(model, &settings->solver, u, exact, &result->solve);
    result->solve.status = PINCH_SOLVE_CONVERGED;
    pinch_static_recover(model, grasp, exact, fingers, result);
}

static void solve_lcp(pinch_statics *statics, pinch_static_model *model, const pinch_grasp *grasp,
                      const pinch_statics_settings *settings, pinch_finger_result *fingers,
                      pinch_statics_result *result)
{
    const double nowhere[6] = {0};
    pinch_static_solve_lcp(statics, model, grasp, settings, fingers, result);
    if (result->solve.status != PINCH_SOLVE_CONVERGED && !settings->faithful)
        explain_failure(model, grasp, settings, PINCH_FLOW_UNDECIDED, nowhere, result);
}

/*
 * Takes back an answer that is not verified. Where its displacements are a hundred million times the object, the search
 * has followed an escape for so long that the forces are rounding of the displacements, and the escape is the answer.
 */
static void refuse(pinch_static_model *model, const pinch_grasp *grasp, const pinch_statics_settings *settings,
                   pinch_finger_result *fingers, pinch_statics_result *result)
{
    static const double FAR = 1e8;
    const double nowhere[6] = {0};
    pinch_static_verification refused = result->verification;
    double twist[6], way2 = 0.0; /* in the metric of result->twist */
    for (int j = 0; j < 3; j++) {
        twist[j] = result->translation[j];
        twist[3 + j] = result->rotation[j];
        way2 += twist[j] * twist[j] + grasp->radius * grasp->radius * twist[3 + j] * twist[3 + j];
    }
    pinch_static_forget(grasp->finger_count, fingers, result);
    result->verification = refused;
    result->load_fraction = NAN;
    result->solve.status = PINCH_SOLVE_UNVERIFIED;
    if (!(way2 > FAR * FAR * grasp->radius * grasp->radius)) return;
    explain_failure(model, grasp, settings, PINCH_FLOW_ESCAPED, nowhere, result);
    if (result->solve.status != PINCH_SOLVE_UNSTABLE) return;
    for (int j = 0; j < 6; j++) result->twist[j] = twist[j] / sqrt(way2);
}

pinch_status pinch_statics_solve(pinch_statics *statics, const pinch_grasp *grasp,
                                 const pinch_statics_settings *settings, pinch_finger_result *fingers,
                                 pinch_statics_result *result)
{
    if (!fingers || !result) return PINCH_INVALID_ARGUMENT;
    pinch_status status = pinch_static_validate(statics, grasp, settings);
    if (status == PINCH_OK) status = pinch_static_validate_method(statics, grasp, settings);
    if (status != PINCH_OK) return status;

    pinch_static_model model;
    pinch_static_model_build(&model, statics->contacts, grasp, settings, settings->faithful && !settings->unit);
    *result = (pinch_statics_result){.load_fraction = NAN};
    if (pinch_static_uses_displacements(settings))
        solve_displacements(&model, grasp, settings, fingers, result);
    else
        solve_lcp(statics, &model, grasp, settings, fingers, result);

    if (result->solve.status != PINCH_SOLVE_CONVERGED) {
        pinch_static_forget(grasp->finger_count, fingers, result);
        return PINCH_OK;
    }
    pinch_static_slide(grasp, fingers, result);
    pinch_statics_verify(grasp, settings, fingers, result, &result->verification);
    pinch_static_stiffness(&model, grasp, fingers, result->stiffness);
    if (!result->verification.passed && !settings->faithful) refuse(&model, grasp, settings, fingers, result);
    return PINCH_OK;
}
