/* The rows of a space's bodies: which are along their joints, how they make a body move, and what they bear. */
#include "kinematics/joint_space.h"

#include "support/dense.h"
#include "support/extremes.h"
#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* What is left of a body's rows beside each other has to be this part of their lengths. Below, errors grow too much on
 * the way from body to body. */
static const double SMALLEST_PIVOT = 1e-3;

bool pinch_loose_rows_list(pinch_arena *arena, const pinch_problem *problem, pinch_tree_rows rows,
                           pinch_loose_rows *loose)
{
    loose->first = PINCH_ARENA_ARRAY(arena, int, problem->body_count + 1);
    for (int side = 0; side < 2; side++) loose->next[side] = PINCH_ARENA_ARRAY(arena, int, problem->row_count + 1);
    loose->rate = PINCH_ARENA_ARRAY(arena, pinch_joint_rate, problem->row_count + 1);
    if (arena->failed) return false;
    for (int b = 0; b < problem->body_count; b++) loose->first[b] = -1;
    for (int i = rows.count - 1; i >= 0; i--) {
        int k = rows.index[i];
        const int body[2] = {problem->rows[k].body1, problem->rows[k].body2};
        loose->rate[k] = (pinch_joint_rate){-1, 0};
        for (int side = 0; side < 2; side++) {
            if (body[side] < 0) continue;
            loose->next[side][k] = loose->first[body[side]];
            loose->first[body[side]] = k;
        }
    }
    return true;
}

static int other_body(const pinch_joint_row *row, int body)
{
    int other = row->body1 == body ? row->body2 : row->body1;
    return other < 0 ? -1 : other;
}

static inline bool are_equal(pinch_row_ends a, pinch_row_ends b)
{
    pinch_lanes_mask differ = {0, 0};
    for (int i = 0; i < 6; i += 2)
        differ |= (pinch_lanes_at(a.own + i) != pinch_lanes_at(b.own + i)) |
                  (pinch_lanes_at(a.parent + i) != pinch_lanes_at(b.parent + i));
    return (differ[0] | differ[1]) == 0;
}

/* Finds the f with which a is f b but for rounding. */
static bool is_multiple(pinch_row_ends a, pinch_row_ends b, double *f)
{
    static const double ROUNDING = 4e-16;
    double size = 0, largest = 0, miss = 0;
    *f = 1;
    if (are_equal(a, b)) return true;
    *f = 0;
    for (int i = 0; i < 6; i++) {
        size += b.own[i] * b.own[i] + b.parent[i] * b.parent[i];
        *f += a.own[i] * b.own[i] + a.parent[i] * b.parent[i];
    }
    if (!(size > 0) || *f == 0) return false;
    *f /= size;
    for (int i = 0; i < 6; i++) {
        largest = pinch_larger(pinch_larger(fabs(a.own[i]), fabs(a.parent[i])), largest);
        miss = pinch_larger(pinch_larger(fabs(a.own[i] - *f * b.own[i]), fabs(a.parent[i] - *f * b.parent[i])), miss);
    }
    return miss <= ROUNDING * largest;
}

bool pinch_space_body_coordinates(const pinch_problem *problem, const pinch_space_body *bodies, pinch_loose_rows *loose,
                                  pinch_space_body *b)
{
    int count = b->hard, parent = b->parent < 0 ? -1 : bodies[b->parent].body;
    if (count == 0 && parent < 0) { /* nothing holds it */
        for (int k = 0; k < 6; k++) b->row[k] = -1;
        return true;
    }
    for (int k = loose->first[b->body]; k >= 0; k = loose->next[problem->rows[k].body1 == b->body ? 0 : 1][k]) {
        const pinch_joint_row *row = &problem->rows[k];
        if (row->body1 == row->body2 || other_body(row, b->body) != parent) continue;
        int same = b->hard;
        double factor = 1;
        const pinch_row_ends parts = pinch_row_ends_of(row, b->body);
        while (same < count && !is_multiple(parts, pinch_row_ends_of(&problem->rows[b->row[same]], b->body), &factor))
            same++;
        if (same == count) {
            if (count == 6) continue;
            b->row[count++] = k;
            factor = 1;
        }
        loose->rate[k] = (pinch_joint_rate){b->first_direction + same - b->hard, factor};
    }
    return count == 6;
}

