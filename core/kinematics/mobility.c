#include "kinematics/mobility.h"

#include "kinematics/joint_tree.h"
#include "kinematics/space_loops.h"
#include "support/dense.h"

#include <math.h>
#include <string.h>

/* The directions that hard rows leave are dense: more freedoms than the first are not looked for. Where rows make
 * loops, they are looked for among the second many unknowns of the bodies at most. */
enum { LARGEST_DENSE = 60, LARGEST_LOOP = 30 };

static int find_root(int *parent, int body)
{
    while (parent[body] != body) {
        parent[body] = parent[parent[body]];
        body = parent[body];
    }
    return body;
}

/* Groups the bodies into clusters, numbered by their first body. */
static bool group_bodies(pinch_arena *arena, const pinch_problem *problem, pinch_mobility *mobility)
{
    int n = problem->body_count;
    int *parent = PINCH_ARENA_ARRAY(arena, int, n + 1), *members = PINCH_ARENA_ARRAY(arena, int, n + 1);
    mobility->cluster_of = PINCH_ARENA_ARRAY(arena, int, n + 1);
    mobility->slot_of = PINCH_ARENA_ARRAY(arena, int, n + 1);
    mobility->clusters = PINCH_ARENA_ARRAY(arena, pinch_cluster, n + 1);
    if (arena->failed) return false;

    for (int b = 0; b < n; b++) parent[b] = b;
    for (int k = 0; k < problem->row_count; k++) {
        const pinch_joint_row *row = &problem->rows[k];
        if (!mobility->eliminated[k] || row->body1 < 0 || row->body2 < 0) continue;
        if (k > 0 && mobility->eliminated[k - 1] && row[-1].body1 == row->body1 && row[-1].body2 == row->body2)
            continue;
        int a = find_root(parent, row->body1), b = find_root(parent, row->body2);
        if (a < b)
            parent[b] = a;
        else
            parent[a] = b;
    }
    mobility->cluster_count = 0;
    for (int b = 0; b < n; b++) {
        int root = find_root(parent, b);
        if (root == b) {
            pinch_cluster *cluster = &mobility->clusters[mobility->cluster_count];
            memset(cluster, 0, sizeof *cluster);
            cluster->inertia = 1;
            mobility->cluster_of[b] = mobility->cluster_count++;
        } else {
            mobility->cluster_of[b] = mobility->cluster_of[root];
        }
        mobility->slot_of[b] = mobility->clusters[mobility->cluster_of[b]].body_count++;
    }
    for (int k = 0, next = 0; k < mobility->cluster_count; k++) {
        mobility->clusters[k].bodies = members + next;
        next += mobility->clusters[k].body_count;
    }
    for (int b = 0; b < n; b++)
        members[mobility->clusters[mobility->cluster_of[b]].bodies - members + mobility->slot_of[b]] = b;
    return true;
}

/* Groups the hard rows by cluster, by counting. Cluster k's are rows[start[k]] to rows[start[k + 1] - 1]. */
static bool group_rows(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility, int **start,
                       int **rows)
{
    int clusters = mobility->cluster_count;
    int *first = PINCH_ARENA_ARRAY(arena, int, clusters + 2);
    *rows = PINCH_ARENA_ARRAY(arena, int, problem->row_count + 1);
    *start = first;
    if (arena->failed) return false;
    memset(first, 0, sizeof(int) * (size_t)(clusters + 2));
    for (int k = 0; k < problem->row_count; k++)
        if (mobility->eliminated[k]) first[pinch_cluster_of_row(mobility, &problem->rows[k]) + 2]++;
    for (int k = 0; k < clusters; k++) first[k + 2] += first[k + 1];
    for (int k = 0; k < problem->row_count; k++)
        if (mobility->eliminated[k]) (*rows)[first[pinch_cluster_of_row(mobility, &problem->rows[k]) + 1]++] = k;
    return true;
}

/* Equation (13): U = Y Q2 of a jointed cluster. */
static void admissible_directions(const pinch_constraint_factor *c, pinch_cluster *cluster)
{
    for (int f = 0; f < cluster->freedoms; f++) {
        double u[6];
        memset(cluster->scratch, 0, sizeof(double) * (size_t)c->n);
        cluster->scratch[c->rank + f] = 1;
        pinch_constraint_apply_q(c, cluster->scratch);
        for (int slot = 0; slot < cluster->body_count; slot++) {
            pinch_root_apply(&c->roots[slot], cluster->scratch + 6 * slot, u);
            for (int i = 0; i < 6; i++) cluster->basis[(6 * slot + i) * cluster->freedoms + f] = u[i];
        }
    }
}

