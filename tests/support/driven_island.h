#ifndef PINCH_TEST_DRIVEN_ISLAND_H
#define PINCH_TEST_DRIVEN_ISLAND_H

#include "support/island.h"

#include <stdbool.h>

/* Random islands whose joints are driven along all of their freedoms, as those of hands are. */

/* Bodies of random size with contacts; the first ones make trees that hang from the world or from a free body. */
void driven_island_make(island *made, uint64_t seed);

/*
 * Adds rows that close loops. Some are independent of the others, some are said twice, and some depend on the rows of
 * joints that hold two bodies together without letting them turn; those ask for nothing that contradicts these. Most
 * islands lose their dry friction, of which loops bear little. Returns how many rows were added that depend on others.
 */
int driven_island_close(island *made, uint64_t seed);

/*
 * Two parallel cranks that hang a coupler on the world, in a plane: four joints, listed in one of 24 orders, with a
 * damper along each hinge. The second crank carries the coupler by a hinge or, with `ball`, by a ball joint alone,
 * which is not driven. A force on the coupler puts the links out of the plane, too, if it could.
 */
void driven_island_four_bar(island *made, int order, bool ball);

/*
 * Two bodies of 1 kg on rails along x, from rest. The first is pushed along it, each rail has dry friction of 0.5 N,
 * and a coupling makes both equally fast. The last four rows are the frictions and the coupling; they begin with the
 * forces given.
 */
void driven_island_sliders(island *made, double push, const double friction[2], double coupling);

#endif
