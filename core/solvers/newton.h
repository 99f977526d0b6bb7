#ifndef PINCH_SOLVERS_NEWTON_H
#define PINCH_SOLVERS_NEWTON_H

#include "solvers/iterate.h"

#include <stdbool.h>

/*
 * One Newton step from the current point, with V already linearized there: x - t V^-1 F, t halved from 1 until ||F||
 * falls by Armijo's rule. Accepts it and returns true, or leaves the point and returns false (V singular, or no t that
 * helps).
 */
bool pinch_newton_step(pinch_iterate *it);

/* The same along the steepest descent of ||F||^2 / 2, for where Newton's own direction fails. */
bool pinch_gradient_step(pinch_iterate *it);

/*
 * The last digits: linearizes and takes full Newton steps while each at least halves ||F||, until ||F|| <= goal, at
 * most `limit` of them. Returns the number of steps taken.
 */
int pinch_newton_polish(pinch_iterate *it, double goal, int limit);

#endif