/* Factorizes the hard rows of a cluster. Returns NULL when memory ran out. */
static pinch_constraint_factor *factor_of_rows(pinch_arena *arena, const pinch_problem *problem,
                                               const pinch_mobility *mobility, const pinch_cluster *cluster,
                                               const int *row_indices, int row_count)
{
    pinch_constraint_factor *c = pinch_constraint_allocate(arena, cluster->body_count, row_count);
    if (!c) return NULL;
    for (int slot = 0; slot < cluster->body_count; slot++) c->roots[slot] = mobility->roots[cluster->bodies[slot]];
    for (int k = 0; k < row_count; k++) {
        const pinch_joint_row *row = &problem->rows[row_indices[k]];
        const int slot[2] = {row->body1 >= 0 ? mobility->slot_of[row->body1] : -1,
                             row->body2 >= 0 ? mobility->slot_of[row->body2] : -1};
        const double *const j[2] = {row->j1, row->j2};
        pinch_constraint_add(c, row_indices[k], slot, j);
    }
    pinch_constraint_factorize(c);
    return c;
}

/* Tells whether all rows are clearly independent of each other; pivots descend. */
static bool independent(const pinch_constraint_factor *c)
{
    static const double SMALLEST_PIVOT = 1e-3;
    return c->rank == c->count && (c->rank == 0 || fabs(c->diagonal[c->rank - 1]) > SMALLEST_PIVOT);
}

/* What becomes of the hard rows of a cluster. */
typedef enum row_fate { ROWS_ELIMINATED, ROWS_KEPT, ROWS_KEPT_INDEPENDENT } row_fate;

/* Do motors, servos, springs or dampers act along as many joints of a cluster as half of its bodies have? */
static bool is_driven(const pinch_problem *problem, const pinch_mobility *mobility, const pinch_cluster *cluster)
{
    int driven = 0, body = cluster->bodies[0], own = mobility->cluster_of[body];
    for (int k = 0; k < problem->row_count; k++) {
        const pinch_joint_row *row = &problem->rows[k];
        if (mobility->eliminated[k] || pinch_row_is_hard(row) || row->body1 < 0 || row->body2 < 0) continue;
        driven += mobility->cluster_of[row->body1] == own && mobility->cluster_of[row->body2] == own;
    }
    return 2 * driven >= cluster->body_count;
}

/*
 * Tells whether it costs less to keep the rows of a tree than to eliminate them, in multiplications of a solve of two
 * Newton steps. Its f directions are made orthonormal and factored as a dense block; kept rows have factors whose work
 * goes with the number of bodies. A drive along a joint couples its two bodies directly, which leaves more than twice
 * as many products of blocks to a body and its joint: 12 and 6 in the middle of a chain, in place of 6 and 2.
 */
static bool costs_less_kept(const pinch_problem *problem, const pinch_mobility *mobility, const pinch_cluster *cluster,
                            int row_count)
{
    static const double FOR_A_BODY = 5000, DRIVEN = 18.0 / 8;
    double f = 6.0 * cluster->body_count - row_count, kept = FOR_A_BODY * cluster->body_count;
    double eliminated = f > LARGEST_DENSE ? INFINITY : f * f * (12.0 * cluster->body_count + 4 * f);
    if (eliminated <= kept) return false;
    return eliminated > DRIVEN * kept || !is_driven(problem, mobility, cluster);
}

/* Tells whether the rows make a tree in which no row nearly depends on others. */
static bool independent_tree(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility,
                             const pinch_cluster *cluster, pinch_tree_rows rows)
{
    pinch_arena_mark here = pinch_arena_here(arena);
    bool is =
        pinch_joint_tree_is_independent(arena, problem, mobility->roots, cluster->body_count, mobility->slot_of, rows);
    if (!arena->failed) pinch_arena_rewind(arena, &here);
    return is;
}

/* Computes the roots of a cluster's bodies. Returns false where an inertia is not positive definite. */
static bool find_roots(const pinch_problem *problem, const pinch_mobility *mobility, const pinch_cluster *cluster)
{
    for (int slot = 0; slot < cluster->body_count; slot++) {
        int body = cluster->bodies[slot];
        if (problem->bodies[body].mass != 0.0 && !pinch_root_inverse_of(&problem->bodies[body], &mobility->roots[body]))
            return false;
    }
    return true;
}

