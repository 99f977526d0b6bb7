/* The solution of a stiff system at one compliance floor. */
#ifndef PINCH_FORCE_FORCE_NEWTON_H
#define PINCH_FORCE_FORCE_NEWTON_H

#include "force/force_system.h"

/* `count` sweeps of projected Gauss-Seidel, contact by contact. */
void pinch_force_sweeps(pinch_force_system *system, int count);

/*
 * Semi-smooth Newton with line search from r and y as they are, at most `limit` steps; result->status, iterations,
 * newton_steps and residual (the merit's root) are set, and r lies in the friction cones to the last bit. False when
 * memory ran out.
 */
bool pinch_force_newton(pinch_arena *arena, pinch_force_system *system, const pinch_solver_settings *settings,
                        int limit, pinch_solver_result *result);

#endif
