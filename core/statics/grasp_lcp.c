/* Writes the linearized grasp as a complementarity problem, equations (43) and (44) of core/README.md, and solves it.
 */
#include "statics/results.h"
#include "statics/workspace.h"

#include "support/lu.h"

#include <math.h>
#include <string.h>

/*
 * The linearized grasp as a mixed complementarity problem in (r_n, lambda, s, u):
 *
 *     0 <= r_n    ⊥  C_n r_n + W_n^T u - d + s                      >= 0     C_n = 1/kn
 *     0 <= lambda ⊥  mu r_n - N^T r_t                               >= 0     r_t = K_t (rest - W_t^T u - N lambda)
 *     0 <= s      ⊥  f_max - r_n                                    >= 0     fingers with a force limit
 *          u free    S u - W_n r_n + P lambda - W_t K_t rest - p    =  0     S = W_t K_t W_t^T, P = W_t K_t N
 *
 * N: outward facet normals of the friction polytope, lambda the slip against each. Where the normal force is prescribed
 * its row and column drop out, W_n r_n joins p and mu r_n the friction rows.
 */

/* The unknowns of the mixed problem are r_n, lambda, s, u in this order. */
typedef struct lcp_layout {
    int normals, facets, limits, freedoms;
    int size; /* of the mixed problem */
} lcp_layout;

static int facet_count(const pinch_static_model *model, const pinch_static_contact *contact)
{
    return contact->rows == 1 ? 0 : model->faces + (contact->rows == 4 ? 2 : 0);
}

/* Writes the outward normal of facet k of a contact's polytope in (t1, t2, tau). Returns its distance per newton of
 * normal force. */
static double facet(const pinch_static_model *model, const pinch_static_contact *contact, int k, double normal[3])
{
    normal[0] = normal[1] = normal[2] = 0.0;
    if (k >= model->faces) {
        normal[2] = k == model->faces ? 1.0 : -1.0;
        return model->friction_factor * contact->axis[2] * model->torsion;
    }
    double angle = 2.0 * 3.14159265358979323846 * k / model->faces;
    normal[0] = cos(angle);
    normal[1] = sin(angle);
    return model->friction_factor * contact->axis[0] * model->apothem * (contact->rows == 4 ? model->torsion : 1.0);
}

static bool limited(const pinch_static_contact *contact)
{
    return !contact->controlled && contact->max_force < INFINITY;
}

static lcp_layout lay_out(const pinch_static_model *model)
{
    lcp_layout layout = {.freedoms = model->freedoms};
    for (int c = 0; c < model->count; c++) {
        const pinch_static_contact *contact = &model->contacts[c];
        layout.normals += !contact->controlled;
        layout.limits += limited(contact);
        layout.facets += facet_count(model, contact);
    }
    layout.size = layout.normals + layout.facets + layout.limits + layout.freedoms;
    return layout;
}

/* The position of the next unknown of each kind, while the contacts are gone through in order. */
typedef struct cursor {
    int normal, facet, limit, u;
} cursor;

static cursor start_of(const lcp_layout *layout)
{
    return (cursor){.normal = 0,
                    .facet = layout->normals,
                    .limit = layout->normals + layout->facets,
                    .u = layout->normals + layout->facets + layout->limits};
}

static void advance(const pinch_static_model *model, const pinch_static_contact *contact, cursor *at)
{
    at->normal += !contact->controlled;
    at->limit += limited(contact);
    at->facet += facet_count(model, contact);
}

typedef struct sheet {
    int size;
    double *m, *q;
} sheet;

static double *entry(const sheet *s, int i, int j)
{
    return &s->m[(size_t)i * (size_t)s->size + (size_t)j];
}

static void add_normal(const pinch_static_model *model, const pinch_static_contact *contact, const cursor *at,
                       const sheet *s)
{
    if (contact->controlled) {
        for (int j = 0; j < model->freedoms; j++)
            s->q[at->u + j] -= contact->w[0][j] * pinch_static_controlled_force(model, contact);
        return;
    }
    *entry(s, at->normal, at->normal) = 1.0 / contact->k[0];
    s->q[at->normal] = -model->closing_factor * contact->closing;
    for (int j = 0; j < model->freedoms; j++) {
        *entry(s, at->normal, at->u + j) = contact->w[0][j];
        *entry(s, at->u + j, at->normal) = -contact->w[0][j];
    }
    if (!limited(contact)) return;
    *entry(s, at->normal, at->limit) = 1.0;
    *entry(s, at->limit, at->normal) = -1.0;
    s->q[at->limit] = contact->max_force;
}

