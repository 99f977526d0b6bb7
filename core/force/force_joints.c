/*
 * The multipliers with which all joint rows hold, equation (61) of core/README.md:
 *
 *     S y = c + kappa a - J q,    S = J J^T + C + kappa.
 *
 * In the reduced coordinates inertia is one, and J has rows of unit length, so that S is symmetric, and positive
 * definite where rows are independent or kappa keeps it so. Its Cholesky factor stays within the envelope of S
 * (Jennings, "A compact storage scheme for the solution of symmetric linear simultaneous equations", 1966), which is
 * narrow where rows are numbered from the ends of a mechanism inwards (Cuthill and McKee, "Reducing the bandwidth of
 * sparse symmetric matrices", 1969). It depends on neither forces nor floors, and serves a whole solve.
 */
#include "force/force_joints.h"

#include "support/dense.h"

#include <math.h>
#include <string.h>

/* A factor is made where it takes fewer multiplications than this for each cluster: fewer than one of the blocks of all
 * bodies and joints takes. */
static const double MOST_FOR_A_CLUSTER = 4000;

/*
 * Multipliers with bounds are taken to be between these: the check of the answer tells, and steps on all blocks settle
 * them otherwise. Not where a force was at its bound in the last step, as that of a motor that cannot hold its speed.
 */
static bool is_possible(const pinch_force_system *s)
{
    for (int i = 0; i < s->multiplier_count; i++) {
        const pinch_force_multiplier *m = &s->multipliers[i];
        if (!(m->unit.low < m->unit.high) || (m->y != 0 && (m->y == m->unit.low || m->y == m->unit.high))) return false;
    }
    return s->multiplier_count > 0;
}

/* Lists the multipliers of each cluster, by counting. */
static bool find_incidence(pinch_arena *arena, const pinch_force_system *s, pinch_force_joints *j)
{
    int clusters = s->mobility->cluster_count, ends = 0;
    for (int i = 0; i < j->count; i++) ends += s->multipliers[i].blocks;
    j->start = PINCH_ARENA_ARRAY(arena, int, clusters + 2);
    j->multiplier = PINCH_ARENA_ARRAY(arena, int, ends + 1);
    j->block = PINCH_ARENA_ARRAY(arena, int, ends + 1);
    if (arena->failed) return false;
    memset(j->start, 0, sizeof *j->start * (size_t)(clusters + 2));
    for (int i = 0; i < j->count; i++)
        for (int b = 0; b < s->multipliers[i].blocks; b++) j->start[s->multipliers[i].cluster[b] + 2]++;
    for (int c = 0; c < clusters; c++) j->start[c + 2] += j->start[c + 1];
    for (int i = 0; i < j->count; i++)
        for (int b = 0; b < s->multipliers[i].blocks; b++) {
            int at = j->start[s->multipliers[i].cluster[b] + 1]++;
            j->multiplier[at] = i;
            j->block[at] = b;
        }
    return true;
}

/* Writes the clusters that multipliers tie to `seed`, it included, breadth first. Those reached get `mark`. Returns how
 * many there are. */
static int reach(const pinch_force_system *s, const pinch_force_joints *j, int seed, int mark, int *marks, int *order)
{
    int count = 1;
    order[0] = seed;
    marks[seed] = mark;
    for (int next = 0; next < count; next++)
        for (int k = j->start[order[next]]; k < j->start[order[next] + 1]; k++) {
            const pinch_force_multiplier *m = &s->multipliers[j->multiplier[k]];
            for (int b = 0; b < m->blocks; b++) {
                if (marks[m->cluster[b]] == mark) continue;
                marks[m->cluster[b]] = mark;
                order[count++] = m->cluster[b];
            }
        }
    return count;
}

