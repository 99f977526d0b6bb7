#include "statics/assembly.h"
#include "statics/feasibility.h"
#include "statics/flow.h"
#include "statics/recover.h"
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

/* Iterations times fingers, some seconds: a hundred times what a hard grasp takes. A bare method has its own limit. */
static void allow_work(pinch_static_model *model, const pinch_statics_settings *settings)
{
    const long work = 10000000, least = 100000;
    if (!pinch_static_is_bare(&settings->solver)) model->work_left = work / model->count + least;
}

static void solve_displacements(pinch_static_model *model, const pinch_grasp *grasp,
                                const pinch_statics_settings *settings, pinch_finger_result *fingers,
                                pinch_statics_result *result)
{
    double u[6] = {0}, escape[6] = {0};
    long double exact[6];
    result->size = model->freedoms;
    allow_work(model, settings);
    pinch_flow_outcome outcome =
        pinch_static_search(model, settings, 1.0, true, u, &result->load_fraction, escape, &result->solve);
    if (outcome != PINCH_FLOW_SETTLED) {
        result->solve.status = PINCH_SOLVE_MAX_ITERATIONS;
        explain_failure(model, grasp, settings, outcome, escape, result);
        if (isnan(result->load_fraction)) {
            /* how far the wrench gets is a question of the load path, whatever the formulation */
            pinch_solver_result uncounted = {0};
            allow_work(model, settings);
            if (pinch_static_path(model, settings, 1.0, u, &result->load_fraction, escape, &uncounted) ==
                PINCH_FLOW_SETTLED)
                result->load_fraction = NAN;
        }
        return;
    }
    for (int j = 0; j < 6; j++) exact[j] = u[j];
    model->alpha = 0.0;
    result->solve.residual = pinch_static_refine(model, exact, PINCH_STATIC_REFINEMENTS);
    result->solve.status = PINCH_SOLVE_CONVERGED;
    pinch_static_recover(model, grasp, exact, fingers, result);
}

int pinch_statics_lcp_size(pinch_statics *statics, const pinch_grasp *grasp, const pinch_statics_settings *settings,
                           pinch_static_form form)
{
    if (pinch_static_check(statics, grasp, settings) != PINCH_OK || settings->formulation != PINCH_FORMULATION_LCP)
        return 0;
    if ((grasp->planar ? 3 : settings->faces) > statics->faces) return 0;
    pinch_static_model model;
    pinch_static_model_build(&model, statics->contacts, grasp, settings, settings->faithful && !settings->unit);
    pinch_static_layout layout = pinch_static_lay_out(&model);
    if (form == PINCH_FORM_MIXED) return layout.size;
    if (form == PINCH_FORM_SPLIT) return layout.size + layout.freedoms;
    pinch_static_assemble(&model, &layout, NULL, statics->mixed, statics->mixed_q, statics->free);
    bool exists = layout.size > layout.freedoms && pinch_static_condense(&layout, statics->mixed, statics->mixed_q,
                                                                         statics->m, statics->q, statics->back);
    return exists ? layout.size - layout.freedoms : 0;
}

pinch_status pinch_statics_lcp(pinch_statics *statics, const pinch_grasp *grasp, const pinch_statics_settings *settings,
                               pinch_static_form form, double *m, double *q, bool *free_rows)
{
    int size = pinch_statics_lcp_size(statics, grasp, settings, form);
    if (size == 0) return PINCH_INVALID_ARGUMENT;
    pinch_static_model model;
    pinch_static_model_build(&model, statics->contacts, grasp, settings, settings->faithful && !settings->unit);
    pinch_static_layout layout = pinch_static_lay_out(&model);
    pinch_static_assemble(&model, &layout, NULL, statics->mixed, statics->mixed_q, statics->free);
    for (int i = 0; i < size; i++) free_rows[i] = form == PINCH_FORM_MIXED && statics->free[i];
    if (form == PINCH_FORM_MIXED) {
        memcpy(m, statics->mixed, (size_t)size * (size_t)size * sizeof *m);
        memcpy(q, statics->mixed_q, (size_t)size * sizeof *q);
    } else if (form == PINCH_FORM_CONDENSED) {
        pinch_static_condense(&layout, statics->mixed, statics->mixed_q, m, q, statics->back);
    } else {
        pinch_static_split(&layout, statics->mixed, statics->mixed_q, m, q);
    }
    return PINCH_OK;
}