/* Inverts the matrix with the rows a, b and c: its columns go into `columns`. Returns what is left of the rows beside
 * each other, as a part of their lengths. */
static double invert3(const double *a, const double *b, const double *c, double columns[3][3])
{
    double size = sqrt(pinch_v3_dot(a, a) * pinch_v3_dot(b, b) * pinch_v3_dot(c, c));
    pinch_v3_cross(b, c, columns[0]);
    pinch_v3_cross(c, a, columns[1]);
    pinch_v3_cross(a, b, columns[2]);
    double determinant = pinch_v3_dot(a, columns[0]), over = 1 / determinant;
    for (int k = 0; k < 3; k++) pinch_v3_scale(columns[k], over);
    return fabs(determinant) / size;
}

/* The six rows of a body, three of which turn it alone. */
typedef struct split_rows {
    int moving[3], turning[3]; /* among the six */
    pinch_row_ends part[6];
} split_rows;

static bool only_turns(const pinch_row_ends *part)
{
    return part->own[0] == 0 && part->own[1] == 0 && part->own[2] == 0 && part->parent[0] == 0 &&
           part->parent[1] == 0 && part->parent[2] == 0;
}

static bool split(const pinch_problem *problem, const pinch_space_body *b, split_rows *s)
{
    int moving = 0, turning = 0;
    for (int k = 0; k < 6; k++) {
        s->part[k] = pinch_row_ends_of(&problem->rows[b->row[k]], b->body);
        if (only_turns(&s->part[k])) {
            if (turning == 3) return false;
            s->turning[turning++] = k;
        } else {
            if (moving == 3) return false;
            s->moving[moving++] = k;
        }
    }
    return true;
}

/* v = -(sum of the columns, each times the product of its row with what is given), the rows being those that move. */
static void undo_ways(const split_rows *s, const double ways[3][3], const double *v, const double *w, double *to)
{
    to[0] = to[1] = to[2] = 0;
    for (int k = 0; k < 3; k++) {
        const pinch_row_ends *part = &s->part[s->moving[k]];
        double rate = pinch_v3_dot(part->own + 3, w);
        if (v) rate += pinch_v3_dot(part->parent, v) + pinch_v3_dot(part->parent + 3, v + 3);
        pinch_v3_add_scaled(to, -rate, ways[k]);
    }
}

/*
 * Tells whether the joint holds a point of both bodies, by rows along the world's axes, and turns them against each
 * other. The body then turns with its parent, and moves with it as the point does; `lever` is what a turn adds to its
 * way.
 */
static bool is_pinned(const split_rows *s, double lever[3][3])
{
    double off = 0;
    for (int k = 0; k < 3 && off == 0; k++) {
        const pinch_row_ends *moves = &s->part[s->moving[k]], *turns = &s->part[s->turning[k]];
        for (int i = 0; i < 3; i++) {
            double unit = i == k;
            off += fabs(moves->own[i] - unit) + fabs(moves->parent[i] + unit) +
                   fabs(turns->own[3 + i] + turns->parent[3 + i]);
            lever[i][k] = -(moves->own[3 + i] + moves->parent[3 + i]);
        }
    }
    return off == 0;
}