/* Numbers the rows of S: breadth first from an end of each mechanism, and back. Returns false when memory ran out. */
static bool number_rows(pinch_arena *arena, const pinch_force_system *s, pinch_force_joints *j)
{
    int clusters = s->mobility->cluster_count, reached = 0, next = 0;
    int *marks = PINCH_ARENA_ARRAY(arena, int, clusters + 1), *order = PINCH_ARENA_ARRAY(arena, int, clusters + 1);
    if (arena->failed) return false;
    memset(marks, 0, sizeof *marks * (size_t)(clusters + 1));
    for (int c = 0; c < clusters; c++) {
        if (marks[c] > 0) continue;
        int far = order[reached + reach(s, j, c, 1, marks, order + reached) - 1];
        reached += reach(s, j, far, 2, marks, order + reached);
    }
    for (int i = 0; i < j->count; i++) j->place[i] = -1;
    for (int k = reached - 1; k >= 0; k--)
        for (int at = j->start[order[k]]; at < j->start[order[k] + 1]; at++)
            if (j->place[j->multiplier[at]] < 0) j->place[j->multiplier[at]] = next++;
    for (int i = 0; i < j->count; i++)
        if (j->place[i] < 0) j->place[i] = next++; /* it acts on nothing */
    return true;
}

/* Finds the envelope of S, and makes room for it, all zero. Returns false where a factor is not worth it, or when
 * memory ran out. */
static bool lay_out(pinch_arena *arena, const pinch_force_system *s, pinch_force_joints *j)
{
    double work = 0;
    size_t size = 0;
    for (int p = 0; p < j->count; p++) j->begin[p] = p;
    for (int k = 0; k < s->mobility->cluster_count; k++) {
        int least = j->count;
        for (int at = j->start[k]; at < j->start[k + 1]; at++)
            if (j->place[j->multiplier[at]] < least) least = j->place[j->multiplier[at]];
        for (int at = j->start[k]; at < j->start[k + 1]; at++) {
            int *begin = &j->begin[j->place[j->multiplier[at]]];
            if (least < *begin) *begin = least;
        }
    }
    for (int p = 0; p < j->count; p++) {
        int width = p - j->begin[p] + 1;
        work += 0.5 * width * width;
        size += (size_t)width;
    }
    if (work > MOST_FOR_A_CLUSTER * s->mobility->cluster_count) return false;
    double *at = PINCH_ARENA_ARRAY(arena, double, size + 1);
    if (!at) return false;
    memset(at, 0, sizeof *at * size);
    for (int p = 0; p < j->count; p++) {
        j->line[p] = at - j->begin[p];
        at += p - j->begin[p] + 1;
    }
    return true;
}

/* The rows' blocks are of one cluster. */
static double product(const pinch_row_block *a, const pinch_row_block *b)
{
    return a->size == 6 ? pinch_dot6(a->g, b->g) : pinch_dot_strands(a->g, b->g, a->size);
}

static void form(const pinch_force_system *s, const pinch_force_joints *j)
{
    for (int k = 0; k < s->mobility->cluster_count; k++)
        for (int a = j->start[k]; a < j->start[k + 1]; a++) {
            const pinch_row_block *mine = &s->multipliers[j->multiplier[a]].block[j->block[a]];
            int row = j->place[j->multiplier[a]];
            double *line = j->line[row];
            for (int b = j->start[k]; b < j->start[k + 1]; b++) {
                int column = j->place[j->multiplier[b]];
                if (column <= row) line[column] += product(mine, &s->multipliers[j->multiplier[b]].block[j->block[b]]);
            }
        }
    for (int i = 0; i < j->count; i++) {
        const pinch_force_multiplier *m = &s->multipliers[i];
        j->line[j->place[i]][j->place[i]] += m->unit.compliance + (s->dependent_rows ? m->kappa : 0);
    }
}

/* Puts L in the place of S. Returns false where rows nearly depend on each other and nothing keeps S regular. */
static bool factor(const pinch_force_joints *j, bool dependent)
{
    static const double SMALLEST = 1e-9, ROUNDING = 1e-15; /* squares of what is independent of other rows, of one */
    for (int p = 0; p < j->count; p++) {
        double *line = j->line[p];
        for (int k = j->begin[p]; k < p; k++) {
            int from = j->begin[k] > j->begin[p] ? j->begin[k] : j->begin[p];
            line[k] = (line[k] - pinch_dot_strands(line + from, j->line[k] + from, k - from)) / j->line[k][k];
        }
        double left = line[p] - pinch_dot_strands(line + j->begin[p], line + j->begin[p], p - j->begin[p]);
        if (!(left > (dependent ? ROUNDING : SMALLEST))) return false;
        line[p] = sqrt(left);
    }
    return true;
}

