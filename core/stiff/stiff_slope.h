/* The force of an element eliminated from a Newton step: dr = -shift - slope G dq. */
#ifndef PINCH_STIFF_STIFF_SLOPE_H
#define PINCH_STIFF_STIFF_SLOPE_H

#include "stiff/stiff_system.h"

/* slope = D = A^-1 J rho, shift = A^-1 F, gives; false where A is singular. */
bool pinch_stiff_eliminate(pinch_stiff_element *element);

#endif
