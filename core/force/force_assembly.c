/* The matrix of the linear system of a Newton step, equation (27) of core/README.md: its blocks are added up contact by
 * contact. */
#include "force/force_joints.h"
#include "force/force_rows.h"
#include "force/force_system.h"

#include <limits.h>
#include <string.h>

enum { WIDE = 64 }; /* columns of a block that are looked at together */

/* These are the places of the blocks of the matrix that a pair of clusters has. Contacts of the same pair mostly follow
 * each other. */
static const size_t NO_BLOCK = SIZE_MAX;
typedef struct pair_blocks {
    int cluster[2];
    size_t to[2][2];
    bool first_later; /* the first of the clusters is eliminated after the second */
} pair_blocks;

static void find_blocks(const pinch_force_system *s, const int cluster[2], pair_blocks *blocks)
{
    if (cluster[0] == blocks->cluster[0] && cluster[1] == blocks->cluster[1]) return;
    blocks->first_later = cluster[0] >= 0 && cluster[1] >= 0 && pinch_block_lu_is_lower(&s->lu, cluster[0], cluster[1]);
    for (int a = 0; a < 2; a++) {
        blocks->cluster[a] = cluster[a];
        for (int b = 0; b < 2; b++)
            blocks->to[a][b] = cluster[a] < 0 || cluster[b] < 0 || !pinch_block_lu_reads(&s->lu, cluster[a], cluster[b])
                                   ? NO_BLOCK
                                   : pinch_block_lu_offset(&s->lu, cluster[a], cluster[b]);
    }
}

/* Of the products with an element's conductance, these and the next two add those of the column of its block b. */
static void add_body_products(const pinch_force_system *s, const pinch_force_element *e, int b, double *const to[2])
{
    const double *conductance = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
    const double *const left[2] = {e->block[0].g, e->block[1].g};
    double d[9];
    for (int i = 0; i < 9; i++) d[i] = s->step * conductance[i];
    pinch_block_add_contact(left, d, e->block[b].g, to);
}

/* to (6 x 6) += left^T weighted, both rows x 6, for the rows of any law. */
static void add_product_of_rows(int rows, const double *restrict left, const double *restrict weighted,
                                double *restrict to)
{
    enum { N = PINCH_FORCE_BODY };
    for (int l = 0; l < N; l++, to += N) {
        double sum[N];
        for (int k = 0; k < N; k++) sum[k] = to[k];
        for (int i = 0; i < rows; i++) {
            double g = left[i * N + l];
            if (g == 0) continue; /* rolling and spinning do not depend on the bodies' velocities along lines */
            for (int k = 0; k < N; k++) sum[k] += g * weighted[i * N + k];
        }
        for (int k = 0; k < N; k++) to[k] = sum[k];
    }
}

static void add_products_of_bodies(const pinch_force_system *s, const pinch_force_element *e, int b,
                                   double *const to[2])
{
    enum { N = PINCH_FORCE_BODY };
    const double *conductance = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
    double weighted[PINCH_CONTACT_ROWS_MAX * N];
    int rows = e->rows;
    memset(weighted, 0, sizeof weighted);
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < rows; j++) {
            double d = s->step * conductance[i * rows + j];
            for (int k = 0; d != 0 && k < N; k++) weighted[i * N + k] += d * e->block[b].g[j * N + k];
        }
    for (int a = 0; a < 2; a++)
        if (to[a]) add_product_of_rows(rows, e->block[a].g, weighted, to[a]);
}

/* The columns of a block that are not zero: those of the freedoms that move its body. */
typedef struct acting_columns {
    int count;
    int at[WIDE];
    double g[PINCH_CONTACT_ROWS_MAX * WIDE]; /* rows x count */
} acting_columns;

/* Looks at the columns from `from` on, as many as there is room for. */
static void find_acting(const pinch_row_block *block, int rows, int from, acting_columns *acting)
{
    int end = block->size - from < WIDE ? block->size : from + WIDE;
    acting->count = 0;
    for (int k = from; k < end; k++) {
        bool acts = false;
        for (int i = 0; i < rows; i++) acts = acts || block->g[i * block->size + k] != 0;
        if (acts) acting->at[acting->count++] = k;
    }
    for (int i = 0; i < rows; i++)
        for (int k = 0; k < acting->count; k++)
            acting->g[i * acting->count + k] = block->g[i * block->size + acting->at[k]];
}

