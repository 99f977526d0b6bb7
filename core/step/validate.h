#ifndef PINCH_STEP_VALIDATE_H
#define PINCH_STEP_VALIDATE_H

#include <pinch/problem.h>

/* Is every number of the problem in the range that problem.h documents? NaN and infinities end here. */
bool pinch_problem_valid(const pinch_problem *problem);

#endif
