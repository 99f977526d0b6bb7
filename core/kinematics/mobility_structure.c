/* How bodies fall into clusters, and which of their hard rows are eliminated, by which directions. */
#include "kinematics/mobility.h"

#include "kinematics/joint_tree.h"

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

bool pinch_mobility_find_structure(pinch_arena *arena, const pinch_problem *problem, pinch_elimination elimination,
                                   pinch_mobility *mobility)
{
    int *start = NULL, *rows = NULL; /* none where bodies are free */
    mobility->unknowns = 0;
    const pinch_tree_rows others = {mobility->remaining, mobility->remaining_count};
    if (elimination == PINCH_ELIMINATE_INTO_RATES && !pinch_loose_rows_list(arena, problem, others, &mobility->loose))
        return false;
    if (!group_bodies(arena, problem, mobility)) return false;
    if (problem->row_count > 0 && !group_rows(arena, problem, mobility, &start, &rows)) return false;
    for (int k = 0; k < mobility->cluster_count; k++) {
        pinch_cluster *cluster = &mobility->clusters[k];
        int row_count = start ? start[k + 1] - start[k] : 0;
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
