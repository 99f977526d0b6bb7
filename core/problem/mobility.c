#include "problem/mobility.h"

#include <math.h>
#include <string.h>

/* Rows that depend on the others to this relative size (loops, doubled joints) constrain nothing more. */
static const double RANK_TOLERANCE = 1e-9;

bool pinch_row_is_hard(const pinch_joint_row *row)
{
    return row->cfm == 0 && row->low == -INFINITY && row->high == INFINITY;
}

static int find_root(int *parent, int body)
{
    while (parent[body] != body) {
        parent[body] = parent[parent[body]];
        body = parent[body];
    }
    return body;
}

/* W = M^-1/2 of one body as a lower-right triangle: linear 1/sqrt(m), angular L^-T with inertia = L L^T (6 entries:
 * the upper triangle of L^-T row by row). False when the inertia is not positive definite. */
typedef struct root_inverse {
    double linear;
    double t[6]; /* t00 t01 t02 t11 t12 t22 */
} root_inverse;

static bool root_inverse_of(const pinch_body *body, root_inverse *w)
{
    const double *I = body->inertia;
    w->linear = 1 / sqrt(body->mass);
    double l00 = sqrt(I[0]), l10 = I[3] / l00, l11 = sqrt(I[4] - l10 * l10);
    double l20 = I[6] / l00, l21 = (I[7] - l20 * l10) / l11, l22 = sqrt(I[8] - l20 * l20 - l21 * l21);
    if (!(l00 > 0) || !(l11 > 0) || !(l22 > 0)) return false;
    /* L^-1 by forward substitution; its transpose is W's angular block */
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

/* y = W x and y = W^T x for the six components of one body */
static void root_apply(const root_inverse *w, const double *x, double *y)
{
    const double *t = w->t;
    for (int i = 0; i < 3; i++) y[i] = w->linear * x[i];
    y[3] = t[0] * x[3] + t[1] * x[4] + t[2] * x[5];
    y[4] = t[3] * x[4] + t[4] * x[5];
    y[5] = t[5] * x[5];
}

static void root_apply_transposed(const root_inverse *w, const double *x, double *y)
{
    const double *t = w->t;
    for (int i = 0; i < 3; i++) y[i] = w->linear * x[i];
    y[5] = t[2] * x[3] + t[4] * x[4] + t[5] * x[5];
    y[4] = t[1] * x[3] + t[3] * x[4];
    y[3] = t[0] * x[3];
}

static bool free_body(pinch_arena *arena, const pinch_body *body, pinch_cluster *cluster)
{
    root_inverse w;
    cluster->basis = PINCH_ARENA_ARRAY(arena, double, 36);
    cluster->rest = PINCH_ARENA_ARRAY(arena, double, 6);
    if (arena->failed || !root_inverse_of(body, &w)) return false;
    double *u = cluster->basis;
    memset(u, 0, 36 * sizeof(double));
    for (int i = 0; i < 3; i++) u[7 * i] = w.linear;
    u[21] = w.t[0];
    u[22] = w.t[1];
    u[23] = w.t[2];
    u[28] = w.t[3];
    u[29] = w.t[4];
    u[35] = w.t[5];
    memcpy(cluster->rest, body->velocity, 6 * sizeof(double));
    cluster->freedoms = 6;
    return true;
}

/* A drive without mass has one freedom and no inertia; its row is a balance of forces. What resists it in a step is the
 * normal laws of its contacts, h (h kn + cn) in kg: the root of that scales it as a mass scales a body's freedoms. */
static bool massless_drive(pinch_arena *arena, const pinch_problem *problem, int index, pinch_cluster *cluster)
{
    const pinch_body *body = &problem->bodies[index];
    double resistance = 0;
    for (int k = 0; k < problem->contact_count; k++) {
        const pinch_contact *contact = &problem->contacts[k];
        if (contact->body1 == index || contact->body2 == index)
            resistance += problem->step * (problem->step * contact->stiffness[0] + contact->damping[0]);
    }
    cluster->basis = PINCH_ARENA_ARRAY(arena, double, 6);
    cluster->rest = PINCH_ARENA_ARRAY(arena, double, 6);
    if (arena->failed) return false;
    memset(cluster->basis, 0, 6 * sizeof(double));
    memset(cluster->rest, 0, 6 * sizeof(double));
    for (int i = 0; i < 3; i++) cluster->basis[i] = body->drive_axis[i] / (resistance > 0 ? sqrt(resistance) : 1);
    cluster->freedoms = 1;
    cluster->inertia = 0;
    return true;
}

/* The hard rows of one cluster as columns of (J W)^T, each scaled to length one, with the scaled right hand sides c - J
 * v*. */
struct pinch_constraint_factor {
    int n;          /* 6 body_count */
    int count;      /* columns */
    double *column; /* count x n: column k at column + k n; after factoring: R and the Householder vectors */
    int *row;       /* the problem's row of each column */
    double *length; /* before scaling */
    double *rhs;
    double *tau; /* Householder scales */
    double *diagonal;
    int *order; /* pivoting */
    int rank;
    double *y;           /* R^-T (c - J v*) */
    root_inverse *roots; /* per body */
};

static double dot(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += a[i] * b[i];
    return sum;
}

static void add_row(const pinch_problem *problem, const pinch_mobility *mobility, int cluster, int index,
                    pinch_constraint_factor *c)
{
    const pinch_joint_row *row = &problem->rows[index];
    double *column = c->column + (size_t)c->count * (size_t)c->n;
    double rhs = row->rhs;
    memset(column, 0, sizeof(double) * (size_t)c->n);
    const int body[2] = {row->body1, row->body2};
    const double *j[2] = {row->j1, row->j2};
    for (int side = 0; side < 2; side++) {
        if (body[side] < 0 || mobility->cluster_of[body[side]] != cluster) continue;
        int slot = mobility->slot_of[body[side]];
        double part[6];
        root_apply_transposed(&c->roots[slot], j[side], part);
        for (int i = 0; i < 6; i++) column[6 * slot + i] += part[i];
        rhs -= dot(j[side], problem->bodies[body[side]].velocity, 6);
    }
    double length = sqrt(dot(column, column, c->n));
    if (!(length > 0)) return;
    for (int i = 0; i < c->n; i++) column[i] /= length;
    c->rhs[c->count] = rhs / length;
    c->row[c->count] = index;
    c->length[c->count] = length;
    c->count++;
}

/* Householder factorization with column pivoting; vector k lives below the diagonal of column k (its head is 1). */
static void factor_columns(pinch_constraint_factor *c)
{
    int n = c->n;
    c->rank = 0;
    for (int k = 0; k < c->count; k++) c->order[k] = k;
    for (int k = 0; k < c->count && k < n; k++) {
        int best = k;
        double most = -1;
        for (int j = k; j < c->count; j++) {
            const double *v = c->column + (size_t)c->order[j] * (size_t)n;
            double size = dot(v + k, v + k, n - k);
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
            double scale = c->tau[k] * dot(v + k, other + k, n - k);
            for (int i = k; i < n; i++) other[i] -= scale * v[i];
        }
        c->rank++;
    }
}

/* x <- Q x */
static void apply_q(const pinch_constraint_factor *c, double *x)
{
    for (int k = c->rank - 1; k >= 0; k--) {
        const double *v = c->column + (size_t)c->order[k] * (size_t)c->n;
        double scale = c->tau[k] * dot(v + k, x + k, c->n - k);
        for (int i = k; i < c->n; i++) x[i] -= scale * v[i];
    }
}

/* x <- Q^T x */
static void apply_q_transposed(const pinch_constraint_factor *c, double *x)
{
    for (int k = 0; k < c->rank; k++) {
        const double *v = c->column + (size_t)c->order[k] * (size_t)c->n;
        double scale = c->tau[k] * dot(v + k, x + k, c->n - k);
        for (int i = k; i < c->n; i++) x[i] -= scale * v[i];
    }
}

/* y = R^-T rhs: forward substitution with R's columns (entry i of column k above the diagonal) */
static void solve_transposed(const pinch_constraint_factor *c, double *y)
{
    for (int k = 0; k < c->rank; k++) {
        const double *column = c->column + (size_t)c->order[k] * (size_t)c->n;
        double sum = c->rhs[c->order[k]];
        for (int i = 0; i < k; i++) sum -= column[i] * y[i];
        y[k] = sum / c->diagonal[k];
    }
}

static pinch_constraint_factor *allocate_factor(pinch_arena *arena, int bodies, int rows)
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
    c->roots = PINCH_ARENA_ARRAY(arena, root_inverse, bodies);
    return arena->failed ? NULL : c;
}

