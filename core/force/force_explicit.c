/*
 * The same step with the velocities as unknowns: with rho = 1/C, equation (11) says what force follows from a velocity,
 * and q and the impulses y of the joint rows are all that is left. Stiff contacts lose digits in this form, which is
 * why it is no way to the answer, but it is a non-smooth system like any other, and a path of solutions
 * (solvers/path.c) leads it near the answer where Newton's method in the forces stops.
 */
#include "force/force_system.h"
#include "solvers/methods.h"

#include <math.h>
#include <string.h>

typedef struct explicit_form {
    pinch_force_system *s;
    int freedoms, unknowns;
    double *jacobian; /* unknowns^2 */
    pinch_row_segment segment;
} explicit_form;

/* Writes the element's force at q, and where `conductance` is not NULL, -dr/dw (rows x rows). */
static void force_at(const pinch_force_element *e, const double *q, double *r, double *conductance)
{
    const double *compliance = pinch_force_values(e, PINCH_FORCE_COMPLIANCE), *b = pinch_force_values(e, PINCH_FORCE_B);
    double w[PINCH_CONTACT_ROWS_MAX], z[PINCH_CONTACT_ROWS_MAX], rho[PINCH_CONTACT_ROWS_MAX];
    pinch_force_element_velocity(e, q, w);
    for (int i = 0; i < e->rows; i++) {
        rho[i] = 1 / compliance[i];
        z[i] = rho[i] * (b[i] - w[i]);
    }
    (void)pinch_contact_law_project(e->law, rho, z, r, conductance);
    for (int i = 0; i < e->rows && conductance; i++)
        for (int j = 0; j < e->rows; j++) conductance[i * e->rows + j] *= rho[j];
}

/* Returns y - (w - c) - C y - kappa (y - a) of a multiplier: what its bounds clamp. */
static double trial_of(const pinch_force_system *s, const pinch_force_multiplier *m, const double *q, double y)
{
    double w = 0;
    for (int b = 0; b < m->blocks; b++)
        for (int k = 0; k < m->block[b].size; k++) w += m->block[b].g[k] * q[m->block[b].first + k];
    return y - (w - m->unit.target) - m->unit.compliance * y - (s->dependent_rows ? m->kappa * (y - m->anchor) : 0);
}

static void residual(void *self, const double *x, double *f)
{
    const explicit_form *form = self;
    const pinch_force_system *s = form->s;
    const double *y = x + form->freedoms;
    for (int i = 0; i < form->freedoms; i++) f[i] = x[i];
    for (int k = 0; k < s->element_count; k++) {
        double r[PINCH_CONTACT_ROWS_MAX];
        force_at(&s->elements[k], x, r, NULL);
        pinch_force_add_impulse(&s->elements[k], -s->step, r, f);
    }
    for (int i = 0; i < s->multiplier_count; i++) {
        const pinch_force_multiplier *m = &s->multipliers[i];
        for (int b = 0; b < m->blocks; b++)
            for (int k = 0; k < m->block[b].size; k++) f[m->block[b].first + k] -= y[i] * m->block[b].g[k];
        f[form->freedoms + i] = y[i] - fmin(fmax(trial_of(s, m, x, y[i]), m->unit.low), m->unit.high);
    }
    for (int i = 0; i < form->unknowns; i++) f[i] /= s->scale;
}

/* jacobian += h G_a^T D G_b for all pairs of the element's blocks */
static void add_element(const explicit_form *form, const pinch_force_element *e, const double *conductance)
{
    size_t n = (size_t)form->unknowns;
    for (int a = 0; a < 2; a++) {
        const pinch_row_block *left = &e->block[a];
        for (int i = 0; i < e->rows; i++)
            for (int j = 0; j < e->rows; j++) {
                double d = form->s->step * conductance[i * e->rows + j];
                for (int b = 0; b < 2 && d != 0; b++) {
                    const pinch_row_block *right = &e->block[b];
                    for (int l = 0; l < left->size; l++) {
                        double dg = d * left->g[i * left->size + l];
                        double *to = form->jacobian + (size_t)(left->first + l) * n + right->first;
                        for (int k = 0; k < right->size; k++) to[k] += dg * right->g[j * right->size + k];
                    }
                }
            }
    }
}

