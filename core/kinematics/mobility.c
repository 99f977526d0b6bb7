#include "kinematics/mobility.h"

#include "kinematics/joint_tree.h"
#include "kinematics/space_loops.h"
#include "support/dense.h"

#include <math.h>
#include <string.h>

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
        if (!pinch_mobility_find_structure(arena, problem, elimination, mobility)) return false;
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
    if (!pinch_mobility_find_structure(arena, problem, elimination, mobility)) return false;
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
