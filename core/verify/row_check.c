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

/* One row with what its law needs. */
typedef struct row_view {
    const pinch_joint_row *row;
    double velocity; /* j1 v1 + j2 v2 */
    double size;     /* the magnitudes of its terms, added up */
    double rounding; /* of the velocity, from what the bodies' velocities have been summed up from */
    double carried;  /* what the largest of its bodies' velocities could be along the row */
} row_view;

static void view_row(const pinch_problem *problem, const pinch_joint_row *row, const double *motion, row_view *v)
{
    const int body[2] = {row->body1, row->body2};
    const double *j[2] = {row->j1, row->j2};
    *v = (row_view){.row = row};
    for (int side = 0; side < 2; side++) {
        if (body[side] < 0) continue;
        const pinch_body *b = &problem->bodies[body[side]];
        double turns[3], length2 = 0, speed2 = 0;
        for (int i = 0; i < 6; i++) {
            double term = j[side][i] * b->velocity_end[i];
            v->velocity += term;
            v->size += fabs(term);
            length2 += j[side][i] * j[side][i];
            speed2 += b->velocity_end[i] * b->velocity_end[i];
        }
        v->carried = pinch_check_larger(sqrt(length2 * speed2), v->carried);
        if (b->mass == 0) continue;
        pinch_check_solve3(b->inertia, j[side] + 3, turns);
        double moves = (j[side][0] * j[side][0] + j[side][1] * j[side][1] + j[side][2] * j[side][2]) / b->mass;
        for (int i = 0; i < 3; i++) moves += j[side][3 + i] * turns[i];
        v->rounding += ROUNDINGS * DBL_EPSILON * sqrt(moves) * motion[body[side]];
    }
}

/* Returns by how much the force is beyond its bounds, N or N m. */
static double force_excess(const pinch_joint_row *row)
{
    double above = row->force - row->high, below = row->low - row->force;
    return pinch_check_larger(0, pinch_check_larger(above, below));
}

/* Is the force at the bound, to the rounding of what it was computed from? */
static bool at_bound(double force, double bound)
{
    return fabs(force - bound) <= LAW_TOLERANCE * fabs(bound);
}

/*
 * The velocity by which the row misses its law, m/s or rad/s. A hard row that depends on others may give way to its own
 * force, by its `yield` or the small compliance that stands for one; no other row may.
 */
static double missed_velocity(const row_view *v, bool dependent)
{
    const pinch_joint_row *row = v->row;
    double given_way = dependent ? row->violation : 0;
    double missing = row->rhs - given_way - v->velocity - row->cfm * row->force;
    if (missing > 0 && at_bound(row->force, row->high)) return 0;
    if (missing < 0 && at_bound(row->force, row->low)) return 0;
    return fabs(missing);
}

static bool was_dropped(const pinch_joint_row *row)
{
    return row->cfm == 0 && row->low == -INFINITY && row->high == INFINITY && row->pivot == 0;
}

bool pinch_row_check(const pinch_problem *problem, const double *motion, pinch_step_result *result)
{
    bool dependent = result->dependent_rows > 0, all_hold = true;
    result->row_velocity = result->row_force = 0;
    for (int k = 0; k < problem->row_count; k++) {
        const pinch_joint_row *row = &problem->rows[k];
        row_view v;
        if (was_dropped(row)) continue;
        view_row(problem, row, motion, &v);
        double missed = missed_velocity(&v, dependent), excess = force_excess(row);
        double allowed = LAW_TOLERANCE * (fabs(row->rhs) + v.size + fabs(row->cfm * row->force)) + v.rounding +
                         (dependent ? LEAST_DEPENDENT + LAW_TOLERANCE * v.carried : LEAST_ERROR);
        result->row_velocity = pinch_check_larger(missed, result->row_velocity);
        result->row_force = pinch_check_larger(excess, result->row_force);
        double bound = row->force > row->high ? row->high : row->low;
        bool holds = missed <= allowed && (excess == 0 || excess <= LAW_TOLERANCE * fabs(bound));
        all_hold = all_hold && holds;
    }
    return all_hold;
}
