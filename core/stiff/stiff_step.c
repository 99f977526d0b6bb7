/* The linear system of a Newton step on a stiff system: forces eliminated contact by contact, blocks of the bodies
 * left. */
#include "stiff/stiff_system.h"

#include "support/lu.h"

#include <string.h>

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
