#include "statics/feasibility.h"

#include "law/friction_cone.h"
#include "statics/results.h"
#include "support/dense.h"
#include "support/lu.h"

#include <math.h>
#include <string.h>

/*
 * The forces y in the product C of the contacts' cones that come closest to balance minimize 1/2 |A y + p|^2, A the
 * grasp matrix with friction scaled to 1; this problem is convex. Its Tikhonov dual, equation (46) of core/README.md,
 * is smooth and convex:
 *
 *     g(u) = sum max_{y in C} (x.y - |y|^2/2) + alpha/2 |u|^2 - p.u,   x = -A^T u,
 *     -grad g = A P(x) + p - alpha u = R - alpha u,
 *
 * which Newton with Armijo's rule on g minimizes from anywhere. As alpha -> 0 the residual R = alpha u tends to the
 * least one, R*. Where that is not zero, A C lies in the half-space y.R* >= 0 that -p is not in (Moreau): the twist -R*
 * is a proof that nothing in C balances p.
 */
typedef struct dual {
    const pinch_static_model *model;
    double alpha;
    double hessian[36];
} dual;

static double limits_of(const pinch_static_model *model, const pinch_static_contact *contact, double *low)
{
    double prescribed = pinch_static_controlled_force(model, contact);
    *low = contact->controlled ? prescribed : 0.0;
    return contact->controlled ? prescribed : contact->max_force;
}

/* Writes the columns of A for one contact. */
static void scaled_columns(const pinch_static_model *model, const pinch_static_contact *contact, double a[4][6])
{
    for (int i = 0; i < 4; i++) {
        double factor = 1.0;
        if (i > 0) factor = model->friction_factor * contact->axis[i - 1];
        if (i > 0 && model->faces > 0)
            factor *= i == 3 ? model->torsion : model->apothem * (contact->rows == 4 ? model->torsion : 1.0);
        for (int j = 0; j < model->freedoms; j++) a[i][j] = factor * contact->w[i][j];
    }
}

/* Returns g(u), with the gradient -(R - alpha u) and the Hessian. */
static double evaluate(dual *problem, const double *u, double *gradient)
{
    const pinch_static_model *model = problem->model;
    int m = model->freedoms;
    double g = 0.0;
    memset(problem->hessian, 0, sizeof problem->hessian);
    for (int j = 0; j < m; j++) {
        double p = model->wrench_factor * model->wrench[j];
        gradient[j] = problem->alpha * u[j] - p;
        problem->hessian[j * m + j] = problem->alpha;
        g += 0.5 * problem->alpha * u[j] * u[j] - p * u[j];
    }
    for (int c = 0; c < model->count; c++) {
        double a[4][6], x[4], y[4], d[16], low;
        double high = limits_of(model, &model->contacts[c], &low);
        scaled_columns(model, &model->contacts[c], a);
        for (int i = 0; i < 4; i++) {
            x[i] = 0.0;
            for (int j = 0; j < m; j++) x[i] -= a[i][j] * u[j];
        }
        pinch_friction_cone_project(model->faces, low, high, x, y, d);
        for (int i = 0; i < 4; i++) {
            g += (x[i] - 0.5 * y[i]) * y[i];
            double da[6] = {0};
            for (int k = 0; k < 4; k++)
                for (int j = 0; j < m; j++) da[j] += d[4 * i + k] * a[k][j];
            for (int j = 0; j < m; j++) {
                gradient[j] -= a[i][j] * y[i];
                for (int k = 0; k < m; k++) problem->hessian[j * m + k] += a[i][j] * da[k];
            }
        }
    }
    return g;
}

static void minimize(dual *problem, double tolerance, double *u)
{
    enum { STEPS = 60, HALVINGS = 30 };
    int m = problem->model->freedoms, pivot[6];
    double gradient[6], next_gradient[6], step[6], at[6], scratch[6];
    double g = evaluate(problem, u, gradient);
    for (int k = 0; k < STEPS && pinch_norm(gradient, m) > tolerance; k++) {
        if (!pinch_lu_factor(m, problem->hessian, pivot, scratch)) return;
        pinch_lu_solve(m, problem->hessian, pivot, gradient, step);
        double slope = 0.0, t = 1.0, next = g;
        for (int j = 0; j < m; j++) slope += gradient[j] * step[j];
        bool moved = false;
        for (int halving = 0; halving < HALVINGS && !moved; halving++, t *= 0.5) {
            for (int j = 0; j < m; j++) at[j] = u[j] - t * step[j];
            next = evaluate(problem, at, next_gradient);
            /* near the minimum g has no digits left; there a smaller gradient decides */
            moved = next <= g - 1e-4 * t * slope ||
                    (t == 1.0 && pinch_norm(next_gradient, m) < 0.5 * pinch_norm(gradient, m) &&
                     next <= g + 1e-12 * fabs(g));
        }
        if (!moved) return;
        memcpy(u, at, (size_t)m * sizeof *u);
        memcpy(gradient, next_gradient, (size_t)m * sizeof *gradient);
        g = next;
    }
}

