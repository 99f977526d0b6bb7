/*
 * A stiff island, solved with as little softening as it takes: a ladder of compliance floors, each rung five times
 * softer than the one below. The floor that an island needed is remembered with its contacts, so that islands may part
 * and merge; after a number of quiet steps it is lowered little by little: what lies on soft contacts is pressed in
 * deeper, and contacts that stiffened all at once would throw it up.
 */
#ifndef PINCH_FORCE_FORCE_FLOORS_H
#define PINCH_FORCE_FORCE_FLOORS_H

#include "force/force_system.h"

/* Has the island anything that the velocity system does not take or does not take well? */
bool pinch_force_preferred(const pinch_problem *problem, const pinch_mobility *mobility);
/* Does it have anything that only the stiff system has laws for? */
bool pinch_force_required(const pinch_problem *problem);

/*
 * Solves and writes velocities, contact and row results into the problem. False when memory ran out; result->solve
 * says how it ended. `system` serves pinch_force_undo; where it converged, it has scratch for the check.
 */
bool pinch_force_solve(pinch_arena *arena, pinch_problem *problem, const pinch_mobility *mobility,
                       const pinch_solver_settings *settings, pinch_force_system *system, pinch_step_result *result);

#endif
