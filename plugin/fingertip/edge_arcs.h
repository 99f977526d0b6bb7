/* The straight edges of polytopes, with their arcs on the Gauss sphere. */
#ifndef PINCH_FINGERTIP_EDGE_ARCS_H
#define PINCH_FINGERTIP_EDGE_ARCS_H

#include "core.h"

enum { PINCH_MAX_EDGES = 96 };

/* A straight edge: a point on it, its direction, and one arc of its outward normals, less than a half turn. */
typedef struct pinch_edge_arc {
    double v[3], u[3], n1[3], n2[3];
} pinch_edge_arc;

/* Their number; -1: more than there is room for. A point has none. */
int pinch_edge_arcs(const pinch_core *core, pinch_edge_arc arcs[PINCH_MAX_EDGES]);

/* That edge of a hull. */
void pinch_hull_edge_arc(const pinch_core_hull *hull, int edge, pinch_edge_arc *arc);

#endif