/* v0 and U from the factor; x: n doubles of scratch */
static void admissible_motion(const pinch_problem *problem, const pinch_constraint_factor *c, pinch_cluster *cluster,
                              double *x)
{
    int n = c->n;
    memset(x, 0, sizeof(double) * (size_t)n);
    for (int k = 0; k < c->rank; k++) x[k] = c->y[k];
    apply_q(c, x);
    for (int slot = 0; slot < cluster->body_count; slot++) {
        double *rest = cluster->rest + 6 * slot;
        const double *v = problem->bodies[cluster->bodies[slot]].velocity;
        root_apply(&c->roots[slot], x + 6 * slot, rest);
        for (int i = 0; i < 6; i++) rest[i] += v[i];
    }
    for (int f = 0; f < cluster->freedoms; f++) {
        double u[6];
        memset(x, 0, sizeof(double) * (size_t)n);
        x[c->rank + f] = 1;
        apply_q(c, x);
        for (int slot = 0; slot < cluster->body_count; slot++) {
            root_apply(&c->roots[slot], x + 6 * slot, u);
            for (int i = 0; i < 6; i++) cluster->basis[(6 * slot + i) * cluster->freedoms + f] = u[i];
        }
    }
}

static bool jointed_bodies(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility, int index,
                           const int *row_indices, int row_count)
{
    pinch_cluster *cluster = &mobility->clusters[index];
    pinch_constraint_factor *c = allocate_factor(arena, cluster->body_count, row_count);
    if (!c) return false;
    for (int slot = 0; slot < cluster->body_count; slot++)
        if (!root_inverse_of(&problem->bodies[cluster->bodies[slot]], &c->roots[slot])) return false;
    for (int k = 0; k < row_count; k++) add_row(problem, mobility, index, row_indices[k], c);
    factor_columns(c);
    solve_transposed(c, c->y);

    cluster->factor = c;
    cluster->freedoms = c->n - c->rank;
    cluster->rest = PINCH_ARENA_ARRAY(arena, double, c->n);
    cluster->basis = PINCH_ARENA_ARRAY(arena, double, (size_t)c->n *(size_t)(cluster->freedoms + 1));
    double *x = PINCH_ARENA_ARRAY(arena, double, c->n);
    if (arena->failed) return false;
    admissible_motion(problem, c, cluster, x);
    return true;
}