static void add_multiplier(const explicit_form *form, const double *x, int index)
{
    const pinch_force_system *s = form->s;
    const pinch_force_multiplier *m = &s->multipliers[index];
    size_t n = (size_t)form->unknowns, y = (size_t)(form->freedoms + index);
    double trial = trial_of(s, m, x, x[y]);
    bool inside = trial > m->unit.low && trial < m->unit.high;
    form->jacobian[y * n + y] = !inside ? 1 : m->unit.compliance + (s->dependent_rows ? m->kappa : 0);
    for (int b = 0; b < m->blocks; b++)
        for (int k = 0; k < m->block[b].size; k++) {
            size_t q = (size_t)(m->block[b].first + k);
            form->jacobian[q * n + y] -= m->block[b].g[k];
            if (inside) form->jacobian[y * n + q] += m->block[b].g[k];
        }
}

static void linearize(void *self, const double *x)
{
    explicit_form *form = self;
    const pinch_force_system *s = form->s;
    size_t n = (size_t)form->unknowns;
    memset(form->jacobian, 0, n * n * sizeof(double));
    for (int i = 0; i < form->freedoms; i++) form->jacobian[(size_t)i * (n + 1)] = 1;
    for (int k = 0; k < s->element_count; k++) {
        double r[PINCH_CONTACT_ROWS_MAX], conductance[PINCH_CONTACT_ROWS_MAX * PINCH_CONTACT_ROWS_MAX];
        force_at(&s->elements[k], x, r, conductance);
        add_element(form, &s->elements[k], conductance);
    }
    for (int i = 0; i < s->multiplier_count; i++) add_multiplier(form, x, i);
    for (size_t i = 0; i < n * n; i++) form->jacobian[i] /= s->scale;
}

static pinch_row row_of(void *self, int row)
{
    explicit_form *form = self;
    form->segment = (pinch_row_segment){
        .start = 0, .length = form->unknowns, .values = form->jacobian + (size_t)row * (size_t)form->unknowns};
    return (pinch_row){1, &form->segment};
}

static void take_over(const pinch_force_system *s, const double *x)
{
    for (int k = 0; k < s->element_count; k++)
        force_at(&s->elements[k], x, pinch_force_values(&s->elements[k], PINCH_FORCE_R), NULL);
    for (int i = 0; i < s->multiplier_count; i++) {
        pinch_force_multiplier *m = &s->multipliers[i];
        m->y = fmin(fmax(x[s->mobility->unknowns + i], m->unit.low), m->unit.high);
    }
}

bool pinch_force_follow_path(pinch_arena *arena, pinch_force_system *s, int *steps, bool *arrived)
{
    explicit_form form = {.s = s, .freedoms = s->mobility->unknowns};
    size_t n = (size_t)(form.unknowns = form.freedoms + s->multiplier_count);
    pinch_system system = {
        .size = form.unknowns, .self = &form, .residual = residual, .linearize = linearize, .row = row_of};
    pinch_arena_mark here = pinch_arena_here(arena);
    double *x = PINCH_ARENA_ARRAY(arena, double, 2 * n), *scratch;
    form.jacobian = PINCH_ARENA_ARRAY(arena, double, n *n);
    scratch = PINCH_ARENA_ARRAY(arena, double, pinch_path_scratch(form.unknowns));
    if (arena->failed) return false;
    memset(x, 0, 2 * n * sizeof *x);
    pinch_path_start start = {.anchor = x + n, .size = s->scale};
    *arrived = pinch_path(&system, &start, scratch, x, steps);
    if (*arrived) take_over(s, x);
    pinch_arena_rewind(arena, &here);
    return true;
}
