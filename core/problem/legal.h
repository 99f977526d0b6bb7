#ifndef PINCH_PROBLEM_LEGAL_H
#define PINCH_PROBLEM_LEGAL_H

#include <pinch/problem.h>

/* Is every number of the problem in the range that problem.h documents? NaN and infinities end here. */
bool pinch_problem_legal(const pinch_problem *problem);

#endif
