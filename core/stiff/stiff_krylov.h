/* Large islands: the linear system of a Newton step solved by iteration. */
#ifndef PINCH_STIFF_STIFF_KRYLOV_H
#define PINCH_STIFF_STIFF_KRYLOV_H

#include "stiff/stiff_system.h"

/*
 * (I + h sum G^T D G) x = rhs with the incomplete factors of system->lu as preconditioner, until the residual is
 * `exactness` of the right hand side; x replaces system->rhs. False, with rhs as it was, where that takes more than
 * `limit` iterations.
 */
bool pinch_stiff_krylov(pinch_stiff_system *system, double exactness, int limit);

#endif
