/* A hull's face that is pressed in well inside its border. */
#ifndef PINCH_FINGERTIP_HULL_FIRST_H
#define PINCH_FINGERTIP_HULL_FIRST_H

#include "contact_normal.h"

/* The faces of a pair in which one is a hull. True: `best` has the least overlap, or one of less than -skins. */
bool pinch_hull_first(const pinch_core_pair *pair, pinch_contact_normal *best);

#endif
