/*
 * Is the answer of a step one? Checked in newtons and metres per second from the problem's data and outputs alone: the
 * laws are written out again here, and nothing is shared with the code that solved them.
 */
#ifndef PINCH_VERIFY_STEP_CHECK_H
#define PINCH_VERIFY_STEP_CHECK_H

#include <pinch/problem.h>

typedef struct pinch_step_check {
    double residual_max;    /* momentum balance, relative, see pinch_step_result */
    double cone;            /* N */
    double complementarity; /* N */
    double slip_direction;  /* N */
    double force_scale;     /* N */
} pinch_step_check;

/* scratch: 9 doubles per body */
void pinch_check_step(const pinch_problem *problem, double *scratch, pinch_step_check *check);

#endif
