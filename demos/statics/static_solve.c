/* Semi-smooth Newton on the statics of hands, in long double. */
#include "static_system.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What turns lengths into forces in the equation of a rigid row; any positive number leads to the same answer. */
static const double RIGID = 1e4; /* N/m */

typedef struct newton {
    static_system *s;
    int n;
    long double *f, *jacobian, *step, *trial;
    long double alpha, *anchor; /* of the flow; 0: none */
    long double *size;          /* per unknown: what makes a coordinate a length and its force a force, m or 1 */
    int *column, *row;
} newton;

static long double clamp(long double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}

/* ---- F and its Jacobian. ---- */

static void add_contact(newton *t, static_contact *c, const long double *z)
{
    const static_system *s = t->s;
    int m = s->coordinates, rows = c->law.rows;
    long double slope[16];
    for (int i = 0; i < 4; i++) {
        c->w[i] = 0;
        for (int j = 0; i < rows && j < m; j++) c->w[i] += c->g[i * m + j] * z[j];
    }
    exact_law_force(&c->law, c->w, -1, c->r, slope);
    for (int i = 0; i < rows; i++)
        for (int a = 0; a < m; a++) {
            long double ga = c->g[i * m + a];
            if (ga == 0) continue;
            t->f[a] += ga * c->r[i];
            for (int j = 0; j < rows; j++)
                for (int b = 0; b < m; b++) t->jacobian[a * t->n + b] += ga * slope[4 * i + j] * c->g[j * m + b];
        }
}

static void add_row(newton *t, static_row *b, const long double *z)
{
    int m = t->s->coordinates, n = t->n, u = b->unknown;
    long double missing = b->missing, slope = 0;
    for (int j = 0; j < m; j++) missing -= b->a[j] * z[j];
    if (b->rigid) {
        b->y = z[u];
        long double free = z[u] + RIGID * missing, bounded = clamp(free, b->low, b->high);
        bool acts = free > b->low && free < b->high;
        t->f[u] = z[u] - bounded;
        t->jacobian[u * n + u] = acts ? 0 : 1;
        for (int j = 0; j < m && acts; j++) t->jacobian[u * n + j] = RIGID * (long double)b->a[j];
        for (int j = 0; j < m; j++) t->jacobian[j * n + u] += b->a[j];
    } else {
        long double asked = b->constant + b->stiffness * missing;
        b->y = clamp(asked, b->low, b->high);
        slope = asked > b->low && asked < b->high ? b->stiffness : 0;
    }
    for (int i = 0; i < m; i++) {
        if (b->a[i] == 0) continue;
        t->f[i] += b->a[i] * b->y;
        for (int j = 0; j < m && slope > 0; j++) t->jacobian[i * n + j] -= slope * b->a[i] * b->a[j];
    }
}

/* Returns |F| in N, moments over the lever. */
static long double evaluate(newton *t, const long double *z)
{
    static_system *s = t->s;
    memset(t->f, 0, (size_t)t->n * sizeof *t->f);
    memset(t->jacobian, 0, (size_t)t->n * (size_t)t->n * sizeof *t->jacobian);
    for (int i = 0; i < s->coordinates; i++) {
        t->f[i] = s->load[i];
        for (int j = 0; j < s->coordinates; j++) {
            t->jacobian[i * t->n + j] = s->weight_change[i * s->coordinates + j];
            t->f[i] += s->weight_change[i * s->coordinates + j] * z[j];
        }
    }
    for (int i = 0; i < s->contact_count; i++) add_contact(t, &s->contacts[i], z);
    for (int i = 0; i < s->row_count; i++) add_row(t, &s->rows[i], z);
    for (int i = 0; i < s->coordinates && t->alpha > 0; i++) {
        long double drag = t->alpha * t->size[i] * t->size[i];
        t->f[i] -= drag * (z[i] - t->anchor[i]);
        t->jacobian[i * t->n + i] -= drag;
    }
    long double most = 0;
    for (int i = 0; i < t->n; i++) most = fmaxl(most, fabsl(t->f[i]) / t->size[i]);
    return most;
}

