#include "force/force_system.h"

#include "force/force_rows.h"
#include "support/dense.h"
#include "support/extremes.h"

#include <math.h>
#include <string.h>

void pinch_force_shift_base(pinch_force_multiplier *m, double by)
{
    m->unit.target -= m->kappa * by;
    m->unit.low -= by;
    m->unit.high -= by;
    m->base += by;
}

static void start_contacts(void *argument, int first, int end)
{
    const pinch_force_system *s = argument;
    for (int k = first; k < end; k++) {
        const pinch_force_element *e = &s->elements[k];
        double *r = pinch_force_values(e, PINCH_FORCE_R);
        for (int i = 0; i < e->rows; i++) r[i] = i < 4 ? e->contact->force[i] : e->contact->rolling_moment[i - 4];
    }
}

void pinch_force_warm_start(pinch_force_system *s, const pinch_problem *problem)
{
    s->is_warm_start = true;
    if (s->base_q) memset(s->base_q, 0, sizeof(double) * (size_t)s->mobility->unknowns);
    pinch_loop(s->crew, s->contact_count, start_contacts, s);
    for (int j = 0; j < problem->row_count; j++) {
        int e = s->element_of_row[j];
        if (e >= 0) *pinch_force_values(&s->elements[e], PINCH_FORCE_R) = problem->rows[j].force;
        if (e > -2) continue;
        pinch_force_multiplier *m = &s->multipliers[-2 - e];
        pinch_force_shift_base(m, -m->base);
        m->anchor = m->missed = 0;
        m->y = pinch_within(s->step * m->unit.sigma * problem->rows[j].force, m->unit.low, m->unit.high);
    }
}

double pinch_force_of_row(const pinch_force_system *s, int row)
{
    int e = s->element_of_row[row];
    if (e >= 0) return *pinch_force_values(&s->elements[e], PINCH_FORCE_R);
    if (e == -1) return 0;
    const pinch_force_multiplier *m = &s->multipliers[-2 - e];
    return m->unit.sigma > 0 ? (m->base + m->y) / (s->step * m->unit.sigma) : 0;
}

/* Equation (29): when its compliance has changed, the elastic displacement x stays where that grew (the force falls)
 * and shrinks where it fell (the force stays). Keeping the force while the compliance grows would feed energy in. */
static void shrink(double *x, int count, double before, double now)
{
    for (int i = 0; i < count && before > 0 && now < before; i++) x[i] *= now / before;
}

double pinch_force_prescribed(const pinch_contact *c, double h, int row)
{
    int kind = row == 0 ? 0 : row < 3 ? 1 : 2;
    if (kind == 1 && c->viscous[row - 1] > 0) return c->viscous[row - 1];
    return 1 / (h * c->stiffness[kind] + c->damping[kind]);
}

void pinch_force_elastic(const pinch_force_element *e, double elastic[5])
{
    const pinch_contact *c = e->contact;
    const double *compliance = pinch_force_values(e, PINCH_FORCE_COMPLIANCE);
    memcpy(elastic, c->elastic, sizeof c->elastic);
    memcpy(elastic + 3, c->rolling_elastic, sizeof c->rolling_elastic);
    if (e->rows > 1) shrink(elastic, 2, c->compliance[1], compliance[1]);
    if (e->rows > 3) shrink(elastic + 2, 1, c->compliance[2], compliance[3]);
    if (e->rows > 4) shrink(elastic + 3, 2, c->compliance[2], compliance[3]);
}

/* inertia: W of the rows; tangential: the largest of the tangents */
static inline void set_contact(pinch_force_element *e, int rows, double h, double floor, const double *inertia,
                               double tangential)
{
    const pinch_contact *c = e->contact;
    double *compliance = pinch_force_values(e, PINCH_FORCE_COMPLIANCE), *b = pinch_force_values(e, PINCH_FORCE_B);
    double prescribed[PINCH_CONTACT_ROWS_MAX], least[PINCH_CONTACT_ROWS_MAX] = {0}, elastic[5];
    for (int i = 0; i < rows; i++) {
        prescribed[i] = pinch_force_prescribed(c, h, i);
        least[i] = c->may_soften ? floor * h * inertia[i] : 0;
    }
    if (rows > 1) least[1] = least[2] = c->may_soften ? floor * h * tangential : 0;
    if (rows == 6) least[3] = least[4] = least[5] = fmax(least[3], fmax(least[4], least[5]));
    for (int i = 0; i < rows; i++) compliance[i] = pinch_larger(prescribed[i], least[i]);
    pinch_force_elastic(e, elastic);
    for (int i = 0; i < rows; i++) {
        int kind = i == 0 ? 0 : i < 3 ? 1 : 2;
        bool flows = kind == 1 && c->viscous[i - 1] > 0;
        double x = i == 0 ? -c->depth : elastic[i - 1];
        b[i] = flows ? 0 : -c->stiffness[kind] * prescribed[i] * x; /* k / (h k + c): the same for both compliances */
    }
}

