/*
 * How long the solve of an island may take.
 *
 * A heap of bodies that overlap, as programs make them at their start, couples every body with many others. Factors of
 * its equations fill in, iterations do not converge, and floor after floor is tried: seconds, where ODE's few sweeps
 * take a fraction of one. So a solve has a budget, some times what ODE's own step takes for as many rows. An island
 * that goes over it is left to ODE for a while (backoff.c).
 */
#include "islands/island_life.h"

#include <math.h>

/* In products of blocks: what is allowed to any island, for a contact and each of quickstep's sweeps, and for the cube
 * of the number of contacts that worldstep takes. */
static const double LEAST = 2e6, FOR_A_SWEEP = 24, FOR_A_CUBE = 1.0 / 16;
/* Where worldstep takes longer than anybody waits, Pinch does not. */
static const double MOST_OF_CUBE = 2e8;

double pinch_budget_of(const pinch_step_context *context, const pinch_island *island)
{
    double n = island->contacts.count + island->joints.row_count / 3.0, least = LEAST;
    if (context->settings.stepper == PINCH_ODE_WORLDSTEP)
        least = fmax(least, fmin(FOR_A_CUBE * n * n * n, MOST_OF_CUBE));
    return fmax(least, FOR_A_SWEEP * dWorldGetQuickStepNumIterations(context->world) * n);
}
