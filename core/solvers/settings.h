#ifndef PINCH_SOLVERS_SETTINGS_H
#define PINCH_SOLVERS_SETTINGS_H

#include <pinch/solver.h>

/* PINCH_INVALID_ARGUMENT when a field is outside the range that solver.h documents. */
pinch_status pinch_check_solver_settings(const pinch_solver_settings *settings);

#endif
