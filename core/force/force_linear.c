/* Solves the linear system of a Newton step, equation (27) of core/README.md: the forces are eliminated contact by
 * contact, and blocks of the bodies are left. */
#include "force/force_joints.h"
#include "force/force_rows.h"
#include "force/force_system.h"
#include "support/block_dilu.h"
#include "support/blocks.h"

#include <limits.h>
#include <math.h>
#include <string.h>

/* A complete factorization is given up for an iteration where it takes more products of blocks than this many times
 * what the matrix has of blocks and contacts. */
static const double WORTH_ITERATING = 20;
/* A complete factorization has to leave room in the budget for a few more of its kind. */
static const double PART_OF_BUDGET = 0.125, WORK_OF_ELEMENT = 6; /* in a Newton step, its evaluations included */
static const double PRODUCT = 216;                               /* of blocks, in multiplications */
static const double LEAST_EXACT = 1e-3, MOST_EXACT = 1e-7, END = 2e-13;

enum { WIDE = 64 }; /* columns of a block that are looked at together */

/* These are the blocks of the matrix that a pair of clusters has. Contacts of the same pair mostly follow each other.
 */
typedef struct pair_blocks {
    int cluster[2];
    double *to[2][2];
} pair_blocks;

static void find_blocks(const pinch_force_system *s, const int cluster[2], pair_blocks *blocks)
{
    if (cluster[0] == blocks->cluster[0] && cluster[1] == blocks->cluster[1]) return;
    for (int a = 0; a < 2; a++) {
        blocks->cluster[a] = cluster[a];
        for (int b = 0; b < 2; b++)
            blocks->to[a][b] = cluster[a] < 0 || cluster[b] < 0 || !pinch_block_lu_reads(&s->lu, cluster[a], cluster[b])
                                   ? NULL
                                   : pinch_block_lu_at(&s->lu, cluster[a], cluster[b]);
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

static void add_edge(int *edge, int *edges, int from, int to)
{
    if (edge) {
        edge[2 * *edges] = from;
        edge[2 * *edges + 1] = to;
    }
    ++*edges;
}

/* Writes the pairs of blocks that multipliers and elements couple into edge[]; equal pairs of elements that follow each
 * other count once. Returns how many there are. With edge = NULL they are only counted. */
static int coupled_pairs(const pinch_force_system *s, int *edge)
{
    const int *last = NULL;
    int edges = 0;
    for (int i = 0; i < s->multiplier_count; i++) {
        const pinch_force_multiplier *m = &s->multipliers[i];
        for (int b = 0; b < m->blocks; b++)
            if (m->place == 0) add_edge(edge, &edges, m->joint, m->cluster[b]);
    }
    for (int k = 0; k < s->element_count; k++) {
        const int *cluster = s->elements[k].cluster;
        if (cluster[0] < 0 || cluster[1] < 0 || (last && last[0] == cluster[0] && last[1] == cluster[1])) continue;
        add_edge(edge, &edges, cluster[0], cluster[1]);
        last = cluster;
    }
    return edges;
}

/* Gives multipliers that follow each other and act on the same clusters, as a rule those of a joint, a common block. */
static void share_blocks(pinch_force_system *s)
{
    enum { MOST_ROWS = 6 };
    s->block_count = s->mobility->cluster_count;
    for (int i = 0; i < s->multiplier_count; i++) {
        pinch_force_multiplier *m = &s->multipliers[i];
        bool goes_on = i > 0 && m[-1].place + 1 < MOST_ROWS && m[-1].blocks == m->blocks &&
                       memcmp(m[-1].cluster, m->cluster, sizeof *m->cluster * (size_t)m->blocks) == 0;
        if (!goes_on) s->block_size[s->block_count++] = 0;
        m->joint = s->block_count - 1;
        m->place = s->block_size[m->joint]++;
    }
}

static bool lay_out(pinch_arena *arena, pinch_force_system *s)
{
    int clusters = s->mobility->cluster_count, most = clusters + s->multiplier_count;
    s->block_size = PINCH_ARENA_ARRAY(arena, int, most + 1);
    s->block_first = PINCH_ARENA_ARRAY(arena, int, most + 1);
    if (arena->failed) return false;
    for (int c = 0; c < clusters; c++) s->block_size[c] = s->mobility->clusters[c].freedoms;
    share_blocks(s);
    s->block_first[0] = 0;
    for (int k = 0; k < s->block_count; k++) s->block_first[k + 1] = s->block_first[k] + s->block_size[k];
    s->rhs = PINCH_ARENA_ARRAY(arena, double, s->block_first[s->block_count] + 1);
    s->rhs_kept = s->multiplier_count > 0 ? PINCH_ARENA_ARRAY(arena, double, s->block_first[s->block_count]) : NULL;
    s->laid_out = pinch_arena_here(arena);
    return !arena->failed;
}

/* Returns how many products of blocks a factorization may take, where the blocks are of mean size. */
static double most_products(const pinch_force_system *s)
{
    double sum = 0, most = PART_OF_BUDGET * fmax(s->budget - s->work, 0);
    for (int k = 0; k < s->block_count; k++) {
        double size = s->block_size[k] / 6.0;
        sum += size * size * size;
    }
    return sum > 0 ? most * s->block_count / sum : most;
}

static bool plan(pinch_arena *arena, pinch_force_system *s, bool complete)
{
    if (!s->planned && !lay_out(arena, s)) return false;
    int clusters = s->mobility->cluster_count, edges = coupled_pairs(s, NULL);
    pinch_arena_rewind(arena, &s->laid_out);
    s->planned = true;
    int *edge = PINCH_ARENA_ARRAY(arena, int, 2 * edges + 1);
    if (!edge) return false;
    pinch_block_graph graph = {s->block_count, clusters, coupled_pairs(s, edge), edge};
    /* what multipliers couple needs pivots that only a complete factorization has */
    bool needed = complete || s->multiplier_count > 0;
    double worth = WORTH_ITERATING * (clusters + 2 * edges + s->element_count);
    double limit = needed ? most_products(s) : fmax(worth, s->split_products);
    if (!pinch_block_lu_plan(arena, &graph, s->block_size, limit, s->orders, &s->lu)) return false;
    if (!pinch_force_plan_bounds(arena, s)) return false;
    s->iterative = s->lu.incomplete;
    s->dear = !s->iterative && s->lu.products > worth;
    s->too_large = s->iterative && needed;
    s->last_merit = INFINITY;
    s->sharper = 1;
    s->elements_kept = s->bounds ? PINCH_ARENA_ARRAY(arena, double, s->lu.value_count) : NULL;
    if (!s->iterative) return !s->crew || pinch_block_lu_share(arena, &s->lu);
    size_t split = pinch_block_dilu_room(&s->lu), vectors = 6 * (size_t)s->block_first[s->block_count];
    s->krylov = PINCH_ARENA_ARRAY(arena, double, split > vectors ? split : vectors);
    return !arena->failed;
}

/* Adds what an element's conductance has in the column of its block b. */
static void add_column(const pinch_force_system *s, const pinch_force_element *e, int b, const pair_blocks *blocks)
{
    double *const to[2] = {blocks->to[0][b], blocks->to[1][b]};
    if (!between_bodies(e))
        add_products(s, e, b, to);
    else if (e->rows == PINCH_FORCE_CONTACT)
        add_body_products(s, e, b, to);
    else
        add_products_of_bodies(s, e, b, to);
}

static void put_unit(const pinch_force_system *s, int cluster)
{
    double *own = pinch_block_lu_at(&s->lu, cluster, cluster);
    for (int k = 0; k < s->mobility->clusters[cluster].freedoms; k++) own[k * s->block_size[cluster] + k] = 1;
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

/* Assembles the matrix from the conductances, but for the multipliers. With a crew, its columns of blocks gather what
 * is theirs: each block gets the same sum in the same order. */
static void assemble_elements(pinch_force_system *s)
{
    pair_blocks blocks = {.cluster = {-1, -1}};
    clear_matrix(s);
    if (s->meets) {
        pinch_loop(s->crew, s->mobility->cluster_count, assemble_columns, s);
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

static void add_multipliers(pinch_force_system *s)
{
    joint_blocks blocks = {0};
    for (int i = 0; i < s->multiplier_count; i++) {
        const pinch_force_multiplier *m = &s->multipliers[i];
        if (m->place == 0) find_joint_blocks(s, m, &blocks);
        add_multiplier(s, m, &blocks);
    }
}

static void eliminate_elements(void *argument, int first, int end)
{
    pinch_force_system *s = argument;
    bool singular = false, symmetric = true;
    for (int k = first; k < end && !singular; k++) {
        singular = !pinch_force_eliminate(&s->elements[k], s->begins);
        symmetric = symmetric && s->elements[k].symmetric;
    }
    s->partials[first / PINCH_CHUNK] = (pinch_force_partial){.any = singular, .symmetric = symmetric};
}

/* Tells whether the factors may be those of a symmetric matrix, if the conductances are. The rows and columns of
 * multipliers differ in their signs, and small matrices take little time in any case. */
static bool may_be_symmetric(const pinch_force_system *s)
{
    enum { LARGE = 200 };
    return !s->iterative && s->multiplier_count == 0 && s->block_count >= LARGE;
}

static bool conductances_are_symmetric(const pinch_force_system *s)
{
    bool all = true;
    for (int k = 0; k < pinch_chunk_count(s->element_count); k++) all = all && s->partials[k].symmetric;
    return all;
}

/* Eliminates all elements and forms their right hand side, -h G^T shift. Returns false where one is singular. */
static bool eliminate(pinch_force_system *s)
{
    pinch_loop(s->crew, s->element_count, eliminate_elements, s);
    s->begins = false;
    if (pinch_force_any(s)) return false;
    s->lu.symmetric = may_be_symmetric(s) && conductances_are_symmetric(s);
    memset(s->rhs, 0, sizeof(double) * (size_t)s->block_first[s->block_count]);
    pinch_force_add_impulses(s, PINCH_FORCE_CHANGE, s->block_first, s->rhs);
    return true;
}

static double *unknown_of(const pinch_force_system *s, const pinch_force_multiplier *m)
{
    return pinch_force_unknown_of(s, m, s->rhs);
}

/* Puts -F_b into the right hand side, by the bound that each multiplier is taken to be at. */
static void fill_multipliers(pinch_force_system *s)
{
    for (int i = 0; i < s->multiplier_count; i++) {
        const pinch_force_multiplier *m = &s->multipliers[i];
        *unknown_of(s, m) = (m->bound == 0 ? m->trial : m->bound < 0 ? m->unit.low : m->unit.high) - m->y;
    }
}

/* dr = -shift - D G dq */
static void change_elements(void *argument, int first, int end)
{
    const pinch_force_system *s = argument;
    for (int k = first; k < end; k++) {
        const pinch_force_element *e = &s->elements[k];
        const double *conductance = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
        double moved[PINCH_CONTACT_ROWS_MAX] = {0}, *change = pinch_force_values(e, PINCH_FORCE_CHANGE);
        int rows = e->rows;
        for (int b = 0; b < 2 && e->conducts; b++)
            if (e->cluster[b] >= 0)
                pinch_force_rows_times(rows, e->block[b].size, e->block[b].g, s->rhs + s->block_first[e->cluster[b]],
                                       moved);
        for (int i = 0; i < rows; i++)
            for (int j = 0; j < rows; j++) change[i] -= conductance[i * rows + j] * moved[j];
    }
}

static void changes_from(pinch_force_system *s)
{
    pinch_loop(s->crew, s->element_count, change_elements, s);
    for (int i = 0; i < s->multiplier_count; i++) s->multipliers[i].change = *unknown_of(s, &s->multipliers[i]);
}

/*
 * A step is solved as exactly as the next merit is expected to be small (convergence is quadratic), or as it takes to
 * end here. The merit weighs forces and the iteration weighs velocities. Where the two are so far apart, as in tall
 * walls, that steps near the end gain little, the next steps are solved more exactly.
 */
static double exactness_of_step(pinch_force_system *s, double merit)
{
    static const double NEAR = 1e-7, LITTLE = 0.1, SHARPER = 1e-2;
    if (merit < NEAR && merit > LITTLE * s->last_merit) s->sharper *= SHARPER;
    s->last_merit = merit;
    double usual = fmin(fmax(merit, END / merit), LEAST_EXACT);
    return fmax(s->sharper * usual, MOST_EXACT);
}

static bool solve_by_iteration(pinch_force_system *s, double exactness)
{
    assemble_elements(s);
    return pinch_block_dilu_split(&s->lu, s->rhs, s->krylov) && pinch_force_bicgstab(s, exactness);
}

/*
 * Solves the step with the bounds that hold after it, as far as there are such (force_bounds.c): those that come out of
 * one factorization are tried in the next. These few rounds are for what rounding hides, and for the many bounds of
 * large islands, a part of which changes in each.
 */
static bool solve_by_factors(pinch_force_system *s)
{
    enum { MOST_ROUNDS = 16 };
    size_t bytes = sizeof(double) * (size_t)s->block_first[s->block_count];
    pinch_force_bounds_end end = PINCH_FORCE_BOUNDS_NEW;
    assemble_elements(s);
    if (s->bounds) { /* others need no second round */
        memcpy(s->rhs_kept, s->rhs, bytes);
        memcpy(s->elements_kept, s->lu.values, sizeof(double) * s->lu.value_count);
    }
    for (int round = 0; round < MOST_ROUNDS && (round == 0 || s->work <= s->budget); round++) {
        if (round > 0) {
            memcpy(s->rhs, s->rhs_kept, bytes);
            memcpy(s->lu.values, s->elements_kept, sizeof(double) * s->lu.value_count);
        }
        fill_multipliers(s);
        add_multipliers(s);
        s->work += s->lu.products;
        if (!pinch_block_lu_factor_and_solve(&s->lu, s->crew, s->rhs)) return false;
        if (end == PINCH_FORCE_BOUNDS_LAST) break;
        end = pinch_force_settle_bounds(s);
        if (end == PINCH_FORCE_BOUNDS_RIGHT) break;
    }
    return true;
}

bool pinch_force_begin_rows(pinch_arena *arena, pinch_force_system *s)
{
    if (s->joints && !s->joints->bounded) {
        pinch_force_satisfy_rows(s, true);
        return true;
    }
    if (s->work > s->budget) return true;
    if (!s->planned && !plan(arena, s, false)) return false;
    if (s->too_large) return true;
    (void)pinch_force_evaluate(s);
    memset(s->rhs, 0, sizeof(double) * (size_t)s->block_first[s->block_count]);
    for (int k = 0; k < s->element_count; k++) s->elements[k].conducts = false;
    if (!solve_by_factors(s)) return true;
    for (int i = 0; i < s->multiplier_count; i++) s->multipliers[i].y += *unknown_of(s, &s->multipliers[i]);
    return true;
}

bool pinch_force_solve_linear(pinch_arena *arena, pinch_force_system *s, double merit, bool *singular)
{
    *singular = true;
    if (s->work > s->budget) return false;
    if (s->in_contacts) return pinch_force_condensed_step(s);
    if (!s->planned && !plan(arena, s, false)) return *singular = false;
    s->work += WORK_OF_ELEMENT * s->element_count;
    if ((s->too_large && s->multiplier_count > 0) || !eliminate(s)) return false;
    if (s->iterative && !solve_by_iteration(s, exactness_of_step(s, merit))) {
        if (s->too_large) return false;
        if (!plan(arena, s, true)) return *singular = false;
        if (s->too_large) return false;
        (void)pinch_force_evaluate(s); /* the slopes stand where the trial forces stood */
        if (!eliminate(s)) return false;
    }
    if (!s->iterative && !solve_by_factors(s)) return false;
    changes_from(s);
    return true;
}

double *pinch_force_clear_rhs(pinch_arena *arena, pinch_force_system *s)
{
    if (!s->planned && !plan(arena, s, false)) return NULL;
    return memset(s->rhs, 0, sizeof(double) * (size_t)(s->block_first[s->block_count] + 1));
}

bool pinch_force_solve_for_rhs(pinch_force_system *s, double exactness)
{
    s->work += WORK_OF_ELEMENT * s->element_count;
    s->lu.symmetric = may_be_symmetric(s);
    return s->iterative ? solve_by_iteration(s, exactness) : solve_by_factors(s);
}

void pinch_force_solve_again(pinch_force_system *s)
{
    s->work += (double)s->lu.value_count / PRODUCT + WORK_OF_ELEMENT * s->element_count;
    pinch_block_lu_solve(&s->lu, s->rhs);
}

bool pinch_force_stop_iterating(pinch_arena *arena, pinch_force_system *s)
{
    return s->iterative && plan(arena, s, true) && !s->too_large;
}