/* The same as pinch_space_body_solve of a pinned joint, whose turning rows have the inverse `turns`. */
static void pin(const split_rows *s, double turns[3][3], pinch_space_body *b)
{
    for (int k = 0; k < 3; k++) {
        int moving = s->moving[k], turning = s->turning[k];
        for (int i = 0; i < 6; i++) b->unit[moving][i] = i == k;
        pinch_v3_copy(b->unit[turning] + 3, turns[k]);
        for (int i = 0; i < 3; i++) b->unit[turning][i] = -pinch_v3_dot(s->part[s->moving[i]].own + 3, turns[k]);
    }
}

bool pinch_space_body_solve(const pinch_problem *problem, pinch_space_body *b)
{
    split_rows s;
    double ways[3][3], turns[3][3];
    b->pinned = false;
    if (b->row[5] < 0) {
        memset(b->unit, 0, sizeof b->unit);
        for (int k = 0; k < 6; k++) b->unit[k][k] = b->pivot[k] = 1;
        return true;
    }
    if (!split(problem, b, &s)) return false;
    const int *m = s.moving, *t = s.turning;
    double left[2] = {1, invert3(s.part[t[0]].own + 3, s.part[t[1]].own + 3, s.part[t[2]].own + 3, turns)};
    b->pinned = is_pinned(&s, b->lever);
    if (!b->pinned) left[0] = invert3(s.part[m[0]].own, s.part[m[1]].own, s.part[m[2]].own, ways);
    if (!(left[0] > SMALLEST_PIVOT) || !(left[1] > SMALLEST_PIVOT)) return false;
    for (int k = 0; k < 3; k++) {
        b->pivot[m[k]] = left[0];
        b->pivot[t[k]] = left[1];
    }
    if (b->pinned) {
        pin(&s, turns, b);
        return true;
    }
    for (int k = 0; k < 3; k++) {
        pinch_v3_copy(b->unit[m[k]], ways[k]);
        pinch_v3_set(b->unit[m[k]] + 3, 0, 0, 0);
        pinch_v3_copy(b->unit[t[k]] + 3, turns[k]);
        undo_ways(&s, ways, NULL, turns[k], b->unit[t[k]]);
    }
    for (int i = 0; i < 6 && b->parent >= 0; i++) {
        double parent[6] = {0}, *to = b->carried[i];
        parent[i] = 1;
        to[3] = to[4] = to[5] = 0;
        for (int k = 0; k < 3 && i >= 3; k++) pinch_v3_add_scaled(to + 3, -s.part[t[k]].parent[i], turns[k]);
        undo_ways(&s, ways, parent, to + 3, to);
    }
    return true;
}

void pinch_space_bear(const pinch_joint_space *space, const pinch_problem *problem, double *x, double *force)
{
    for (int place = space->count - 1; place >= 0; place--) {
        const pinch_space_body *b = &space->bodies[place];
        for (int k = 0; k < b->hard; k++) {
            double borne = force[6 * place + k] = pinch_dot6(b->unit[k], x + 6 * place);
            if (b->parent >= 0)
                pinch_add_multiple6(-borne, pinch_row_ends_of(&problem->rows[b->row[k]], b->body).parent,
                                    x + 6 * b->parent);
        }
    }
}

void pinch_space_forget_rates(const pinch_problem *problem, const pinch_joint_space *space, pinch_loose_rows *loose)
{
    for (int place = 0; place < space->count; place++) {
        int body = space->bodies[place].body;
        for (int k = loose->first[body]; k >= 0; k = loose->next[problem->rows[k].body1 == body ? 0 : 1][k])
            loose->rate[k].direction = -1;
    }
}

void pinch_space_forget_mixed_rates(const pinch_problem *problem, const pinch_joint_space *space,
                                    pinch_loose_rows *loose)
{
    for (int place = 0; place < space->count; place++) {
        int body = space->bodies[place].body;
        for (int k = loose->first[body]; k >= 0; k = loose->next[problem->rows[k].body1 == body ? 0 : 1][k])
            if (loose->rate[k].direction >= 0 && space->unknown[loose->rate[k].direction] < 0)
                loose->rate[k].direction = -1;
    }
}
