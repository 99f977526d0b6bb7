#include "kinematics/reduced_rows.h"

#include "kinematics/joint_space.h"
#include "law/contact_law.h"
#include "support/dense.h"
#include "support/vec3.h"

#include <math.h>
#include <string.h>

void pinch_contact_jacobian(const pinch_contact *contact, const pinch_body *body, int rows, double *jacobian)
{
    double t2[3], arm[3];
    const double *axes[3] = {contact->normal, contact->tangent1, t2};
    for (int i = 0; i < 3; i++) arm[i] = contact->position[i] - body->position[i];
    if (rows > 2) pinch_v3_cross(contact->normal, contact->tangent1, t2);
    for (int row = 0; row < rows && row < 3; row++) {
        memcpy(jacobian + 6 * row, axes[row], 3 * sizeof(double));
        pinch_v3_cross(arm, axes[row], jacobian + 6 * row + 3);
    }
    for (int row = 3; row < rows; row++) {
        memset(jacobian + 6 * row, 0, 3 * sizeof(double));
        memcpy(jacobian + 6 * row + 3, axes[row - 3], 3 * sizeof(double));
    }
}

/* A couple about `lever` acts on a free body: its columns of g, and what v0 adds to w0. */
static double couple(const pinch_cluster *cluster, const double *lever, double *g)
{
    const double *t = cluster->basis + PINCH_FREE_T, *v0 = cluster->v0;
    g[3] = lever[0] * t[0];
    g[4] = lever[0] * t[1] + lever[1] * t[3];
    g[5] = lever[0] * t[2] + lever[1] * t[4] + lever[2] * t[5];
    return lever[0] * v0[3] + lever[1] * v0[4] + lever[2] * v0[5];
}

/*
 * jacobian (rows x 6) times U of a free body into g, and times v0 added to w0: U is a multiple of the identity beside
 * an upper triangle (mobility.h), and nine products a row do what thirty-six would.
 */
static void reduce_free(const pinch_cluster *cluster, int rows, const double *jacobian, double sign, double *g,
                        double *w0)
{
    const double *v0 = cluster->v0, linear = sign * cluster->basis[PINCH_FREE_LINEAR];
    for (int row = 0; row < rows; row++, g += 6) {
        const double *j = jacobian + 6 * row, lever[3] = {sign * j[3], sign * j[4], sign * j[5]};
        for (int i = 0; i < 3; i++) g[i] = linear * j[i];
        w0[row] += sign * (j[0] * v0[0] + j[1] * v0[1] + j[2] * v0[2]) + couple(cluster, lever, g);
    }
}

/* Adds `sign` times jacobian (rows x 6, of one body) times the body's part of U to g (rows x size), and times v0 to w0.
 */
static void reduce(const pinch_mobility *mobility, int body, int rows, const double *jacobian, double sign, double *g,
                   double *w0)
{
    const pinch_cluster *cluster = &mobility->clusters[mobility->cluster_of[body]];
    int slot = mobility->slot_of[body], m = cluster->freedoms;
    double expanded[36];
    const double *v0 = cluster->v0 + 6 * slot;
    if (cluster->space) {
        for (int row = 0; row < rows; row++) w0[row] += sign * pinch_dot6(jacobian + 6 * row, v0);
        pinch_joint_space_reduce(cluster->space, slot, rows, jacobian, sign, g);
        return;
    }
    int first = pinch_cluster_first_direction(cluster, slot);
    const double *basis = pinch_cluster_basis(cluster, slot, expanded);
    for (int row = 0; row < rows; row++) {
        const double *j = jacobian + 6 * row;
        for (int k = 0; k < 6; k++) {
            double value = sign * j[k];
            w0[row] += value * v0[k];
            if (value != 0) pinch_add_multiple(m - first, value, basis + k * m + first, g + row * m + first);
        }
    }
}

/* Rows as jacobians of two bodies. */
typedef struct body_rows {
    int rows;
    int body[2];               /* negative: none */
    const double *jacobian[2]; /* rows x 6 each */
    double sign[2];
} body_rows;

