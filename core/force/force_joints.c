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

/* Rows of L are found this many at a time, and begin together: each entry waits for the one before it in its row, and
 * meanwhile those of the other rows are found. */
enum { PANEL = 4 };

/*
 * Holds multipliers at the bounds that they start from. A motor that could not hold its speed in the last step seldom
 * can in this one; the check of the answer tells, and steps on all blocks settle bounds otherwise. Returns false where
 * a guess is worth little: where it is about many, as those of motors that work against each other are, or about a
 * force that is prescribed, or where no contact makes steps on all blocks dear.
 */
static bool hold_at_bounds(const pinch_force_system *s, pinch_force_joints *j)
{
    enum { MOST_HELD = 8 };
    static const double NEAR = 1e-9; /* of the bound: a force comes back with the rounding of its units */
    int count = 0;
    for (int i = 0; i < j->count; i++) {
        const pinch_force_multiplier *m = &s->multipliers[i];
        double low = m->unit.low, high = m->unit.high;
        if (!(low < high)) return false;
        bool at_low = low != 0 && isfinite(low) && m->y <= low + NEAR * fabs(low);
        bool at_high = high != 0 && isfinite(high) && m->y >= high - NEAR * fabs(high);
        j->held[i] = at_low ? -1 : at_high;
        j->bounded = j->bounded || low > -INFINITY || high < INFINITY;
        count += j->held[i] != 0;
    }
    return count <= MOST_HELD && (count == 0 || s->contact_count > 0);
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
            if (j->place[j->multiplier[at]] < 0 && j->held[j->multiplier[at]] == 0)
                j->place[j->multiplier[at]] = next++;
    for (int i = 0; i < j->count; i++)
        if (j->place[i] < 0) j->place[i] = next++; /* it is held, or acts on nothing */
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
            if (least < *begin && j->held[j->multiplier[at]] == 0) *begin = least;
        }
    }
    for (int p = 0; p + PANEL <= j->count; p += PANEL) {
        int least = p;
        for (int k = p; k < p + PANEL; k++) least = j->begin[k] < least ? j->begin[k] : least;
        for (int k = p; k < p + PANEL; k++) j->begin[k] = least;
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

/* The block times numbers of its cluster */
static inline double product_with(const pinch_row_block *a, const double *x)
{
    return a->size == 6 ? pinch_dot6(a->g, x) : pinch_dot_strands(a->g, x, a->size);
}

static void form(const pinch_force_system *s, const pinch_force_joints *j)
{
    for (int k = 0; k < s->mobility->cluster_count; k++)
        for (int a = j->start[k]; a < j->start[k + 1]; a++) {
            const pinch_row_block *mine = &s->multipliers[j->multiplier[a]].block[j->block[a]];
            int row = j->place[j->multiplier[a]];
            double *line = j->line[row];
            if (j->held[j->multiplier[a]] != 0) continue;
            for (int b = j->start[k]; b < j->start[k + 1]; b++) {
                int column = j->place[j->multiplier[b]]; /* those that are held come last */
                if (column <= row)
                    line[column] += product_with(mine, s->multipliers[j->multiplier[b]].block[j->block[b]].g);
            }
        }
    for (int i = 0; i < j->count; i++) {
        const pinch_force_multiplier *m = &s->multipliers[i];
        double *own = &j->line[j->place[i]][j->place[i]];
        *own = j->held[i] == 0 ? *own + m->unit.compliance + (s->dependent_rows ? m->kappa : 0) : 1;
    }
}

static int later(int a, int b)
{
    return a > b ? a : b;
}

/* Finds the entries of a panel's rows in the columns before its own. */
static void factor_panel(const pinch_force_joints *j, int p)
{
    double *const line[PANEL] = {j->line[p], j->line[p + 1], j->line[p + 2], j->line[p + 3]};
    for (int k = j->begin[p]; k < p; k++) {
        int from = later(j->begin[k], j->begin[p]);
        const double *const own[PANEL] = {line[0] + from, line[1] + from, line[2] + from, line[3] + from};
        double sum[PANEL];
        pinch_four_dots(k - from, own, j->line[k] + from, sum);
        for (int i = 0; i < PANEL; i++) line[i][k] = (line[i][k] - sum[i]) * j->inverse[k];
    }
}

/* Finds the entries of a row from column `at` on. Returns false where the row nearly depends on those before it. */
static bool factor_row(const pinch_force_joints *j, int p, int at, double smallest)
{
    double *line = j->line[p];
    for (int k = later(at, j->begin[p]); k < p; k++) {
        int from = later(j->begin[k], j->begin[p]);
        line[k] = (line[k] - pinch_dot_strands(line + from, j->line[k] + from, k - from)) * j->inverse[k];
    }
    double left = line[p] - pinch_dot_strands(line + j->begin[p], line + j->begin[p], p - j->begin[p]);
    if (!(left > smallest)) return false;
    line[p] = sqrt(left);
    j->inverse[p] = 1 / line[p];
    return true;
}

/* Puts L in the place of S. Returns false where rows nearly depend on each other and nothing keeps S regular. */
static bool factor(const pinch_force_joints *j, bool dependent)
{
    static const double SMALLEST = 1e-9, ROUNDING = 1e-15; /* squares of what is independent of other rows, of one */
    for (int p = 0; p < j->count; p++) {
        int panel = p - p % PANEL;
        bool whole = panel + PANEL <= j->count;
        if (whole && p == panel) factor_panel(j, p);
        if (!factor_row(j, p, whole ? panel : 0, dependent ? ROUNDING : SMALLEST)) return false;
    }
    return true;
}

bool pinch_force_factor_joints(pinch_arena *arena, pinch_force_system *s)
{
    if (s->multiplier_count == 0) return true;
    pinch_arena_mark here = pinch_arena_here(arena);
    pinch_force_joints *j = PINCH_ARENA_ARRAY(arena, pinch_force_joints, 1);
    if (!j) return false;
    j->count = s->multiplier_count;
    j->bounded = false;
    j->held = PINCH_ARENA_ARRAY(arena, int, j->count);
    j->place = PINCH_ARENA_ARRAY(arena, int, j->count);
    j->begin = PINCH_ARENA_ARRAY(arena, int, j->count);
    j->line = PINCH_ARENA_ARRAY(arena, double *, j->count);
    j->inverse = PINCH_ARENA_ARRAY(arena, double, j->count);
    j->solution = PINCH_ARENA_ARRAY(arena, double, j->count);
    if (arena->failed) return false;
    if (!find_incidence(arena, s, j)) return false;
    bool done = hold_at_bounds(s, j);
    if (done && !number_rows(arena, s, j)) return false;
    done = done && lay_out(arena, s, j);
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

/* Takes from x of a panel's rows what the columns before its own have of them. */
static void substitute_panel(const pinch_force_joints *j, int p, double *x)
{
    int from = j->begin[p];
    const double *const line[PANEL] = {j->line[p] + from, j->line[p + 1] + from, j->line[p + 2] + from,
                                       j->line[p + 3] + from};
    double sum[PANEL];
    pinch_four_dots(p - from, line, x + from, sum);
    for (int i = 0; i < PANEL; i++) x[p + i] -= sum[i];
}

/* The same for the columns before a panel, from its rows. */
static void substitute_panel_back(const pinch_force_joints *j, int p, double *x)
{
    int from = j->begin[p];
    const double *const line[PANEL] = {j->line[p] + from, j->line[p + 1] + from, j->line[p + 2] + from,
                                       j->line[p + 3] + from};
    const double factors[PANEL] = {-x[p], -x[p + 1], -x[p + 2], -x[p + 3]};
    pinch_add_four_multiples(p - from, factors, line, x + from);
}

/* x = S^-1 x */
static void solve(const pinch_force_joints *j, double *x)
{
    for (int p = 0; p < j->count; p++) {
        int panel = p - p % PANEL;
        bool whole = panel + PANEL <= j->count;
        int from = whole ? panel : j->begin[p];
        if (whole && p == panel) substitute_panel(j, p, x);
        x[p] = (x[p] - pinch_dot(j->line[p] + from, x + from, p - from)) * j->inverse[p];
    }
    for (int p = j->count - 1; p >= 0; p--) {
        int panel = p - p % PANEL;
        bool whole = panel + PANEL <= j->count;
        int from = whole ? panel : j->begin[p];
        x[p] *= j->inverse[p];
        pinch_add_multiple(p - from, -x[p], j->line[p] + from, x + from);
        if (whole && p == panel) substitute_panel_back(j, p, x);
    }
}

/* q += J^T y of one row */
static inline void add_motion(const pinch_force_system *s, const pinch_force_multiplier *m, double y)
{
    for (int b = 0; b < m->blocks; b++) {
        double *q = s->q + m->block[b].first;
        if (m->block[b].size == 6)
            pinch_add_multiple(6, y, m->block[b].g, q);
        else
            pinch_add_multiple(m->block[b].size, y, m->block[b].g, q);
    }
}

/* J q of one row */
static inline double motion_along(const pinch_force_system *s, const pinch_force_multiplier *m)
{
    double sum = 0;
    for (int b = 0; b < m->blocks; b++) sum += product_with(&m->block[b], s->q + m->block[b].first);
    return sum;
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
        pinch_force_multiplier *m = &s->multipliers[i];
        if (j->held[i] == 0) continue;
        m->y = j->held[i] < 0 ? m->unit.low : m->unit.high;
        add_motion(s, m, m->y);
    }
    for (int i = 0; i < j->count; i++) {
        const pinch_force_multiplier *m = &s->multipliers[i];
        double wanted = m->unit.target + (s->dependent_rows ? m->kappa * m->anchor : 0);
        j->solution[j->place[i]] = j->held[i] == 0 ? wanted - motion_along(s, m) : 0;
    }
    solve(j, j->solution);
    for (int i = 0; i < j->count; i++) {
        pinch_force_multiplier *m = &s->multipliers[i];
        m->bound = j->held[i];
        if (j->held[i] != 0) continue;
        m->y = j->solution[j->place[i]];
        add_motion(s, m, m->y);
    }
}

/* S dy = kappa (y - a), a being the anchor of the pass before: what rows missed after it, but for what has been put
 * aside, which is part of their targets */
void pinch_force_advance_rows(pinch_force_system *s)
{
    const pinch_force_joints *j = s->joints;
    memset(s->q, 0, sizeof *s->q * (size_t)s->mobility->unknowns);
    for (int i = 0; i < j->count; i++) {
        const pinch_force_multiplier *m = &s->multipliers[i];
        j->solution[j->place[i]] = j->held[i] == 0 ? m->missed - m->kappa * m->base : 0;
    }
    solve(j, j->solution);
    for (int i = 0; i < j->count; i++)
        if (j->held[i] == 0) add_motion(s, &s->multipliers[i], j->solution[j->place[i]]);
}

void pinch_force_refine_rows(pinch_force_system *s)
{
    const pinch_force_joints *j = s->joints;
    for (int i = 0; i < j->count; i++) j->solution[j->place[i]] = j->held[i] == 0 ? s->multipliers[i].f : 0;
    solve(j, j->solution);
    for (int i = 0; i < j->count; i++) s->multipliers[i].y -= j->solution[j->place[i]];
}

bool pinch_force_may_hold_rows(const pinch_force_system *s)
{
    return s->joints && !s->joints->bounded && !s->dependent_rows;
}

void pinch_force_hold_rows(pinch_force_system *s)
{
    pinch_force_satisfy_rows(s, true);
    (void)pinch_force_evaluate(s);
    pinch_force_refine_rows(s);
    (void)pinch_force_evaluate(s);
}
