/*
 * How long the solve of an island may take, and what becomes of those that take longer.
 *
 * A heap of bodies that overlap, as programs make them at their start, couples every body with many others. Factors of
 * its equations fill in, iterations do not converge, and floor after floor is tried: seconds, where ODE's few sweeps
 * take a fraction of one. So a solve has a budget, some times what ODE's own step takes for as many rows. An island
 * that goes over it is left to ODE, at first for one step, and for twice as many each time that it goes over again:
 * what tries cost in vain grows with the logarithm of the number of steps.
 */
#include "islands/island_life.h"

#include <math.h>

enum { FIRST_SPAN = 1, LONGEST_SPAN = 1 << 24 };

/* In products of blocks: what is allowed to any island, for a contact and each of quickstep's sweeps, and for the cube
 * of the number of contacts that worldstep takes. */
static const double LEAST = 2e6, FOR_A_SWEEP = 8, FOR_A_CUBE = 1.0 / 16;
/* Where worldstep takes longer than anybody waits, Pinch does not. */
static const double MOST_OF_CUBE = 2e8;

static int size_of(const pinch_island *island)
{
    return island->contacts.count + island->joints.range.count;
}

double pinch_budget_of(const pinch_step_context *context, const pinch_island *island)
{
    double n = island->contacts.count + island->joints.row_count / 3.0, least = LEAST;
    if (context->settings.stepper == PINCH_ODE_WORLDSTEP)
        least = fmax(least, fmin(FOR_A_CUBE * n * n * n, MOST_OF_CUBE));
    return fmax(least, FOR_A_SWEEP * dWorldGetQuickStepNumIterations(context->world) * n);
}

bool pinch_backoff_holds(const pinch_step_context *context, const pinch_island_graph *graph, const pinch_island *island)
{
    const pinch_backoff *b = &graph->backoff;
    return context->number < b->until && size_of(island) >= b->size;
}

void pinch_judge_budget(const pinch_step_context *context, pinch_island_graph *graph, const pinch_island *island)
{
    pinch_backoff *b = &graph->backoff;
    if (!island->tried || island->phase != PINCH_ISLAND_FALLBACK || !island->result.over_budget) return;
    long now = context->number;
    bool soon = b->span > 0 && now - b->until <= b->span;
    if (now < b->until) { /* another island of this step, or one too small until now */
        if (size_of(island) / 2 < b->size) b->size = size_of(island) / 2;
        return;
    }
    b->span = soon ? 2 * b->span : FIRST_SPAN;
    if (b->span > LONGEST_SPAN) b->span = LONGEST_SPAN;
    b->until = now + 1 + b->span;
    b->size = size_of(island) / 2; /* what it may fall apart into */
}
