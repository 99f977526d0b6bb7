/* Solves the linear system of a Newton step, equation (27) of core/README.md: the forces are eliminated contact by
 * contact, and blocks of the bodies are left. */
#include "force/force_joints.h"
#include "force/force_rows.h"
#include "force/force_system.h"
#include "support/block_dilu.h"
#include "support/dense.h"

#include <math.h>
#include <string.h>

/* A complete factorization is given up for an iteration where it takes more products of blocks than this many times
 * what the matrix has of blocks and contacts; the second is for those in single precision. */
static const double WORTH_ITERATING = 20, WORTH_IN_SINGLE = 40;
/* A complete factorization has to leave room in the budget for a few more of its kind. */
static const double PART_OF_BUDGET = 0.125, WORK_OF_ELEMENT = 6; /* in a Newton step, its evaluations included */
static const double PRODUCT = 216;                               /* of blocks, in multiplications */
static const double LEAST_EXACT = 1e-3, MOST_EXACT = 1e-7, END = 2e-13;
/* Factors in single precision leave this much of the right hand side at most, as one more Newton step would take longer
 * than refining; and a product of theirs takes this part of one in double precision. */
static const double EXACT = 1e-9, SINGLE_PRODUCT = 0.5;

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
    s->plan_start = s->plan_end = pinch_arena_here(arena);
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

/* Small matrices take little time in any case. The rows and columns of multipliers differ in their signs, and need
 * pivots. */
static bool is_large(const pinch_force_system *s)
{
    enum { LARGE = 200 };
    return s->multiplier_count == 0 && s->block_count >= LARGE;
}

/* May the factors be in single precision? */
static bool may_be_single(const pinch_force_system *s)
{
    bool bodies = is_large(s) && !s->needs_double;
    for (int k = 0; k < s->block_count && bodies; k++) bodies = s->block_size[k] == PINCH_FORCE_BODY;
    return bodies;
}

/* Plans the factorization of the blocks that have been laid out. */
static bool plan_blocks(pinch_arena *arena, pinch_force_system *s, bool complete)
{
    int clusters = s->mobility->cluster_count, edges = coupled_pairs(s, NULL);
    int *edge = PINCH_ARENA_ARRAY(arena, int, 2 * edges + 1);
    if (!edge) return false;
    pinch_block_graph graph = {s->block_count, clusters, coupled_pairs(s, edge), edge};
    /* what multipliers couple needs pivots that only a complete factorization has */
    bool needed = complete || s->multiplier_count > 0;
    bool single = may_be_single(s);
    double worth = (single ? WORTH_IN_SINGLE : WORTH_ITERATING) * (clusters + 2 * edges + s->element_count);
    double limit = needed ? most_products(s) : fmax(worth, s->split_products);
    bool planned = single ? pinch_block_lu_plan_single(arena, &graph, s->block_size, limit, s->orders, &s->lu)
                          : pinch_block_lu_plan(arena, &graph, s->block_size, limit, s->orders, &s->lu);
    if (!planned) return false;
    s->refined = s->lu.single ? PINCH_ARENA_ARRAY(arena, double, 2 * s->block_first[s->block_count]) : NULL;
    if (!pinch_force_plan_bounds(arena, s)) return false;
    s->iterative = s->lu.incomplete;
    s->dear = !s->iterative && s->lu.products > worth;
    s->too_large = s->iterative && needed;
    s->last_merit = INFINITY;
    s->exactness_factor = 1;
    s->elements_kept = s->bounds ? PINCH_ARENA_ARRAY(arena, double, s->lu.value_count) : NULL;
    if (!s->iterative) return (!s->crew || pinch_block_lu_share(arena, &s->lu)) && !arena->failed;
    size_t split = pinch_block_dilu_room(&s->lu), vectors = 6 * (size_t)s->block_first[s->block_count];
    s->krylov = PINCH_ARENA_ARRAY(arena, double, split > vectors ? split : vectors);
    return !arena->failed;
}

/* Plans anew, in the place of the last plan unless its caller has put something behind that one. */
static bool plan(pinch_arena *arena, pinch_force_system *s, bool complete)
{
    if (!s->planned && !lay_out(arena, s)) return false;
    if (pinch_arena_is_at(arena, &s->plan_end))
        pinch_arena_rewind(arena, &s->plan_start);
    else
        s->plan_start = pinch_arena_here(arena);
    s->planned = true;
    bool done = plan_blocks(arena, s, complete);
    s->plan_end = pinch_arena_here(arena);
    return done;
}

static void eliminate_elements(void *argument, int first, int end)
{
    pinch_force_system *s = argument;
    bool singular = false, symmetric = true;
    for (int k = first; k < end && !singular; k++) {
        pinch_force_element *e = &s->elements[k];
        singular = !pinch_force_eliminate(e, s->is_warm_start);
        symmetric = symmetric && e->symmetric;
        if (!s->meets) pinch_force_add_impulse(e, s->step, pinch_force_values(e, PINCH_FORCE_CHANGE), s->rhs);
    }
    s->partials[first / PINCH_CHUNK] = (pinch_force_partial){.any = singular, .symmetric = symmetric};
}