/* Adds up the element's rows after `sum`. */
static inline double add_scale(const pinch_force_element *e, int rows, double h, double sum)
{
    const double *w0 = pinch_force_values(e, PINCH_FORCE_W0), *b = pinch_force_values(e, PINCH_FORCE_B);
    const double *r = pinch_force_values(e, PINCH_FORCE_R), *rho = pinch_force_values(e, PINCH_FORCE_RHO);
    for (int i = 0; i < rows; i++) {
        double alone = rho[i] * fabs(w0[i] - b[i]), acts = pinch_larger(fabs(r[i]), i == 0 ? alone : 0);
        sum += h / rho[i] * acts * acts;
    }
    return sum;
}

static void sum_scales(void *argument, int first, int end)
{
    pinch_force_system *s = argument;
    double sum = 0;
    for (int k = first; k < end; k++) sum = add_scale(&s->elements[k], s->elements[k].rows, s->step, sum);
    s->partials[first / PINCH_CHUNK].sum = sum;
}

static double sum_of_chunks(const pinch_force_system *s)
{
    double sum = 0;
    for (int k = 0; k < pinch_chunk_count(s->element_count); k++) sum += s->partials[k].sum;
    return sum;
}

/* The chunks have summed up the elements. */
static void add_multipliers_to_scale(pinch_force_system *s)
{
    double sum = sum_of_chunks(s);
    for (int i = 0; i < s->multiplier_count; i++) {
        const pinch_force_multiplier *m = &s->multipliers[i];
        double alone = m->unit.target; /* bounds are far from what is left where something has been put aside */
        if (m->base == 0) alone = pinch_within(alone, m->unit.low, m->unit.high);
        double acts = pinch_larger(fabs(m->y), fabs(alone));
        sum += acts * acts;
    }
    s->scale = sum > 0 ? sqrt(sum) : 1;
}

void pinch_force_set_scale(pinch_force_system *s)
{
    pinch_loop(s->crew, s->element_count, sum_scales, s);
    add_multipliers_to_scale(s);
}

/* Returns the largest that W is along any tangent. Another pair of tangents has the same: what turns with its contacts
 * keeps its compliances, and with them all of its elastic state (29). */
static double largest_tangential(const pinch_force_element *e, const double *inertia)
{
    double across = pinch_blocks_dot(e->block, 1, 2), half = 0.5 * (inertia[1] - inertia[2]);
    return 0.5 * (inertia[1] + inertia[2]) + sqrt(half * half + across * across);
}

/* rows: the element's; the compiler unrolls loops where it is a constant. */
static inline __attribute__((always_inline)) double set_element(const pinch_force_system *s, pinch_force_element *e,
                                                                int rows, double floor, double sum)
{
    double inertia[PINCH_CONTACT_ROWS_MAX], h = s->step;
    for (int i = 0; i < rows; i++) inertia[i] = pinch_blocks_norm2(e->block, i);
    bool softens = e->contact && e->contact->may_soften && rows > 1;
    if (e->contact) set_contact(e, rows, h, floor, inertia, softens ? largest_tangential(e, inertia) : 0);
    if (rows > 1) inertia[1] = inertia[2] = pinch_larger(inertia[1], inertia[2]);
    if (rows == PINCH_CONTACT_ROWS_MAX) inertia[4] = inertia[5] = pinch_larger(inertia[4], inertia[5]);
    const double *compliance = pinch_force_values(e, PINCH_FORCE_COMPLIANCE);
    double *rho = pinch_force_values(e, PINCH_FORCE_RHO);
    for (int i = 0; i < rows; i++) rho[i] = 1 / (compliance[i] + h * inertia[i]);
    return add_scale(e, rows, h, sum);
}

typedef struct floor_task {
    pinch_force_system *system;
    double floor;
} floor_task;