/* z of the mixed problem, u included, from that of the condensed (back) or split one. */
static void complete(const pinch_static_layout *layout, bool condensed, const double *back, double *z)
{
    int f = layout->freedoms, n = layout->size - f;
    for (int i = 0; i < f; i++) {
        if (!condensed) {
            z[n + i] -= z[n + f + i];
            continue;
        }
        const double *row = back + (size_t)i * (size_t)(n + 1);
        double sum = row[n];
        for (int j = 0; j < n; j++) sum += row[j] * z[j];
        z[n + i] = sum;
    }
}

/* The paper's form: condensed where it exists, u split in two non-negative parts otherwise. */
static pinch_lcp assemble(pinch_statics *s, const pinch_static_model *model, const pinch_static_layout *layout,
                          bool *condensed)
{
    pinch_static_assemble(model, layout, NULL, s->mixed, s->mixed_q, s->free);
    *condensed =
        layout->size > layout->freedoms && pinch_static_condense(layout, s->mixed, s->mixed_q, s->m, s->q, s->back);
    if (!*condensed) pinch_static_split(layout, s->mixed, s->mixed_q, s->m, s->q);
    int size = layout->size + (*condensed ? -layout->freedoms : layout->freedoms);
    return (pinch_lcp){.size = size, .m = s->m, .q = s->q};
}

static void solve_lcp(pinch_statics *s, pinch_static_model *model, const pinch_grasp *grasp,
                      const pinch_statics_settings *settings, pinch_finger_result *fingers,
                      pinch_statics_result *result)
{
    pinch_solver_settings inner = settings->solver;
    if (settings->faithful) {
        inner.tolerance = 1e-4;
        inner.goal = 0.0;
        inner.max_iterations = 20000;
        inner.newton_finish = false;
    }
    pinch_static_layout layout = pinch_static_lay_out(model);
    bool condensed;
    pinch_lcp lcp = assemble(s, model, &layout, &condensed);
    result->size = lcp.size;
    for (int i = 0; i < lcp.size; i++) s->z[i] = 0.0;
    pinch_lcp_solve(&lcp, &inner, s->lcp, s->z, s->w, &result->solve);
    if (result->solve.status != PINCH_SOLVE_CONVERGED) {
        double escape[6] = {0};
        if (!settings->faithful) explain_failure(model, grasp, settings, PINCH_FLOW_UNDECIDED, escape, result);
        return;
    }
    complete(&layout, condensed, s->back, s->z);
    long double u[6] = {0};
    for (int j = 0; j < layout.freedoms; j++) u[j] = s->z[layout.size - layout.freedoms + j];
    pinch_static_recover_object(model, grasp, u, result);
    for (int c = 0; c < model->count; c++) {
        double r[4], slip[3];
        pinch_static_read(model, &layout, s->z, c, r, slip);
        pinch_contact_state state = pinch_static_state(&model->contacts[c], r, slip, 10.0 * inner.tolerance);
        pinch_static_recover_finger(model, &grasp->fingers[c], &model->contacts[c], r, slip, slip, state, &fingers[c]);
    }
    result->load_fraction = 1.0;
}

pinch_status pinch_statics_solve(pinch_statics *statics, const pinch_grasp *grasp,
                                 const pinch_statics_settings *settings, pinch_finger_result *fingers,
                                 pinch_statics_result *result)
{
    pinch_status status = pinch_static_check(statics, grasp, settings);
    if (status == PINCH_OK) status = pinch_static_check_method(statics, grasp, settings);
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
    pinch_statics_verify(grasp, settings, fingers, result, &result->verification);
    pinch_static_stiffness(&model, grasp, fingers, result->stiffness);
    if (!result->verification.passed && !settings->faithful) {
        pinch_static_verification refused = result->verification;
        pinch_static_forget(grasp->finger_count, fingers, result);
        result->solve.status = PINCH_SOLVE_UNVERIFIED;
        result->verification = refused;
    }
    return PINCH_OK;
}
