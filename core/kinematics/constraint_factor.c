#include "kinematics/constraint_factor.h"

#include "support/dense.h"

#include <math.h>
#include <string.h>

/* A row whose remainder beside the others is smaller than this, relative to its length, constrains nothing more. */
static const double RANK_TOLERANCE = 1e-9;

bool pinch_root_inverse_of(const pinch_body *body, pinch_root_inverse *w)
{
    const double *I = body->inertia;
    w->linear = 1 / sqrt(body->mass);
    double l00 = sqrt(I[0]), l10 = I[3] / l00, l11 = sqrt(I[4] - l10 * l10);
    double l20 = I[6] / l00, l21 = (I[7] - l20 * l10) / l11, l22 = sqrt(I[8] - l20 * l20 - l21 * l21);
    if (!(l00 > 0) || !(l11 > 0) || !(l22 > 0)) return false;
    /* L^-1 by forward substitution; its transpose is Y's angular block */
    double m00 = 1 / l00, m11 = 1 / l11, m22 = 1 / l22;
    double m10 = -l10 * m00 * m11, m21 = -l21 * m11 * m22, m20 = -(l20 * m00 + l21 * m10) * m22;
    w->t[0] = m00;
    w->t[1] = m10;
    w->t[2] = m20;
    w->t[3] = m11;
    w->t[4] = m21;
    w->t[5] = m22;
    return isfinite(w->linear);
}

void pinch_root_apply(const pinch_root_inverse *w, const double *x, double *y)
{
    const double *t = w->t;
    for (int i = 0; i < 3; i++) y[i] = w->linear * x[i];
    y[3] = t[0] * x[3] + t[1] * x[4] + t[2] * x[5];
    y[4] = t[3] * x[4] + t[4] * x[5];
    y[5] = t[5] * x[5];
}

void pinch_root_apply_transposed(const pinch_root_inverse *w, const double *x, double *y)
{
    const double *t = w->t;
    for (int i = 0; i < 3; i++) y[i] = w->linear * x[i];
    y[5] = t[2] * x[3] + t[4] * x[4] + t[5] * x[5];
    y[4] = t[1] * x[3] + t[3] * x[4];
    y[3] = t[0] * x[3];
}

pinch_constraint_factor *pinch_constraint_allocate(pinch_arena *arena, int bodies, int rows)
{
    pinch_constraint_factor *c = PINCH_ARENA_ARRAY(arena, pinch_constraint_factor, 1);
    if (!c) return NULL;
    memset(c, 0, sizeof *c);
    c->n = 6 * bodies;
    c->column = PINCH_ARENA_ARRAY(arena, double, (size_t)c->n *(size_t)rows);
    c->row = PINCH_ARENA_ARRAY(arena, int, rows);
    c->length = PINCH_ARENA_ARRAY(arena, double, rows);
    c->rhs = PINCH_ARENA_ARRAY(arena, double, rows);
    c->tau = PINCH_ARENA_ARRAY(arena, double, rows);
    c->diagonal = PINCH_ARENA_ARRAY(arena, double, rows);
    c->order = PINCH_ARENA_ARRAY(arena, int, rows);
    c->y = PINCH_ARENA_ARRAY(arena, double, rows);
    c->roots = PINCH_ARENA_ARRAY(arena, pinch_root_inverse, bodies);
    return arena->failed ? NULL : c;
}

void pinch_constraint_add(pinch_constraint_factor *c, int row, const int slot[2], const double *const j[2])
{
    double *column = c->column + (size_t)c->count * (size_t)c->n;
    memset(column, 0, sizeof(double) * (size_t)c->n);
    for (int side = 0; side < 2; side++) {
        double part[6];
        if (slot[side] < 0) continue;
        pinch_root_apply_transposed(&c->roots[slot[side]], j[side], part);
        for (int i = 0; i < 6; i++) column[6 * slot[side] + i] += part[i];
    }
    double length = sqrt(pinch_dot(column, column, c->n));
    if (!(length > 0)) return;
    for (int i = 0; i < c->n; i++) column[i] /= length;
    c->row[c->count] = row;
    c->length[c->count] = length;
    c->count++;
}

/* Householder factorization with column pivoting; vector k lives below the diagonal of column k (its head is 1). */
void pinch_constraint_factorize(pinch_constraint_factor *c)
{
    int n = c->n;
    c->rank = 0;
    for (int k = 0; k < c->count; k++) c->order[k] = k;
    for (int k = 0; k < c->count && k < n; k++) {
        int best = k;
        double most = -1;
        for (int j = k; j < c->count; j++) {
            const double *v = c->column + (size_t)c->order[j] * (size_t)n;
            double size = pinch_dot(v + k, v + k, n - k);
            if (size > most) {
                most = size;
                best = j;
            }
        }
        if (!(most > RANK_TOLERANCE * RANK_TOLERANCE)) break;
        int swap = c->order[k];
        c->order[k] = c->order[best];
        c->order[best] = swap;

        double *v = c->column + (size_t)c->order[k] * (size_t)n;
        double alpha = v[k] > 0 ? -sqrt(most) : sqrt(most), head = v[k] - alpha;
        c->diagonal[k] = alpha;
        c->tau[k] = -head / alpha;
        for (int i = k + 1; i < n; i++) v[i] /= head;
        v[k] = 1;
        for (int j = k + 1; j < c->count; j++) {
            double *other = c->column + (size_t)c->order[j] * (size_t)n;
            double scale = c->tau[k] * pinch_dot(v + k, other + k, n - k);
            for (int i = k; i < n; i++) other[i] -= scale * v[i];
        }
        c->rank++;
    }
}

void pinch_constraint_apply_q(const pinch_constraint_factor *c, double *x)
{
    for (int k = c->rank - 1; k >= 0; k--) {
        const double *v = c->column + (size_t)c->order[k] * (size_t)c->n;
        double scale = c->tau[k] * pinch_dot(v + k, x + k, c->n - k);
        for (int i = k; i < c->n; i++) x[i] -= scale * v[i];
    }
}

void pinch_constraint_apply_q_transposed(const pinch_constraint_factor *c, double *x)
{
    for (int k = 0; k < c->rank; k++) {
        const double *v = c->column + (size_t)c->order[k] * (size_t)c->n;
        double scale = c->tau[k] * pinch_dot(v + k, x + k, c->n - k);
        for (int i = k; i < c->n; i++) x[i] -= scale * v[i];
    }
}

/* forward substitution with R's columns: entry i of column k stands above the diagonal */
void pinch_constraint_solve_transposed(pinch_constraint_factor *c)
{
    for (int k = 0; k < c->rank; k++) {
        const double *column = c->column + (size_t)c->order[k] * (size_t)c->n;
        double sum = c->rhs[c->order[k]];
        for (int i = 0; i < k; i++) sum -= column[i] * c->y[i];
        c->y[k] = sum / c->diagonal[k];
    }
}

/* back substitution with the same columns */
void pinch_constraint_solve(const pinch_constraint_factor *c, double *x)
{
    for (int k = c->rank - 1; k >= 0; k--) {
        double sum = x[k];
        for (int j = k + 1; j < c->rank; j++) sum -= c->column[(size_t)c->order[j] * (size_t)c->n + (size_t)k] * x[j];
        x[k] = sum / c->diagonal[k];
    }
}