static void add_friction(const pinch_static_model *model, const pinch_static_contact *contact, const cursor *at,
                         const sheet *s)
{
    int m = model->freedoms, facets = facet_count(model, contact);
    for (int i = 1; i < contact->rows; i++)
        for (int a = 0; a < m; a++) {
            s->q[at->u + a] -= contact->w[i][a] * contact->k[i] * contact->rest[i - 1];
            for (int b = 0; b < m; b++)
                *entry(s, at->u + a, at->u + b) += contact->k[i] * contact->w[i][a] * contact->w[i][b];
        }
    for (int k = 0; k < facets; k++) {
        double nk[3];
        double limit = facet(model, contact, k, nk);
        int row = at->facet + k;
        if (contact->controlled)
            s->q[row] += limit * pinch_static_controlled_force(model, contact);
        else
            *entry(s, row, at->normal) = limit;
        for (int i = 1; i < contact->rows; i++) {
            double stretch = nk[i - 1] * contact->k[i];
            s->q[row] -= stretch * contact->rest[i - 1];
            for (int a = 0; a < m; a++) {
                *entry(s, row, at->u + a) += stretch * contact->w[i][a];
                *entry(s, at->u + a, row) += stretch * contact->w[i][a];
            }
        }
        for (int l = 0; l < facets; l++) {
            double nl[3], sum = 0.0;
            facet(model, contact, l, nl);
            for (int i = 1; i < contact->rows; i++) sum += nk[i - 1] * contact->k[i] * nl[i - 1];
            *entry(s, row, at->facet + l) = sum;
        }
    }
}

/* Writes the mixed problem: m[size^2], q[size], free[size]. */
static void assemble_mixed(const pinch_static_model *model, const lcp_layout *layout, double *m, double *q, bool *free)
{
    sheet s = {.size = layout->size, .m = m, .q = q};
    memset(m, 0, (size_t)s.size * (size_t)s.size * sizeof *m);
    memset(q, 0, (size_t)s.size * sizeof *q);
    cursor at = start_of(layout);
    for (int i = 0; i < s.size; i++) free[i] = i >= at.u;
    for (int a = 0; a < layout->freedoms; a++) q[at.u + a] = -model->wrench_factor * model->wrench[a];
    for (int c = 0; c < model->count; c++) {
        add_normal(model, &model->contacts[c], &at, &s);
        if (model->contacts[c].rows > 1) add_friction(model, &model->contacts[c], &at, &s);
        advance(model, &model->contacts[c], &at);
    }
}

/*
 * S u = -(M_uz z + q_u) gives u = back (z, 1); the rest is M_zz + M_zu back. A pivot of S below 1e-10 of the largest
 * counts as zero: eliminating with it would cost the digits of everything else.
 */
static bool condense(const lcp_layout *layout, const double *mixed, const double *mixed_q, double *m, double *q,
                     double *back)
{
    int f = layout->freedoms, n = layout->size - f, full = layout->size, pivot[6];
    double s[36], scratch[6], column[6], least = INFINITY, largest = 0.0;
    for (int i = 0; i < f; i++) memcpy(s + i * f, mixed + (size_t)(n + i) * (size_t)full + n, (size_t)f * sizeof *s);
    if (!pinch_lu_factor(f, s, pivot, scratch)) return false;
    for (int i = 0; i < f; i++) {
        least = fmin(least, fabs(s[i * f + i]));
        largest = fmax(largest, fabs(s[i * f + i]));
    }
    if (least < 1e-10 * largest) return false;
    for (int j = 0; j <= n; j++) {
        for (int i = 0; i < f; i++)
            column[i] = -(j < n ? mixed[(size_t)(n + i) * (size_t)full + (size_t)j] : mixed_q[n + i]);
        pinch_lu_solve(f, s, pivot, column, column);
        for (int i = 0; i < f; i++) back[(size_t)i * (size_t)(n + 1) + (size_t)j] = column[i];
    }
    for (int i = 0; i < n; i++) {
        const double *row = mixed + (size_t)i * (size_t)full;
        for (int j = 0; j <= n; j++) {
            double sum = j < n ? row[j] : mixed_q[i];
            for (int k = 0; k < f; k++) sum += row[n + k] * back[(size_t)k * (size_t)(n + 1) + (size_t)j];
            if (j < n)
                m[(size_t)i * (size_t)n + (size_t)j] = sum;
            else
                q[i] = sum;
        }
    }
    return true;
}

static void split(const lcp_layout *layout, const double *mixed, const double *mixed_q, double *m, double *q)
{
    int full = layout->size, f = layout->freedoms, wide = full + f;
    for (int i = 0; i < wide; i++) {
        int from = i < full ? i : i - f;
        double row_sign = i < full ? 1.0 : -1.0;
        q[i] = row_sign * mixed_q[from];
        for (int j = 0; j < wide; j++) {
            double sign = j < full ? row_sign : -row_sign;
            m[(size_t)i * (size_t)wide + (size_t)j] =
                sign * mixed[(size_t)from * (size_t)full + (size_t)(j < full ? j : j - f)];
        }
    }
}

/* Reads forces and slips from the mixed problem's z: r[4] and slip[3] of contact `index`, model units. */
static void read_finger(const pinch_static_model *model, const lcp_layout *layout, const double *z, int index,
                        double r[4], double slip[3])
{
    cursor at = start_of(layout);
    for (int c = 0; c < index; c++) advance(model, &model->contacts[c], &at);
    const pinch_static_contact *contact = &model->contacts[index];
    double w[4];
    pinch_static_displacement(model, contact, z + at.u, w);
    r[0] = contact->controlled ? pinch_static_controlled_force(model, contact) : z[at.normal];
    slip[0] = slip[1] = slip[2] = 0.0;
    for (int k = 0; k < facet_count(model, contact); k++) {
        double nk[3];
        facet(model, contact, k, nk);
        for (int i = 0; i < 3; i++) slip[i] -= nk[i] * z[at.facet + k];
    }
    for (int i = 1; i < 4; i++)
        r[i] = i < contact->rows ? contact->k[i] * (contact->rest[i - 1] + slip[i - 1] - w[i]) : 0.0;
}

