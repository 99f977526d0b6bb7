/*
 * The law of a joint row: what it misses of what it asks for, rhs - j1 v1 - j2 v2 - cfm lambda, is zero while lambda
 * lies between its bounds. At the upper bound the row may be too slow (it would need more force), at the lower one too
 * fast. Two errors come of it, each in its own unit:
 *
 *     the velocity that is missed where the force is not at the bound that would excuse it, m/s or rad/s
 *     the part of the force that is beyond a bound, N or N m
 */
#include "verify/row_check.h"

#include "verify/check_arithmetic.h"

#include <float.h>
#include <math.h>

/* The largest error of a row, relative to the velocities in it, and of its force relative to the bound. */
static const double LAW_TOLERANCE = 1e-8;
/* m/s or rad/s: the least error that counts, of rows that depend on each other, which are solved to a tolerance, and of
 * others. */
static const double LEAST_DEPENDENT = 1e-9, LEAST_ERROR = 1e-12;
/* of what has been added up to a velocity, in the elimination of joints and in the sums of impulses */
static const double ROUNDINGS = 64;

static double along(const double *j, const double *v)
{
    double part[6];
    for (int i = 0; i < 6; i++) part[i] = j[i] * v[i];
    return (part[0] + part[2] + part[4]) + (part[1] + part[3] + part[5]);
}

/* Is there a row behind this one that continues it? */
static bool goes_on(const pinch_problem *problem, const pinch_joint_row *row)
{
    return row + 1 < problem->rows + problem->row_count && row[1].continues;
}

/* Returns j1 v1 + j2 v2 at the end of the step, summed up over the row and those that continue it. */
static double row_velocity(const pinch_problem *problem, const pinch_joint_row *row)
{
    double velocity = 0;
    if (row->body1 >= 0) velocity += along(row->j1, problem->bodies[row->body1].velocity_end);
    if (row->body2 >= 0) velocity += along(row->j2, problem->bodies[row->body2].velocity_end);
    while (goes_on(problem, row)) {
        row++;
        if (row->body1 >= 0) velocity += along(row->j1, problem->bodies[row->body1].velocity_end);
        if (row->body2 >= 0) velocity += along(row->j2, problem->bodies[row->body2].velocity_end);
    }
    return velocity;
}

/* Returns the rounding of a body's part of a row's velocity, from what its velocities have been summed up from. */
static double row_rounding(const pinch_body *body, const double *j, double motion)
{
    double turns[3];
    if (body->mass == 0) return 0;
    pinch_check_solve3(body->inertia, j + 3, turns);
    double moves = (j[0] * j[0] + j[1] * j[1] + j[2] * j[2]) / body->mass;
    for (int i = 0; i < 3; i++) moves += j[3 + i] * turns[i];
    return ROUNDINGS * DBL_EPSILON * sqrt(moves) * motion;
}

/* Returns the error that is allowed to a row, m/s or rad/s: a part of its terms, its rounding where `motion` tells it,
 * and of rows that depend on others a part of what the largest of its bodies' velocities could be along it. */
static double allowed_error(const pinch_problem *problem, const pinch_joint_row *row, const double *motion,
                            bool dependent)
{
    double size = fabs(row->rhs), rounding = 0, carried = 0;
    const pinch_joint_row *part = row;
    for (int side = 0; side < 2 || goes_on(problem, part); side++) {
        if (side == 2) {
            part++;
            side = 0;
        }
        const double *j = side ? part->j2 : part->j1;
        int body = side ? part->body2 : part->body1;
        if (body < 0) continue;
        const pinch_body *b = &problem->bodies[body];
        double length2 = 0, speed2 = 0;
        for (int i = 0; i < 6; i++) {
            size += fabs(j[i] * b->velocity_end[i]);
            length2 += j[i] * j[i];
            speed2 += b->velocity_end[i] * b->velocity_end[i];
        }
        carried = pinch_check_larger(sqrt(length2 * speed2), carried);
        if (motion) rounding += row_rounding(b, j, motion[body]);
    }
    return LAW_TOLERANCE * (size + fabs(row->cfm * row->force)) + rounding +
           (dependent ? LEAST_DEPENDENT + LAW_TOLERANCE * carried : LEAST_ERROR);
}