/* to += h left^T D right, `to` having rows of `stride` */
static void add_acting(const acting_columns *left, const acting_columns *right, const double *weight, int rows,
                       int stride, double *to)
{
    for (int i = 0; i < rows; i++) {
        double weighted[WIDE] = {0};
        bool any = false;
        for (int j = 0; j < rows; j++) {
            double d = weight[i * rows + j];
            if (d == 0) continue;
            any = true;
            for (int k = 0; k < right->count; k++) weighted[k] += d * right->g[j * right->count + k];
        }
        for (int l = 0; any && l < left->count; l++) {
            double g = left->g[i * left->count + l], *line = to + left->at[l] * stride;
            for (int k = 0; k < right->count; k++) line[right->at[k]] += g * weighted[k];
        }
    }
}

/* matrix += h G_a^T D G_b for the pairs of the element's blocks; wide blocks go through in parts */
static void add_products(const pinch_force_system *s, const pinch_force_element *e, int b, double *const to[2])
{
    const double *conductance = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
    double weight[PINCH_CONTACT_ROWS_MAX * PINCH_CONTACT_ROWS_MAX];
    int rows = e->rows;
    acting_columns acting[2];
    for (int i = 0; i < rows * rows; i++) weight[i] = s->step * conductance[i];
    for (int from = 0; from < e->block[b].size; from += WIDE) {
        find_acting(&e->block[b], rows, from, &acting[1]);
        for (int a = 0; a < 2; a++) {
            for (int l = 0; to[a] && l < e->block[a].size; l += WIDE) {
                if (a != b || l != from) find_acting(&e->block[a], rows, l, &acting[0]);
                add_acting(a == b && l == from ? &acting[1] : &acting[0], &acting[1], weight, rows,
                           s->block_size[e->cluster[b]], to[a]);
            }
        }
    }
}

/* Are the blocks those of free bodies? */
static bool between_bodies(const pinch_force_element *e)
{
    bool plain = true;
    for (int b = 0; b < 2; b++) plain = plain && (e->cluster[b] < 0 || e->block[b].size == PINCH_FORCE_BODY);
    return plain;
}

/* The blocks of the matrix that the multipliers of a common block have: their own, and beside the first clusters their
 * rows and columns. */
enum { JOINED = 2 };
typedef struct joint_blocks {
    double *own, *row[JOINED], *column[JOINED];
} joint_blocks;

static void find_joint_blocks(const pinch_force_system *s, const pinch_force_multiplier *m, joint_blocks *blocks)
{
    blocks->own = pinch_block_lu_at(&s->lu, m->joint, m->joint);
    for (int b = 0; b < m->blocks && b < JOINED; b++) {
        blocks->row[b] = pinch_block_lu_at(&s->lu, m->joint, m->cluster[b]);
        blocks->column[b] = pinch_block_lu_at(&s->lu, m->cluster[b], m->joint);
    }
}

/* Adds one block's part, g[n], to the row and to the column, whose entries are `stride` apart; a constant n is
 * unrolled.
 */
static inline void add_row_and_column(const double *restrict g, int n, bool inside, int stride, double *restrict row,
                                      double *restrict column)
{
    for (int k = 0; inside && k < n; k++) row[k] += g[k];
    for (int k = 0; k < n; k++) column[k * stride] -= g[k];
}

/* Adds the row and the column of a multiplier. Inside its bounds F_b is w - c + C y + kappa (y - a), at one of them it
 * is y - bound. */