/* ---- A step. ---- */

static void exchange_rows(newton *t, int a, int b)
{
    int n = t->n;
    for (int j = 0; j < n; j++) {
        long double x = t->jacobian[a * n + j];
        t->jacobian[a * n + j] = t->jacobian[b * n + j];
        t->jacobian[b * n + j] = x;
    }
    long double x = t->f[a];
    t->f[a] = t->f[b];
    t->f[b] = x;
}

static void exchange_columns(newton *t, int a, int b)
{
    for (int i = 0; i < t->n; i++) {
        long double x = t->jacobian[i * t->n + a];
        t->jacobian[i * t->n + a] = t->jacobian[i * t->n + b];
        t->jacobian[i * t->n + b] = x;
    }
    int x = t->column[a];
    t->column[a] = t->column[b];
    t->column[b] = x;
}

/* In units in which lengths and forces are alike; each row is divided by its largest number. A row that is rounding
 * alone, as of a loop across its plane, asks for nothing. */
static void balance(newton *t)
{
    static const long double ROUNDING = 1e-9L; /* N/m */
    int n = t->n;
    for (int i = 0; i < n; i++) {
        long double most = 0, *row = t->jacobian + (size_t)i * n;
        for (int j = 0; j < n; j++) {
            row[j] /= t->size[j];
            most = fmaxl(most, fabsl(row[j]));
        }
        bool acts = most > ROUNDING;
        for (int j = 0; j < n; j++) row[j] = acts ? row[j] / most : 0;
        if (acts) t->f[i] /= most;
    }
}

/* Gaussian elimination with full pivoting: where rows depend on each other (loops in a plane, what nothing holds), the
 * rest is solved and what is left over does not move. */
static void solve_step(newton *t)
{
    static const long double LEAST = 1e-13L;
    int n = t->n, rank = 0;
    balance(t);
    for (int i = 0; i < n; i++) t->column[i] = i;
    for (; rank < n; rank++) {
        int pi = rank, pj = rank;
        long double most = 0;
        for (int i = rank; i < n; i++)
            for (int j = rank; j < n; j++)
                if (fabsl(t->jacobian[i * n + j]) > most) most = fabsl(t->jacobian[i * n + j]), pi = i, pj = j;
        if (!(most > LEAST)) break;
        exchange_rows(t, rank, pi);
        exchange_columns(t, rank, pj);
        for (int i = rank + 1; i < n; i++) {
            long double part = t->jacobian[i * n + rank] / t->jacobian[rank * n + rank];
            if (part == 0) continue;
            for (int j = rank; j < n; j++) t->jacobian[i * n + j] -= part * t->jacobian[rank * n + j];
            t->f[i] -= part * t->f[rank];
        }
    }
    memset(t->step, 0, (size_t)n * sizeof *t->step);
    for (int i = rank - 1; i >= 0; i--) {
        long double sum = -t->f[i];
        for (int j = i + 1; j < rank; j++) sum -= t->jacobian[i * n + j] * t->trial[j];
        t->trial[i] = sum / t->jacobian[i * n + i];
    }
    for (int i = 0; i < rank; i++) t->step[t->column[i]] = t->trial[i] / t->size[t->column[i]];
}

/* ---- The iteration. ---- */

static bool newton_start(newton *t, static_system *s)
{
    size_t n = (size_t)s->unknowns;
    *t = (newton){.s = s, .n = s->unknowns};
    t->f = calloc(5 * n + n * n + 1, sizeof *t->f);
    t->column = calloc(n + 1, sizeof *t->column);
    if (!t->f || !t->column) return false;
    t->step = t->f + n;
    t->trial = t->step + n;
    t->size = t->trial + n;
    t->anchor = t->size + n;
    t->jacobian = t->anchor + n;
    for (int i = 0; i < s->unknowns; i++) t->size[i] = 1;
    for (int k = 0; k < s->w->object_count; k++)
        for (int i = 3; i < 6; i++) t->size[6 * k + i] = s->lever;
    for (int k = 0; k < s->w->hand_count; k++)
        for (int i = 0; i < s->w->hands[k].joint_count; i++)
            if (s->w->hands[k].joints[i].of->type == HAND_HINGE) t->size[s->first_joint[k] + i] = s->lever;
    return true;
}

