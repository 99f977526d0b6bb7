/*
 * Factors of the generalized Jacobian, the Newton steps that they give, and the system as the solvers see it. Where
 * multipliers depend on each other, they give way by a little, and steps end at their bounds.
 */
#include "velocity/velocity_system.h"

#include "support/dense.h"
#include "support/extremes.h"
#include "support/lu.h"

#include <math.h>
#include <string.h>

/* The marks of a direction: no multiplier follows it; or one holds it. */
enum { NO_ROW = -1, HELD = -2 };

/* Returns the first direction that a multiplier moves and none holds, or -1. */
static int first_moved(const pinch_element *element, const int *first_of)
{
    int first = -1;
    for (int b = 0; b < element->blocks; b++) {
        int q = element->block[b].first, end = q + element->block[b].size;
        while (q < end && first_of[q] == HELD) q++;
        if (q < end && (first < 0 || q < first)) first = q;
    }
    return first;
}

/* Marks the directions that multipliers of rate rows hold, and chains the other multipliers inside their bounds behind
 * the first direction that each moves. Returns the chain of those that move none but what is held; of rate rows that
 * hold what another one holds there, `behind` has places after those of the elements. */
static int sort_multipliers(pinch_velocity_system *vs, const unsigned char *states)
{
    int *first_of = vs->row_of_first, *behind = first_of + vs->freedoms, others = NO_ROW;
    vs->held_count = 0;
    for (int i = 0; i < vs->freedoms; i++) first_of[i] = NO_ROW;
    for (int k = 0; k < vs->rate_count; k++) {
        const pinch_rate_row *row = &vs->rates[k];
        int e = vs->element_count + k;
        if (row->multiplier < 0 || states[e] != PINCH_VELOCITY_INSIDE) continue;
        if (first_of[row->unknown] == HELD) {
            behind[e] = others;
            others = e;
            continue;
        }
        first_of[row->unknown] = HELD;
        vs->held[vs->held_count++] = k;
    }
    for (int e = vs->element_count - 1; e >= 0; e--) {
        const pinch_element *element = &vs->elements[e];
        if (element->multiplier < 0 || states[e] != PINCH_VELOCITY_INSIDE) continue;
        int q = first_moved(element, first_of), *chain = q < 0 ? &others : &first_of[q];
        behind[e] = *chain;
        *chain = e;
    }
    return others;
}

/*
 * Chooses the order in which the unknowns of a tree of joints are eliminated. Few of them act on each other, and the
 * factors stay so where the leaves come first, as they do among the directions of a tree. A multiplier follows the
 * first direction that its row moves, by which it gets a pivot; free bodies, which tie the fingers together that hold
 * them, come last. Where a multiplier holds one unknown alone, as dry friction holds a joint, the unknown follows from
 * its row, and neither is in the order. states: of the elements, where the Jacobian was assembled.
 */
static void choose_order(pinch_velocity_system *vs, const unsigned char *states)
{
    const pinch_mobility *mobility = vs->mobility;
    int next = 0, *first_of = vs->row_of_first, *behind = first_of + vs->freedoms;
    int others = sort_multipliers(vs, states);
    for (int pass = 0; pass < 2; pass++)
        for (int c = 0; c < mobility->cluster_count; c++) {
            const pinch_cluster *cluster = &mobility->clusters[c];
            if (cluster->free != (pass == 1)) continue;
            for (int q = cluster->first; q < cluster->first + cluster->freedoms; q++) {
                if (first_of[q] == HELD) continue;
                vs->order[next++] = q;
                for (int e = first_of[q]; e >= 0; e = behind[e]) vs->order[next++] = vs->elements[e].multiplier;
            }
        }
    for (int e = others; e >= 0; e = behind[e])
        vs->order[next++] =
            e < vs->element_count ? vs->elements[e].multiplier : vs->rates[e - vs->element_count].multiplier;
    vs->ordered = next;
}

static void linearize(void *self, const double *x)
{
    /* Where masses turn slowly, old factors gain three digits a step. New factors of one or two free bodies are cheaper
     * than another step. */
    enum { REMEMBERED_STEPS = 4 };
    pinch_velocity_system *vs = self;
    int steps = vs->unknowns > PINCH_FEW_UNKNOWNS ? REMEMBERED_STEPS : 1;
    memcpy(vs->frozen, x, sizeof(double) * (size_t)vs->unknowns);
    vs->assembled = vs->softened = false;
    vs->remembered = vs->linearized++ < steps && vs->pull == 0 && pinch_velocity_memory_fits(vs);
}