static void add_multiplier(const pinch_force_system *s, const pinch_force_multiplier *m, const joint_blocks *blocks)
{
    bool inside = m->bound == 0;
    int size = s->block_size[m->joint];
    blocks->own[m->place * size + m->place] = inside ? m->kappa + m->unit.compliance : 1;
    for (int b = 0; b < m->blocks; b++) {
        bool known = b < JOINED;
        double *row = known ? blocks->row[b] : pinch_block_lu_at(&s->lu, m->joint, m->cluster[b]);
        double *column = known ? blocks->column[b] : pinch_block_lu_at(&s->lu, m->cluster[b], m->joint);
        row += m->place * m->block[b].size;
        column += m->place;
        if (m->block[b].size == PINCH_FORCE_BODY)
            add_row_and_column(m->block[b].g, PINCH_FORCE_BODY, inside, size, row, column);
        else
            add_row_and_column(m->block[b].g, m->block[b].size, inside, size, row, column);
    }
}

/* Adds to the block (a, b) in single precision, where it stands transposed if it is a lower one. */
static void add_single_product(const pinch_force_system *s, const pinch_force_element *e, int a, int b, bool lower,
                               float *to)
{
    enum { N = PINCH_FORCE_BODY, C = PINCH_FORCE_CONTACT };
    if (e->rows == C) {
        const double *conductance = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
        double d[C * C];
        for (int i = 0; i < C; i++)
            for (int j = 0; j < C; j++) d[C * i + j] = s->step * conductance[lower ? C * j + i : C * i + j];
        pinch_single_add_contact(s->lu.width, e->block[lower ? b : a].g, d, e->block[lower ? a : b].g, to);
        return;
    }
    double product[N * N] = {0}, *const blocks[2] = {a == 0 ? product : NULL, a == 1 ? product : NULL};
    add_products_of_bodies(s, e, b, blocks);
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) to[PINCH_SINGLE_ROW * i + j] += (float)product[lower ? N * j + i : N * i + j];
}

/* Adds what an element's conductance has in the column of its block b. */
static void add_column(const pinch_force_system *s, const pinch_force_element *e, int b, const pair_blocks *blocks)
{
    const size_t place[2] = {blocks->to[0][b], blocks->to[1][b]};
    for (int a = 0; a < 2 && s->lu.single; a++)
        if (place[a] != NO_BLOCK)
            add_single_product(s, e, a, b, a != b && (a == 0) == blocks->first_later, s->lu.singles + place[a]);
    if (s->lu.single) return;
    double *to[2];
    for (int a = 0; a < 2; a++) to[a] = place[a] == NO_BLOCK ? NULL : s->lu.values + place[a];
    if (!between_bodies(e))
        add_products(s, e, b, to);
    else if (e->rows == PINCH_FORCE_CONTACT)
        add_body_products(s, e, b, to);
    else
        add_products_of_bodies(s, e, b, to);
}

static void put_unit(const pinch_force_system *s, int cluster)
{
    size_t own = pinch_block_lu_offset(&s->lu, cluster, cluster);
    int row = s->lu.single ? PINCH_SINGLE_ROW : s->block_size[cluster];
    for (int k = 0; k < s->mobility->clusters[cluster].freedoms; k++, own += (size_t)row + 1)
        if (s->lu.single)
            s->lu.singles[own] = 1;
        else
            s->lu.values[own] = 1;
}

static void assemble_columns(void *argument, int first, int end)
{
    const pinch_force_system *s = argument;
    pair_blocks blocks = {.cluster = {-1, -1}};
    for (int c = first; c < end; c++) {
        put_unit(s, c);
        for (int m = s->meet_first[c]; m < s->meet_first[c + 1]; m++) {
            const pinch_force_element *e = &s->elements[s->meets[m] / 2];
            if (!e->conducts) continue;
            find_blocks(s, e->cluster, &blocks);
            add_column(s, e, s->meets[m] % 2, &blocks);
        }
    }
}

static void clear_values(void *argument, int first, int end)
{
    pinch_force_system *s = argument;
    pinch_block_lu_clear_part(&s->lu, (size_t)first, (size_t)end);
}

/* As pinch_block_lu_clear. */
static void clear_matrix(pinch_force_system *s)
{
    enum { AT_A_TIME = 1 << 15 };
    if (s->crew && s->lu.value_count <= INT_MAX)
        s->crew->parallel_for(s->crew->context, (int)s->lu.value_count, AT_A_TIME, clear_values, s);
    else
        pinch_block_lu_clear(&s->lu);
}

