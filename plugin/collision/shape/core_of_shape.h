#ifndef PINCH_FINGERTIP_CORE_OF_SHAPE_H
#define PINCH_FINGERTIP_CORE_OF_SHAPE_H

#include "convex_shape.h"

/* The core of a tip (of piece `piece`, whose hull is given). */
pinch_core pinch_core_of_tip(const pinch_tip *tip, const pinch_core_hull *hull);
pinch_core pinch_core_of_triangle(const double corners[9]);

#endif