static pinch_row row_of(void *self, int row)
{
    pinch_velocity_system *vs = self;
    if (!vs->assembled) pinch_velocity_assemble(vs);
    if (!vs->scaled) {
        double over = 1 / vs->scale;
        for (size_t i = 0; i < (size_t)vs->unknowns * (size_t)vs->unknowns; i++) vs->jacobian[i] *= over;
        vs->scaled = true;
    }
    vs->segment.start = 0;
    vs->segment.length = vs->unknowns;
    vs->segment.values = vs->jacobian + (size_t)row * (size_t)vs->unknowns;
    pinch_row result = {1, &vs->segment};
    return result;
}

/* With the pull of a flow, more acts on each other than in a tree. */
static bool in_order(const pinch_velocity_system *vs)
{
    return vs->order && vs->pull == 0 && !vs->softened;
}

/* The unknown that a held pair's multiplier holds. */
static int held_unknown(const pinch_velocity_system *vs, int k)
{
    return vs->rates[vs->held[k]].unknown;
}

/*
 * The parts of the Jacobian where `held` unknowns are held by a multiplier each, in the order of elimination: with
 * these pairs taken out, `ordered` unknowns are left. Held unknowns q follow from the rows of their multipliers, the
 * others from `kept` and `of_held`, and the multipliers last from the rows of q.
 */
typedef struct held_parts {
    double *kept;    /* ordered x ordered: the others by themselves, or its factors */
    double *of_held; /* ordered x held: what held unknowns do to the others' rows */
    double *rows;    /* held x ordered: the held unknowns' rows, in the others */
    double *mutual;  /* held x held: the same in the held unknowns */
    double *hold;    /* held: the multiplier's row in its unknown */
    size_t size;     /* of all */
} held_parts;

static held_parts parts_in(const pinch_velocity_system *vs, double *lu)
{
    size_t n = (size_t)vs->ordered, held = (size_t)vs->held_count;
    held_parts p = {.kept = lu};
    p.of_held = p.kept + n * n;
    p.rows = p.of_held + n * held;
    p.mutual = p.rows + held * n;
    p.hold = p.mutual + held * held;
    p.size = n * n + 2 * n * held + held * held + held;
    return p;
}

/* Copies the Jacobian, without F's scale, to where its factors are to be: as it is, or its parts. */
static void copy_jacobian(pinch_velocity_system *vs)
{
    size_t n = (size_t)vs->unknowns, ordered = (size_t)vs->ordered, held = (size_t)vs->held_count;
    double scale = vs->scaled ? vs->scale : 1;
    if (!in_order(vs)) {
        for (size_t i = 0; i < n * n; i++) vs->lu[i] = scale * vs->jacobian[i];
        vs->factor_size = n * n;
        return;
    }
    held_parts p = parts_in(vs, vs->lu);
    vs->factor_size = p.size;
    for (size_t i = 0; i < ordered; i++) {
        const double *from = vs->jacobian + (size_t)vs->order[i] * n;
        for (size_t j = 0; j < ordered; j++) p.kept[i * ordered + j] = scale * from[vs->order[j]];
        for (size_t j = 0; j < held; j++) p.of_held[i * held + j] = scale * from[held_unknown(vs, (int)j)];
    }
    for (size_t i = 0; i < held; i++) {
        const double *from = vs->jacobian + (size_t)held_unknown(vs, (int)i) * n;
        for (size_t j = 0; j < ordered; j++) p.rows[i * ordered + j] = scale * from[vs->order[j]];
        for (size_t j = 0; j < held; j++) p.mutual[i * held + j] = scale * from[held_unknown(vs, (int)j)];
        p.hold[i] = vs->rates[vs->held[i]].g;
    }
}

/*
 * Factors with multipliers inside their bounds that give way by a little, `gives` of the inertia that the row would
 * move. Where dry friction holds the joints that a mimic row couples, these rows depend on each other: any sharing of
 * the forces will do, and there is no V^-1.
 */
static void factor_softened(pinch_velocity_system *vs, double gives)
{
    vs->softened = true;
    copy_jacobian(vs);
    for (int i = vs->freedoms; i < vs->unknowns; i++) {
        double *pivot = &vs->lu[(size_t)i * (size_t)(vs->unknowns + 1)];
        if (*pivot == 0) *pivot = gives;
    }
    vs->factor_good = pinch_lu_factor(vs->unknowns, vs->lu, vs->pivot, vs->lu_scratch);
}

