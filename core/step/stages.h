/* What comes before and after the solve of a step. */
#ifndef PINCH_STEP_STAGES_H
#define PINCH_STEP_STAGES_H

#include "support/arena.h"

#include <pinch/problem.h>

/* validate.c: is every number of the problem in the range that problem.h documents? NaN and infinities end here. */
bool pinch_problem_valid(const pinch_problem *problem);

/* sticking.c, from here on: of several answers of one step, the one in which contacts go on sticking. What a step began
 * with: */
typedef struct pinch_sticking {
    pinch_contact *contacts; /* as they were; NULL: none presses, or it is not asked for */
    double *row_forces;
} pinch_sticking;

/* Notes what a solve changes. Returns false when memory ran out. */
bool pinch_note_start(pinch_arena *arena, const pinch_problem *problem, pinch_sticking *start);

/* How many contacts stick by the forces of the last step and do not in the answer that the problem has, and how many
 * press by these forces and are open in it. */
int pinch_contacts_let_go(const pinch_sticking *start, const pinch_problem *problem);

/* A solve, as pinch_step_solve does it but for this search. by_forces: the forces are the first unknowns, if they can
 * be. */
typedef pinch_status pinch_sticking_solve(pinch_step_solver *solver, pinch_problem *problem,
                                          const pinch_solver_settings *settings, bool by_forces,
                                          pinch_step_result *result);

/*
 * Looks for an answer in which fewer contacts have let go than in the one that the problem and result have. Both are
 * replaced by it where there is one, and stay as they are otherwise. What the result counts includes the search.
 * Returns PINCH_OUT_OF_MEMORY, as another answer than with memory must not pass for it, or PINCH_OK.
 */
pinch_status pinch_go_on_sticking(pinch_arena *arena, const pinch_sticking *start, pinch_sticking_solve *solve,
                                  pinch_step_solver *solver, pinch_problem *problem,
                                  const pinch_solver_settings *settings, pinch_step_result *result);

#endif