/* Tells whether the factors may be those of a symmetric matrix, if the conductances are. */
static bool may_be_symmetric(const pinch_force_system *s)
{
    return !s->iterative && is_large(s);
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
    memset(s->rhs, 0, sizeof(double) * (size_t)s->block_first[s->block_count]);
    pinch_loop(s->crew, s->element_count, eliminate_elements, s);
    s->is_warm_start = false;
    if (pinch_force_any(s)) return false;
    s->lu.symmetric = may_be_symmetric(s) && conductances_are_symmetric(s);
    if (s->meets) pinch_force_add_impulses(s, PINCH_FORCE_CHANGE, s->rhs);
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
static inline void change_element(const pinch_force_element *e, const double *dq)
{
    const double *conductance = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
    double moved[PINCH_CONTACT_ROWS_MAX] = {0}, *change = pinch_force_values(e, PINCH_FORCE_CHANGE);
    int rows = e->rows;
    for (int b = 0; b < 2 && e->conducts; b++)
        if (e->cluster[b] >= 0)
            pinch_force_rows_times(rows, e->block[b].size, e->block[b].g, dq + e->block[b].first, moved);
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < rows; j++) change[i] -= conductance[i * rows + j] * moved[j];
}

static void change_elements(void *argument, int first, int end)
{
    const pinch_force_system *s = argument;
    for (int k = first; k < end; k++)
        if (s->elements[k].rows == PINCH_FORCE_CONTACT) /* the same, with loops that the compiler unrolls */
            change_element(&s->elements[k], s->rhs);
        else
            change_element(&s->elements[k], s->rhs);
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
    if (merit < NEAR && merit > LITTLE * s->last_merit) s->exactness_factor *= SHARPER;
    s->last_merit = merit;
    double usual = fmin(fmax(merit, END / merit), LEAST_EXACT);
    return fmax(s->exactness_factor * usual, MOST_EXACT);
}

static bool solve_by_iteration(pinch_force_system *s, double exactness)
{
    pinch_force_assemble_elements(s);
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
    pinch_force_assemble_elements(s);
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
        pinch_force_add_multipliers(s);
        s->work += s->lu.products;
        if (!pinch_block_lu_factor_and_solve(&s->lu, s->crew, s->rhs)) return false;
        if (end == PINCH_FORCE_BOUNDS_LAST) break;
        end = pinch_force_settle_bounds(s);
        if (end == PINCH_FORCE_BOUNDS_RIGHT) break;
    }
    return true;
}

/*
 * Solves with factors in single precision, and refines what comes out until it is as exact as it should be. Each round
 * is expected to gain what the one before it has gained. Returns false where a round gains too little: the matrix is
 * too badly conditioned for such factors.
 */
static bool solve_in_single(pinch_force_system *s, double exactness)
{
    static const double LEAST_GAIN = 0.1;
    int n = s->block_first[s->block_count];
    double *b = s->refined, *x = b + n, off = 1, gain = 1;
    memcpy(b, s->rhs, sizeof(double) * (size_t)n);
    pinch_force_assemble_elements(s);
    s->work += SINGLE_PRODUCT * s->lu.products;
    if (!pinch_block_lu_factor_and_solve(&s->lu, s->crew, s->rhs)) return false;
    memcpy(x, s->rhs, sizeof(double) * (size_t)n);
    double all = pinch_dot_strands(b, b, n);
    while (all > 0 && off * gain > exactness) {
        pinch_force_find_residual(s, b, x, s->rhs);
        double left = sqrt(pinch_dot_strands(s->rhs, s->rhs, n) / all);
        gain = left / off;
        off = left;
        if (!(gain <= LEAST_GAIN)) return false; /* nor is it where something is not finite */
        if (off <= exactness) break;
        pinch_block_lu_solve(&s->lu, s->crew, s->rhs);
        for (int i = 0; i < n; i++) x[i] += s->rhs[i];
    }
    memcpy(s->rhs, x, sizeof(double) * (size_t)n);
    return true;
}

/* Solves with complete factors. Returns false where they are not to be had, or memory ran out. */
static bool solve_completely(pinch_arena *arena, pinch_force_system *s, double exactness)
{
    if (!s->lu.single) return solve_by_factors(s);
    if (solve_in_single(s, exactness)) return true;
    bool symmetric = s->lu.symmetric;
    memcpy(s->rhs, s->refined, sizeof(double) * (size_t)s->block_first[s->block_count]);
    s->needs_double = true;
    if (!plan(arena, s, true) || s->too_large) return false;
    s->lu.symmetric = symmetric;
    return solve_by_factors(s);
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
    if (!s->iterative && !solve_completely(arena, s, EXACT)) {
        *singular = !arena->failed;
        return false;
    }
    changes_from(s);
    return true;
}

double *pinch_force_clear_rhs(pinch_arena *arena, pinch_force_system *s)
{
    if (!s->planned && !plan(arena, s, false)) return NULL;
    return memset(s->rhs, 0, sizeof(double) * (size_t)(s->block_first[s->block_count] + 1));
}

bool pinch_force_solve_for_rhs(pinch_arena *arena, pinch_force_system *s, double exactness)
{
    s->work += WORK_OF_ELEMENT * s->element_count;
    s->lu.symmetric = may_be_symmetric(s);
    return s->iterative ? solve_by_iteration(s, exactness) : solve_completely(arena, s, exactness);
}

void pinch_force_solve_again(pinch_force_system *s)
{
    s->work += (double)s->lu.value_count / PRODUCT + WORK_OF_ELEMENT * s->element_count;
    pinch_block_lu_solve(&s->lu, s->crew, s->rhs);
}

bool pinch_force_plan_for_split(pinch_arena *arena, pinch_force_system *s, bool *complete)
{
    if ((!s->planned || s->iterative) && !plan(arena, s, false)) return false;
    *complete = !s->iterative;
    return true;
}

bool pinch_force_stop_iterating(pinch_arena *arena, pinch_force_system *s)
{
    return s->iterative && plan(arena, s, true) && !s->too_large;
}