static bool reduce_rows(pinch_arena *arena, const pinch_mobility *mobility, const body_rows *given,
                        pinch_row_block block[2], int cluster[2], double *w0)
{
    int rows = given->rows;
    const int *body = given->body;
    const double *sign = given->sign, *const *jacobian = given->jacobian;
    int used = 0;
    double *g[2] = {NULL, NULL};
    memset(block, 0, 2 * sizeof *block);
    cluster[0] = cluster[1] = -1;
    for (int side = 0; side < 2; side++) {
        if (body[side] < 0) continue;
        int index = mobility->cluster_of[body[side]], to = used > 0 && cluster[0] == index ? 0 : used;
        if (to == used) {
            const pinch_cluster *of = &mobility->clusters[index];
            size_t entries = (size_t)rows * (size_t)of->freedoms;
            g[to] = PINCH_ARENA_ARRAY(arena, double, entries + 1);
            if (arena->failed) return false;
            cluster[to] = index;
            block[to].first = of->first;
            block[to].size = of->freedoms;
            block[to].g = g[to];
            used++;
            if (of->free) {
                reduce_free(of, rows, jacobian[side], sign[side], g[to], w0);
                continue;
            }
            memset(g[to], 0, entries * sizeof(double));
        }
        reduce(mobility, body[side], rows, jacobian[side], sign[side], g[to], w0);
    }
    return true;
}

/* A unit force along `axis` at `arm` acts on a free body: its row of g, and what v0 adds to w0. */
static void push(const pinch_cluster *cluster, const double *arm, const double *axis, double *g, double *w0)
{
    const double *v0 = cluster->v0, linear = cluster->basis[PINCH_FREE_LINEAR];
    double lever[3];
    pinch_v3_cross(arm, axis, lever);
    for (int i = 0; i < 3; i++) g[i] = linear * axis[i];
    *w0 += (axis[0] * v0[0] + axis[1] * v0[1] + axis[2] * v0[2]) + couple(cluster, lever, g);
}

/*
 * A contact's rows for a free body: axes a of the contact frame act on it by (a, arm x a), spins by (0, a), and U is a
 * multiple of the identity beside an upper triangle (mobility.h).
 */
static void free_rows(const pinch_cluster *cluster, const pinch_contact *contact, const pinch_body *body, int rows,
                      double sign, double *restrict g, double *restrict w0)
{
    double arm[3], axes[3][3];
    for (int i = 0; i < 3; i++) {
        arm[i] = contact->position[i] - body->position[i];
        axes[0][i] = sign * contact->normal[i];
        axes[1][i] = sign * contact->tangent1[i];
    }
    push(cluster, arm, axes[0], g, w0);
    if (rows == 1) return;
    pinch_v3_cross(contact->normal, axes[1], axes[2]);
    push(cluster, arm, axes[1], g + 6, w0 + 1);
    push(cluster, arm, axes[2], g + 12, w0 + 2);
    for (int row = 3; row < rows; row++) {
        g[6 * row] = g[6 * row + 1] = g[6 * row + 2] = 0;
        w0[row] += couple(cluster, axes[row - 3], g + 6 * row);
    }
}

/* A contact's rows for a massless drive, which moves along one axis and does not turn. */
static void drive_rows(const pinch_cluster *cluster, const pinch_contact *contact, int rows, double sign, double *g)
{
    double t2[3];
    const double *axes[3] = {contact->normal, contact->tangent1, t2};
    pinch_v3_cross(contact->normal, contact->tangent1, t2);
    for (int row = 0; row < rows; row++) g[row] = row < 3 ? sign * pinch_v3_dot(axes[row], cluster->basis) : 0;
}

/* Has the cluster one body without joints, free or a massless drive? */
static bool is_single(const pinch_cluster *cluster)
{
    return cluster->free || cluster->inertia == 0;
}

bool pinch_all_clusters_single(const pinch_mobility *mobility)
{
    for (int c = 0; c < mobility->cluster_count; c++)
        if (!is_single(&mobility->clusters[c])) return false;
    return true;
}

/* The blocks of both sides are aligned for lanes. */
static int block_room(const pinch_mobility *mobility, int body, int rows)
{
    return body < 0 ? 0 : (mobility->clusters[mobility->cluster_of[body]].freedoms * rows + 1) / 2 * 2;
}

int pinch_contact_rows_room(const pinch_mobility *mobility, const pinch_contact *contact)
{
    int rows = (int)contact->model;
    return block_room(mobility, contact->body1, rows) + block_room(mobility, contact->body2, rows);
}

void pinch_contact_rows_place(const pinch_mobility *mobility, const pinch_contact *contact, double *room,
                              pinch_row_block block[2], int cluster[2])
{
    int rows = (int)contact->model, used = 0;
    const int body[2] = {contact->body1, contact->body2};
    memset(block, 0, 2 * sizeof *block);
    cluster[0] = cluster[1] = -1;
    for (int side = 0; side < 2; side++) {
        if (body[side] < 0) continue;
        const pinch_cluster *of = &mobility->clusters[cluster[used] = mobility->cluster_of[body[side]]];
        block[used++] = (pinch_row_block){of->first, of->freedoms, room};
        room += block_room(mobility, body[side], rows);
    }
}

