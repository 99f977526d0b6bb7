#include "stiff/stiff_system.h"

#include "support/lu.h"

#include <math.h>
#include <string.h>

/* of a block with one row */
static double block_norm2(const pinch_element_block *block)
{
    double sum = 0;
    for (int k = 0; k < block->size; k++) sum += block->g[k] * block->g[k];
    return sum;
}

static double row_norm2(const pinch_element_block block[2], int row)
{
    double sum = 0;
    for (int b = 0; b < 2; b++)
        for (int k = 0; k < block[b].size; k++) {
            double g = block[b].g[row * block[b].size + k];
            sum += g * g;
        }
    return sum;
}

static bool add_contact(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility,
                        pinch_contact *contact, pinch_stiff_element *e)
{
    double jacobian[2][6 * PINCH_STIFF_ROWS], h = problem->step;
    const int body[2] = {contact->body1, contact->body2};
    const double sign[2] = {1, -1};
    const double *const jacobians[2] = {jacobian[0], jacobian[1]};
    memset(e, 0, sizeof *e);
    e->contact = contact;
    pinch_stiff_law_of_contact(contact, &e->law);
    int rows = e->law.rows;
    memcpy(e->w0, contact->surface_velocity, sizeof contact->surface_velocity);
    for (int side = 0; side < 2; side++)
        if (body[side] >= 0) pinch_contact_jacobian(contact, &problem->bodies[body[side]], rows, jacobian[side]);
    if (!pinch_reduce_rows(arena, mobility, rows, body, jacobians, sign, e->block, e->cluster, e->w0)) return false;
    for (int i = 0; i < rows; i++) {
        int kind = i == 0 ? 0 : i < 3 ? 1 : 2;
        e->inertia[i] = row_norm2(e->block, i);
        e->prescribed[i] = 1 / (h * contact->stiffness[kind] + contact->damping[kind]);
        if (kind == 1 && contact->viscous[i - 1] > 0) e->prescribed[i] = contact->viscous[i - 1];
    }
    memcpy(e->elastic, contact->elastic, sizeof contact->elastic);
    memcpy(e->elastic + 3, contact->rolling_elastic, sizeof contact->rolling_elastic);
    memcpy(e->stiffness, contact->stiffness, sizeof contact->stiffness);
    memcpy(e->damping, contact->damping, sizeof contact->damping);
    memcpy(e->viscous, contact->viscous, sizeof contact->viscous);
    memcpy(e->compliance_before, contact->compliance, sizeof contact->compliance);
    return true;
}

void pinch_stiff_undo(const pinch_stiff_system *s)
{
    for (int k = 0; k < s->contact_count; k++) {
        const pinch_stiff_element *e = &s->elements[k];
        pinch_contact *c = e->contact;
        memcpy(c->elastic, e->elastic, sizeof c->elastic);
        memcpy(c->rolling_elastic, e->elastic + 3, sizeof c->rolling_elastic);
        memcpy(c->stiffness, e->stiffness, sizeof c->stiffness);
        memcpy(c->damping, e->damping, sizeof c->damping);
        memcpy(c->viscous, e->viscous, sizeof c->viscous);
        memcpy(c->compliance, e->compliance_before, sizeof c->compliance);
    }
}