/* Makes the rates of the joints the cluster's unknowns, where they can be. Returns false where not, or when memory ran
 * out. */
static bool find_rates(pinch_arena *arena, const pinch_problem *problem, pinch_mobility *mobility,
                       pinch_cluster *cluster, pinch_tree_rows rows)
{
    const pinch_space_members members = {cluster->bodies, cluster->body_count, mobility->slot_of};
    cluster->space = pinch_joint_space_build(arena, problem, members, rows, &mobility->loose);
    if (!cluster->space) return false;
    cluster->freedoms = cluster->space->freedoms;
    return true;
}

/* Finds the directions that a cluster's hard rows leave, or keeps the rows. Returns false when memory ran out, or where
 * an inertia is not positive definite. */
static bool factor_joints(pinch_arena *arena, const pinch_problem *problem, pinch_elimination elimination,
                          pinch_mobility *mobility, pinch_cluster *cluster, pinch_tree_rows rows, row_fate *fate)
{
    int size = 6 * cluster->body_count;
    bool rates = elimination == PINCH_ELIMINATE_INTO_RATES;
    *fate = ROWS_ELIMINATED;
    cluster->scratch = PINCH_ARENA_ARRAY(arena, double, size);
    if (rates && size - rows.count <= LARGEST_DENSE && find_rates(arena, problem, mobility, cluster, rows)) return true;
    if (arena->failed) return false;
    *fate = ROWS_KEPT_INDEPENDENT;
    if ((elimination == PINCH_ELIMINATE_WHERE_CHEAP || rates) &&
        costs_less_kept(problem, mobility, cluster, rows.count)) {
        if (!find_roots(problem, mobility, cluster)) return false;
        if (independent_tree(arena, problem, mobility, cluster, rows)) return !arena->failed;
    }
    /* As many freedoms are left at least. To look for the directions would cost more the longer a mechanism is, to the
     * third power. */
    *fate = elimination != PINCH_ELIMINATE_ALL && size - rows.count > LARGEST_DENSE ? ROWS_KEPT : ROWS_ELIMINATED;
    if (*fate == ROWS_KEPT) return !arena->failed;
    if (!find_roots(problem, mobility, cluster)) return false;
    cluster->tree = pinch_joint_tree_build(arena, problem, mobility->roots, cluster->bodies, cluster->body_count,
                                           mobility->slot_of, rows);
    if (arena->failed) return false;
    if (elimination != PINCH_ELIMINATE_ALL &&
        (cluster->tree ? cluster->tree->freedoms > LARGEST_DENSE : size > LARGEST_LOOP || rows.count > size))
        *fate = ROWS_KEPT;
    if (*fate == ROWS_KEPT) return true;
    if (cluster->tree) {
        cluster->freedoms = cluster->tree->freedoms;
        cluster->basis = PINCH_ARENA_ARRAY(arena, double, size *(cluster->freedoms + 1));
        if (!arena->failed) pinch_joint_tree_basis(cluster->tree, cluster->basis);
        return !arena->failed;
    }
    pinch_constraint_factor *c = factor_of_rows(arena, problem, mobility, cluster, rows.index, rows.count);
    if (!c) return false;
    if (elimination != PINCH_ELIMINATE_ALL && !independent(c)) *fate = ROWS_KEPT;
    if (*fate == ROWS_KEPT) return true;
    cluster->factor = c;
    cluster->freedoms = c->n - c->rank;
    cluster->basis = PINCH_ARENA_ARRAY(arena, double, (size_t)c->n *(size_t)(cluster->freedoms + 1));
    if (arena->failed) return false;
    admissible_directions(c, cluster);
    return true;
}

/* Builds what depends on the joints and the masses they tie together alone. Where rows are to be kept, it takes them
 * out of `eliminated`, and wants to be called once more. */
