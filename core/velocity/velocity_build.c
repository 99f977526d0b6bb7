/* Builds the velocity system from the problem and its mobility. */
#include "velocity/velocity_system.h"

#include "kinematics/joint_space.h"
#include "support/extremes.h"
#include "support/lanes.h"

#include <math.h>
#include <string.h>

/* Blocks of no more columns are those of single bodies, which are multiplied out as they are. */
enum { FEW_COLUMNS = 6 };

/* The columns of a block that are not all zero: from `first` to before `end`, and among these the longest run of zero
 * columns, `zeros` from `gap` on. */
typedef struct used_columns {
    int first, end, gap, zeros;
} used_columns;

static inline bool is_zero(const pinch_row_block *block, int rows, int k)
{
    bool zero = true;
    const double *g = block->g + k;
    for (int i = 0; i < rows; i++, g += block->size) zero &= *g == 0;
    return zero;
}

static inline used_columns columns_of(const pinch_row_block *block, int rows)
{
    used_columns used = {0, block->size, 0, 0};
    while (used.first < used.end && is_zero(block, rows, used.first)) used.first++;
    while (used.end > used.first && is_zero(block, rows, used.end - 1)) used.end--;
    for (int k = used.first + 1; k < used.end; k++) {
        int gap = k;
        while (is_zero(block, rows, k)) k++; /* the last column is not */
        if (k - gap <= used.zeros) continue;
        used.gap = gap;
        used.zeros = k - gap;
    }
    return used;
}

/* Copies columns of a block into one of their own. Returns false when memory ran out. */
static bool cut_out(pinch_arena *arena, const pinch_row_block *from, int rows, int first, int size, pinch_row_block *to)
{
    double *g = PINCH_ARENA_ARRAY(arena, double, rows *size + 1);
    if (!g) return false;
    for (int i = 0; i < rows; i++) memcpy(g + i * size, from->g + i * from->size + first, sizeof *g * (size_t)size);
    *to = (pinch_row_block){from->first + first, size, g};
    return true;
}

/*
 * Appends to the element's blocks what of one is not zero: a joint of a finger moves the finger and what carries it,
 * and the columns of the other fingers lie between these. It is parted where most zeros are. Returns false when memory
 * ran out.
 */
static bool append(pinch_arena *arena, const pinch_row_block *from, pinch_element *element)
{
    int rows = element->law.rows;
    pinch_row_block *block = &element->block[element->blocks];
    if (from->size <= FEW_COLUMNS) {
        if (from->size > 0) element->block[element->blocks++] = *from;
        return true;
    }
    const used_columns used = rows == 1   ? columns_of(from, 1) /* the compiler knows the number of rows */
                              : rows == 3 ? columns_of(from, 3)
                                          : columns_of(from, 4);
    if (used.first == used.end) return true;
    bool parted = used.zeros >= FEW_COLUMNS / 2;
    element->blocks += parted ? 2 : 1;
    if (!parted) return cut_out(arena, from, rows, used.first, used.end - used.first, block);
    int behind = used.gap + used.zeros;
    return cut_out(arena, from, rows, used.first, used.gap - used.first, block) &&
           cut_out(arena, from, rows, behind, used.end - behind, block + 1);
}

/* Leaves out what is zero in the rows of an element, which are in two blocks. */
static bool leave_out_zeros(pinch_arena *arena, const pinch_row_block reduced[2], pinch_element *element)
{
    element->blocks = 0;
    for (int b = 0; b < 2; b++)
        if (!append(arena, &reduced[b], element)) return false;
    return true;
}

static bool add_contact(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility,
                        const pinch_contact *contact, pinch_element *element)
{
    int cluster[2];
    pinch_row_block block[2];
    element->multiplier = -1;
    memcpy(element->w0, contact->surface_velocity, sizeof element->w0); /* torsion is the last row here */
    memcpy(element->r, contact->force, sizeof element->r);
    pinch_contact_law_of(contact, problem->faces, &element->law);
    pinch_trial_force_of(contact, problem->step, &element->trial);
    return pinch_contact_rows(arena, mobility, problem->bodies, contact, block, cluster, element->w0) &&
           leave_out_zeros(arena, block, element);
}

/* The cluster that a joint's rate is an unknown of. */
static const pinch_cluster *cluster_of_rate(const pinch_mobility *mobility, const pinch_joint_row *row)
{
    return &mobility->clusters[pinch_cluster_of_row(mobility, row)];
}

/*
 * Fills in the element of a row whose parts are all along rates of joints that are unknowns, each another one. Returns
 * false where they are not, or when memory ran out.
 */