static bool add_row(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility, int index,
                    pinch_stiff_element *e, pinch_stiff_multiplier *m, bool compliant)
{
    const pinch_joint_row *row = &problem->rows[index];
    const int body[2] = {row->body1, row->body2};
    const double sign[2] = {1, 1};
    const double *const jacobians[2] = {row->j1, row->j2};
    double w0 = 0;
    pinch_element_block *block = compliant ? e->block : m->block;
    int *cluster = compliant ? e->cluster : m->cluster;
    if (compliant)
        memset(e, 0, sizeof *e);
    else
        memset(m, 0, sizeof *m);
    if (!pinch_reduce_rows(arena, mobility, 1, body, jacobians, sign, block, cluster, &w0)) return false;
    if (cluster[1] >= 0 && block_norm2(&block[1]) > block_norm2(&block[0])) { /* the home is where it acts most */
        pinch_element_block swapped = block[0];
        int other = cluster[0];
        block[0] = block[1];
        cluster[0] = cluster[1];
        block[1] = swapped;
        cluster[1] = other;
    }
    double sigma2 = row_norm2(block, 0);
    if (compliant) {
        e->law.rows = 1;
        e->law.low = row->low;
        e->law.high = row->high;
        e->w0[0] = w0;
        e->b[0] = row->rhs;
        e->inertia[0] = sigma2;
        e->prescribed[0] = row->cfm;
        return true;
    }
    double h = problem->step, sigma = sqrt(sigma2);
    m->row = index;
    m->sigma = sigma;
    if (sigma == 0) return true; /* acts on nothing that can move: its target, bounds and y stay 0 */
    m->target = (row->rhs - w0) / sigma;
    m->low = h * sigma * row->low;
    m->high = h * sigma * row->high;
    for (int b = 0; b < 2; b++) { /* the array is this row's own */
        double *g = (double *)m->block[b].g;
        for (int k = 0; k < m->block[b].size; k++) g[k] /= sigma;
    }
    return true;
}

bool pinch_stiff_system_build(pinch_arena *arena, pinch_problem *problem, const pinch_mobility *mobility,
                              pinch_stiff_system *s)
{
    memset(s, 0, sizeof *s);
    s->step = problem->step;
    s->mobility = mobility;
    s->contact_count = problem->contact_count;
    s->elements = PINCH_ARENA_ARRAY(arena, pinch_stiff_element, problem->contact_count + problem->row_count + 1);
    s->multipliers = PINCH_ARENA_ARRAY(arena, pinch_stiff_multiplier, problem->row_count + 1);
    s->element_of_row = PINCH_ARENA_ARRAY(arena, int, problem->row_count + 1);
    s->q = PINCH_ARENA_ARRAY(arena, double, mobility->unknowns + 1);
    if (arena->failed) return false;
    for (int k = 0; k < problem->contact_count; k++)
        if (!add_contact(arena, problem, mobility, &problem->contacts[k], &s->elements[k])) return false;
    s->element_count = problem->contact_count;
    for (int j = 0; j < problem->row_count; j++) {
        bool compliant = problem->rows[j].cfm > 0;
        s->element_of_row[j] = -1;
        if (pinch_row_is_hard(&problem->rows[j])) continue;
        s->element_of_row[j] = compliant ? s->element_count : -2 - s->multiplier_count;
        if (!add_row(arena, problem, mobility, j, &s->elements[s->element_count], &s->multipliers[s->multiplier_count],
                     compliant))
            return false;
        if (compliant)
            s->element_count++;
        else
            s->multiplier_count++;
    }
    return true;
}

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
    for (int b = 0; b < 2; b++) {
        const pinch_element_block *block = &e->block[b];
        const double *x = q + block->first;
        int size = block->size;
        for (int i = 0; i < rows; i++) {
            const double *g = block->g + i * size;
            double sum = 0;
            for (int k = 0; k < size; k++) sum += g[k] * x[k];
            w[i] += sum;
        }
    }
}

void pinch_stiff_add_impulse(const pinch_stiff_element *e, double factor, const double *x, double *q)
{
    for (int b = 0; b < 2; b++) {
        const pinch_element_block *block = &e->block[b];
        double *to = q + block->first;
        int size = block->size;
        for (int i = 0; i < e->law.rows; i++) {
            double impulse = factor * x[i];
            if (impulse == 0) continue;
            const double *g = block->g + i * size;
            for (int k = 0; k < size; k++) to[k] += impulse * g[k];
        }
    }
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

double pinch_stiff_evaluate(pinch_stiff_system *s)
{
    double sum = 0, h = s->step;
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
        for (int i = 0; i < e->law.rows; i++) {
            e->f[i] = e->r[i] - p[i];
            sum += h / e->rho[i] * e->f[i] * e->f[i];
        }
    }
    return sqrt(sum + evaluate_multipliers(s)) / s->scale;
}