static void set_floor(void *argument, int first, int end)
{
    const floor_task *task = argument;
    pinch_force_system *s = task->system;
    double sum = 0;
    for (int k = first; k < end; k++)
        if (s->elements[k].rows == PINCH_FORCE_CONTACT) /* as most have */
            sum = set_element(s, &s->elements[k], PINCH_FORCE_CONTACT, task->floor, sum);
        else
            sum = set_element(s, &s->elements[k], s->elements[k].rows, task->floor, sum);
    s->partials[first / PINCH_CHUNK].sum = sum;
}

void pinch_force_set_floor(pinch_force_system *s, double floor)
{
    floor_task task = {s, floor};
    pinch_loop(s->crew, s->element_count, set_floor, &task);
    add_multipliers_to_scale(s);
}

/* These are inline for the loops of this file. */
static inline void velocity_of(const pinch_force_element *e, const double *q, double *w)
{
    const double *w0 = pinch_force_values(e, PINCH_FORCE_W0);
    int rows = e->rows;
    for (int i = 0; i < rows; i++) w[i] = w0[i];
    for (int b = 0; b < 2; b++) pinch_force_rows_times(rows, e->block[b].size, e->block[b].g, q + e->block[b].first, w);
}

static inline void trial_at(const pinch_force_element *e, const double *w, double *z)
{
    const double *rho = pinch_force_values(e, PINCH_FORCE_RHO), *r = pinch_force_values(e, PINCH_FORCE_R);
    const double *compliance = pinch_force_values(e, PINCH_FORCE_COMPLIANCE), *b = pinch_force_values(e, PINCH_FORCE_B);
    for (int i = 0; i < e->rows; i++) z[i] = (1 - rho[i] * compliance[i]) * r[i] - rho[i] * (w[i] - b[i]);
}

static inline void trial_of(const pinch_force_element *e, const double *q, double *z)
{
    double w[PINCH_CONTACT_ROWS_MAX];
    velocity_of(e, q, w);
    trial_at(e, w, z);
}

void pinch_force_element_velocity(const pinch_force_element *e, const double *q, double *w)
{
    velocity_of(e, q, w);
}

void pinch_force_trial(const pinch_force_element *e, const double *q, double *z)
{
    trial_of(e, q, z);
}

/* impulse = factor x. Returns whether there is any. */
static inline bool find_impulse(const pinch_force_element *e, double factor, const double *x, double *impulse)
{
    bool any = false;
    for (int i = 0; i < e->rows; i++) {
        impulse[i] = factor * x[i];
        any = any || impulse[i] != 0;
    }
    return any;
}

/* Adds what the impulse does to the block b. */
static inline void add_to_block(const pinch_force_element *e, int b, const double *impulse, double *q)
{
    pinch_force_rows_transposed_times(e->rows, e->block[b].size, e->block[b].g, impulse, q + e->block[b].first);
}

static inline void add_impulse(const pinch_force_element *e, double factor, const double *x, double *q)
{
    double impulse[PINCH_CONTACT_ROWS_MAX];
    if (!find_impulse(e, factor, x, impulse)) return;
    for (int b = 0; b < 2; b++)
        if (e->block[b].size > 0) add_to_block(e, b, impulse, q);
}

void pinch_force_add_impulse(const pinch_force_element *e, double factor, const double *x, double *q)
{
    if (e->rows == PINCH_FORCE_CONTACT) /* the same, with loops that the compiler unrolls */
        add_impulse(e, factor, x, q);
    else
        add_impulse(e, factor, x, q);
}

/* w + g x and q += y g: most blocks are those of free bodies, whose loops the compiler unrolls. */
static inline double plus_row(double w, const pinch_row_block *block, const double *x)
{
    const double *g = block->g;
    return w + (block->size == PINCH_FORCE_BODY ? pinch_dot6(g, x) : pinch_dot_strands(g, x, block->size));
}

static inline void add_row(const pinch_row_block *block, double y, double *restrict q)
{
    const double *restrict g = block->g;
    if (block->size == PINCH_FORCE_BODY) {
        for (int k = 0; k < PINCH_FORCE_BODY; k++) q[k] += y * g[k];
        return;
    }
    for (int k = 0; k < block->size; k++) q[k] += y * g[k];
}