int pinch_statics_lcp_size(pinch_statics *statics, const pinch_grasp *grasp, const pinch_statics_settings *settings,
                           pinch_static_form form)
{
    if (pinch_static_validate(statics, grasp, settings) != PINCH_OK || settings->formulation != PINCH_FORMULATION_LCP)
        return 0;
    if ((grasp->planar ? 3 : settings->faces) > statics->faces) return 0;
    pinch_static_model model;
    pinch_static_model_build(&model, statics->contacts, grasp, settings, settings->faithful && !settings->unit);
    lcp_layout layout = lay_out(&model);
    if (form == PINCH_FORM_MIXED) return layout.size;
    if (form == PINCH_FORM_SPLIT) return layout.size + layout.freedoms;
    assemble_mixed(&model, &layout, statics->mixed, statics->mixed_q, statics->free);
    bool exists = layout.size > layout.freedoms &&
                  condense(&layout, statics->mixed, statics->mixed_q, statics->m, statics->q, statics->back);
    return exists ? layout.size - layout.freedoms : 0;
}

pinch_status pinch_statics_lcp(pinch_statics *statics, const pinch_grasp *grasp, const pinch_statics_settings *settings,
                               pinch_static_form form, double *m, double *q, bool *free_rows)
{
    int size = m && q && free_rows ? pinch_statics_lcp_size(statics, grasp, settings, form) : 0;
    if (size == 0) return PINCH_INVALID_ARGUMENT;
    pinch_static_model model;
    pinch_static_model_build(&model, statics->contacts, grasp, settings, settings->faithful && !settings->unit);
    lcp_layout layout = lay_out(&model);
    assemble_mixed(&model, &layout, statics->mixed, statics->mixed_q, statics->free);
    for (int i = 0; i < size; i++) free_rows[i] = form == PINCH_FORM_MIXED && statics->free[i];
    if (form == PINCH_FORM_MIXED) {
        memcpy(m, statics->mixed, (size_t)size * (size_t)size * sizeof *m);
        memcpy(q, statics->mixed_q, (size_t)size * sizeof *q);
    } else if (form == PINCH_FORM_CONDENSED) {
        condense(&layout, statics->mixed, statics->mixed_q, m, q, statics->back);
    } else {
        split(&layout, statics->mixed, statics->mixed_q, m, q);
    }
    return PINCH_OK;
}

/* Completes z of the mixed problem, u included, from that of the condensed (back) or split one. */
static void complete(const lcp_layout *layout, bool condensed, const double *back, double *z)
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

/* Assembles the paper's form: condensed where it exists, with u split in two non-negative parts otherwise. */
static pinch_lcp assemble_for_paper(pinch_statics *s, const pinch_static_model *model, const lcp_layout *layout,
                                    bool *condensed)
{
    assemble_mixed(model, layout, s->mixed, s->mixed_q, s->free);
    *condensed = layout->size > layout->freedoms && condense(layout, s->mixed, s->mixed_q, s->m, s->q, s->back);
    if (!*condensed) split(layout, s->mixed, s->mixed_q, s->m, s->q);
    int size = layout->size + (*condensed ? -layout->freedoms : layout->freedoms);
    return (pinch_lcp){.size = size, .m = s->m, .q = s->q};
}

void pinch_static_solve_lcp(pinch_statics *s, const pinch_static_model *model, const pinch_grasp *grasp,
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
    lcp_layout layout = lay_out(model);
    bool condensed;
    pinch_lcp lcp = assemble_for_paper(s, model, &layout, &condensed);
    result->size = lcp.size;
    for (int i = 0; i < lcp.size; i++) s->z[i] = 0.0;
    pinch_lcp_solve(&lcp, &inner, s->lcp, s->z, s->w, &result->solve);
    if (result->solve.status != PINCH_SOLVE_CONVERGED) return;
    complete(&layout, condensed, s->back, s->z);
    pinch_double_double u[6] = {{0, 0}};
    for (int j = 0; j < layout.freedoms; j++) u[j].high = s->z[layout.size - layout.freedoms + j];
    pinch_static_recover_object(model, grasp, u, result);
    for (int c = 0; c < model->count; c++) {
        pinch_static_forces forces;
        read_finger(model, &layout, s->z, c, forces.r, forces.slip);
        memcpy(forces.last_slip, forces.slip, sizeof forces.slip);
        forces.state = pinch_static_state(&model->contacts[c], forces.r, forces.slip, 10.0 * inner.tolerance);
        pinch_static_recover_finger(model, &grasp->fingers[c], &model->contacts[c], &forces, &fingers[c]);
    }
    result->load_fraction = 1.0;
}
