#include "stiff/stiff_system.h"

#include "stiff/stiff_rows.h"

#include <math.h>
#include <string.h>

void pinch_stiff_warm_start(pinch_stiff_system *s, const pinch_problem *problem)
{
    for (int k = 0; k < s->contact_count; k++) {
        pinch_stiff_element *e = &s->elements[k];
        for (int i = 0; i < e->law.rows; i++)
            e->r[i] = i < 4 ? e->contact->force[i] : e->contact->rolling_moment[i - 4];
    }
    for (int j = 0; j < problem->row_count; j++) {
        int e = s->element_of_row[j];
        if (e >= 0) s->elements[e].r[0] = problem->rows[j].force;
        if (e > -2) continue;
        pinch_stiff_multiplier *m = &s->multipliers[-2 - e];
        m->y = fmin(fmax(s->step * m->sigma * problem->rows[j].force, m->low), m->high);
    }
}

/* What the elastic displacement x becomes when its compliance has changed: unchanged where that grew (the force falls),
 * shrunk where it fell (the force stays). Keeping the force on the way up would feed energy in. */
static void shrink(double *x, int count, double before, double now)
{
    for (int i = 0; i < count && before > 0 && now < before; i++) x[i] *= now / before;
}

static void set_contact(pinch_stiff_element *e, double h, double floor)
{
    pinch_contact *c = e->contact;
    int rows = e->law.rows;
    double least[PINCH_STIFF_ROWS];
    for (int i = 0; i < rows; i++) least[i] = c->may_soften ? floor * h * e->inertia[i] : 0;
    if (rows > 1) least[1] = least[2] = fmax(least[1], least[2]);
    if (rows == 6) least[3] = least[4] = least[5] = fmax(least[3], fmax(least[4], least[5]));
    for (int i = 0; i < rows; i++) e->compliance[i] = fmax(e->prescribed[i], least[i]);
    memcpy(c->elastic, e->elastic, sizeof c->elastic);
    memcpy(c->rolling_elastic, e->elastic + 3, sizeof c->rolling_elastic);
    if (rows > 1) shrink(c->elastic, 2, e->compliance_before[1], e->compliance[1]);
    if (rows > 3) shrink(c->elastic + 2, 1, e->compliance_before[2], e->compliance[3]);
    if (rows > 4) shrink(c->rolling_elastic, 2, e->compliance_before[2], e->compliance[3]);
    for (int i = 0; i < rows; i++) {
        int kind = i == 0 ? 0 : i < 3 ? 1 : 2;
        double x = i == 0 ? -c->depth : i < 4 ? c->elastic[i - 1] : c->rolling_elastic[i - 4];
        if (kind == 1 && c->viscous[i - 1] > 0) {
            e->b[i] = 0;
            continue;
        }
        c->compliance[kind] = e->compliance[i];
        e->b[i] = -c->stiffness[kind] * e->prescribed[i] * x; /* k / (h k + c): the same for both compliances */
    }
}

void pinch_stiff_set_floor(pinch_stiff_system *s, double floor)
{
    double h = s->step, sum = 0;
    for (int k = 0; k < s->element_count; k++) {
        pinch_stiff_element *e = &s->elements[k];
        if (e->contact)
            set_contact(e, h, floor);
        else
            e->compliance[0] = e->prescribed[0];
        double tangents = e->law.rows > 1 ? fmax(e->inertia[1], e->inertia[2]) : 0;
        for (int i = 0; i < e->law.rows; i++) {
            double inertia = i == 1 || i == 2 ? tangents : e->inertia[i];
            e->rho[i] = 1 / (e->compliance[i] + h * inertia);
            double alone = e->rho[i] * fabs(e->w0[i] - e->b[i]), acts = fmax(fabs(e->r[i]), i == 0 ? alone : 0);
            sum += h / e->rho[i] * acts * acts;
        }
    }
    for (int m = 0; m < s->multiplier_count; m++) sum += s->multipliers[m].y * s->multipliers[m].y;
    s->scale = sum > 0 ? sqrt(sum) : 1;
}

void pinch_stiff_element_velocity(const pinch_stiff_element *e, const double *q, double *w)
{
    int rows = e->law.rows;
    for (int i = 0; i < rows; i++) w[i] = e->w0[i];
    for (int b = 0; b < 2; b++) pinch_stiff_rows_times(rows, e->block[b].size, e->block[b].g, q + e->block[b].first, w);
}

