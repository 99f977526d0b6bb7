#include "support/driven_island.h"

#include "support/draw.h"

#include <math.h>
#include <string.h>

enum { JOINTS = 5 };

static pinch_joint_row *new_row(pinch_problem *p, const int body[2])
{
    pinch_joint_row *row = &p->rows[p->row_count++];
    memset(row, 0, sizeof *row);
    row->body1 = body[0];
    row->body2 = body[1];
    row->low = -INFINITY;
    row->high = INFINITY;
    return row;
}

static pinch_joint_row *angular(pinch_problem *p, const int body[2], const double axis[3], double rhs)
{
    pinch_joint_row *row = new_row(p, body);
    for (int i = 0; i < 3; i++) {
        row->j1[3 + i] = axis[i];
        row->j2[3 + i] = body[1] < 0 ? 0 : -axis[i];
    }
    row->rhs = rhs;
    return row;
}

/* The two bodies have their points a little apart, as joints that have drifted have. */
static pinch_joint_row *linear(pinch_problem *p, const int body[2], const double axis[3], double point[2][3])
{
    pinch_joint_row *row = new_row(p, body);
    double *const j[2] = {row->j1, row->j2};
    for (int side = 0; side < 2; side++) {
        double arm[3], along[3];
        if (body[side] < 0) continue;
        for (int i = 0; i < 3; i++) {
            arm[i] = point[side][i] - p->bodies[body[side]].position[i];
            j[side][i] = along[i] = side ? -axis[i] : axis[i];
        }
        cross(arm, along, j[side] + 3);
    }
    return row;
}

/* Adds up to three rows along the freedom that `first` is the Jacobian of: servo, dry friction, damper. */
static void drive(pinch_random *random, pinch_problem *p, const pinch_joint_row *first)
{
    const pinch_joint_row pattern = *first;
    for (int kind = 0; kind < 3; kind++) {
        if (kind > 0 && !draw_chance(random, 0.6)) continue;
        pinch_joint_row *row = kind == 0 ? &p->rows[p->row_count - 1] : &p->rows[p->row_count++];
        *row = pattern;
        double bound = draw_log_uniform(random, 0.01, 10), sign = kind == 2 && draw_chance(random, 0.5) ? -2 : 1;
        if (kind < 2) row->low = -bound;
        if (kind < 2) row->high = bound;
        row->cfm = kind == 1 ? 0 : draw_log_uniform(random, 0.1, 100);
        row->rhs = kind == 1 ? 0 : draw_uniform(random, -1, 1);
        for (int i = 0; i < 6; i++) { /* a damper may act by a gear */
            row->j1[i] *= sign;
            row->j2[i] *= sign;
        }
    }
}

/* Joins a body to its parent by a hinge, a slider, a ball joint or a fixed one, and drives what is left free. */
static void join(pinch_random *random, pinch_problem *p, int child, int parent)
{
    static const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    bool turned = parent >= 0 && draw_chance(random, 0.5);
    const int body[2] = {turned ? parent : child, turned ? child : parent};
    double frame[9], point[2][3];
    int type = draw_index(random, 4);
    draw_frame(random, frame);
    for (int i = 0; i < 3; i++) {
        point[0][i] = p->bodies[child].position[i] + draw_uniform(random, -1, 1) * p->bodies[child].radius;
        point[1][i] = point[0][i] + draw_uniform(random, -1e-4, 1e-4);
    }
    if (type != 1) {
        for (int k = 0; k < 3; k++) linear(p, body, axes[k], point)->rhs = draw_uniform(random, -0.1, 0.1);
        for (int k = 0; k < 3; k++) {
            bool free = type == 2 || (type == 0 && k == 2);
            const pinch_joint_row *row = angular(p, body, frame + 3 * k, draw_uniform(random, -0.1, 0.1));
            if (free) drive(random, p, row);
        }
        return;
    }
    for (int k = 0; k < 3; k++) (void)angular(p, body, axes[k], draw_uniform(random, -0.1, 0.1));
    for (int k = 0; k < 3; k++) {
        pinch_joint_row *row = linear(p, body, frame + 3 * k, point);
        if (k == 2) drive(random, p, row);
    }
}