/* Rows that agree are met to the sixth digit in a step then. */
static const double GIVES = 1e-6;

/* Factors the Jacobian: without exchanges where the order is that of a tree and its pivots will do, and where there is
 * no inverse with multipliers that give way. */
static void factor(pinch_velocity_system *vs)
{
    vs->factored = true;
    vs->softened = false;
    for (int i = 0; i < vs->unknowns; i++) vs->pivot[i] = i;
    if (in_order(vs)) choose_order(vs, vs->states);
    copy_jacobian(vs);
    if (in_order(vs)) {
        vs->factor_good = pinch_sparse_lu_factor(&vs->sparse, vs->ordered, vs->lu);
        if (vs->factor_good) return;
        copy_jacobian(vs);
    }
    vs->factor_good = pinch_lu_factor(in_order(vs) ? vs->ordered : vs->unknowns, vs->lu, vs->pivot, vs->lu_scratch);
    if (!vs->factor_good) factor_softened(vs, GIVES);
}

/* The same in the order of elimination. A multiplier at its bound has the row y - bound, and is known beforehand. */
static void solve_ordered(const pinch_velocity_system *vs, double *lu, const int *pivot, const unsigned char *states,
                          const double *rhs, double *dx)
{
    const held_parts p = parts_in(vs, lu);
    int ordered = vs->ordered, held = vs->held_count;
    double *own = vs->permuted, *of_held = own + ordered;
    memcpy(dx, rhs, sizeof *dx * (size_t)vs->unknowns);
    for (int e = 0; e < vs->element_count; e++) {
        const pinch_element *element = &vs->elements[e];
        if (element->multiplier < 0 || states[e] == PINCH_VELOCITY_INSIDE) continue;
        double y = rhs[element->multiplier];
        for (int b = 0; b < element->blocks && y != 0; b++)
            for (int k = 0; k < element->block[b].size; k++)
                dx[element->block[b].first + k] += y * element->block[b].g[k];
    }
    for (int k = 0; k < vs->rate_count; k++) {
        const pinch_rate_row *row = &vs->rates[k];
        if (row->multiplier >= 0 && states[vs->element_count + k] != PINCH_VELOCITY_INSIDE)
            dx[row->unknown] += row->g * rhs[row->multiplier];
    }
    for (int k = 0; k < held; k++) of_held[k] = rhs[vs->rates[vs->held[k]].multiplier] / p.hold[k];
    for (int i = 0; i < ordered; i++)
        own[i] = dx[vs->order[i]] - pinch_dot_strands(p.of_held + (size_t)i * (size_t)held, of_held, held);
    pinch_lu_solve_strands(ordered, p.kept, pivot, own);
    for (int i = 0; i < ordered; i++) dx[vs->order[i]] = own[i];
    for (int k = 0; k < held; k++) {
        double force = dx[held_unknown(vs, k)];
        force -= pinch_dot_strands(p.rows + (size_t)k * (size_t)ordered, own, ordered);
        force -= pinch_dot_strands(p.mutual + (size_t)k * (size_t)held, of_held, held);
        dx[vs->rates[vs->held[k]].multiplier] = -force / p.hold[k];
    }
    for (int k = 0; k < held; k++) dx[held_unknown(vs, k)] = of_held[k];
    for (int i = 0; i < vs->unknowns; i++) dx[i] *= vs->scale;
}

/* dx = J^-1 rhs by factors of the Jacobian without F's scale */
static void solve_by_factors(const pinch_velocity_system *vs, double *lu, const int *pivot, const unsigned char *states,
                             const double *rhs, double *dx)
{
    int n = vs->unknowns;
    if (in_order(vs)) {
        solve_ordered(vs, lu, pivot, states, rhs, dx);
        return;
    }
    pinch_lu_solve(n, lu, pivot, rhs, dx);
    for (int i = 0; i < n; i++) dx[i] *= vs->scale;
}

/* A multiplier that a step x - dx takes to a bound, and how much of the step it takes to get there. */
typedef struct bound_reached {
    int unknown; /* -1: none */
    double bound, part;
} bound_reached;

