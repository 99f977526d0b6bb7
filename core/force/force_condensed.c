/*
 * Newton's steps of a mechanism in its contacts alone, equation (62) of core/README.md: the multipliers of its joint
 * rows are eliminated once a solve (static condensation), and every step has a dense matrix of as many rows as contacts
 * have, in place of blocks for all bodies and joints. What forces move while the rows hold is
 *
 *     w = w_0 + h W r,    W = G G^T - X^T X,    X = L^-1 J G^T.
 */
#include "force/force_joints.h"
#include "force/force_rows.h"

#include "support/dense.h"
#include "support/lu.h"

#include <math.h>
#include <string.h>

/* A solve with as many Newton steps as usual takes fewer multiplications in the contacts alone where three factors of
 * theirs, and W, take up to this many for each cluster. */
static const double MOST_FOR_A_CLUSTER = 7500;

/* Numbers the rows. meets[p]: how many of them meet a row of S up to p; these come first. */
static bool number_rows(pinch_arena *arena, const pinch_force_system *s, pinch_force_condensed *c, int *meets)
{
    const pinch_force_joints *j = s->joints;
    int *earliest = PINCH_ARENA_ARRAY(arena, int, s->element_count + 1);
    int *element_at = PINCH_ARENA_ARRAY(arena, int, c->rows + 1);
    if (arena->failed) return false;
    memset(meets, 0, sizeof *meets * (size_t)(j->count + 1));
    for (int k = 0; k < s->element_count; k++) {
        const pinch_force_element *e = &s->elements[k];
        earliest[k] = j->count;
        for (int b = 0; b < 2; b++)
            for (int at = e->cluster[b] < 0 ? 0 : j->start[e->cluster[b]];
                 e->cluster[b] >= 0 && at < j->start[e->cluster[b] + 1]; at++)
                if (j->place[j->multiplier[at]] < earliest[k]) earliest[k] = j->place[j->multiplier[at]];
        meets[earliest[k]] += e->rows;
    }
    for (int p = 1; p <= j->count; p++) meets[p] += meets[p - 1];
    for (int k = s->element_count - 1; k >= 0; k--) { /* counting sort, backwards: meets[p] becomes where p's begin */
        meets[earliest[k]] -= s->elements[k].rows;
        c->first[k] = meets[earliest[k]];
    }
    for (int p = 0; p < j->count; p++) meets[p] = meets[p + 1]; /* where those of p end */
    for (int k = 0; k < s->element_count; k++) element_at[c->first[k]] = k;
    for (int row = 0, k = 0; row < c->rows; row += s->elements[c->order[k++]].rows) c->order[k] = element_at[row];
    return true;
}

/* x = L^-1 J G^T, a row for each of S, of which those that `meets` it are not zero */
static void project(const pinch_force_system *s, const int *meets, const pinch_force_condensed *c, double *x)
{
    const pinch_force_joints *j = s->joints;
    int n = c->rows;
    memset(x, 0, sizeof *x * (size_t)j->count * (size_t)n);
    for (int k = 0; k < s->element_count; k++) {
        const pinch_force_element *e = &s->elements[k];
        for (int b = 0; b < 2; b++)
            for (int at = e->cluster[b] < 0 ? 0 : j->start[e->cluster[b]];
                 e->cluster[b] >= 0 && at < j->start[e->cluster[b] + 1]; at++) {
                if (j->held[j->multiplier[at]] != 0) continue;
                int size = e->block[b].size;
                const double *g = s->multipliers[j->multiplier[at]].block[j->block[at]].g;
                double *own = x + j->place[j->multiplier[at]] * n + c->first[k];
                for (int i = 0; i < e->rows; i++) own[i] += pinch_dot_strands(g, e->block[b].g + i * size, size);
            }
    }
    for (int p = 0; p < j->count; p++) {
        double *own = x + p * n, over = j->inverse[p];
        const double *factor = j->line[p];
        int k = j->begin[p];
        for (; k + 3 < p; k += 4) { /* later rows meet as many or more */
            const double f[4] = {-factor[k], -factor[k + 1], -factor[k + 2], -factor[k + 3]};
            const double *const other[4] = {x + k * n, x + (k + 1) * n, x + (k + 2) * n, x + (k + 3) * n};
            int common = meets[k];
            pinch_add_four_multiples(common, f, other, own);
            for (int l = 1; l < 4; l++)
                pinch_add_multiple(meets[k + l] - common, f[l], other[l] + common, own + common);
        }
        for (; k < p; k++) pinch_add_multiple(meets[k], -factor[k], x + k * n, own);
        for (int i = 0; i < meets[p]; i++) own[i] *= over;
    }
}