/* Bodies of random size with contacts; the first ones make trees that hang from the world or from a free body. */
void driven_island_make(island *made, uint64_t seed)
{
    pinch_random random;
    pinch_random_seed(&random, seed);
    island_make(made, ISLAND_MIXED, seed);
    pinch_problem *p = &made->problem;
    for (int b = 0; b < p->body_count && b < JOINTS; b++) {
        bool held = b > 0 || draw_chance(&random, 0.7);
        if (!held || p->row_count + 12 > ISLAND_ROWS) continue;
        int parent = b == 0 || draw_chance(&random, 0.2) ? -1 : draw_index(&random, b);
        join(&random, p, b, parent);
    }
    for (int k = 0; k < p->contact_count; k++)
        if (p->contacts[k].stiffness[0] > 1e4) p->contacts[k].stiffness[0] = 1e4;
}

/* Counts the rows of a joint that stop all turning between two bodies, and adds what they ask for: the velocity at
 * which the second of `body` turns away from the first. */
static int stops_turning(const pinch_problem *p, const int body[2], double turn[3])
{
    int rows = 0;
    for (int k = 0; k < p->row_count; k++) {
        const pinch_joint_row *row = &p->rows[k];
        bool same = row->body1 == body[0] && row->body2 == body[1];
        bool turned = row->body1 == body[1] && row->body2 == body[0];
        bool angular_alone = row->j1[0] == 0 && row->j1[1] == 0 && row->j1[2] == 0;
        if ((!same && !turned) || !angular_alone || row->cfm > 0 || row->low > -INFINITY) continue;
        rows++;
        for (int i = 0; i < 3; i++) turn[i] += (turned ? -1 : 1) * row->rhs * row->j1[3 + i];
    }
    return rows;
}

/* Adds a row between a body and the one that its parent hangs from, where the joints of both let them not turn. */
static bool repeat_joints(pinch_random *random, pinch_problem *p, const int parent[])
{
    for (int child = 0; child < JOINTS && child < p->body_count; child++) {
        int above = parent[child];
        double turn[3] = {0}, axis[3];
        if (above < 0 || parent[above] < -1) continue;
        const int lower[2] = {child, above}, upper[2] = {above, parent[above]}, ends[2] = {child, parent[above]};
        if (stops_turning(p, lower, turn) != 3 || stops_turning(p, upper, turn) != 3) continue;
        draw_direction(random, axis);
        angular(p, ends, axis, dot(axis, turn));
        return true;
    }
    return false;
}

/* Notes for each body which one its joint ties it to: -1 the world, -2: it has none. */
static void find_parents(const pinch_problem *p, int parent[])
{
    for (int b = 0; b < p->body_count; b++) parent[b] = -2;
    for (int k = p->row_count - 1; k >= 0; k--) {
        int lower = p->rows[k].body1 < p->rows[k].body2 ? p->rows[k].body1 : p->rows[k].body2;
        parent[p->rows[k].body1 + p->rows[k].body2 - lower] = lower; /* parents come first */
    }
}

int driven_island_close(island *made, uint64_t seed)
{
    pinch_random random;
    pinch_random_seed(&random, seed + 1000);
    pinch_problem *p = &made->problem;
    int parent[ISLAND_BODIES], dependent = 0, trees = p->row_count, first = p->row_count;
    find_parents(p, parent);
    bool rough = draw_chance(&random, 0.2);
    for (int k = 0; k < trees && !rough; k++)
        if (p->rows[k].cfm == 0 && p->rows[k].low > -INFINITY) p->rows[k].cfm = 0.1;
    for (int loop = 0; loop < 2 && p->row_count + 3 <= ISLAND_ROWS; loop++) {
        double axis[3], point[2][3];
        int body[2] = {draw_index(&random, JOINTS), draw_index(&random, JOINTS + 1) - 1};
        if (body[0] == body[1] || body[0] >= p->body_count || body[1] >= p->body_count) continue;
        if (parent[body[0]] == body[1] || (body[1] >= 0 && parent[body[1]] == body[0])) continue;
        draw_direction(&random, axis);
        for (int i = 0; i < 3; i++)
            point[0][i] = point[1][i] = p->bodies[body[0]].position[i] + draw_uniform(&random, -0.02, 0.02);
        linear(p, body, axis, point)->rhs = draw_uniform(&random, -0.1, 0.1);
    }
    int said = p->row_count;
    for (int k = first; k < said && p->row_count < ISLAND_ROWS; k++) {
        if (!draw_chance(&random, 0.5)) continue;
        p->rows[p->row_count++] = p->rows[k];
        dependent++;
    }
    if (p->row_count < ISLAND_ROWS && draw_chance(&random, 0.8)) dependent += repeat_joints(&random, p, parent);
    bool yields = draw_chance(&random, 0.7);
    for (int k = 0; k < p->row_count && yields; k++) p->rows[k].yield = draw_log_uniform(&random, 1e-10, 1e-9);
    return dependent;
}