/* Groups the bodies into clusters, numbered by their first body. */
static bool group_bodies(pinch_arena *arena, const pinch_problem *problem, pinch_mobility *mobility)
{
    int n = problem->body_count;
    int *parent = PINCH_ARENA_ARRAY(arena, int, n + 1), *members = PINCH_ARENA_ARRAY(arena, int, n + 1);
    mobility->cluster_of = PINCH_ARENA_ARRAY(arena, int, n + 1);
    mobility->slot_of = PINCH_ARENA_ARRAY(arena, int, n + 1);
    mobility->clusters = PINCH_ARENA_ARRAY(arena, pinch_cluster, n + 1);
    if (arena->failed) return false;

    for (int b = 0; b < n; b++) parent[b] = b;
    for (int k = 0; k < problem->row_count; k++) {
        const pinch_joint_row *row = &problem->rows[k];
        if (!pinch_row_is_hard(row) || row->body1 < 0 || row->body2 < 0) continue;
        int a = find_root(parent, row->body1), b = find_root(parent, row->body2);
        if (a < b)
            parent[b] = a;
        else
            parent[a] = b;
    }
    mobility->cluster_count = 0;
    for (int b = 0; b < n; b++) {
        int root = find_root(parent, b);
        if (root == b) {
            pinch_cluster *cluster = &mobility->clusters[mobility->cluster_count];
            memset(cluster, 0, sizeof *cluster);
            cluster->inertia = 1;
            mobility->cluster_of[b] = mobility->cluster_count++;
        } else {
            mobility->cluster_of[b] = mobility->cluster_of[root];
        }
        mobility->slot_of[b] = mobility->clusters[mobility->cluster_of[b]].body_count++;
    }
    for (int k = 0, next = 0; k < mobility->cluster_count; k++) {
        mobility->clusters[k].bodies = members + next;
        next += mobility->clusters[k].body_count;
    }
    for (int b = 0; b < n; b++)
        members[mobility->clusters[mobility->cluster_of[b]].bodies - members + mobility->slot_of[b]] = b;
    return true;
}