/* The largest force that acts where everything is still as it was. */
static double force_scale(const static_system *s)
{
    double most = 1e-9;
    for (int i = 0; i < s->coordinates; i++) most = fmax(most, fabs(s->load[i]));
    for (int i = 0; i < s->contact_count; i++) most = fmax(most, (double)fabsl(s->contacts[i].r[0]));
    for (int i = 0; i < s->row_count; i++)
        if (!s->rows[i].rigid) most = fmax(most, (double)fabsl(s->rows[i].y));
    return most;
}

/* Takes the step, shortened where |F| would grow. A short step that helps no more is taken all the same: another piece
 * of the laws may lead on. */
static long double take_step(newton *t, long double *z, long double before)
{
    enum { HALVINGS = 6 };
    long double part = 1, error = before;
    memcpy(t->trial, z, (size_t)t->n * sizeof *z);
    for (int k = 0; k <= HALVINGS; k++, part *= 0.5L) {
        for (int i = 0; i < t->n; i++) z[i] = t->trial[i] + part * t->step[i];
        error = evaluate(t, z);
        if (error < (1 - 1e-3L * part) * before) break;
    }
    return error;
}

/* Newton's steps from z. Returns their number, negative where they did not get there. */
static int iterate(newton *t, long double *z, long double *error)
{
    enum { MOST = 60, POLISH = 4 };
    const long double near = 1e-12L * t->s->scale;
    int steps = 0, polished = 0;
    *error = evaluate(t, z);
    for (; steps < MOST && polished<POLISH && * error> 0; steps++) {
        solve_step(t);
        *error = take_step(t, z, *error);
        polished += *error <= near;
    }
    return *error <= near ? steps : -steps;
}

/* Where Newton's method cycles, the implicit flow F(z) - alpha (x - x_k) = 0 leads from z = 0 to an answer: each of its
 * steps is easy, and the farther the alpha falls, the nearer is F = 0 (as in core/README.md, equation (20)). */
static int follow_flow(newton *t, long double *z, long double *error)
{
    enum { MOST = 60 };
    long double alpha = 1e6L; /* N/m */
    int steps = 0;
    memset(z, 0, (size_t)t->n * sizeof *z);
    for (int k = 0; k < MOST; k++) {
        memcpy(t->anchor, z, (size_t)t->n * sizeof *z);
        t->alpha = alpha;
        int taken = iterate(t, z, error);
        t->alpha = 0;
        steps += abs(taken);
        if (taken < 0) {
            memcpy(z, t->anchor, (size_t)t->n * sizeof *z);
            alpha *= 5;
            continue;
        }
        alpha /= 10;
        memcpy(t->anchor, z, (size_t)t->n * sizeof *z);
        taken = iterate(t, z, error);
        steps += abs(taken);
        if (taken >= 0) return steps;
        memcpy(z, t->anchor, (size_t)t->n * sizeof *z);
    }
    return -steps;
}

/* What the weights do to the joints where these are in the end. */
static void turn_weights(static_system *s, const long double *z)
{
    for (int i = 0; i < s->coordinates; i++)
        for (int j = 0; j < s->coordinates; j++)
            s->weight[i] += (double)(s->weight_change[i * s->coordinates + j] * z[j]);
}

int static_solve(static_system *s, long double *z, double *residual, bool *found)
{
    newton t;
    int steps = -1;
    if (newton_start(&t, s)) {
        long double error;
        memset(z, 0, (size_t)s->unknowns * sizeof *z);
        (void)evaluate(&t, z);
        s->scale = force_scale(s);
        int taken = iterate(&t, z, &error);
        steps = abs(taken);
        if (taken < 0) {
            taken = follow_flow(&t, z, &error);
            steps += abs(taken);
        }
        turn_weights(s, z);
        *residual = (double)error;
        *found = taken >= 0;
    }
    free(t.f);
    free(t.column);
    return steps;
}
