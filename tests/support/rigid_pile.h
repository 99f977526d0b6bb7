#ifndef PINCH_TEST_RIGID_PILE_H
#define PINCH_TEST_RIGID_PILE_H

#include "support/random.h"

#include <pinch/friction.h>

enum { RIGID_BODIES = 12, RIGID_CONTACTS = 40, RIGID_FREEDOMS = 6, RIGID_AXES = 3 };

typedef struct rigid_pile {
    int freedoms[RIGID_BODIES];
    double g[RIGID_CONTACTS][2][RIGID_AXES * RIGID_FREEDOMS];
    pinch_friction_contact contacts[RIGID_CONTACTS];
    pinch_friction_problem problem;
} rigid_pile;

/*
 * Bodies that fall with velocities of their own onto each other and onto a floor, where each contact has a twin that
 * says the same, as those of flat sides do: forces are not unique. `stiff`: masses differ by up to 1e6.
 */
void rigid_pile_draw(pinch_random *random, bool stiff, bool doubled, rigid_pile *p);

#endif
