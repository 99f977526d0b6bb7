#ifndef PINCH_STATICS_LOAD_STEP_H
#define PINCH_STATICS_LOAD_STEP_H

#include "statics/flow.h"

/* One phase of the load path: closing, or the wrench. */
typedef struct pinch_static_phase {
    pinch_static_model *model;
    pinch_solver_settings solver;
    double tolerance; /* of the tangential springs' forces, per load step; INFINITY: whatever a step gives */
    double *factor;   /* the model's, taken from 0 to goal */
    double goal;
    double *u, *rate; /* rate: of u along the phase, from the last step */
    double *direction;
    pinch_solver_result *total;
} pinch_static_phase;

/* The contacts' rest, put aside and back. */
void pinch_static_save(pinch_static_model *model);
void pinch_static_restore(pinch_static_model *model);

/*
 * One load step from `done` to `next` (parts of the goal), at once and in two halves. True: u and rest are those of the
 * halves, the slip of the second half committed and extrapolated unless `last`. False: too long, nothing changed.
 * *error: estimate of the slip's error as a force; 0 where Newton's method failed already.
 */
bool pinch_static_load_step(const pinch_static_phase *p, double done, double next, bool last, double *error);

#endif