/* shift = A^-1 F, slope = D = A^-1 J rho; false where A is singular. */
static bool eliminate_force(pinch_stiff_element *e)
{
    enum { N = PINCH_STIFF_ROWS };
    double derivative[N * N], a[N * N], column[N], scratch[N], p[N];
    int pivot[N], rows = e->law.rows;
    (void)pinch_stiff_project(&e->law, e->rho, e->z, p, derivative);
    if (rows == 1) {
        double j = derivative[0], over = 1 / (1 - j * (1 - e->rho[0] * e->compliance[0]));
        e->shift[0] = over * e->f[0];
        e->slope[0] = over * j * e->rho[0];
        return true;
    }
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < rows; j++)
            a[i * rows + j] = (i == j) - derivative[i * rows + j] * (1 - e->rho[j] * e->compliance[j]);
    if (!pinch_lu_factor(rows, a, pivot, scratch)) return false;
    pinch_lu_solve(rows, a, pivot, e->f, e->shift);
    for (int j = 0; j < rows; j++) {
        for (int i = 0; i < rows; i++) column[i] = derivative[i * rows + j] * e->rho[j];
        pinch_lu_solve(rows, a, pivot, column, column);
        for (int i = 0; i < rows; i++) e->slope[i * rows + j] = column[i];
    }
    return true;
}

/* matrix += h G_a^T D G_b for the pairs of the element's blocks */
static void add_products(pinch_stiff_system *s, const pinch_stiff_element *e)
{
    int rows = e->law.rows;
    for (int b = 0; b < 2; b++) {
        const pinch_element_block *right = &e->block[b];
        if (e->cluster[b] < 0) continue;
        for (int a = 0; a < 2; a++) {
            const pinch_element_block *left = &e->block[a];
            if (e->cluster[a] < 0) continue;
            double *to = pinch_block_lu_at(&s->lu, e->cluster[a], e->cluster[b]);
            int stride = s->block_size[e->cluster[b]], size = right->size;
            for (int i = 0; i < rows; i++) {
                double weighted[64];
                for (int k0 = 0; k0 < size; k0 += 64) { /* wide blocks go through in parts */
                    int width = size - k0 < 64 ? size - k0 : 64;
                    for (int k = 0; k < width; k++) weighted[k] = 0;
                    bool any = false;
                    for (int j = 0; j < rows; j++) {
                        double d = s->step * e->slope[i * rows + j];
                        if (d == 0) continue;
                        any = true;
                        const double *g = right->g + j * size + k0;
                        for (int k = 0; k < width; k++) weighted[k] += d * g[k];
                    }
                    for (int l = 0; any && l < left->size; l++) {
                        double g = left->g[i * left->size + l];
                        double *line = to + l * stride + k0;
                        for (int k = 0; k < width; k++) line[k] += g * weighted[k];
                    }
                }
            }
        }
    }
}

/* The rows and columns of a multiplier, which stands in its first cluster's block: inside its bounds F_b = w - c, at
 * one of them y - bound. Multipliers that say the same twice leave the matrix singular but for a little of their own,
 * which makes a step less exact and no answer. */
static void add_multiplier(pinch_stiff_system *s, const pinch_stiff_multiplier *m)
{
    bool inside = m->trial > m->low && m->trial < m->high;
    int home = m->cluster[0], at = m->unknown - s->block_first[home];
    double *own = pinch_block_lu_at(&s->lu, home, home);
    static const double REDUNDANT = 1e-10;
    own[at * s->block_size[home] + at] = inside ? REDUNDANT : 1;
    s->rhs[m->unknown] = -m->f;
    for (int b = 0; b < 2; b++) {
        if (m->cluster[b] < 0) continue;
        double *row = pinch_block_lu_at(&s->lu, home, m->cluster[b]) + at * s->block_size[m->cluster[b]];
        double *column = pinch_block_lu_at(&s->lu, m->cluster[b], home) + at;
        for (int k = 0; k < m->block[b].size; k++) {
            if (inside) row[k] += m->block[b].g[k];
            column[k * s->block_size[home]] -= m->block[b].g[k];
        }
    }
}

