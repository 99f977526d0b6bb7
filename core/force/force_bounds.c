/*
 * The bounds of multipliers, settled within a Newton step.
 *
 * That is a primal-dual active set method (Hintermueller, Ito and Kunisch, "The primal-dual active set strategy as a
 * semismooth Newton method", 2002). Where a row depends on others, as a motor's in a loop that is locked, its
 * multiplier would go far beyond its bounds first, and no search along that way descends.
 *
 * To change all bounds at once takes few passes, but may go in circles where rows work against each other. So where
 * the number of wrong bounds has not fallen for some passes, only the first of them changes, until it has (block
 * principal pivoting; Judice and Pires, "A block principal pivoting algorithm for large-scale strictly monotone linear
 * complementarity problems", 1994). With one change at a time, always the first, the bounds are settled after finitely
 * many where all principal minors of the reduced matrix are positive (Murty, 1974), as they are without slip: after 125
 * where some motors work against each other in a locked loop. With slip, a row may be wrong between its bounds and at
 * one of them as well. Then no bounds are right until a contact sticks or opens, and the row stays at its bound for
 * this step, which keeps it small.
 *
 * A pass needs no factors of its own (principal pivot transform; Tucker, "A combinatorial equivalence of matrices",
 * 1960). Each row with bounds has its impulse y and its error e. For the bounds that the factors are for, one of the
 * two is given, u, which is 0 or the bound, and the other one, z, follows: z = z0 + Z (u - u0). Other bounds ask for z
 * in place of u in the rows that have changed, which are as many equations in their u. A column of Z is a solve with
 * the factors that are there, and only rows that change once have one. With the bounds that come out, the step is
 * solved with factors of its own, and its bounds are looked at again: what they are is never a matter of how Z was
 * rounded.
 */
#include "force/force_system.h"

#include "support/lu.h"

#include <math.h>
#include <string.h>

static bool may_change(const pinch_force_multiplier *m)
{
    return m->unit.low > -INFINITY || m->unit.high < INFINITY;
}

bool pinch_force_plan_bounds(pinch_arena *arena, pinch_force_system *s)
{
    enum { MOST = PINCH_FORCE_MOST_CHANGED };
    int count = 0;
    s->bounds = NULL;
    for (int i = 0; i < s->multiplier_count; i++) count += may_change(&s->multipliers[i]);
    if (count == 0) return true;
    pinch_force_bounds *b = PINCH_ARENA_ARRAY(arena, pinch_force_bounds, 1);
    if (!b) return false;
    *b = (pinch_force_bounds){
        .count = 0,
        .multiplier = PINCH_ARENA_ARRAY(arena, int, count),
        .base = PINCH_ARENA_ARRAY(arena, int, count),
        .column = PINCH_ARENA_ARRAY(arena, int, count),
        .value = PINCH_ARENA_ARRAY(arena, double, count),
        .changed = PINCH_ARENA_ARRAY(arena, double, count),
        .answer = PINCH_ARENA_ARRAY(arena, double, MOST *count),
        .amount = PINCH_ARENA_ARRAY(arena, double, MOST),
        .matrix = PINCH_ARENA_ARRAY(arena, double, MOST *MOST),
        .scratch = PINCH_ARENA_ARRAY(arena, double, 2 * MOST),
        .rhs = PINCH_ARENA_ARRAY(arena, double, s->block_first[s->block_count] + 1),
        .of = PINCH_ARENA_ARRAY(arena, int, MOST),
        .active = PINCH_ARENA_ARRAY(arena, int, MOST),
        .pivot = PINCH_ARENA_ARRAY(arena, int, MOST),
    };
    if (arena->failed) return false;
    for (int i = 0; i < s->multiplier_count; i++)
        if (may_change(&s->multipliers[i])) b->multiplier[b->count++] = i;
    s->bounds = b;
    return true;
}

static pinch_force_multiplier *numbered(const pinch_force_system *s, int k)
{
    return &s->multipliers[s->bounds->multiplier[k]];
}

static double at_bound(const pinch_force_multiplier *m, int bound)
{
    return bound < 0 ? m->unit.low : m->unit.high;
}

/* Returns what the change in x adds to the error of a multiplier's row. */
static double error_of_change(const pinch_force_system *s, const pinch_force_multiplier *m, double *x)
{
    double error = (m->kappa + m->unit.compliance) * *pinch_force_unknown_of(s, m, x);
    for (int b = 0; b < m->blocks; b++) {
        const double *dq = x + s->block_first[m->cluster[b]];
        for (int k = 0; k < m->block[b].size; k++) error += m->block[b].g[k] * dq[k];
    }
    return error;
}

/* Reads y or the row's error, w - c + C y + kappa (y - a), of each after the step in s->rhs. */
static void read_values(const pinch_force_system *s)
{
    pinch_force_bounds *b = s->bounds;
    for (int k = 0; k < b->count; k++) {
        const pinch_force_multiplier *m = numbered(s, k);
        b->base[k] = m->bound;
        b->column[k] = -1;
        b->value[k] = m->bound == 0 ? m->y + *pinch_force_unknown_of(s, m, s->rhs)
                                    : m->y - m->trial + error_of_change(s, m, s->rhs);
    }
    memcpy(b->changed, b->value, sizeof *b->value * (size_t)b->count);
}