static bool reduce_rates(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility, int k,
                         int parts, pinch_element *element)
{
    const pinch_joint_rate *rate = mobility->loose.rate + k;
    double w0 = 0;
    if (!mobility->loose.rate || parts > PINCH_ELEMENT_BLOCKS) return false;
    for (int i = 0; i < parts; i++) {
        if (rate[i].direction < 0) return false;
        const pinch_cluster *cluster = cluster_of_rate(mobility, &problem->rows[k + i]);
        double *g = PINCH_ARENA_ARRAY(arena, double, 1);
        if (!g) return false;
        *g = pinch_joint_rate_gain(cluster->space, &rate[i]);
        w0 += pinch_joint_rate_start(cluster->space, &rate[i]);
        element->block[i] = (pinch_row_block){cluster->first + cluster->space->unknown[rate[i].direction], 1, g};
        for (int other = 0; other < i; other++)
            if (element->block[other].first == element->block[i].first) return false;
    }
    element->blocks = parts;
    element->w0[0] = w0;
    return true;
}

/* Adds row k, which is along a rate. */
static void add_rate(const pinch_problem *problem, const pinch_mobility *mobility, int k, int multiplier,
                     pinch_rate_row *row)
{
    const pinch_joint_rate *rate = &mobility->loose.rate[k];
    const pinch_cluster *cluster = cluster_of_rate(mobility, &problem->rows[k]);
    row->g = pinch_joint_rate_gain(cluster->space, rate);
    pinch_rate_row_make(&problem->rows[k], problem->step, pinch_joint_rate_start(cluster->space, rate),
                        cluster->first + cluster->space->unknown[rate->direction], multiplier, row);
}

/* Reduces a row of `parts` parts, which act on two clusters at most. */
static bool reduce_parts(pinch_arena *arena, const pinch_mobility *mobility, const pinch_joint_row *row, int parts,
                         pinch_element *element)
{
    pinch_row_block reduced[2] = {{0}};
    int cluster[2];
    if (parts == 1) {
        if (!pinch_joint_row_reduce(arena, mobility, row, reduced, cluster, element->w0)) return false;
    } else {
        pinch_row_block *block = PINCH_ARENA_ARRAY(arena, pinch_row_block, 2 * parts);
        int *of = PINCH_ARENA_ARRAY(arena, int, 2 * parts);
        int blocks = arena->failed ? -1 : pinch_coupling_reduce(arena, mobility, row, parts, block, of, element->w0);
        for (int i = 0; i < blocks; i++) reduced[i] = block[i];
        if (blocks < 0) return false;
    }
    return leave_out_zeros(arena, reduced, element);
}

/* The rows of joints on their way into the system. */
typedef struct row_builder {
    pinch_arena *arena;
    const pinch_problem *problem;
    const pinch_mobility *mobility;
    struct reduced_row *last; /* per body: the last row that has it as its first */
} row_builder;

typedef struct reduced_row {
    const pinch_joint_row *row; /* NULL: none yet */
    int blocks;
    pinch_row_block block[PINCH_ELEMENT_BLOCKS]; /* not scaled */
    double w0;
} reduced_row;

/* Returns NULL when memory ran out. */
static reduced_row *no_rows_yet(pinch_arena *arena, const pinch_problem *problem)
{
    reduced_row *last = PINCH_ARENA_ARRAY(arena, reduced_row, problem->body_count + 1);
    for (int b = 0; b < problem->body_count && last; b++) last[b].row = NULL;
    return last;
}

static bool same_jacobian(const pinch_joint_row *a, const pinch_joint_row *b)
{
    return a->body2 == b->body2 && memcmp(a->j1, b->j1, sizeof a->j1) == 0 && memcmp(a->j2, b->j2, sizeof a->j2) == 0;
}

/*
 * Reduces row k into the element. Servo, damper, dry friction and stop of a joint are rows with the same Jacobian, of
 * which one is reduced.
 */
static bool reduce_row(const row_builder *b, int k, pinch_element *element)
{
    const pinch_joint_row *row = &b->problem->rows[k];
    int parts = pinch_row_parts(b->problem, k);
    if (reduce_rates(b->arena, b->problem, b->mobility, k, parts, element)) return true;
    if (b->arena->failed) return false;
    reduced_row *last = parts == 1 && row->body1 >= 0 ? &b->last[row->body1] : NULL;
    if (last && last->row && same_jacobian(last->row, row)) {
        memcpy(element->block, last->block, sizeof element->block);
        element->blocks = last->blocks;
        element->w0[0] = last->w0;
        return true;
    }
    if (!reduce_parts(b->arena, b->mobility, row, parts, element)) return false;
    if (!last) return true;
    last->row = row;
    memcpy(last->block, element->block, sizeof last->block);
    last->blocks = element->blocks;
    last->w0 = element->w0[0];
    return true;
}