static double evaluate_multipliers(pinch_force_system *s)
{
    double sum = 0, off = 0, missed = 0;
    for (int i = 0; i < s->multiplier_count; i++) {
        pinch_force_multiplier *m = &s->multipliers[i];
        double w = 0;
        for (int b = 0; b < m->blocks; b++) w = plus_row(w, &m->block[b], s->q + m->block[b].first);
        if (!s->dependent_rows) m->anchor = m->y; /* kappa keeps the matrix regular, and is no part of the law */
        m->trial = m->y - (w - m->unit.target + m->kappa * (m->y - m->anchor)) - m->unit.compliance * m->y;
        m->bound = m->trial <= m->unit.low ? -1 : m->trial >= m->unit.high ? 1 : 0;
        m->f = m->y - pinch_within(m->trial, m->unit.low, m->unit.high);
        sum += m->f * m->f;
        off = pinch_larger(off, fabs(m->f));
        missed = pinch_larger(missed, fabs(m->f) * m->unit.sigma);
    }
    s->row_off = off / s->scale;
    s->row_missed = missed;
    return sum;
}

/*
 * Returns how far the force p = P(z), which is f off, is from its law as the check of an answer will measure it, N. The
 * law's own trial force p - f / (rho C) is f magnified; where it lies beyond the limit of friction and p does not, p's
 * distance from that limit counts.
 */
static inline double distance_from_law(const pinch_force_element *e, int rows, const double *p, const double *force_off)
{
    const double *rho = pinch_force_values(e, PINCH_FORCE_RHO);
    const double *compliance = pinch_force_values(e, PINCH_FORCE_COMPLIANCE);
    double off = 0, magnified = 0;
    bool compliant = e->contact && !e->contact->may_soften;
    for (int i = 0; i < rows && i < 3; i++) {
        double f = fabs(force_off[i]), by_law = f / (rho[i] * compliance[i]);
        off = pinch_larger(off, compliant ? by_law : f);
        if (i > 0) magnified = pinch_larger(magnified, 2 * by_law);
    }
    if (rows == 1 || magnified <= off) return off;
    double reach2 = 0, largest = 0, smallest = INFINITY;
    for (int i = 0; i < 2; i++) {
        double axis = e->law->limit[i] + e->law->friction[i] * p[0];
        if (!(axis > 0) || isinf(axis)) continue;
        reach2 += p[1 + i] / axis * (p[1 + i] / axis);
        largest = pinch_larger(largest, axis);
        smallest = axis < smallest ? axis : smallest;
    }
    double inside = 1 - magnified / smallest;
    if (reach2 < 1 && (inside <= 0 || reach2 > inside * inside)) off = pinch_larger(off, largest * (1 - sqrt(reach2)));
    return off;
}

typedef struct impulse_task {
    const pinch_force_system *system;
    pinch_force_value value;
    double *to;
} impulse_task;

static void gather_impulses(void *argument, int first, int end)
{
    const impulse_task *task = argument;
    const pinch_force_system *s = task->system;
    double impulse[PINCH_CONTACT_ROWS_MAX];
    for (int m = s->meet_first[first]; m < s->meet_first[end]; m++) {
        const pinch_force_element *e = &s->elements[s->meets[m] / 2];
        if (find_impulse(e, s->step, pinch_force_values(e, task->value), impulse))
            add_to_block(e, s->meets[m] % 2, impulse, task->to);
    }
}

void pinch_force_add_impulses(const pinch_force_system *s, pinch_force_value value, double *to)
{
    impulse_task task = {s, value, to};
    if (s->meets) {
        pinch_each(s->crew, s->mobility->cluster_count, gather_impulses, &task);
        return;
    }
    for (int k = 0; k < s->element_count; k++)
        pinch_force_add_impulse(&s->elements[k], s->step, pinch_force_values(&s->elements[k], value), to);
}

void pinch_force_move(pinch_force_system *s)
{
    size_t bytes = sizeof(double) * (size_t)s->mobility->unknowns;
    if (s->base_q)
        memcpy(s->q, s->base_q, bytes);
    else
        memset(s->q, 0, bytes);
    pinch_force_add_impulses(s, PINCH_FORCE_R, s->q);
    for (int i = 0; i < s->multiplier_count; i++) {
        const pinch_force_multiplier *m = &s->multipliers[i];
        for (int b = 0; b < m->blocks; b++) add_row(&m->block[b], m->y, s->q + m->block[b].first);
    }
}

