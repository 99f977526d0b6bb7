/* Large islands: the linear system of a Newton step solved by iteration. */
#ifndef PINCH_STIFF_STIFF_KRYLOV_H
#define PINCH_STIFF_STIFF_KRYLOV_H

#include "stiff/stiff_system.h"

/*
 * x of (I + h sum G^T D G) x = rhs in the place of rhs, from what pinch_block_dilu_split made of system->lu and rhs:
 * until the preconditioned residual is `exactness` of that right hand side. False, rhs destroyed, where that takes too
 * long.
 */
bool pinch_stiff_krylov(pinch_stiff_system *system, double exactness);

#endif