static bool build_structure(pinch_arena *arena, const pinch_problem *problem, pinch_elimination elimination,
                            pinch_mobility *mobility)
{
    int *start, *rows;
    mobility->unknowns = 0;
    const pinch_tree_rows others = {mobility->remaining, mobility->remaining_count};
    if (elimination == PINCH_ELIMINATE_INTO_RATES && !pinch_loose_rows_list(arena, problem, others, &mobility->loose))
        return false;
    if (!group_bodies(arena, problem, mobility) || !group_rows(arena, problem, mobility, &start, &rows)) return false;
    for (int k = 0; k < mobility->cluster_count; k++) {
        pinch_cluster *cluster = &mobility->clusters[k];
        int row_count = start[k + 1] - start[k];
        if (row_count > 0) {
            row_fate fate;
            pinch_tree_rows own = {rows + start[k], row_count};
            if (!factor_joints(arena, problem, elimination, mobility, cluster, own, &fate)) return false;
            for (int i = start[k]; i < start[k + 1] && fate != ROWS_ELIMINATED; i++) {
                mobility->eliminated[rows[i]] = false;
                mobility->kept_count++;
                mobility->dependent_count += fate == ROWS_KEPT;
            }
        } else {
            bool massless = problem->bodies[cluster->bodies[0]].mass == 0.0;
            if (!find_roots(problem, mobility, cluster)) return false;
            cluster->inertia = massless ? 0 : 1;
            cluster->freedoms = massless ? 1 : 6;
            cluster->free = !massless;
            cluster->basis = PINCH_ARENA_ARRAY(arena, double, massless ? 6 : PINCH_FREE_BASIS);
        }
        cluster->v0 = PINCH_ARENA_ARRAY(arena, double, 6 * cluster->body_count);
        cluster->first = mobility->unknowns;
        mobility->unknowns += cluster->freedoms;
        if (arena->failed) return false;
    }
    return true;
}

static void free_body(const pinch_body *body, const pinch_root_inverse *root, pinch_cluster *cluster)
{
    cluster->basis[PINCH_FREE_LINEAR] = root->linear;
    memcpy(cluster->basis + PINCH_FREE_T, root->t, sizeof root->t);
    memcpy(cluster->v0, body->velocity, 6 * sizeof(double));
}

const double *pinch_cluster_basis(const pinch_cluster *cluster, int slot, double expanded[36])
{
    const double *t = cluster->basis + PINCH_FREE_T;
    if (!cluster->free) return cluster->basis + (size_t)(6 * slot) * (size_t)cluster->freedoms;
    memset(expanded, 0, 36 * sizeof *expanded);
    for (int i = 0; i < 3; i++) expanded[7 * i] = cluster->basis[PINCH_FREE_LINEAR];
    expanded[21] = t[0];
    expanded[22] = t[1];
    expanded[23] = t[2];
    expanded[28] = t[3];
    expanded[29] = t[4];
    expanded[35] = t[5];
    return expanded;
}

int pinch_cluster_first_direction(const pinch_cluster *cluster, int slot)
{
    return cluster->tree ? cluster->tree->bodies[slot].first_direction : 0;
}

void pinch_drive_direction(const pinch_problem *problem, int drive, double direction[3])
{
    double resistance = 0;
    for (int k = 0; k < problem->contact_count; k++) {
        const pinch_contact *contact = &problem->contacts[k];
        if (contact->body1 == drive || contact->body2 == drive)
            resistance += problem->step * (problem->step * contact->stiffness[0] + contact->damping[0]);
    }
    for (int i = 0; i < 3; i++)
        direction[i] = problem->bodies[drive].drive_axis[i] / (resistance > 0 ? sqrt(resistance) : 1);
}

static void massless_drive(const pinch_problem *problem, int index, pinch_cluster *cluster)
{
    memset(cluster->basis, 0, 6 * sizeof(double));
    memset(cluster->v0, 0, 6 * sizeof(double));
    pinch_drive_direction(problem, index, cluster->basis);
}

/* Equation (13): v0 = v* + Y Q1 y with y = R^-T (c - J v*) */
static void jointed_v0(const pinch_problem *problem, pinch_cluster *cluster)
{
    pinch_constraint_factor *c = cluster->factor;
    for (int k = 0; k < c->count; k++) {
        const pinch_joint_row *row = &problem->rows[c->row[k]];
        double rhs = row->rhs;
        if (row->body1 >= 0) rhs -= pinch_dot(row->j1, problem->bodies[row->body1].velocity, 6);
        if (row->body2 >= 0) rhs -= pinch_dot(row->j2, problem->bodies[row->body2].velocity, 6);
        c->rhs[k] = rhs / c->length[k];
    }
    pinch_constraint_solve_transposed(c);
    double *x = cluster->scratch;
    memset(x, 0, sizeof(double) * (size_t)c->n);
    memcpy(x, c->y, sizeof(double) * (size_t)c->rank);
    pinch_constraint_apply_q(c, x);
    for (int slot = 0; slot < cluster->body_count; slot++) {
        double *v0 = cluster->v0 + 6 * slot;
        const double *v = problem->bodies[cluster->bodies[slot]].velocity;
        pinch_root_apply(&c->roots[slot], x + 6 * slot, v0);
        for (int i = 0; i < 6; i++) v0[i] += v[i];
    }
}

