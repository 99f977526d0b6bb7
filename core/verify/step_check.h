/*
 * Is it an answer? A step is checked in newtons and metres per second from the problem's data and outputs
 * alone: the laws are written out again here, one function for each, and nothing is shared with the code that solved
 * them.
 */
#ifndef PINCH_VERIFY_STEP_CHECK_H
#define PINCH_VERIFY_STEP_CHECK_H

#include <pinch/friction.h>
#include <pinch/problem.h>

/*
 * Writes the errors of the answer into result: residual_max, cone, complementarity, slip_direction, row_velocity,
 * row_force and force_scale.
 * Returns whether all are small enough for an answer that was solved to `tolerance`. scratch: 11 doubles per body.
 */
bool pinch_step_verify(const pinch_problem *problem, double tolerance, double *scratch, pinch_step_result *result);

/* friction_check.c, for rigid frictional problems. Writes the contacts' velocities from their impulses, and returns
 * pinch_friction_missed. x: scratch for all freedoms; first[b]: where those of body b begin. */
double pinch_friction_error(pinch_friction_problem *problem, const int *first, double *x);

#endif
