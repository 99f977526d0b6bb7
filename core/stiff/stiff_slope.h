/* The force of an element eliminated from a Newton step: dr = -shift - slope G dq. */
#ifndef PINCH_STIFF_STIFF_SLOPE_H
#define PINCH_STIFF_STIFF_SLOPE_H

#include "stiff/stiff_system.h"

/* f[rows] = F at the point last evaluated, derivative (rows x rows; may be NULL) = J. */
void pinch_stiff_force_off(const pinch_stiff_element *element, double *f, double *derivative);

/* D = A^-1 J rho, minus the shift A^-1 F where the change goes, gives; false where A is singular. */
bool pinch_stiff_eliminate(pinch_stiff_element *element);

#endif
