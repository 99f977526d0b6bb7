/* Do the rows of the joints hold? Their law is checked in m/s or rad/s, and in N or N m, from data and outputs alone.
 */
#ifndef PINCH_VERIFY_ROW_CHECK_H
#define PINCH_VERIFY_ROW_CHECK_H

#include <pinch/problem.h>

/*
 * Writes result->row_velocity and result->row_force, equation (55) of core/README.md, from the velocities and forces in
 * `problem`. motion: per body, what its velocities have been summed up from, as a velocity in the metric of its inertia
 * (sqrt(J)); NULL: no rounding of them is allowed for, which most rows do without. Rows that were dropped because they
 * depend on others (pivot 0) are not judged. Returns whether all others hold.
 */
bool pinch_row_check(const pinch_problem *problem, const double *motion, pinch_step_result *result);

/*
 * Writes for every body the root of the sum of motion^2 over the bodies that joint rows, couplings among them, tie to
 * it, itself included. tree_motion: 2 doubles per body, of which the first body_count are the answer.
 */
void pinch_tree_motions(const pinch_problem *problem, const double *motion, double *tree_motion);

#endif