/* Finds how all values answer to a unit of row k's error, or where the factors have it at a bound, of its y. */
static void find_answers(pinch_force_system *s, int k, int column)
{
    pinch_force_bounds *b = s->bounds;
    double *answer = b->answer + (size_t)column * (size_t)b->count;
    memset(b->rhs, 0, sizeof *b->rhs * (size_t)s->block_first[s->block_count]);
    *pinch_force_unknown_of(s, numbered(s, k), b->rhs) = 1;
    pinch_block_lu_solve(&s->lu, NULL, b->rhs);
    for (int i = 0; i < b->count; i++) {
        const pinch_force_multiplier *m = numbered(s, i);
        answer[i] = b->base[i] == 0 ? *pinch_force_unknown_of(s, m, b->rhs) : error_of_change(s, m, b->rhs);
    }
    b->column[k] = column;
    b->of[column] = k;
}

/* Changes the values to those with the multipliers' bounds as they are. Returns false where there are none. */
static bool change_values(pinch_force_system *s, int columns)
{
    pinch_force_bounds *b = s->bounds;
    size_t count = (size_t)b->count;
    double *right = b->scratch + PINCH_FORCE_MOST_CHANGED;
    int active = 0;
    for (int c = 0; c < columns; c++) {
        const pinch_force_multiplier *m = numbered(s, b->of[c]);
        int base = b->base[b->of[c]];
        b->amount[c] = base != 0 && m->bound == -base ? at_bound(m, m->bound) - at_bound(m, base) : 0;
        if (m->bound != base && b->amount[c] == 0) b->active[active++] = c;
    }
    for (int r = 0; r < active; r++) {
        int k = b->of[b->active[r]];
        const pinch_force_multiplier *m = numbered(s, k);
        right[r] = (m->bound == 0 ? 0 : at_bound(m, m->bound)) - b->value[k];
        for (int c = 0; c < columns; c++) right[r] -= b->answer[(size_t)c * count + (size_t)k] * b->amount[c];
        for (int c = 0; c < active; c++)
            b->matrix[r * active + c] = b->answer[(size_t)b->active[c] * count + (size_t)k];
    }
    if (active > 0 && !pinch_lu_factor(active, b->matrix, b->pivot, b->scratch)) return false;
    if (active > 0) pinch_lu_solve(active, b->matrix, b->pivot, right, right);
    for (int r = 0; r < active; r++) b->amount[b->active[r]] = right[r];
    memcpy(b->changed, b->value, sizeof *b->value * count);
    for (int c = 0; c < columns; c++)
        for (size_t i = 0; i < count && b->amount[c] != 0; i++)
            b->changed[i] += b->answer[(size_t)c * count + i] * b->amount[c];
    return true;
}

/* Returns where the k-th belongs by the values: as it is, at the bound that its y is beyond, or off the bound that its
 * row pulls away from. */
static int right_bound(const pinch_force_system *s, int k)
{
    const pinch_force_bounds *b = s->bounds;
    const pinch_force_multiplier *m = numbered(s, k);
    const pinch_unit_row *u = &m->unit;
    double other = b->column[k] < 0 ? 0 : b->amount[b->column[k]];
    if (m->bound == 0) {
        double y = b->base[k] == 0 ? b->changed[k] : at_bound(m, b->base[k]) + other;
        return y < u->low ? -1 : y > u->high ? 1 : 0;
    }
    double error = b->base[k] == 0 ? other : b->changed[k];
    return u->low < u->high && m->bound * error > 0 ? 0 : m->bound;
}

/* Corrects bounds that are wrong, with `alone` only the first of them. Returns how many there were; *first is the first
 * of them. */
static int correct_bounds(pinch_force_system *s, bool alone, int *first)
{
    int wrong = 0;
    for (int k = 0; k < s->bounds->count; k++) {
        int bound = right_bound(s, k);
        if (bound == numbered(s, k)->bound) continue;
        if (wrong == 0) *first = k;
        if (wrong++ == 0 || !alone) numbered(s, k)->bound = bound;
    }
    return wrong;
}

/* Finds the answers to those rows that are not as in the factors. Returns false where there are too many. */
static bool find_all_answers(pinch_force_system *s, int *columns)
{
    const pinch_force_bounds *b = s->bounds;
    for (int k = 0; k < b->count; k++) {
        if (numbered(s, k)->bound == b->base[k] || b->column[k] >= 0) continue;
        if (*columns == PINCH_FORCE_MOST_CHANGED) return false;
        find_answers(s, k, (*columns)++);
    }
    return true;
}

pinch_force_bounds_end pinch_force_settle_bounds(pinch_force_system *s)
{
    enum { MOST_PASSES = 400, PATIENCE = 5 };
    if (!s->bounds) return PINCH_FORCE_BOUNDS_RIGHT;
    int least = s->bounds->count + 1, waited = 0, first = -1, last = -1, columns = 0;
    read_values(s);
    for (int pass = 0; pass < MOST_PASSES; pass++) {
        bool alone = waited >= PATIENCE;
        int before = last < 0 ? 0 : numbered(s, last)->bound, wrong = correct_bounds(s, alone, &first);
        if (wrong == 0) return pass == 0 ? PINCH_FORCE_BOUNDS_RIGHT : PINCH_FORCE_BOUNDS_NEW;
        if (alone && first == last && numbered(s, first)->bound == 0) {
            numbered(s, first)->bound = before;
            return PINCH_FORCE_BOUNDS_LAST;
        }
        last = alone ? first : -1;
        waited = wrong < least ? 0 : waited + 1;
        least = wrong < least ? wrong : least;
        if (!find_all_answers(s, &columns) || !change_values(s, columns)) return PINCH_FORCE_BOUNDS_NEW;
    }
    return PINCH_FORCE_BOUNDS_LAST;
}
