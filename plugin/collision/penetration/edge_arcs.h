/* The straight edges of polytopes, with their arcs on the Gauss sphere. */
#ifndef PINCH_FINGERTIP_EDGE_ARCS_H
#define PINCH_FINGERTIP_EDGE_ARCS_H

#include "collision/shape/convex_shape.h"

enum { PINCH_MAX_EDGES = 96 };

/* Their number; -1: more than there is room for. A point has none. */
int pinch_edge_arcs(const pinch_core *core, pinch_edge_arc arcs[PINCH_MAX_EDGES]);

#endif
