/* A corner or a rim's lowest point that alone is pressed into a flat face. */
#ifndef PINCH_FINGERTIP_LONE_POINT_H
#define PINCH_FINGERTIP_LONE_POINT_H

#include "collision/shape/convex_shape.h"

#include <float.h>

#define PINCH_NOT_LONE DBL_MAX

/* How far (m) from its point that lies farthest along d, a hull's corner, a core is still pressed in where that point
 * is `depth` deep; PINCH_NOT_LONE: other corners are, too. */
double pinch_lone_spread(const pinch_core *core, unsigned corner, const double d[3], double depth);

#endif