/* Looks whether a multiplier that is inside its bounds gets to one before the one known. */
static void look_for_bound(const pinch_velocity_system *vs, int unknown, double low, double high, const double *dx,
                           bound_reached *first)
{
    double x = vs->frozen[unknown], end = pinch_clamp(x - dx[unknown], low, high);
    bool inside = vs->jacobian[(size_t)unknown * (size_t)(vs->unknowns + 1)] == 0;
    if (!inside || end == x - dx[unknown]) return;
    double part = (x - end) / dx[unknown];
    if (first->unknown < 0 || part < first->part) *first = (bound_reached){unknown, end, part};
}

static bound_reached first_bound(const pinch_velocity_system *vs, const double *dx)
{
    bound_reached first = {.unknown = -1};
    for (int e = 0; e < vs->element_count; e++) {
        const pinch_multiplier *m = pinch_multiplier_of(vs, &vs->elements[e]);
        if (m) look_for_bound(vs, vs->elements[e].multiplier, m->unit.low, m->unit.high, dx, &first);
    }
    for (int k = 0; k < vs->rate_count; k++) {
        const pinch_rate_row *row = &vs->rates[k];
        if (row->multiplier >= 0) look_for_bound(vs, row->multiplier, row->low, row->high, dx, &first);
    }
    return first;
}

/* From now on the row of a multiplier is that it ends at its bound. */
static void end_at_bound(pinch_velocity_system *vs, const bound_reached *at)
{
    double *row = vs->jacobian + (size_t)at->unknown * (size_t)vs->unknowns;
    memset(row, 0, sizeof *row * (size_t)vs->unknowns);
    row[at->unknown] = vs->scaled ? 1 / vs->scale : 1;
    vs->bounded[at->unknown] = (vs->frozen[at->unknown] - at->bound) / vs->scale;
}

/* The most that a row misses by which its multiplier gives way, as a part of F's scale. */
static double missed_by_giving(const pinch_velocity_system *vs, double gives, const double *dx)
{
    double most = 0;
    for (int i = vs->freedoms; i < vs->unknowns; i++)
        if (vs->jacobian[(size_t)i * (size_t)(vs->unknowns + 1)] == 0)
            most = pinch_larger(fabs(gives * dx[i]) / vs->scale, most);
    return most;
}

/*
 * The step of softened factors, with multipliers within their bounds. Rows that contradict each other, as those of a
 * mimic joint that has drifted do while friction holds it, push theirs on until one reaches its bound: it ends there,
 * and the others are solved for once more. As long as rows are missed and none is at a bound, they give way by less.
 * The Jacobian is used up.
 */
static bool solve_within_bounds(pinch_velocity_system *vs, const double *rhs, double *dx)
{
    enum { MOST_PASSES = 24 };
    static const double MISSED = 1e-13, LESS = 1e-3, LEAST = 1e-15;
    double gives = GIVES;
    memcpy(vs->bounded, rhs, sizeof *rhs * (size_t)vs->unknowns);
    vs->assembled = false;
    for (int pass = 0; pass < MOST_PASSES && vs->factor_good; pass++) {
        solve_by_factors(vs, vs->lu, vs->pivot, vs->states, vs->bounded, dx);
        bound_reached first = first_bound(vs, dx);
        if (first.unknown >= 0)
            end_at_bound(vs, &first);
        else if (gives > LEAST && missed_by_giving(vs, gives, dx) > MISSED)
            gives *= LESS;
        else
            return true;
        factor_softened(vs, gives);
    }
    return false;
}

static bool solve(void *self, const double *rhs, double *dx)
{
    pinch_velocity_system *vs = self;
    if (vs->remembered) {
        if (vs->order) choose_order(vs, vs->memory->states);
        solve_by_factors(vs, vs->memory->lu, vs->memory->pivot, vs->memory->states, rhs, dx);
        return true;
    }
    if (!vs->assembled) pinch_velocity_assemble(vs);
    if (!vs->factored) factor(vs);
    if (!vs->factor_good) return false;
    if (vs->softened) return solve_within_bounds(vs, rhs, dx);
    solve_by_factors(vs, vs->lu, vs->pivot, vs->states, rhs, dx);
    return true;
}

static bool sharpen(void *self)
{
    pinch_velocity_system *vs = self;
    bool was_remembered = vs->remembered;
    vs->remembered = false;
    return was_remembered;
}

pinch_system pinch_velocity_system_interface(pinch_velocity_system *vs)
{
    pinch_system system = {
        .size = vs->unknowns,
        .self = vs,
        .residual = pinch_velocity_residual,
        .residual_row = pinch_velocity_residual_row,
        .linearize = linearize,
        .row = row_of,
        .solve = solve,
        .sharpen = sharpen,
    };
    return system;
}