static void refresh(const pinch_problem *problem, const pinch_mobility *mobility)
{
    for (int k = 0; k < mobility->cluster_count; k++) {
        pinch_cluster *cluster = &mobility->clusters[k];
        if (cluster->space)
            pinch_joint_space_v0(cluster->space, problem, cluster->v0);
        else if (cluster->tree)
            pinch_joint_tree_v0(cluster->tree, problem, cluster->bodies, cluster->v0);
        else if (cluster->factor)
            jointed_v0(problem, cluster);
        else if (cluster->inertia == 0)
            massless_drive(problem, cluster->bodies[0], cluster);
        else
            free_body(&problem->bodies[cluster->bodies[0]], &mobility->roots[cluster->bodies[0]], cluster);
    }
}

static bool any_massless(const pinch_problem *problem)
{
    bool any = false;
    for (int b = 0; b < problem->body_count; b++) any |= problem->bodies[b].mass == 0.0;
    return any;
}

static bool ties_massless(const pinch_problem *problem, const pinch_joint_row *row)
{
    return (row->body1 >= 0 && problem->bodies[row->body1].mass == 0.0) ||
           (row->body2 >= 0 && problem->bodies[row->body2].mass == 0.0);
}

/* Builds the structure anew, without rates as unknowns. Rows of loops that were in these may be kept then. */
static bool build_without_rates(pinch_arena *arena, const pinch_problem *problem, pinch_elimination elimination,
                                pinch_mobility *mobility)
{
    int kept;
    if (elimination == PINCH_ELIMINATE_INTO_RATES) elimination = PINCH_ELIMINATE_WHERE_CHEAP;
    mobility->loose.rate = NULL;
    do {
        kept = mobility->kept_count;
        if (!build_structure(arena, problem, elimination, mobility)) return false;
    } while (mobility->kept_count > kept);
    return true;
}

bool pinch_mobility_has_loops(const pinch_mobility *mobility)
{
    bool any = false;
    for (int c = 0; c < mobility->cluster_count && !any; c++)
        any = mobility->clusters[c].space && mobility->clusters[c].space->loops;
    return any;
}

/* Counts the hard rows among which some depend on others, where loops are in the rates of joints. */
static int count_dependent(const pinch_mobility *mobility)
{
    int count = 0;
    for (int c = 0; c < mobility->cluster_count; c++) {
        const pinch_joint_space *space = mobility->clusters[c].space;
        if (!space || !space->loops || space->loops->rank == space->loops->count) continue;
        count += space->loops->count;
        for (int place = 0; place < space->count; place++) count += space->bodies[place].hard;
    }
    return count;
}

/* Lists the rows that are not eliminated. What a row is nobody foresees, a processor neither: it is not asked. */
static void list_remaining(const pinch_problem *problem, pinch_mobility *mobility)
{
    int count = 0;
    for (int k = 0; k < problem->row_count; k++) {
        mobility->remaining[count] = k;
        count += !mobility->eliminated[k];
    }
    mobility->remaining_count = count;
    mobility->eliminated_count = problem->row_count - count;
}

/* Has every hard row eliminated that is not for more than two bodies, and returns how many are. */
static int eliminate_hard_rows(const pinch_problem *problem, bool *eliminated)
{
    int couplings = 0, count = problem->row_count;
    const pinch_joint_row *row = problem->rows;
    for (int k = 0; k < count; k++) {
        bool goes_on = k + 1 < count && row[k + 1].continues;
        bool hard = !row[k].continues & (row[k].cfm == 0) & (row[k].low == -INFINITY) & (row[k].high == INFINITY);
        eliminated[k] = hard & !goes_on;
        couplings += hard & goes_on;
    }
    return couplings;
}

/* Does a hard row act on a massless drive? */
static bool holds_massless(const pinch_problem *problem, const bool *eliminated)
{
    if (!any_massless(problem)) return false;
    for (int k = 0; k < problem->row_count; k++)
        if ((eliminated[k] || pinch_row_is_coupling(problem, k)) && ties_massless(problem, &problem->rows[k]))
            return true;
    return false;
}