static bool plan(pinch_arena *arena, pinch_stiff_system *s)
{
    int clusters = s->mobility->cluster_count, edges = 0;
    s->block_size = PINCH_ARENA_ARRAY(arena, int, clusters + 1);
    s->block_first = PINCH_ARENA_ARRAY(arena, int, clusters + 1);
    int *edge = PINCH_ARENA_ARRAY(arena, int, 2 * (s->element_count + s->multiplier_count) + 1);
    if (arena->failed) return false;
    for (int c = 0; c < clusters; c++) s->block_size[c] = s->mobility->clusters[c].freedoms;
    for (int i = 0; i < s->multiplier_count; i++) {
        pinch_stiff_multiplier *m = &s->multipliers[i];
        m->unknown = s->block_size[m->cluster[0]]++;
    }
    s->block_first[0] = 0;
    for (int c = 0; c < clusters; c++) s->block_first[c + 1] = s->block_first[c] + s->block_size[c];
    for (int i = 0; i < s->multiplier_count; i++) {
        pinch_stiff_multiplier *m = &s->multipliers[i];
        m->unknown += s->block_first[m->cluster[0]];
        if (m->cluster[1] < 0) continue;
        edge[2 * edges] = m->cluster[0];
        edge[2 * edges++ + 1] = m->cluster[1];
    }
    for (int k = 0; k < s->element_count; k++) {
        const int *cluster = s->elements[k].cluster;
        if (cluster[0] < 0 || cluster[1] < 0) continue;
        edge[2 * edges] = cluster[0];
        edge[2 * edges++ + 1] = cluster[1];
    }
    s->rhs = PINCH_ARENA_ARRAY(arena, double, s->block_first[clusters] + 1);
    s->planned = true;
    return !arena->failed && pinch_block_lu_plan(arena, clusters, s->block_size, edges, edge, &s->lu);
}

static bool assemble(pinch_stiff_system *s)
{
    pinch_block_lu_clear(&s->lu);
    memset(s->rhs, 0, sizeof(double) * (size_t)s->block_first[s->mobility->cluster_count]);
    for (int c = 0; c < s->mobility->cluster_count; c++) {
        double *own = pinch_block_lu_at(&s->lu, c, c);
        for (int k = 0; k < s->mobility->clusters[c].freedoms; k++) own[k * s->block_size[c] + k] = 1;
    }
    for (int k = 0; k < s->element_count; k++) {
        pinch_stiff_element *e = &s->elements[k];
        if (!eliminate_force(e)) return false;
        add_products(s, e);
        for (int b = 0; b < 2; b++) { /* rhs -= h G^T shift */
            if (e->cluster[b] < 0) continue;
            double *to = s->rhs + s->block_first[e->cluster[b]];
            for (int i = 0; i < e->law.rows; i++)
                for (int l = 0; l < e->block[b].size; l++)
                    to[l] -= s->step * e->block[b].g[i * e->block[b].size + l] * e->shift[i];
        }
    }
    for (int i = 0; i < s->multiplier_count; i++) add_multiplier(s, &s->multipliers[i]);
    return true;
}

/* dr = -shift - D G dq */
static void changes_from(pinch_stiff_system *s)
{
    for (int k = 0; k < s->element_count; k++) {
        pinch_stiff_element *e = &s->elements[k];
        int rows = e->law.rows;
        double moved[PINCH_STIFF_ROWS] = {0};
        for (int b = 0; b < 2; b++) {
            if (e->cluster[b] < 0) continue;
            const double *dq = s->rhs + s->block_first[e->cluster[b]];
            for (int i = 0; i < rows; i++)
                for (int l = 0; l < e->block[b].size; l++) moved[i] += e->block[b].g[i * e->block[b].size + l] * dq[l];
        }
        for (int i = 0; i < rows; i++) {
            e->change[i] = -e->shift[i];
            for (int j = 0; j < rows; j++) e->change[i] -= e->slope[i * rows + j] * moved[j];
        }
    }
    for (int i = 0; i < s->multiplier_count; i++) s->multipliers[i].change = s->rhs[s->multipliers[i].unknown];
}

bool pinch_stiff_step(pinch_arena *arena, pinch_stiff_system *s, bool *singular)
{
    *singular = false;
    if (!s->planned && !plan(arena, s)) return false;
    if (!assemble(s) || !pinch_block_lu_factor(&s->lu)) {
        *singular = true;
        return false;
    }
    pinch_block_lu_solve(&s->lu, s->rhs);
    changes_from(s);
    return true;
}