/* The velocities of all elements while joint rows hold: w = w_0 + h W r. */
static void move_in_contacts(const pinch_force_system *s)
{
    const pinch_force_condensed *c = s->condensed;
    int n = c->rows;
    double *restrict w = c->w;
    memcpy(w, c->still, sizeof *w * (size_t)n);
    const double *line[4];
    double force[4];
    int waiting = 0;
    for (int k = 0; k < s->element_count; k++) {
        const double *r = pinch_force_values(&s->elements[k], PINCH_FORCE_R);
        for (int i = 0; i < s->elements[k].rows; i++) {
            if (r[i] == 0) continue;
            force[waiting] = r[i];
            line[waiting++] = c->delassus + (c->first[k] + i) * n; /* W is symmetric */
            if (waiting < 4) continue;
            pinch_add_four_multiples(n, force, line, w);
            waiting = 0;
        }
    }
    for (int i = 0; i < waiting; i++) pinch_add_multiple(n, force[i], line[i], w);
}

/* Adds what the k-th element has to what is found of a chunk. rows: its rows; the compiler unrolls loops where it is a
 * constant. */
static inline void evaluate_element(const pinch_force_system *s, int k, int rows, pinch_force_partial *found)
{
    pinch_force_element *e = &s->elements[k];
    const double *rho = pinch_force_values(e, PINCH_FORCE_RHO), *r = pinch_force_values(e, PINCH_FORCE_R);
    double *z = pinch_force_values(e, PINCH_FORCE_Z), p[PINCH_CONTACT_ROWS_MAX], f[PINCH_CONTACT_ROWS_MAX];
    bool inside = true;
    if (s->in_contacts)
        trial_at(e, s->condensed->w + s->condensed->first[k], z);
    else
        trial_of(e, s->q, z);
    (void)pinch_contact_law_project(e->law, rho, z, p, NULL);
    for (int i = 0; i < rows; i++) {
        inside = inside && p[i] == z[i];
        f[i] = r[i] - p[i];
        found->sum += s->step / rho[i] * f[i] * f[i];
    }
    e->inside = inside;
    found->off = pinch_larger(found->off, distance_from_law(e, rows, p, f));
    for (int i = 0; i < rows && i < 3; i++) found->force = pinch_larger(found->force, fabs(p[i]));
}

static void evaluate_elements(void *argument, int first, int end)
{
    pinch_force_system *s = argument;
    pinch_force_partial found = {.sum = 0};
    for (int k = first; k < end; k++)
        if (s->elements[k].rows == PINCH_FORCE_CONTACT) /* as most have */
            evaluate_element(s, k, PINCH_FORCE_CONTACT, &found);
        else
            evaluate_element(s, k, s->elements[k].rows, &found);
    s->partials[first / PINCH_CHUNK] = found;
}

double pinch_force_evaluate(pinch_force_system *s)
{
    if (s->in_contacts)
        move_in_contacts(s);
    else
        pinch_force_move(s);
    pinch_loop(s->crew, s->element_count, evaluate_elements, s);
    double sum = sum_of_chunks(s);
    s->off = s->force = 0;
    for (int k = 0; k < pinch_chunk_count(s->element_count); k++) {
        s->off = pinch_larger(s->off, s->partials[k].off);
        s->force = pinch_larger(s->force, s->partials[k].force);
    }
    s->row_off = s->row_missed = 0;
    if (!s->in_contacts) sum += evaluate_multipliers(s);
    return sqrt(sum) / s->scale;
}

bool pinch_force_make_room(pinch_arena *arena, const pinch_force_system *s, pinch_force_answer *a)
{
    int forces = 0;
    for (int k = 0; k < s->element_count; k++) forces += s->elements[k].rows;
    a->r = PINCH_ARENA_ARRAY(arena, double, forces + 1);
    a->base_q = s->base_q ? PINCH_ARENA_ARRAY(arena, double, s->mobility->unknowns + 1) : NULL;
    a->multipliers = PINCH_ARENA_ARRAY(arena, pinch_force_multiplier, s->multiplier_count + 1);
    return !arena->failed;
}

static void copy(void *to, void *from, bool back, size_t bytes)
{
    memcpy(back ? from : to, back ? to : from, bytes);
}

void pinch_force_keep(pinch_force_system *s, pinch_force_answer *a, bool back)
{
    double *kept = a->r;
    for (int k = 0; k < s->element_count; kept += s->elements[k++].rows)
        copy(kept, pinch_force_values(&s->elements[k], PINCH_FORCE_R), back,
             sizeof *kept * (size_t)s->elements[k].rows);
    copy(a->multipliers, s->multipliers, back, sizeof *s->multipliers * (size_t)s->multiplier_count);
    if (s->base_q) copy(a->base_q, s->base_q, back, sizeof *s->base_q * (size_t)s->mobility->unknowns);
}