/* Gives the element numbers of its own, which are to be scaled. */
static bool own_numbers(pinch_arena *arena, pinch_row_block *block, int blocks)
{
    int size = 0;
    for (int b = 0; b < blocks; b++) size += block[b].size;
    double *g = PINCH_ARENA_ARRAY(arena, double, size + 1);
    if (!g) return false;
    for (int b = 0; b < blocks; b++) {
        memcpy(g, block[b].g, sizeof *g * (size_t)block[b].size);
        block[b].g = g;
        g += block[b].size;
    }
    return true;
}

/* Adds row k. A row without compliance has a multiplier, whose place among the unknowns is `unknown`. */
static bool add_row(const row_builder *b, int k, int unknown, pinch_multiplier *multiplier, pinch_element *element)
{
    const pinch_joint_row *row = &b->problem->rows[k];
    element->blocks = 0;
    element->w0[0] = element->r[0] = 0;
    element->state = PINCH_CONTACT_OPEN;
    element->multiplier = -1;
    element->law = (pinch_contact_law){.rows = 1};
    if (!reduce_row(b, k, element)) return false;
    if (row->cfm > 0) {
        element->trial.a[0] = (row->rhs - element->w0[0]) / row->cfm; /* see pinch_rate_row_make */
        element->w0[0] = 0;
        element->trial.g[0] = 1 / row->cfm;
        element->law.low = row->low;
        element->law.high = row->high;
    } else if (!own_numbers(b->arena, element->block, element->blocks)) {
        return false;
    } else if (pinch_unit_row_make(row, b->problem->step, element->w0[0], element->block, element->blocks,
                                   &multiplier->unit)) {
        element->multiplier = unknown;
        element->w0[0] = 0;
    } else { /* no force on it changes anything: it has none */
        *multiplier = (pinch_multiplier){.unit = {.sigma = 1}};
        element->multiplier = unknown;
        element->blocks = 0;
        element->w0[0] = 0;
    }
    if (element->multiplier < 0) element->r[0] = row->force;
    return true;
}

/* The same as external_size of a free body, whose directions are a multiple of the identity beside an upper triangle
 * (mobility.h). */
static void external_size_of_free(const pinch_cluster *cluster, const double *external, double h, double *size)
{
    const double linear = h * cluster->basis[PINCH_FREE_LINEAR], *t = cluster->basis + PINCH_FREE_T;
    for (int i = 0; i < 3; i++) size[i] += fabs(linear * external[i]);
    size[3] += fabs(h * t[0] * external[3]);
    size[4] += fabs(h * t[1] * external[3]);
    size[5] += fabs(h * t[2] * external[3]);
    size[4] += fabs(h * t[3] * external[4]);
    size[5] += fabs(h * t[4] * external[4]);
    size[5] += fabs(h * t[5] * external[5]);
}

/* sum += |h u f| */
static void add_magnitudes(int n, double h, const double *restrict u, double f, double *restrict sum)
{
    int i = 0;
    for (; i + 1 < n; i += 2)
        pinch_lanes_put(pinch_lanes_at(sum + i) + pinch_lanes_abs(h * pinch_lanes_at(u + i) * f), sum + i);
    if (i < n) sum[i] += fabs(h * u[i] * f);
}

/* Adds |h U^T f_ext|, the first part of the scale of F, and sets a drive's guess of its speed. */
static void external_size(const pinch_problem *problem, const pinch_cluster *cluster, double h, double *size, double *x)
{
    if (cluster->free) {
        external_size_of_free(cluster, problem->bodies[cluster->bodies[0]].external, h, size + cluster->first);
        return;
    }
    for (int slot = 0; slot < cluster->body_count; slot++) {
        double expanded[36];
        const double *external = problem->bodies[cluster->bodies[slot]].external;
        if (cluster->space) {
            pinch_joint_space_add_size(cluster->space, slot, h, external, size + cluster->first);
            continue;
        }
        const double *basis = pinch_cluster_basis(cluster, slot, expanded);
        int first = pinch_cluster_first_direction(cluster, slot);
        for (int k = 0; k < 6; k++)
            if (external[k] != 0)
                add_magnitudes(cluster->freedoms - first, h, basis + k * cluster->freedoms + first, external[k],
                               size + cluster->first + first);
    }
    if (cluster->inertia != 0) return;
    const pinch_body *body = &problem->bodies[cluster->bodies[0]];
    double speed = 0, unit2 = 0;
    for (int k = 0; k < 3; k++) {
        speed += cluster->basis[k] * body->velocity[k];
        unit2 += cluster->basis[k] * cluster->basis[k];
    }
    x[cluster->first] = speed / unit2;
}

