/* What the contacts and rows of a solved problem do to its bodies. */
#ifndef PINCH_KINEMATICS_WRENCHES_H
#define PINCH_KINEMATICS_WRENCHES_H

#include "kinematics/mobility.h"

/*
 * The forces of the rows that the mobility eliminated, into problem->rows[].force, from the forces of all contacts and
 * other rows. element_of_row[row] is -1 for those eliminated. scratch: 6 doubles per body.
 */
void pinch_joint_forces(pinch_problem *problem, const pinch_mobility *mobility, const int *element_of_row,
                        double *scratch);

#endif
