/* The force of an element eliminated from a Newton step: dr = -shift - conductance G dq. */
#ifndef PINCH_FORCE_FORCE_CONDUCTANCE_H
#define PINCH_FORCE_FORCE_CONDUCTANCE_H

#include "force/force_system.h"

/* f[rows] = F at the point last evaluated, derivative (rows x rows; may be NULL) = J. */
void pinch_force_force_off(const pinch_force_element *element, double *f, double *derivative);

/* D = A^-1 J rho, minus the shift A^-1 F where the change goes, conducts; false where A is singular. */
bool pinch_force_eliminate(pinch_force_element *element);

#endif