/* With a crew, the columns of blocks gather what is theirs: each block gets the same sum in the same order. */
void pinch_force_assemble_elements(pinch_force_system *s)
{
    pair_blocks blocks = {.cluster = {-1, -1}};
    clear_matrix(s);
    if (s->meets) {
        pinch_each(s->crew, s->mobility->cluster_count, assemble_columns, s);
        return;
    }
    for (int c = 0; c < s->mobility->cluster_count; c++) put_unit(s, c);
    for (int k = 0; k < s->element_count; k++) {
        const pinch_force_element *e = &s->elements[k];
        if (!e->conducts) continue;
        find_blocks(s, e->cluster, &blocks);
        for (int b = 0; b < 2; b++)
            if (e->cluster[b] >= 0) add_column(s, e, b, &blocks);
    }
}

void pinch_force_add_multipliers(pinch_force_system *s)
{
    joint_blocks blocks = {0};
    for (int i = 0; i < s->multiplier_count; i++) {
        const pinch_force_multiplier *m = &s->multipliers[i];
        if (m->place == 0) find_joint_blocks(s, m, &blocks);
        add_multiplier(s, m, &blocks);
    }
}

/* to = factor d x */
static inline void multiply_by(int rows, double factor, const double *d, const double *x, double *to)
{
    for (int i = 0; i < rows; i++) {
        to[i] = 0;
        for (int j = 0; j < rows; j++) to[i] += factor * d[i * rows + j] * x[j];
    }
}

/* impulse = -h D G x */
static inline void find_response(const pinch_force_system *s, const pinch_force_element *e, const double *x,
                                 double impulse[PINCH_CONTACT_ROWS_MAX])
{
    const double *conductance = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
    double moved[PINCH_CONTACT_ROWS_MAX] = {0};
    int rows = e->rows;
    for (int b = 0; b < 2; b++)
        if (e->cluster[b] >= 0)
            pinch_force_rows_times(rows, e->block[b].size, e->block[b].g, x + e->block[b].first, moved);
    if (rows == PINCH_FORCE_CONTACT) /* the same, with loops that the compiler unrolls */
        multiply_by(PINCH_FORCE_CONTACT, -s->step, conductance, moved, impulse);
    else
        multiply_by(rows, -s->step, conductance, moved, impulse);
}

/* In the unknowns of the element's block b: to += G^T impulse. */
static inline void add_response(const pinch_force_element *e, int b, const double *impulse, double *to)
{
    pinch_force_rows_transposed_times(e->rows, e->block[b].size, e->block[b].g, impulse, to + e->block[b].first);
}

typedef struct residual_task {
    const pinch_force_system *s;
    const double *rhs, *x;
    double *to;
} residual_task;

static void find_residual_of(void *argument, int first, int end)
{
    const residual_task *t = argument;
    const pinch_force_system *s = t->s;
    for (int i = s->block_first[first]; i < s->block_first[end]; i++) t->to[i] = t->rhs[i] - t->x[i];
    if (!s->meets) return;
    for (int m = s->meet_first[first]; m < s->meet_first[end]; m++) {
        const pinch_force_element *e = &s->elements[s->meets[m] / 2];
        double impulse[PINCH_CONTACT_ROWS_MAX];
        if (!e->conducts) continue;
        find_response(s, e, t->x, impulse);
        add_response(e, s->meets[m] % 2, impulse, t->to);
    }
}

void pinch_force_find_residual(const pinch_force_system *s, const double *rhs, const double *x, double *residual)
{
    residual_task task = {s, rhs, x, residual};
    if (s->meets) {
        pinch_each(s->crew, s->mobility->cluster_count, find_residual_of, &task);
        return;
    }
    find_residual_of(&task, 0, s->mobility->cluster_count);
    for (int k = 0; k < s->element_count; k++) {
        const pinch_force_element *e = &s->elements[k];
        double impulse[PINCH_CONTACT_ROWS_MAX];
        if (!e->conducts) continue;
        find_response(s, e, x, impulse);
        for (int b = 0; b < 2; b++)
            if (e->cluster[b] >= 0) add_response(e, b, impulse, residual);
    }
}