/* G G^T of two elements, rows x rows of them, is added to `to`. */
static void add_coupling(const pinch_force_element *a, const pinch_force_element *b, int stride, double *to)
{
    for (int p = 0; p < 2; p++)
        for (int q = 0; q < 2; q++) {
            if (a->cluster[p] < 0 || a->cluster[p] != b->cluster[q]) continue;
            int size = a->block[p].size;
            for (int i = 0; i < a->rows; i++)
                for (int k = 0; k < b->rows; k++)
                    to[i * stride + k] += pinch_dot_strands(a->block[p].g + i * size, b->block[q].g + k * size, size);
        }
}

/* Forms h W. */
static void form_delassus(const pinch_force_system *s, const int *meets, const double *x, pinch_force_condensed *c)
{
    int n = c->rows;
    double *w = c->delassus;
    memset(w, 0, sizeof *w * (size_t)n * (size_t)n);
    int p = 0, count = s->joints->count;
    for (; p + 3 < count; p += 4) {
        const double *const own[4] = {x + p * n, x + (p + 1) * n, x + (p + 2) * n, x + (p + 3) * n};
        for (int i = 0; i < meets[p + 3]; i++) { /* where a row meets less, it has zeros */
            const double f[4] = {-own[0][i], -own[1][i], -own[2][i], -own[3][i]};
            pinch_add_four_multiples(i + 1, f, own, w + i * n);
        }
    }
    for (; p < count; p++)
        for (int i = 0; i < meets[p]; i++) pinch_add_multiple(i + 1, -x[p * n + i], x + p * n, w + i * n);
    for (int a = 0; a < s->element_count; a++)
        for (int b = 0; b < s->element_count; b++)
            if (c->first[b] <= c->first[a])
                add_coupling(&s->elements[a], &s->elements[b], n, w + c->first[a] * n + c->first[b]);
    for (int i = 0; i < n; i++)
        for (int k = 0; k <= i; k++) w[k * n + i] = w[i * n + k] *= s->step;
}

static bool make_room(pinch_arena *arena, const pinch_force_system *s, pinch_force_condensed *c)
{
    int n = c->rows;
    c->first = PINCH_ARENA_ARRAY(arena, int, s->element_count + 1);
    c->order = PINCH_ARENA_ARRAY(arena, int, s->element_count + 1);
    c->acting = PINCH_ARENA_ARRAY(arena, int, s->element_count + 1);
    c->delassus = PINCH_ARENA_ARRAY(arena, double, n *n + 1);
    c->matrix = PINCH_ARENA_ARRAY(arena, double, n *n + 1);
    c->still = PINCH_ARENA_ARRAY(arena, double, n + 1);
    c->w = PINCH_ARENA_ARRAY(arena, double, n + 1);
    c->rhs = PINCH_ARENA_ARRAY(arena, double, n + 1);
    c->scratch = PINCH_ARENA_ARRAY(arena, double, n + 1);
    c->gathered = PINCH_ARENA_ARRAY(arena, double, PINCH_CONTACT_ROWS_MAX *n + 1);
    c->pivot = PINCH_ARENA_ARRAY(arena, int, n + 1);
    return !arena->failed;
}