void driven_island_sliders(island *made, double push, const double friction[2], double coupling)
{
    static const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    pinch_problem *p = &made->problem;
    memset(made, 0, sizeof *made);
    *p = (pinch_problem){
        .step = 1e-3, .body_count = 2, .bodies = made->bodies, .contacts = made->contacts, .rows = made->rows};
    for (int b = 0; b < 2; b++) {
        made->bodies[b] = (pinch_body){.mass = 1, .position = {0, b, 0}, .radius = 0.1};
        for (int i = 0; i < 3; i++) made->bodies[b].inertia[4 * i] = 0.01;
        const int body[2] = {b, PINCH_STATIC_BODY};
        double point[2][3] = {{0, b, 0}, {0, b, 0}};
        for (int k = 0; k < 3; k++) (void)angular(p, body, axes[k], 0);
        for (int k = 1; k < 3; k++) (void)linear(p, body, axes[k], point);
    }
    made->bodies[0].external[0] = push;
    made->bodies[0].velocity[0] = p->step * push;
    for (int k = 0; k < 4; k++) {
        const int body[2] = {k % 2, PINCH_STATIC_BODY};
        double point[2][3] = {{0, k % 2, 0}, {0, k % 2, 0}};
        pinch_joint_row *row = linear(p, body, axes[0], point);
        row->continues = k == 3;
        row->force = k < 2 ? friction[k] : coupling;
        if (k < 2) row->low = -0.5;
        if (k < 2) row->high = 0.5;
        if (k == 3) row->j1[0] = -1;
    }
}

/* The i-th of the numbers 0 to 3 in an order from 0 to 23. */
static int in_order(int order, int i)
{
    int left[4] = {0, 1, 2, 3}, count = 4, at = 0;
    for (int k = 0; k <= i; k++, count--) {
        int picked = order % count;
        order /= count;
        at = left[picked];
        for (int j = picked; j + 1 < count; j++) left[j] = left[j + 1];
    }
    return at;
}

void driven_island_four_bar(island *made, int order, bool ball)
{
    enum { CRANK, OTHER_CRANK, COUPLER };
    static const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const int bodies[4][2] = {{CRANK, -1}, {OTHER_CRANK, -1}, {COUPLER, CRANK}, {COUPLER, OTHER_CRANK}};
    static const double points[4][3] = {{0, 0, 0}, {0.1, 0, 0}, {0.03, 0, -0.1}, {0.13, 0, -0.1}};
    pinch_problem *p = &made->problem;
    memset(made, 0, sizeof *made);
    *p = (pinch_problem){
        .step = 1e-3, .body_count = 3, .bodies = made->bodies, .contacts = made->contacts, .rows = made->rows};
    for (int b = 0; b < 3; b++) {
        made->bodies[b] =
            (pinch_body){.mass = 0.1 + 0.1 * b, .radius = 0.1, .external = {1, 0.3, -2, 0.01, 0.02, 0.03}};
        made->bodies[b].position[0] = b == COUPLER ? 0.08 : 0.015 + 0.1 * b;
        made->bodies[b].position[2] = b == COUPLER ? -0.12 : -0.05;
        for (int i = 0; i < 3; i++) made->bodies[b].inertia[4 * i] = 1e-4 * (i + 1);
        for (int i = 0; i < 3; i++) {
            made->bodies[b].velocity[i] = p->step * made->bodies[b].external[i] / made->bodies[b].mass;
            made->bodies[b].velocity[3 + i] =
                p->step * made->bodies[b].external[3 + i] / made->bodies[b].inertia[4 * i];
        }
    }
    for (int i = 0; i < 4; i++) {
        int joint = in_order(order, i);
        double point[2][3];
        memcpy(point[0], points[joint], sizeof point[0]);
        memcpy(point[1], points[joint], sizeof point[1]);
        for (int k = 0; k < 3; k++) linear(p, bodies[joint], axes[k], point)->yield = 1e-9;
        for (int k = 0; k < 3 && !(ball && joint == 3); k += 2) angular(p, bodies[joint], axes[k], 0)->yield = 1e-9;
    }
    for (int joint = 0; joint < (ball ? 3 : 4); joint++) angular(p, bodies[joint], axes[1], 0.2)->cfm = 10;
}
