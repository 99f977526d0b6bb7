/* Solves the linear system of a Newton step, equation (27) of core/README.md: the forces are eliminated contact by
 * contact, and blocks of the bodies are left. */
#include "force/force_rows.h"
#include "force/force_system.h"
#include "support/block_dilu.h"

#include <math.h>
#include <string.h>

/* A complete factorization is given up for an iteration where it takes more products of blocks than this many times
 * what the matrix has of blocks and contacts. */
static const double WORTH_ITERATING = 12;
static const double LEAST_EXACT = 1e-3, MOST_EXACT = 1e-7, END = 2e-13;

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
            blocks->to[a][b] =
                cluster[a] < 0 || cluster[b] < 0 ? NULL : pinch_block_lu_at(&s->lu, cluster[a], cluster[b]);
    }
}

/* to (6 x 6) += left^T weighted, both 3 x 6 */
static void add_body_product(const double *restrict left, const double *restrict weighted, double *restrict to)
{
    enum { N = PINCH_FORCE_BODY };
    for (int l = 0; l < N; l++) {
        double g0 = left[l], g1 = left[N + l], g2 = left[2 * N + l];
        for (int k = 0; k < N; k++) to[l * N + k] += g0 * weighted[k] + g1 * weighted[N + k] + g2 * weighted[2 * N + k];
    }
}

static void add_body_products(pinch_force_system *s, const pinch_force_element *e, pair_blocks *blocks)
{
    enum { N = PINCH_FORCE_BODY };
    const double *conductance = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
    double d[9], weighted[3 * N];
    for (int i = 0; i < 9; i++) d[i] = s->step * conductance[i];
    for (int b = 0; b < 2; b++) {
        if (e->cluster[b] < 0) continue;
        const double *g = e->block[b].g;
        for (int k = 0; k < N; k++) { /* no force moves the normal but the normal velocity: d[1] = d[2] = 0 */
            weighted[k] = d[0] * g[k];
            weighted[N + k] = d[3] * g[k] + d[4] * g[N + k] + d[5] * g[2 * N + k];
            weighted[2 * N + k] = d[6] * g[k] + d[7] * g[N + k] + d[8] * g[2 * N + k];
        }
        for (int a = 0; a < 2; a++)
            if (e->cluster[a] >= 0) add_body_product(e->block[a].g, weighted, blocks->to[a][b]);
    }
}