static bool is_worth_it(const pinch_force_system *s, int rows)
{
    double work = pow(rows, 3), most = MOST_FOR_A_CLUSTER * s->mobility->cluster_count;
    if (s->dependent_rows) most *= 2; /* further passes take further steps */
    for (int p = 0; p < s->joints->count && work <= most; p++)
        work += (double)(p - s->joints->begin[p]) * rows + rows * rows / 4.0;
    return work <= most;
}

bool pinch_force_condense(pinch_arena *arena, pinch_force_system *s)
{
    int rows = 0;
    for (int k = 0; k < s->element_count; k++) rows += s->elements[k].rows;
    if (!s->joints || !is_worth_it(s, rows)) return true;
    pinch_force_condensed *c = PINCH_ARENA_ARRAY(arena, pinch_force_condensed, 1);
    if (!c) return false;
    c->rows = rows;
    if (!make_room(arena, s, c)) return false;
    pinch_arena_mark here = pinch_arena_here(arena);
    int *meets = PINCH_ARENA_ARRAY(arena, int, s->joints->count + 1);
    double *x = PINCH_ARENA_ARRAY(arena, double, s->joints->count *rows + 1);
    if (arena->failed || !number_rows(arena, s, c, meets)) return false;
    project(s, meets, c, x);
    form_delassus(s, meets, x, c);
    pinch_arena_rewind(arena, &here);
    s->condensed = c;
    return true;
}

void pinch_force_enter_contacts(pinch_force_system *s)
{
    pinch_force_satisfy_rows(s, false);
    for (int k = 0; k < s->element_count; k++)
        pinch_force_element_velocity(&s->elements[k], s->q, s->condensed->still + s->condensed->first[k]);
    for (int i = 0; i < s->multiplier_count; i++) s->multipliers[i].change = s->multipliers[i].f = 0;
    s->in_contacts = true;
}

void pinch_force_advance_contacts(pinch_force_system *s)
{
    pinch_force_advance_rows(s);
    for (int k = 0; k < s->element_count; k++) {
        const pinch_force_element *e = &s->elements[k];
        for (int b = 0; b < 2; b++)
            pinch_force_rows_times(e->rows, e->block[b].size, e->block[b].g, s->q + e->block[b].first,
                                   s->condensed->still + s->condensed->first[k]);
    }
}

/* Writes how the elements that do not conduct change all velocities. */
static void move_by_others(const pinch_force_system *s, double *restrict moved)
{
    const pinch_force_condensed *c = s->condensed;
    int n = c->rows;
    memset(moved, 0, sizeof *moved * (size_t)n);
    for (int k = 0; k < s->element_count; k++) {
        const double *change = pinch_force_values(&s->elements[k], PINCH_FORCE_CHANGE);
        for (int i = 0; i < s->elements[k].rows && !s->elements[k].conducts; i++) {
            const double *restrict line = c->delassus + (c->first[k] + i) * n;
            if (change[i] != 0) pinch_add_multiple(n, change[i], line, moved);
        }
    }
}

/* Returns what a row of h W has for the elements that conduct; it is copied to `to` where others are in between. */
static const double *gather(const pinch_force_system *s, const double *row, int acting, double *restrict to)
{
    const pinch_force_condensed *c = s->condensed;
    if (acting == s->element_count) return row;
    const double *gathered = to;
    for (int b = 0; b < acting; b++) {
        const double *restrict from = row + c->first[c->acting[b]];
        int rows = s->elements[c->acting[b]].rows;
        if (rows == PINCH_FORCE_CONTACT) {
            for (int k = 0; k < PINCH_FORCE_CONTACT; k++) to[k] = from[k];
        } else {
            for (int k = 0; k < rows; k++) to[k] = from[k];
        }
        to += rows;
    }
    return gathered;
}

