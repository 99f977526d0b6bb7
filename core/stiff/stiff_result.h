/* The answer of a stiff system as the problem wants it. */
#ifndef PINCH_STIFF_STIFF_RESULT_H
#define PINCH_STIFF_STIFF_RESULT_H

#include "stiff/stiff_system.h"

/*
 * Velocities, contact and row results into the problem, from the forces of `system`; stiffness and damping as they were
 * used. Sets result->floor_depth; returns the largest part of its smaller body's size by which the floor lets a contact
 * sink. scratch: 6 doubles per body.
 */
double pinch_stiff_read_back(pinch_problem *problem, const pinch_stiff_system *system, double *scratch,
                             pinch_step_result *result);

#endif