/*
 * The dual point at alpha > 0 presses a little against the contacts that carry the residual: x.v is positive there by
 * about alpha. The proof needs the limit, where  phi = w_n + |friction work| = 0  on each of them (and w = 0 where the
 * twist neither opens nor slides the contact). Gauss-Newton steps of least length lead there.
 */
static void sharpen(const pinch_static_model *model, const double *u, double *v)
{
    enum { STEPS = 6 };
    const double neither = 1e-6;
    int m = model->freedoms, pivot[6];
    double scratch[6], length = pinch_norm(u, m);
    for (int j = 0; j < m; j++) v[j] = -u[j] / length;
    for (int step = 0; step < STEPS; step++) {
        double normal[36] = {0}, rhs[6] = {0};
        for (int j = 0; j < m; j++) normal[j * m + j] = 1e-13;
        for (int c = 0; c < model->count; c++) {
            const pinch_static_contact *contact = &model->contacts[c];
            if (contact->controlled || contact->max_force < INFINITY) continue;
            double a[4][6], x[4] = {0}, y[4], d[16], direction[4] = {1.0, 0.0, 0.0, 0.0};
            scaled_columns(model, contact, a);
            for (int i = 0; i < 4; i++)
                for (int j = 0; j < m; j++) x[i] += a[i][j] * v[j];
            pinch_friction_cone_project(model->faces, 0.0, INFINITY, x, y, d);
            if (y[0] <= 0.0) continue;
            for (int i = 0; i < 4; i++) direction[i] = y[i] / y[0];
            bool apex = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3]) < neither;
            for (int i = 0; i < (apex ? 4 : 1); i++) {
                double row[6], phi = 0.0;
                for (int j = 0; j < m; j++) {
                    row[j] = a[i][j];
                    for (int k = 0; !apex && k < 4; k++) row[j] += (k == 0 ? 0.0 : direction[k]) * a[k][j];
                    phi += row[j] * v[j];
                }
                for (int j = 0; j < m; j++) {
                    rhs[j] += row[j] * phi;
                    for (int k = 0; k < m; k++) normal[j * m + k] += row[j] * row[k];
                }
            }
        }
        if (!pinch_lu_factor(m, normal, pivot, scratch)) return;
        pinch_lu_solve(m, normal, pivot, rhs, rhs);
        for (int j = 0; j < m; j++) v[j] -= rhs[j];
    }
}

pinch_feasibility pinch_static_feasibility(const pinch_static_model *model, const pinch_grasp *grasp,
                                           const pinch_statics_settings *settings, double twist[6])
{
    int m = model->freedoms;
    double u[6] = {0}, direction[6], before = 0.0, scale = model->wrench_factor * pinch_norm(model->wrench, m);
    for (int c = 0; c < model->count; c++)
        if (model->contacts[c].controlled)
            scale = fmax(scale, fmin(model->contacts[c].normal_force, model->contacts[c].max_force));
    if (!(scale > 0.0)) return PINCH_FEASIBLE;
    dual problem = {.model = model};
    /* where forces balance, u stays bounded and |R| = alpha |u| vanishes; otherwise u grows as 1/alpha */
    for (problem.alpha = 1.0; problem.alpha > 1e-15; problem.alpha *= 0.1) {
        minimize(&problem, 1e-13 * scale, u);
        double length = pinch_norm(u, m);
        if (problem.alpha * length <= 1e-9 * scale) return PINCH_FEASIBLE;
        /* bounded, but with forces so large that rounding leaves more than that of R */
        if (problem.alpha * length <= 1e-5 * scale && length <= 1.1 * before) return PINCH_FEASIBLE;
        before = length;
        for (int attempt = 0; attempt < 2; attempt++) {
            for (int j = 0; j < m; j++) direction[j] = -u[j] / length;
            if (attempt == 1) sharpen(model, u, direction);
            pinch_static_twist(model, grasp, direction, twist);
            if (pinch_statics_proves_infeasible(grasp, settings, twist)) return PINCH_INFEASIBLE;
        }
    }
    memset(twist, 0, 6 * sizeof *twist);
    return PINCH_UNKNOWN_FEASIBILITY;
}