/* matrix += h G_a^T D G_b for the pairs of the element's blocks */
static void add_products(pinch_force_system *s, const pinch_force_element *e, pair_blocks *blocks)
{
    const double *conductance = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
    int rows = e->rows;
    for (int b = 0; b < 2; b++) {
        const pinch_row_block *right = &e->block[b];
        if (e->cluster[b] < 0) continue;
        for (int a = 0; a < 2; a++) {
            const pinch_row_block *left = &e->block[a];
            if (e->cluster[a] < 0) continue;
            double *to = blocks->to[a][b];
            int stride = s->block_size[e->cluster[b]], size = right->size;
            for (int i = 0; i < rows; i++) {
                double weighted[64];
                for (int k0 = 0; k0 < size; k0 += 64) { /* wide blocks go through in parts */
                    int width = size - k0 < 64 ? size - k0 : 64;
                    for (int k = 0; k < width; k++) weighted[k] = 0;
                    bool any = false;
                    for (int j = 0; j < rows; j++) {
                        double d = s->step * conductance[i * rows + j];
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

/* Is this a contact with friction between free bodies, neither of which has multipliers in its block? */
static bool between_bodies(const pinch_force_system *s, const pinch_force_element *e)
{
    bool plain = e->rows == PINCH_FORCE_CONTACT;
    for (int b = 0; b < 2; b++)
        plain = plain && (e->cluster[b] < 0 ||
                          (e->block[b].size == PINCH_FORCE_BODY && s->block_size[e->cluster[b]] == PINCH_FORCE_BODY));
    return plain;
}

/* Adds the rows and columns of a multiplier, which stands in its first cluster's block. Inside its bounds F_b is w - c,
 * at one of them it is y - bound. Multipliers that say the same twice leave the matrix singular but for a little of
 * their own, which makes a step less exact and no answer. */
static void add_multiplier(pinch_force_system *s, const pinch_force_multiplier *m)
{
    bool inside = m->trial > m->unit.low && m->trial < m->unit.high;
    int home = m->cluster[0], at = m->unknown - s->block_first[home];
    double *own = pinch_block_lu_at(&s->lu, home, home);
    static const double REDUNDANT = 1e-10;
    own[at * s->block_size[home] + at] = inside ? REDUNDANT : 1;
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

/* Writes the pairs of clusters that elements and multipliers couple into edge[]; equal pairs that follow each other
 * count once. Returns how many there are. With edge = NULL they are only counted. */
static int coupled_pairs(const pinch_force_system *s, int *edge)
{
    const int *last = NULL;
    int edges = 0;
    for (int k = 0; k < s->multiplier_count + s->element_count; k++) {
        const int *cluster =
            k < s->multiplier_count ? s->multipliers[k].cluster : s->elements[k - s->multiplier_count].cluster;
        if (cluster[0] < 0 || cluster[1] < 0 || (last && last[0] == cluster[0] && last[1] == cluster[1])) continue;
        if (edge) memcpy(edge + 2 * edges, cluster, 2 * sizeof *edge);
        last = cluster;
        edges++;
    }
    return edges;
}

static bool lay_out(pinch_arena *arena, pinch_force_system *s)
{
    int clusters = s->mobility->cluster_count;
    s->block_size = PINCH_ARENA_ARRAY(arena, int, clusters + 1);
    s->block_first = PINCH_ARENA_ARRAY(arena, int, clusters + 1);
    if (arena->failed) return false;
    for (int c = 0; c < clusters; c++) s->block_size[c] = s->mobility->clusters[c].freedoms;
    for (int i = 0; i < s->multiplier_count; i++) {
        pinch_force_multiplier *m = &s->multipliers[i];
        m->unknown = s->block_size[m->cluster[0]]++;
    }
    s->block_first[0] = 0;
    for (int c = 0; c < clusters; c++) s->block_first[c + 1] = s->block_first[c] + s->block_size[c];
    for (int i = 0; i < s->multiplier_count; i++)
        s->multipliers[i].unknown += s->block_first[s->multipliers[i].cluster[0]];
    s->rhs = PINCH_ARENA_ARRAY(arena, double, s->block_first[clusters] + 1);
    s->laid_out = pinch_arena_here(arena);
    return !arena->failed;
}

static bool plan(pinch_arena *arena, pinch_force_system *s, bool complete)
{
    int clusters = s->mobility->cluster_count, edges = coupled_pairs(s, NULL);
    if (!s->planned && !lay_out(arena, s)) return false;
    pinch_arena_rewind(arena, &s->laid_out);
    s->planned = true;
    int *edge = PINCH_ARENA_ARRAY(arena, int, 2 * edges + 1);
    if (!edge) return false;
    (void)coupled_pairs(s, edge);
    /* what multipliers couple needs pivots that only a complete factorization has */
    double limit =
        complete || s->multiplier_count > 0 ? INFINITY : WORTH_ITERATING * (clusters + 2 * edges + s->element_count);
    if (!pinch_block_lu_plan(arena, clusters, s->block_size, edges, edge, limit, &s->lu)) return false;
    s->iterative = s->lu.incomplete;
    s->last_merit = INFINITY;
    s->sharper = 1;
    if (!s->iterative) return true;
    size_t split = pinch_block_dilu_room(&s->lu), vectors = 6 * (size_t)s->block_first[clusters];
    s->krylov = PINCH_ARENA_ARRAY(arena, double, split > vectors ? split : vectors);
    return !arena->failed;
}

/* Assembles the matrix from the conductances. */
static void assemble(pinch_force_system *s)
{
    pair_blocks blocks = {.cluster = {-1, -1}};
    pinch_block_lu_clear(&s->lu);
    for (int c = 0; c < s->mobility->cluster_count; c++) {
        double *own = pinch_block_lu_at(&s->lu, c, c);
        for (int k = 0; k < s->mobility->clusters[c].freedoms; k++) own[k * s->block_size[c] + k] = 1;
    }
    for (int k = 0; k < s->element_count; k++) {
        const pinch_force_element *e = &s->elements[k];
        if (!e->conducts) continue;
        find_blocks(s, e->cluster, &blocks);
        if (between_bodies(s, e))
            add_body_products(s, e, &blocks);
        else
            add_products(s, e, &blocks);
    }
    for (int i = 0; i < s->multiplier_count; i++) add_multiplier(s, &s->multipliers[i]);
}

/* Eliminates all elements and forms the right hand side: -h G^T shift, and -F_b of a multiplier. Returns false where
 * one is singular. */
static bool eliminate(pinch_force_system *s)
{
    memset(s->rhs, 0, sizeof(double) * (size_t)s->block_first[s->mobility->cluster_count]);
    for (int k = 0; k < s->element_count; k++) {
        pinch_force_element *e = &s->elements[k];
        const double *change = pinch_force_values(e, PINCH_FORCE_CHANGE);
        double impulse[PINCH_CONTACT_ROWS_MAX];
        int rows = e->rows;
        if (!pinch_force_eliminate(e)) return false;
        for (int i = 0; i < rows; i++) impulse[i] = s->step * change[i];
        for (int b = 0; b < 2; b++)
            if (e->cluster[b] >= 0)
                pinch_force_rows_transposed_times(rows, e->block[b].size, e->block[b].g, impulse,
                                                  s->rhs + s->block_first[e->cluster[b]]);
    }
    for (int i = 0; i < s->multiplier_count; i++) s->rhs[s->multipliers[i].unknown] = -s->multipliers[i].f;
    return true;
}

/* dr = -shift - D G dq */
static void changes_from(pinch_force_system *s)
{
    for (int k = 0; k < s->element_count; k++) {
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
    for (int i = 0; i < s->multiplier_count; i++) s->multipliers[i].change = s->rhs[s->multipliers[i].unknown];
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

static bool solve_by_iteration(pinch_force_system *s, double merit)
{
    assemble(s);
    return pinch_block_dilu_split(&s->lu, s->rhs, s->krylov) && pinch_force_bicgstab(s, exactness_of_step(s, merit));
}

static bool solve_by_factors(pinch_force_system *s)
{
    assemble(s);
    if (!pinch_block_lu_factor(&s->lu)) return false;
    pinch_block_lu_solve(&s->lu, s->rhs);
    return true;
}

bool pinch_force_solve_linear(pinch_arena *arena, pinch_force_system *s, double merit, bool *singular)
{
    *singular = true;
    if (!s->planned && !plan(arena, s, false)) return *singular = false;
    if (!eliminate(s)) return false;
    if (s->iterative && !solve_by_iteration(s, merit)) {
        if (!plan(arena, s, true)) return *singular = false;
        (void)pinch_force_evaluate(s); /* the slopes stand where the trial forces stood */
        if (!eliminate(s)) return false;
    }
    if (!s->iterative && !solve_by_factors(s)) return false;
    changes_from(s);
    return true;
}
