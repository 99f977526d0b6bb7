/* What the contacts and rows of a solved problem do to its bodies decides the forces of the eliminated rows, (15). */
#ifndef PINCH_KINEMATICS_WRENCHES_H
#define PINCH_KINEMATICS_WRENCHES_H

#include "kinematics/mobility.h"

/*
 * Writes the forces of the rows that the mobility eliminated into problem->rows[].force; they follow from those of all
 * contacts and other rows. scratch: 6 doubles per body.
 */
void pinch_joint_forces(pinch_problem *problem, const pinch_mobility *mobility, double *scratch);

#endif
