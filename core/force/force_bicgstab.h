/* Large islands: the linear system of a Newton step solved by iteration. */
#ifndef PINCH_FORCE_FORCE_BICGSTAB_H
#define PINCH_FORCE_FORCE_BICGSTAB_H

#include "force/force_system.h"

/*
 * x of (I + h sum G^T D G) x = rhs in the place of rhs, from what pinch_block_dilu_split made of system->lu and rhs:
 * until the preconditioned residual is `exactness` of that right hand side. False, rhs destroyed, where that takes too
 * long.
 */
bool pinch_force_bicgstab(pinch_force_system *system, double exactness);

#endif