/* Returns by how much the force is beyond its bounds, N or N m. */
static double force_excess(const pinch_joint_row *row)
{
    double above = row->force - row->high, below = row->low - row->force;
    return pinch_check_larger(0, pinch_check_larger(above, below));
}

/* Is the force at the bound, to the rounding of what it was computed from? None is at a bound that is not there. */
static bool at_bound(double force, double bound)
{
    return isfinite(bound) && fabs(force - bound) <= LAW_TOLERANCE * fabs(bound);
}

/*
 * The velocity that the row lacks of what it asks for, m/s or rad/s. A hard row that depends on others may give way to
 * its own force, by its `yield` or the small compliance that stands for one; no other row may.
 */
static double missing_velocity(const pinch_problem *problem, const pinch_joint_row *row, bool dependent)
{
    double given_way = dependent ? row->violation : 0;
    return row->rhs - given_way - row_velocity(problem, row) - row->cfm * row->force;
}

/* The velocity by which the row misses its law: what is missing where no bound of its force excuses it. */
static double missed_velocity(const pinch_joint_row *row, double missing)
{
    if (missing > 0 && at_bound(row->force, row->high)) return 0;
    if (missing < 0 && at_bound(row->force, row->low)) return 0;
    return fabs(missing);
}

static bool was_dropped(const pinch_joint_row *row)
{
    return row->pivot == 0 && row->cfm == 0 && row->low == -INFINITY && row->high == INFINITY;
}

bool pinch_row_check(const pinch_problem *problem, const double *motion, pinch_step_result *result)
{
    bool dependent = result->dependent_rows > 0, all_hold = true;
    result->row_velocity = result->row_force = 0;
    for (int k = 0; k < problem->row_count; k++) {
        const pinch_joint_row *row = &problem->rows[k];
        if (row->continues || was_dropped(row)) continue;
        double missing = missing_velocity(problem, row, dependent);
        if (fabs(missing) <= LEAST_ERROR && row->force >= row->low && row->force <= row->high) { /* as most are */
            result->row_velocity = pinch_check_larger(fabs(missing), result->row_velocity);
            continue;
        }
        double missed = missed_velocity(row, missing), excess = force_excess(row);
        result->row_velocity = pinch_check_larger(missed, result->row_velocity);
        result->row_force = pinch_check_larger(excess, result->row_force);
        double bound = row->force > row->high ? row->high : row->low;
        bool holds = missed <= allowed_error(problem, row, motion, dependent) &&
                     (excess == 0 || excess <= LAW_TOLERANCE * fabs(bound));
        all_hold = all_hold && holds;
    }
    return all_hold;
}

/* Follows where a body's tree begins, and shortens the way for the next time. */
static int first_of_tree(double *towards_first, int body)
{
    while ((int)towards_first[body] != body)
        body = (int)(towards_first[body] = towards_first[(int)towards_first[body]]);
    return body;
}

void pinch_tree_motions(const pinch_problem *problem, const double *motion, double *tree_motion)
{
    double *towards_first = tree_motion + problem->body_count; /* indices of bodies */
    int before = -1;                                           /* a body of this row or of those that it continues */
    for (int b = 0; b < problem->body_count; b++) {
        towards_first[b] = b;
        tree_motion[b] = 0;
    }
    for (int k = 0; k < 2 * problem->row_count; k++) {
        const pinch_joint_row *row = &problem->rows[k / 2];
        int body = k % 2 ? row->body2 : row->body1;
        if (k % 2 == 0 && !row->continues) before = -1;
        if (body < 0) continue;
        if (before >= 0) towards_first[first_of_tree(towards_first, body)] = first_of_tree(towards_first, before);
        before = body;
    }
    for (int b = 0; b < problem->body_count; b++) tree_motion[first_of_tree(towards_first, b)] += motion[b] * motion[b];
    for (int b = 0; b < problem->body_count; b++)
        if (first_of_tree(towards_first, b) != b) tree_motion[b] = tree_motion[first_of_tree(towards_first, b)];
    for (int b = 0; b < problem->body_count; b++) tree_motion[b] = sqrt(tree_motion[b]);
}