void pinch_contact_rows_fill(const pinch_mobility *mobility, const pinch_body *bodies, const pinch_contact *contact,
                             const pinch_row_block block[2], double *w0)
{
    int rows = (int)contact->model;
    const int body[2] = {contact->body1, contact->body2};
    for (int side = 0, used = 0; side < 2; side++) {
        if (body[side] < 0) continue;
        const pinch_cluster *of = &mobility->clusters[mobility->cluster_of[body[side]]];
        double *g = (double *)block[used++].g; /* it was placed to be filled */
        if (of->free)
            free_rows(of, contact, &bodies[body[side]], rows, side ? -1 : 1, g, w0);
        else
            drive_rows(of, contact, rows, side ? -1 : 1, g);
    }
}

bool pinch_contact_rows(pinch_arena *arena, const pinch_mobility *mobility, const pinch_body *bodies,
                        const pinch_contact *contact, pinch_row_block block[2], int cluster[2], double *w0)
{
    int rows = (int)contact->model;
    const int body[2] = {contact->body1, contact->body2};
    bool all_single = true;
    for (int side = 0; side < 2; side++)
        all_single = all_single && (body[side] < 0 || is_single(&mobility->clusters[mobility->cluster_of[body[side]]]));
    if (!all_single || body[0] == body[1]) {
        double jacobian[2][6 * PINCH_CONTACT_ROWS_MAX];
        const body_rows given = {rows, {body[0], body[1]}, {jacobian[0], jacobian[1]}, {1, -1}};
        for (int side = 0; side < 2; side++)
            if (body[side] >= 0) pinch_contact_jacobian(contact, &bodies[body[side]], rows, jacobian[side]);
        return reduce_rows(arena, mobility, &given, block, cluster, w0);
    }
    double *room = PINCH_ARENA_ARRAY(arena, double, pinch_contact_rows_room(mobility, contact));
    if (!room) return false;
    pinch_contact_rows_place(mobility, contact, room, block, cluster);
    pinch_contact_rows_fill(mobility, bodies, contact, block, w0);
    return true;
}

bool pinch_joint_row_reduce(pinch_arena *arena, const pinch_mobility *mobility, const pinch_joint_row *row,
                            pinch_row_block block[2], int cluster[2], double *w0)
{
    const body_rows given = {1, {row->body1, row->body2}, {row->j1, row->j2}, {1, 1}};
    return reduce_rows(arena, mobility, &given, block, cluster, w0);
}

int pinch_coupling_reduce(pinch_arena *arena, const pinch_mobility *mobility, const pinch_joint_row *row, int parts,
                          pinch_row_block *block, int *cluster, double *w0)
{
    int blocks = 0;
    for (int i = 0; i < 2 * parts; i++) {
        const pinch_joint_row *part = &row[i / 2];
        int body = i % 2 ? part->body2 : part->body1, to = 0;
        if (body < 0) continue;
        int index = mobility->cluster_of[body];
        const pinch_cluster *of = &mobility->clusters[index];
        while (to < blocks && cluster[to] != index) to++;
        if (to == blocks) {
            double *g = PINCH_ARENA_ARRAY(arena, double, of->freedoms + 1);
            if (!g) return -1;
            memset(g, 0, sizeof *g * (size_t)of->freedoms);
            cluster[to] = index;
            block[blocks++] = (pinch_row_block){of->first, of->freedoms, g};
        }
        reduce(mobility, body, 1, i % 2 ? part->j2 : part->j1, 1, (double *)block[to].g, w0);
    }
    return blocks;
}

bool pinch_unit_row_make(const pinch_joint_row *row, double step, double w0, pinch_row_block *block, int blocks,
                         pinch_unit_row *unit)
{
    double length2 = 0;
    for (int b = 0; b < blocks; b++) {
        const double *g = block[b].g;
        length2 += block[b].size == 6 ? pinch_dot6(g, g) : pinch_dot_strands(g, g, block[b].size);
    }
    double sigma = unit->sigma = sqrt(length2 + row->cfm / step);
    if (sigma == 0) return false;
    unit->compliance = row->cfm / (step * sigma * sigma);
    unit->target = (row->rhs - w0) / sigma;
    unit->low = step * sigma * row->low;
    unit->high = step * sigma * row->high;
    const double over = 1 / sigma;
    for (int b = 0; b < blocks; b++) { /* the arrays are this row's own */
        double *g = (double *)block[b].g;
        for (int k = 0; k < block[b].size; k++) g[k] *= over;
    }
    return true;
}