bool pinch_mobility_build(pinch_arena *arena, const pinch_problem *problem, pinch_elimination elimination,
                          pinch_mobility *mobility)
{
    memset(mobility, 0, sizeof *mobility);
    mobility->eliminated = PINCH_ARENA_ARRAY(arena, bool, problem->row_count + 1);
    mobility->remaining = PINCH_ARENA_ARRAY(arena, int, problem->row_count + 1);
    mobility->roots = PINCH_ARENA_ARRAY(arena, pinch_root_inverse, problem->body_count + 1);
    if (arena->failed) return false;
    int couplings = eliminate_hard_rows(problem, mobility->eliminated);
    if (holds_massless(problem, mobility->eliminated)) return false;
    list_remaining(problem, mobility);
    if (!build_structure(arena, problem, elimination, mobility)) return false;
    bool rates_do = !pinch_mobility_has_loops(mobility) || pinch_loops_are_held_once(arena, problem, mobility);
    if (arena->failed) return false;
    /* kept rows make a system of forces, which has the identity for the inertia */
    if ((!rates_do || mobility->kept_count > 0) && !build_without_rates(arena, problem, elimination, mobility))
        return false;
    if (mobility->kept_count > 0) list_remaining(problem, mobility);
    mobility->dependent_count += count_dependent(mobility);
    if (couplings > 0 && !pinch_couplings_follow_rates(arena, problem, mobility)) {
        if (arena->failed) return false;
        mobility->kept_count += couplings;
        mobility->dependent_count += couplings;
    }
    refresh(problem, mobility);
    return true;
}

/* v = v0 + U q of a free body, whose U is a multiple of the identity beside an upper triangle. Sums begin with zero, so
 * that none is a negative zero. */
static void free_velocity(const pinch_cluster *cluster, const double *q, double v[6])
{
    const double linear = cluster->basis[PINCH_FREE_LINEAR], *t = cluster->basis + PINCH_FREE_T, *v0 = cluster->v0;
    for (int i = 0; i < 3; i++) v[i] = v0[i] + (0 + linear * q[i]);
    v[3] = v0[3] + (0 + t[0] * q[3] + t[1] * q[4] + t[2] * q[5]);
    v[4] = v0[4] + (0 + t[3] * q[4] + t[4] * q[5]);
    v[5] = v0[5] + (0 + t[5] * q[5]);
}

void pinch_mobility_velocity(const pinch_mobility *mobility, int body, const double *x, double v[6])
{
    const pinch_cluster *cluster = &mobility->clusters[mobility->cluster_of[body]];
    if (cluster->free) {
        free_velocity(cluster, x + cluster->first, v);
        return;
    }
    int slot = mobility->slot_of[body], m = cluster->freedoms;
    double expanded[36];
    if (cluster->space) {
        memcpy(v, cluster->v0 + 6 * slot, 6 * sizeof *v);
        pinch_joint_space_add_velocity(cluster->space, slot, x + cluster->first, v);
        return;
    }
    const double *basis = pinch_cluster_basis(cluster, slot, expanded), *q = x + cluster->first;
    int first = pinch_cluster_first_direction(cluster, slot);
    for (int i = 0; i < 6; i++)
        v[i] = cluster->v0[6 * slot + i] + pinch_dot(basis + (size_t)i * (size_t)m + first, q + first, m - first);
}

void pinch_mobility_joint_forces(const pinch_mobility *mobility, pinch_problem *problem, const double *wrench)
{
    for (int index = 0; index < mobility->cluster_count; index++) {
        const pinch_cluster *cluster = &mobility->clusters[index];
        const pinch_constraint_factor *c = cluster->factor;
        if (cluster->space) pinch_joint_space_forces(cluster->space, problem, wrench, cluster->scratch);
        if (cluster->tree) pinch_joint_tree_forces(cluster->tree, problem, cluster->bodies, wrench, cluster->scratch);
        if (!c) continue;
        double *x = cluster->scratch;
        for (int slot = 0; slot < cluster->body_count; slot++)
            pinch_root_apply_transposed(&c->roots[slot], wrench + 6 * cluster->bodies[slot], x + 6 * slot);
        pinch_constraint_apply_q_transposed(c, x);
        for (int k = 0; k < c->rank; k++) x[k] = c->y[k] / problem->step - x[k];
        pinch_constraint_solve(c, x);
        for (int k = 0; k < c->count; k++) problem->rows[c->row[k]].force = problem->rows[c->row[k]].pivot = 0;
        for (int k = 0; k < c->rank; k++) {
            pinch_joint_row *row = &problem->rows[c->row[c->order[k]]];
            row->force = x[k] / c->length[c->order[k]];
            row->pivot = fabs(c->diagonal[k]);
        }
    }
}
