#ifndef PINCH_TEST_ISLAND_CHECK_H
#define PINCH_TEST_ISLAND_CHECK_H

#include "support/island.h"
#include "support/referee.h"

#include <pinch/problem.h>

/* Islands solved from a cold start, and what counts as an answer. */

/* The solver of a group of tests, with its set-up and tear-down. */
extern pinch_step_solver *island_solver;
int island_create_solver(void **state);
int island_destroy_solver(void **state);

/* The default solver; unless everything is wanted it gives up sooner, which is what takes the time. */
pinch_solver_settings island_settings(void);
/* Asserts that the call was legal. */
pinch_step_result island_solve(island *made, const pinch_solver_settings *settings);

/* Of everything documented as output. */
void island_assert_nan(island *made);
void island_assert_finite(island *made);

/* 1e-9 of the largest force, which is what problem.h's laws are verified to, and what the last bit of the velocities
 * makes of the forces (64 roundings of it). */
double island_law_tolerance(const referee_verdict *v);
/* NULL: every law holds. */
const char *island_fault(const pinch_problem *p, const referee_verdict *v);
/* Largest of the contacts, N. */
double island_force_difference(const pinch_problem *a, const pinch_problem *b);

#endif
