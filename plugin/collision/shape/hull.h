#ifndef PINCH_FINGERTIP_HULL_H
#define PINCH_FINGERTIP_HULL_H

#include "convex_shape.h"

/* False: out of memory, or faces that do not close. The arrays of `convex` must outlive the hull. */
bool pinch_hull_of_convex(const pinch_convex *convex, pinch_core_hull *hull);
/* Frees what was found of it. */
void pinch_hull_free(pinch_core_hull *hull);

#endif