void pinch_stiff_add_impulse(const pinch_stiff_element *e, double factor, const double *x, double *q)
{
    double impulse[PINCH_STIFF_ROWS];
    bool any = false;
    for (int i = 0; i < e->law.rows; i++) {
        impulse[i] = factor * x[i];
        any = any || impulse[i] != 0;
    }
    for (int b = 0; b < 2 && any; b++)
        pinch_stiff_rows_transposed_times(e->law.rows, e->block[b].size, e->block[b].g, impulse, q + e->block[b].first);
}

static double evaluate_multipliers(pinch_stiff_system *s)
{
    double sum = 0;
    for (int i = 0; i < s->multiplier_count; i++) {
        pinch_stiff_multiplier *m = &s->multipliers[i];
        double w = 0;
        for (int b = 0; b < 2; b++)
            for (int k = 0; k < m->block[b].size; k++) w += m->block[b].g[k] * s->q[m->block[b].first + k];
        m->trial = m->y - (w - m->target);
        m->f = m->y - fmin(fmax(m->trial, m->low), m->high);
        sum += m->f * m->f;
    }
    return sum;
}

static double larger(double a, double b)
{
    return a > b ? a : b;
}

/*
 * Of the force p = P(z), N, as the check of an answer will measure it. The law's own trial force p - f / (rho C) is f
 * magnified; where it lies beyond the limit of friction and p does not, p's distance from that limit counts.
 */
static double distance_from_law(const pinch_stiff_element *e, const double *p)
{
    double off = 0, magnified = 0;
    bool compliant = e->contact && !e->contact->may_soften;
    for (int i = 0; i < e->law.rows && i < 3; i++) {
        double f = fabs(e->f[i]), by_law = f / (e->rho[i] * e->compliance[i]);
        off = larger(off, compliant ? by_law : f);
        if (i > 0) magnified = larger(magnified, 2 * by_law);
    }
    if (e->law.rows == 1 || magnified <= off) return off;
    double reach2 = 0, largest = 0, smallest = INFINITY;
    for (int i = 0; i < 2; i++) {
        double axis = e->law.limit[i] + e->law.friction[i] * p[0];
        if (!(axis > 0) || isinf(axis)) continue;
        reach2 += p[1 + i] / axis * (p[1 + i] / axis);
        largest = larger(largest, axis);
        smallest = axis < smallest ? axis : smallest;
    }
    double inside = 1 - magnified / smallest;
    if (reach2 < 1 && (inside <= 0 || reach2 > inside * inside)) off = larger(off, largest * (1 - sqrt(reach2)));
    return off;
}

double pinch_stiff_evaluate(pinch_stiff_system *s)
{
    double sum = 0, h = s->step, off = 0, force = 0;
    memset(s->q, 0, sizeof(double) * (size_t)s->mobility->unknowns);
    for (int k = 0; k < s->element_count; k++) pinch_stiff_add_impulse(&s->elements[k], h, s->elements[k].r, s->q);
    for (int i = 0; i < s->multiplier_count; i++) {
        const pinch_stiff_multiplier *m = &s->multipliers[i];
        for (int b = 0; b < 2; b++)
            for (int k = 0; k < m->block[b].size; k++) s->q[m->block[b].first + k] += m->y * m->block[b].g[k];
    }
    for (int k = 0; k < s->element_count; k++) {
        pinch_stiff_element *e = &s->elements[k];
        double p[PINCH_STIFF_ROWS];
        pinch_stiff_element_velocity(e, s->q, e->w);
        for (int i = 0; i < e->law.rows; i++)
            e->z[i] = (1 - e->rho[i] * e->compliance[i]) * e->r[i] - e->rho[i] * (e->w[i] - e->b[i]);
        (void)pinch_stiff_project(&e->law, e->rho, e->z, p, NULL);
        e->inside = true;
        for (int i = 0; i < e->law.rows; i++) {
            e->inside = e->inside && p[i] == e->z[i];
            e->f[i] = e->r[i] - p[i];
            sum += h / e->rho[i] * e->f[i] * e->f[i];
        }
        off = larger(off, distance_from_law(e, p));
        for (int i = 0; i < e->law.rows && i < 3; i++) force = larger(force, fabs(p[i]));
    }
    s->off = off;
    s->force = force;
    return sqrt(sum + evaluate_multipliers(s)) / s->scale;
}