/* The solve starts from the velocities that the forces of the last step would give now. At rest they are the answer. */
static void warm_start(const pinch_problem *problem, pinch_velocity_system *vs)
{
    const pinch_mobility *mobility = vs->mobility;
    double h = problem->step, *x = vs->x;
    memset(x, 0, sizeof(double) * (size_t)vs->unknowns);
    memset(vs->size, 0, sizeof(double) * (size_t)vs->unknowns);
    for (int k = 0; k < mobility->remaining_count; k++) {
        const pinch_joint_row *from = &problem->rows[mobility->remaining[k]];
        if (vs->part_of_row[k] >= 0) {
            const pinch_rate_row *row = &vs->rates[vs->part_of_row[k]];
            if (row->multiplier >= 0)
                x[row->multiplier] = pinch_clamp(h * row->gain * from->force, row->low, row->high);
            continue;
        }
        const pinch_element *element = &vs->elements[~vs->part_of_row[k]];
        if (element->multiplier < 0 || from->continues) continue;
        const pinch_multiplier *multiplier = pinch_multiplier_of(vs, element);
        x[element->multiplier] =
            pinch_clamp(h * multiplier->unit.sigma * from->force, multiplier->unit.low, multiplier->unit.high);
    }
    for (int e = 0; e < vs->element_count; e++) pinch_element_add_impulse(vs, &vs->elements[e], x, 1, x);
    pinch_rates_add_impulses(vs, x, x);
    for (int c = 0; c < mobility->cluster_count; c++) {
        const pinch_cluster *cluster = &mobility->clusters[c];
        if (!cluster->space) continue;
        for (int i = cluster->first; i < cluster->first + cluster->freedoms; i++) x[i] += vs->drive[i];
        pinch_joint_space_solve(cluster->space, x + cluster->first);
    }
    for (int c = 0; c < mobility->cluster_count; c++) external_size(problem, &mobility->clusters[c], h, vs->size, x);
    memcpy(vs->start, x, sizeof(double) * (size_t)vs->unknowns);
}

/* Tells whether the row is along the rate of one joint, which is an unknown. */
static bool is_along_rate(const pinch_problem *problem, const pinch_mobility *mobility, int j)
{
    bool single = !problem->rows[j].continues && !pinch_row_goes_on(problem, j);
    return single && mobility->loose.rate && mobility->loose.rate[j].direction >= 0;
}

static bool allocate(pinch_arena *arena, const pinch_problem *problem, pinch_velocity_system *vs)
{
    vs->body_scratch = PINCH_ARENA_ARRAY(arena, double, 12 * problem->body_count);
    vs->part_of_row = PINCH_ARENA_ARRAY(arena, int, vs->mobility->remaining_count + 1);
    if (arena->failed) return false;
    vs->element_count = problem->contact_count;
    vs->unknowns = vs->freedoms;
    for (int k = 0; k < vs->mobility->remaining_count; k++) {
        int j = vs->mobility->remaining[k];
        const pinch_joint_row *row = &problem->rows[j];
        if (row->continues)
            vs->part_of_row[k] = vs->part_of_row[k - 1];
        else
            vs->part_of_row[k] = is_along_rate(problem, vs->mobility, j) ? vs->rate_count++ : ~vs->element_count++;
        vs->unknowns += !row->continues && row->cfm == 0;
    }
    size_t n = (size_t)vs->unknowns;
    vs->x = PINCH_ARENA_ARRAY(arena, double, n + 1);
    vs->start = PINCH_ARENA_ARRAY(arena, double, n + 1);
    vs->solver_scratch = PINCH_ARENA_ARRAY(arena, double, pinch_solver_scratch(vs->unknowns) + 1);
    vs->elements = PINCH_ARENA_ARRAY(arena, pinch_element, vs->element_count + 1);
    vs->multipliers = PINCH_ARENA_ARRAY(arena, pinch_multiplier, vs->unknowns - vs->freedoms + 1);
    vs->inertia = PINCH_ARENA_ARRAY(arena, double, n + 1);
    vs->drive = PINCH_ARENA_ARRAY(arena, double, n + 1);
    vs->size = PINCH_ARENA_ARRAY(arena, double, n + 1);
    vs->evaluated = PINCH_ARENA_ARRAY(arena, double, n + 1);
    vs->frozen = PINCH_ARENA_ARRAY(arena, double, n + 1);
    vs->states = PINCH_ARENA_ARRAY(arena, unsigned char, vs->element_count + vs->rate_count + 1);
    vs->rates = PINCH_ARENA_ARRAY(arena, pinch_rate_row, vs->rate_count + 1);
    vs->jacobian = PINCH_ARENA_ARRAY(arena, double, n *n + 1);
    vs->lu = PINCH_ARENA_ARRAY(arena, double, n *n + 1);
    vs->lu_scratch = PINCH_ARENA_ARRAY(arena, double, n + 1);
    vs->bounded = PINCH_ARENA_ARRAY(arena, double, n + 1);
    vs->pivot = PINCH_ARENA_ARRAY(arena, int, n + 1);
    vs->cluster_of_unknown = PINCH_ARENA_ARRAY(arena, int, n + 1);
    vs->touching_start = PINCH_ARENA_ARRAY(arena, int, vs->mobility->cluster_count + 2);
    vs->touching = PINCH_ARENA_ARRAY(arena, int, 2 * vs->element_count + 1);
    return !arena->failed;
}

