#ifndef PINCH_FINGERTIP_KNOWN_CONVEX_H
#define PINCH_FINGERTIP_KNOWN_CONVEX_H

#include "convex_shape.h"

/* NULL: the geom is not known. */
const pinch_core *pinch_known_core(dGeomID geom);
void pinch_forget_convexes(void);

#endif
