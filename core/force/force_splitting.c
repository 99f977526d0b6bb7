/*
 * The alternating direction method of multipliers (Gabay and Mercier, "A dual algorithm for the solution of nonlinear
 * variational problems via finite element approximation", 1976), equation (74) of core/README.md. It splits a step into
 * a linear system of the whole island, whose matrix stays as it is, and the laws, contact by contact. One factorization
 * serves all its steps, and in the first of them what bears a tall pile gets its load. Forces end near their laws
 * everywhere, and a few sweeps take away what is left.
 */
#include "force/force_rows.h"
#include "force/force_system.h"

#include <math.h>
#include <string.h>

/* The products of blocks that complete factors may take, per sweep and contact. */
static const double FOR_A_SWEEP = 8;
enum { LEAST_STEPS = 10, MOST_STEPS = 40 };
/* The resistance R of a row, as a part of C + h W; the change in a step, as a part of the forces, that ends it. */
static const double RESISTANCE = 3e-3, SETTLED = 3e-4;
/* What a solve may leave of its right hand side. */
static const double EXACTNESS = 1e-4;

/* Of an element: y, the force that its law allows, is in r; l and f of (74). l stands where the conductance stood. */
static const pinch_force_value DUAL = PINCH_FORCE_START, PULL = PINCH_FORCE_CHANGE;

static double resistance(const pinch_force_element *e, int i)
{
    return RESISTANCE / pinch_force_values(e, PINCH_FORCE_RHO)[i];
}

static double conductance(const pinch_force_element *e, int i)
{
    return 1 / (pinch_force_values(e, PINCH_FORCE_COMPLIANCE)[i] + resistance(e, i));
}

/* f = D (b - w_0 + R (y - l)) of a row, d being its D */
static double pulled(const pinch_force_element *e, int i, double d, double l)
{
    const double *b = pinch_force_values(e, PINCH_FORCE_B), *w0 = pinch_force_values(e, PINCH_FORCE_W0);
    return d * (b[i] - w0[i] + resistance(e, i) * (pinch_force_values(e, PINCH_FORCE_R)[i] - l));
}

static void begin_elements(void *argument, int first, int end)
{
    pinch_force_system *s = argument;
    for (int k = first; k < end; k++) {
        pinch_force_element *e = &s->elements[k];
        double *f = pinch_force_values(e, PULL), *matrix = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
        memset(matrix, 0, sizeof *matrix * (size_t)(e->rows * e->rows));
        for (int i = 0; i < e->rows; i++) {
            double d = matrix[i * e->rows + i] = conductance(e, i);
            f[i] = pulled(e, i, d, 0);
        }
        e->conducts = true;
    }
}

static void clear_duals(void *argument, int first, int end)
{
    pinch_force_system *s = argument;
    for (int k = first; k < end; k++)
        memset(pinch_force_values(&s->elements[k], DUAL), 0, sizeof(double) * (size_t)s->elements[k].rows);
}

/* x = f - D G q,  y <- P(x + l),  l <- x + l - y */
static void apply_laws(void *argument, int first, int end)
{
    pinch_force_system *s = argument;
    pinch_force_partial *partial = &s->partials[first / PINCH_CHUNK];
    partial->off = partial->force = 0;
    for (int k = first; k < end; k++) {
        pinch_force_element *e = &s->elements[k];
        double *f = pinch_force_values(e, PULL), *y = pinch_force_values(e, PINCH_FORCE_R);
        double *l = pinch_force_values(e, DUAL), w[PINCH_CONTACT_ROWS_MAX] = {0}, d[PINCH_CONTACT_ROWS_MAX];
        double z[PINCH_CONTACT_ROWS_MAX], p[PINCH_CONTACT_ROWS_MAX];
        for (int b = 0; b < 2; b++)
            pinch_force_rows_times(e->rows, e->block[b].size, e->block[b].g, s->rhs + e->block[b].first, w);
        for (int i = 0; i < e->rows; i++) {
            d[i] = conductance(e, i);
            z[i] = f[i] - d[i] * w[i] + l[i];
        }
        (void)pinch_contact_law_project(e->law, pinch_force_values(e, PINCH_FORCE_RHO), z, p, NULL);
        for (int i = 0; i < e->rows; i++) {
            partial->off += (p[i] - y[i]) * (p[i] - y[i]);
            partial->force += p[i] * p[i];
            y[i] = p[i];
            l[i] = z[i] - p[i];
            f[i] = pulled(e, i, d[i], l[i]);
        }
    }
}

/* Returns by which part the last step has changed the forces. */
static double change_of_forces(const pinch_force_system *s)
{
    double off = 0, force = 0;
    for (int k = 0; k < pinch_chunk_count(s->element_count); k++) {
        off += s->partials[k].off;
        force += s->partials[k].force;
    }
    return off > 0 ? sqrt(off / force) : 0;
}

bool pinch_force_may_split(pinch_arena *arena, pinch_force_system *s, int sweeps)
{
    if (s->multiplier_count > 0 || pinch_force_height(arena, s) <= sweeps) return !arena->failed;
    s->split_products = FOR_A_SWEEP * sweeps * s->element_count;
    bool complete;
    if (!pinch_force_plan_for_split(arena, s, &complete)) return false;
    if (!complete) s->split_products = 0;
    return true;
}

bool pinch_force_split(pinch_arena *arena, pinch_force_system *s, bool *done)
{
    bool complete;
    *done = false;
    if (!pinch_force_plan_for_split(arena, s, &complete)) return false;
    if (!complete) return true;
    pinch_loop(s->crew, s->element_count, begin_elements, s);
    double change = INFINITY;
    for (int step = 0; step < LEAST_STEPS || (step < MOST_STEPS && change > SETTLED); step++) {
        double *rhs = pinch_force_clear_rhs(arena, s);
        pinch_force_add_impulses(s, PULL, rhs);
        if (step > 0)
            pinch_force_solve_again(s);
        else if (!pinch_force_solve_for_rhs(arena, s, EXACTNESS))
            return true;
        else
            pinch_loop(s->crew, s->element_count, clear_duals, s);
        pinch_loop(s->crew, s->element_count, apply_laws, s);
        change = change_of_forces(s);
    }
    *done = isfinite(change);
    return true;
}
