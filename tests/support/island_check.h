#ifndef PINCH_TEST_ISLAND_CHECK_H
#define PINCH_TEST_ISLAND_CHECK_H

#include "support/island.h"
#include "support/referee.h"

#include <pinch/problem.h>

/* Solves islands from a cold start, and says what counts as an answer. */

/* The tests of a group share this solver; the two functions are the group's set-up and tear-down. */
extern pinch_step_solver *island_solver;
int island_create_solver(void **state);
int island_destroy_solver(void **state);

/* The default settings. In a quick run the solver gives up sooner, because failing takes the most time. */
pinch_solver_settings island_settings(void);
/* Asserts that the call was legal. */
pinch_step_result island_solve(island *made, const pinch_solver_settings *settings);

/* Both look at everything that is documented as output. */
void island_assert_nan(island *made);
void island_assert_finite(island *made);

/* The bound is 1e-9 of the largest force, to which problem.h has the laws verified, plus what 64 roundings of the
 * velocities make of the forces. */
double island_law_tolerance(const referee_verdict *v);
/* Names the first law that does not hold; NULL where all hold. */
const char *island_fault(const pinch_problem *p, const referee_verdict *v);
/* The largest difference of a contact force's component, N. */
double island_force_difference(const pinch_problem *a, const pinch_problem *b);

#endif
