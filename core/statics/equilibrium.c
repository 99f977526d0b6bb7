#include "statics/model.h"

#include "support/lu.h"

#include <math.h>
#include <string.h>

/*
 * Equations (41) and (42) of core/README.md: F(u) = R(u) - alpha K_ref (u - anchor),   R = sum W r(W^T u) + wrench
 * V = dF/du = -(sum W D W^T + alpha K_ref),  D = -dr/dw
 */

/* model->tangent = sum W D W^T + alpha K_ref from D of each contact, given one after the other. */
static void add_tangent(pinch_static_model *model, const pinch_static_contact *contact, const double d[16])
{
    int m = model->freedoms;
    for (int i = 0; i < contact->rows; i++) {
        double dw[6] = {0};
        for (int j = 0; j < contact->rows; j++) {
            if (d[4 * i + j] == 0.0) continue;
            for (int b = 0; b < m; b++) dw[b] += d[4 * i + j] * contact->w[j][b];
        }
        for (int a = 0; a < m; a++)
            for (int b = 0; b < m; b++) model->tangent[a * m + b] += contact->w[i][a] * dw[b];
    }
}

static void start_tangent(pinch_static_model *model)
{
    int m = model->freedoms;
    for (int i = 0; i < m * m; i++) model->tangent[i] = model->inertial ? 0.0 : model->alpha * model->reference[i];
    for (int i = 0; i < m && model->inertial; i++) model->tangent[i * m + i] = model->alpha;
}

/*
 * Where the fingers that touch leave the object free to move, the tangent is singular. A billionth of the reference
 * stiffness then takes the step that moves it least in the free directions and solves the others to nine digits.
 */
static bool factor_tangent(pinch_static_model *model)
{
    const double little = 1e-9;
    memcpy(model->lu, model->tangent, sizeof model->lu);
    if (pinch_lu_factor(model->freedoms, model->lu, model->pivot, model->scratch)) return true;
    pinch_static_build_reference(model);
    for (int i = 0; i < model->freedoms * model->freedoms; i++)
        model->lu[i] = model->tangent[i] + little * model->reference[i];
    return pinch_lu_factor(model->freedoms, model->lu, model->pivot, model->scratch);
}

static void residual(void *self, const double *u, double *f)
{
    const pinch_static_model *model = self;
    int m = model->freedoms;
    pinch_static_equilibrium(model, u, f);
    if (model->alpha == 0.0) return;
    for (int i = 0; i < m && model->inertial; i++) f[i] -= model->alpha * (u[i] - model->anchor[i]);
    for (int i = 0; i < m && !model->inertial; i++)
        for (int j = 0; j < m; j++) f[i] -= model->alpha * model->reference[i * m + j] * (u[j] - model->anchor[j]);
}

/* Every row needs every contact: one row costs as much as all of them. */
static double residual_row(void *self, const double *u, int row)
{
    double f[6];
    residual(self, u, f);
    return f[row];
}

static void linearize(void *self, const double *u)
{
    pinch_static_model *model = self;
    start_tangent(model);
    for (int c = 0; c < model->count; c++) {
        double s[4], r[4], d[16];
        pinch_static_trial(model, &model->contacts[c], u, s);
        pinch_static_law(model, &model->contacts[c], s, r, d);
        add_tangent(model, &model->contacts[c], d);
    }
}

static pinch_row row(void *self, int i)
{
    pinch_static_model *model = self;
    int m = model->freedoms;
    for (int j = 0; j < m; j++) model->v[i * m + j] = -model->tangent[i * m + j];
    model->segments[i] = (pinch_row_segment){0, m, model->v + i * m};
    return (pinch_row){1, &model->segments[i]};
}

static bool solve(void *self, const double *rhs, double *du)
{
    pinch_static_model *model = self;
    if (!factor_tangent(model)) return false;
    pinch_lu_solve(model->freedoms, model->lu, model->pivot, rhs, du);
    for (int j = 0; j < model->freedoms; j++) du[j] = -du[j];
    return true;
}

pinch_system pinch_static_system(pinch_static_model *model)
{
    return (pinch_system){.size = model->freedoms,
                          .self = model,
                          .residual = residual,
                          .residual_row = residual_row,
                          .linearize = linearize,
                          .row = row,
                          .solve = solve};
}

/* Evaluates R at u in twice the precision, and the tangent there. Returns ||R||. */
static double evaluate_extended(pinch_static_model *model, const pinch_double_double *u, double *equilibrium)
{
    int m = model->freedoms;
    pinch_double_double sum[6];
    for (int j = 0; j < m; j++) sum[j] = pinch_dd_product(model->wrench_factor, model->wrench[j]);
    start_tangent(model);
    for (int c = 0; c < model->count; c++) {
        const pinch_static_contact *contact = &model->contacts[c];
        double s[4], r[4], d[16];
        pinch_static_trial_extended(model, contact, u, s);
        pinch_static_law(model, contact, s, r, d);
        add_tangent(model, contact, d);
        for (int i = 0; i < contact->rows; i++)
            for (int j = 0; j < m; j++) sum[j] = pinch_dd_add(sum[j], pinch_dd_product(contact->w[i][j], r[i]));
    }
    double norm2 = 0.0;
    for (int j = 0; j < m; j++) {
        equilibrium[j] = sum[j].high;
        norm2 += equilibrium[j] * equilibrium[j];
    }
    return sqrt(norm2);
}

/*
 * In double precision r = k (closing - w) carries the rounding of k |u|, which for a stiff finger on an object that
 * soft ones let move far is more than the tolerance on r. With u and the elongation in twice the precision only r itself
 * is rounded.
 */
double pinch_static_refine(pinch_static_model *model, pinch_double_double *u, int steps)
{
    const double enough = 1e-16; /* less is rounding of the forces themselves */
    int m = model->freedoms;
    double f[6], du[6], norm = evaluate_extended(model, u, f);
    for (int step = 0; step < steps && norm > enough; step++) {
        if (!factor_tangent(model)) break;
        pinch_lu_solve(m, model->lu, model->pivot, f, du);
        pinch_double_double trial[6];
        for (int j = 0; j < m; j++) trial[j] = pinch_dd_add(u[j], (pinch_double_double){du[j], 0});
        double next = evaluate_extended(model, trial, f);
        if (!(next < 0.5 * norm)) break;
        memcpy(u, trial, (size_t)m * sizeof *u);
        norm = next;
    }
    return norm;
}
