/* The answer of a stiff system as the problem wants it. */
#ifndef PINCH_FORCE_FORCE_RESULT_H
#define PINCH_FORCE_FORCE_RESULT_H

#include "force/force_system.h"

/*
 * Velocities, contact and row results into the problem, from the forces of `system`; elastic state, stiffness and
 * damping as they were used. Sets result->floor_depth, and *share to the largest part of its smaller body's size by
 * which the floor lets a contact sink. Releases what Newton's steps needed of the arena, to keep there what the
 * contacts came with, and scratch; false when memory ran out.
 */
bool pinch_force_read_back(pinch_arena *arena, pinch_problem *problem, pinch_force_system *system,
                           pinch_step_result *result, double *share);

/* The contacts as they came, where they have been written to. */
void pinch_force_undo(const pinch_force_system *system);

#endif