/* to (3 x n) = D w of a contact with friction, whose normal force follows its normal velocity alone; w: rows of h W. */
static void multiply_contact(int n, const double *d, const double *const w[3], double *restrict to)
{
    double *restrict t = to + n, *restrict u = t + n;
    const double *restrict w0 = w[0], *restrict w1 = w[1], *restrict w2 = w[2];
    int k = 0;
    for (; k + 1 < n; k += 2) {
        const pinch_lanes a = pinch_lanes_at(w0 + k), b = pinch_lanes_at(w1 + k), e = pinch_lanes_at(w2 + k);
        pinch_lanes_put(d[0] * a, to + k);
        pinch_lanes_put(d[3] * a + d[4] * b + d[5] * e, t + k);
        pinch_lanes_put(d[6] * a + d[7] * b + d[8] * e, u + k);
    }
    if (k == n) return;
    to[k] = d[0] * w0[k];
    t[k] = d[3] * w0[k] + d[4] * w1[k] + d[5] * w2[k];
    u[k] = d[6] * w0[k] + d[7] * w1[k] + d[8] * w2[k];
}

/* The same for any law */
static void multiply_any(int rows, int n, const double *d, const double *const *w, double *to)
{
    memset(to, 0, sizeof *to * (size_t)rows * (size_t)n);
    for (int i = 0; i < rows; i++)
        for (int l = 0; l < rows; l++)
            if (d[i * rows + l] != 0) pinch_add_multiple(n, d[i * rows + l], w[l], to + i * n);
}

/* Writes the rows of the matrix and the right hand side that belong to the a-th of the elements that conduct. */
static void fill_rows(const pinch_force_system *s, int a, int acting, int size, int at)
{
    const pinch_force_condensed *c = s->condensed;
    const pinch_force_element *e = &s->elements[c->acting[a]];
    const double *conductance = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
    const double *change = pinch_force_values(e, PINCH_FORCE_CHANGE), *w[PINCH_CONTACT_ROWS_MAX];
    int own = c->first[c->acting[a]], rows = e->rows;
    double *line = c->matrix + at * size;
    for (int l = 0; l < rows; l++) w[l] = gather(s, c->delassus + (own + l) * c->rows, acting, c->gathered + l * size);
    if (rows == PINCH_FORCE_CONTACT)
        multiply_contact(size, conductance, w, line);
    else
        multiply_any(rows, size, conductance, w, line);
    for (int i = 0; i < rows; i++) {
        c->rhs[at + i] = change[i] - pinch_dot(conductance + i * rows, c->scratch + own, rows);
        line[i * size + at + i] += 1;
    }
}

/*
 * The forces that conduct change by what solves (I + h D W) dr = -A^-1 F - h D W dr', dr' being the changes of the
 * others: equation (26) with what forces move in the place of dq.
 */
bool pinch_force_condensed_step(pinch_force_system *s)
{
    pinch_force_condensed *c = s->condensed;
    int acting = 0, size = 0;
    for (int place = 0; place < s->element_count; place++) {
        int k = c->order[place];
        if (!pinch_force_eliminate(&s->elements[k], s->is_warm_start)) return false;
        if (!s->elements[k].conducts) continue;
        c->acting[acting++] = k;
        size += s->elements[k].rows;
    }
    s->is_warm_start = false;
    move_by_others(s, c->scratch);
    for (int a = 0, at = 0; a < acting; at += s->elements[c->acting[a++]].rows) fill_rows(s, a, acting, size, at);
    s->work += pow(size / 6.0, 3) / 3 + s->element_count;
    if (!pinch_lu_factor(size, c->matrix, c->pivot, c->scratch)) return false;
    pinch_lu_solve_strands(size, c->matrix, c->pivot, c->rhs);
    for (int a = 0, at = 0; a < acting; at += s->elements[c->acting[a++]].rows) {
        const pinch_force_element *e = &s->elements[c->acting[a]];
        memcpy(pinch_force_values(e, PINCH_FORCE_CHANGE), c->rhs + at, sizeof *c->rhs * (size_t)e->rows);
    }
    return true;
}