/* Sets the inertia d, and h U^T f_drive of massless drives. */
static void set_inertia(const pinch_problem *problem, pinch_velocity_system *vs)
{
    const pinch_mobility *mobility = vs->mobility;
    for (int c = 0; c < mobility->cluster_count; c++) {
        const pinch_cluster *cluster = &mobility->clusters[c];
        const pinch_body *body = &problem->bodies[cluster->bodies[0]];
        for (int f = 0; f < cluster->freedoms; f++) {
            vs->inertia[cluster->first + f] = cluster->inertia;
            double drive = 0;
            for (int k = 0; k < 3 && cluster->inertia == 0; k++)
                drive += problem->step * cluster->basis[k] * body->drive_axis[k] * body->drive_force;
            if (cluster->space) drive = -cluster->space->moved[f];
            vs->drive[cluster->first + f] = drive;
            vs->has_drive = vs->has_drive || cluster->inertia == 0;
        }
    }
}

/* In a tree of joints few unknowns act on each other: room for factors that know it. Returns false when memory ran
 * out. */
static bool prepare_order(pinch_arena *arena, pinch_velocity_system *vs)
{
    bool tree = false;
    for (int c = 0; c < vs->mobility->cluster_count; c++)
        tree = tree || vs->mobility->clusters[c].tree || vs->mobility->clusters[c].space;
    if (!tree || vs->unknowns <= PINCH_FEW_UNKNOWNS) return true;
    vs->order = PINCH_ARENA_ARRAY(arena, int, vs->unknowns + 1);
    vs->permuted = PINCH_ARENA_ARRAY(arena, double, vs->unknowns + 1);
    vs->held = PINCH_ARENA_ARRAY(arena, int, vs->rate_count + 1);
    vs->row_of_first = PINCH_ARENA_ARRAY(arena, int, vs->freedoms + vs->element_count + vs->rate_count + 1);
    return !arena->failed && pinch_sparse_lu_allocate(arena, vs->unknowns, &vs->sparse);
}

bool pinch_velocity_system_build(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility,
                                 pinch_velocity_system *vs)
{
    memset(vs, 0, sizeof *vs);
    vs->step = problem->step;
    vs->mobility = mobility;
    vs->memory = problem->memory;
    vs->tag = problem->tag;
    vs->freedoms = mobility->unknowns;
    if (!allocate(arena, problem, vs)) return false;
    set_inertia(problem, vs);
    for (int k = 0; k < problem->contact_count; k++)
        if (!add_contact(arena, problem, mobility, &problem->contacts[k], &vs->elements[k])) return false;
    for (int i = 0; i <= vs->unknowns; i++) vs->evaluated[i] = NAN; /* nothing yet */
    int multiplier = 0;
    row_builder rows = {arena, problem, mobility, no_rows_yet(arena, problem)};
    if (!rows.last) return false;
    for (int k = 0; k < mobility->remaining_count; k++) {
        int j = mobility->remaining[k], part = vs->part_of_row[k], unknown = vs->freedoms + multiplier;
        const pinch_joint_row *row = &problem->rows[j];
        if (row->continues) continue;
        if (part >= 0)
            add_rate(problem, mobility, j, unknown, &vs->rates[part]);
        else if (!add_row(&rows, j, unknown, &vs->multipliers[multiplier], &vs->elements[~part]))
            return false;
        multiplier += row->cfm == 0;
    }
    warm_start(problem, vs);
    return prepare_order(arena, vs);
}