bool pinch_force_factor_joints(pinch_arena *arena, pinch_force_system *s)
{
    if (!is_possible(s)) return true;
    pinch_arena_mark here = pinch_arena_here(arena);
    pinch_force_joints *j = PINCH_ARENA_ARRAY(arena, pinch_force_joints, 1);
    if (!j) return false;
    j->count = s->multiplier_count;
    j->bounded = false;
    for (int i = 0; i < j->count; i++) {
        const pinch_unit_row *u = &s->multipliers[i].unit;
        j->bounded = j->bounded || u->low > -INFINITY || u->high < INFINITY;
    }
    j->place = PINCH_ARENA_ARRAY(arena, int, j->count);
    j->begin = PINCH_ARENA_ARRAY(arena, int, j->count);
    j->line = PINCH_ARENA_ARRAY(arena, double *, j->count);
    j->solution = PINCH_ARENA_ARRAY(arena, double, j->count);
    if (arena->failed || !find_incidence(arena, s, j) || !number_rows(arena, s, j)) return false;
    bool done = lay_out(arena, s, j);
    if (done) {
        form(s, j);
        done = factor(j, s->dependent_rows);
    }
    if (done)
        s->joints = j;
    else if (!arena->failed)
        pinch_arena_rewind(arena, &here);
    return !arena->failed;
}

/* x = S^-1 x */
static void solve(const pinch_force_joints *j, double *x)
{
    for (int p = 0; p < j->count; p++) {
        const double *line = j->line[p];
        x[p] = (x[p] - pinch_dot_strands(line + j->begin[p], x + j->begin[p], p - j->begin[p])) / line[p];
    }
    for (int p = j->count - 1; p >= 0; p--) {
        const double *line = j->line[p];
        x[p] /= line[p];
        for (int k = j->begin[p]; k < p; k++) x[k] -= x[p] * line[k];
    }
}

void pinch_force_satisfy_rows(pinch_force_system *s, bool forces)
{
    const pinch_force_joints *j = s->joints;
    size_t bytes = sizeof *s->q * (size_t)s->mobility->unknowns;
    if (s->base_q)
        memcpy(s->q, s->base_q, bytes);
    else
        memset(s->q, 0, bytes);
    for (int k = 0; k < s->element_count && forces; k++)
        pinch_force_add_impulse(&s->elements[k], s->step, pinch_force_values(&s->elements[k], PINCH_FORCE_R), s->q);
    for (int i = 0; i < j->count; i++) {
        const pinch_force_multiplier *m = &s->multipliers[i];
        double missed = m->unit.target + (s->dependent_rows ? m->kappa * m->anchor : 0);
        for (int b = 0; b < m->blocks; b++)
            missed -= pinch_dot_strands(m->block[b].g, s->q + m->block[b].first, m->block[b].size);
        j->solution[j->place[i]] = missed;
    }
    solve(j, j->solution);
    for (int i = 0; i < j->count; i++) {
        pinch_force_multiplier *m = &s->multipliers[i];
        m->y = j->solution[j->place[i]];
        m->bound = 0;
        for (int b = 0; b < m->blocks; b++)
            for (int k = 0; k < m->block[b].size; k++) s->q[m->block[b].first + k] += m->y * m->block[b].g[k];
    }
}

void pinch_force_refine_rows(pinch_force_system *s)
{
    const pinch_force_joints *j = s->joints;
    for (int i = 0; i < j->count; i++) j->solution[j->place[i]] = s->multipliers[i].f;
    solve(j, j->solution);
    for (int i = 0; i < j->count; i++) s->multipliers[i].y -= j->solution[j->place[i]];
}