static int cluster_of_row(const pinch_mobility *mobility, const pinch_joint_row *row)
{
    return mobility->cluster_of[row->body1 >= 0 ? row->body1 : row->body2];
}

bool pinch_mobility_build(pinch_arena *arena, const pinch_problem *problem, pinch_mobility *mobility)
{
    if (!group_bodies(arena, problem, mobility)) return false;

    /* the hard rows of each cluster, by counting */
    int clusters = mobility->cluster_count;
    int *start = PINCH_ARENA_ARRAY(arena, int, clusters + 2),
        *rows = PINCH_ARENA_ARRAY(arena, int, problem->row_count + 1);
    if (arena->failed) return false;
    memset(start, 0, sizeof(int) * (size_t)(clusters + 2));
    for (int k = 0; k < problem->row_count; k++)
        if (pinch_row_is_hard(&problem->rows[k])) start[cluster_of_row(mobility, &problem->rows[k]) + 2]++;
    for (int k = 0; k < clusters; k++) start[k + 2] += start[k + 1];
    for (int k = 0; k < problem->row_count; k++)
        if (pinch_row_is_hard(&problem->rows[k])) rows[start[cluster_of_row(mobility, &problem->rows[k]) + 1]++] = k;

    mobility->unknowns = 0;
    for (int k = 0; k < clusters; k++) {
        pinch_cluster *cluster = &mobility->clusters[k];
        const pinch_body *body = &problem->bodies[cluster->bodies[0]];
        int row_count = start[k + 1] - start[k];
        bool built = row_count > 0       ? jointed_bodies(arena, problem, mobility, k, rows + start[k], row_count)
                     : body->mass == 0.0 ? massless_drive(arena, problem, cluster->bodies[0], cluster)
                                         : free_body(arena, body, cluster);
        if (!built) return false;
        cluster->first = mobility->unknowns;
        mobility->unknowns += cluster->freedoms;
    }
    return true;
}

void pinch_mobility_velocity(const pinch_mobility *mobility, int body, const double *x, double v[6])
{
    const pinch_cluster *cluster = &mobility->clusters[mobility->cluster_of[body]];
    int slot = mobility->slot_of[body], m = cluster->freedoms;
    const double *basis = cluster->basis + (size_t)(6 * slot) * (size_t)m, *q = x + cluster->first;
    for (int i = 0; i < 6; i++) v[i] = cluster->rest[6 * slot + i] + dot(basis + (size_t)i * (size_t)m, q, m);
}

void pinch_mobility_joint_forces(const pinch_mobility *mobility, pinch_problem *problem, const double *wrench,
                                 double *scratch)
{
    for (int index = 0; index < mobility->cluster_count; index++) {
        const pinch_cluster *cluster = &mobility->clusters[index];
        const pinch_constraint_factor *c = cluster->factor;
        if (!c) continue;
        for (int slot = 0; slot < cluster->body_count; slot++)
            root_apply_transposed(&c->roots[slot], wrench + 6 * cluster->bodies[slot], scratch + 6 * slot);
        apply_q_transposed(c, scratch);
        for (int k = 0; k < c->rank; k++) scratch[k] = c->y[k] / problem->step - scratch[k];
        for (int k = c->rank - 1; k >= 0; k--) { /* back substitution with R */
            double sum = scratch[k];
            for (int j = k + 1; j < c->rank; j++)
                sum -= c->column[(size_t)c->order[j] * (size_t)c->n + (size_t)k] * scratch[j];
            scratch[k] = sum / c->diagonal[k];
        }
        for (int k = 0; k < c->count; k++) problem->rows[c->row[k]].force = 0;
        for (int k = 0; k < c->rank; k++)
            problem->rows[c->row[c->order[k]]].force = scratch[k] / c->length[c->order[k]];
    }
}
