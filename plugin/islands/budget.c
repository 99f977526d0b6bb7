/*
 * How long the solve of an island may take.
 *
 * A heap of bodies that overlap, as programs make them at their start, couples every body with many others. Factors of
 * its equations fill in, iterations do not converge, and floor after floor is tried: seconds, where ODE's few sweeps
 * take a fraction of one. So a solve has a budget, some times what ODE's own step takes for as many rows. An island
 * that goes over it is swept for a while, as quickstep does it, where its bodies are free, and left to ODE otherwise
 * (backoff.c).
 *
 * Heaps are also swept where they can be solved, but at a floor as soft as that of sweeps and for more work: they would
 * gain nothing but digits. Walls and pyramids, whose contacts are solved as stiff as they are, are not.
 */
#include "islands/island_life.h"

#include <math.h>

/* In products of blocks: what is allowed to any island, to one of free bodies, which the proximal point method of the
 * core can still lead to an answer, for a contact and each of quickstep's sweeps, and for the cube of the number of
 * contacts that worldstep takes. */
static const double LEAST = 2e6, LEAST_FREE = 4e6, FOR_A_SWEEP = 24, FOR_A_CUBE = 1.0 / 16;
/* The same for an island that has been swept: sweeps bring it so far that a solve is soon done, or it is in vain. */
static const double LEAST_AGAIN = 2e5, FOR_A_SWEEP_AGAIN = 4;
/* Where worldstep takes longer than anybody waits, Pinch does not. */
static const double MOST_OF_CUBE = 2e8;

/* Contacts of free bodies: worldstep takes 20 s for MANY, and minutes for TOO_MANY. More than MANY are swept rather
 * than left to it where a solve goes over its budget, and more than TOO_MANY have the budget that they have under
 * quickstep. An exact answer for fewer does not take long in any case, where there is one. */
enum { MANY = 1000, TOO_MANY = 2000 };

/* Tells whether nothing but contacts acts between an island's bodies. */
static bool is_free(const pinch_island *island)
{
    return island->joints.range.count == 0 && island->joints.couplings.count == 0 && island->drive_rows == 0;
}

bool pinch_island_may_be_swept(const pinch_step_context *context, const pinch_island *island)
{
    /* dWorldStep is asked for its direct method */
    if (context->settings.stepper == PINCH_ODE_WORLDSTEP && island->contacts.count <= MANY) return false;
    return is_free(island);
}

double pinch_budget_of(const pinch_step_context *context, const pinch_island *island, bool again)
{
    double n = island->contacts.count + island->joints.row_count / 3.0, least = is_free(island) ? LEAST_FREE : LEAST;
    bool free_and_many = island->contacts.count > TOO_MANY && pinch_island_may_be_swept(context, island);
    if (context->settings.stepper == PINCH_ODE_WORLDSTEP && !free_and_many)
        least = fmax(least, fmin(FOR_A_CUBE * n * n * n, MOST_OF_CUBE));
    if (again && pinch_island_may_be_swept(context, island))
        return fmax(LEAST_AGAIN, FOR_A_SWEEP_AGAIN * dWorldGetQuickStepNumIterations(context->world) * n);
    return fmax(least, FOR_A_SWEEP * dWorldGetQuickStepNumIterations(context->world) * n);
}

bool pinch_solve_was_dear(const pinch_step_context *context, const pinch_island *island)
{
    enum { SOFT_LEVEL = 3 };       /* that of the floor of sweeps */
    static const double VISIT = 1; /* of a sweep to a contact, in products of blocks */
    int n = island->contacts.count;
    return pinch_island_may_be_swept(context, island) && n > TOO_MANY && island->result.floor_level >= SOFT_LEVEL &&
           island->result.work > VISIT * dWorldGetQuickStepNumIterations(context->world) * n;
}
