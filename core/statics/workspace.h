#ifndef PINCH_STATICS_WORKSPACE_H
#define PINCH_STATICS_WORKSPACE_H

#include "statics/model.h"

struct pinch_statics {
    int fingers, faces, unknowns; /* unknowns of the largest complementarity problem; 0: none */
    pinch_static_contact *contacts;
    pinch_finger *scaled; /* and results: what the search for limits solves */
    pinch_finger_result *results;
    pinch_lcp_workspace *lcp;
    double *mixed, *mixed_q, *m, *q, *z, *w, *back;
    bool *free;
};

/* Return PINCH_INVALID_ARGUMENT or PINCH_UNSUPPORTED as pinch_statics_solve documents. */
pinch_status pinch_static_validate(const pinch_statics *statics, const pinch_grasp *grasp,
                                   const pinch_statics_settings *settings);
pinch_status pinch_static_validate_method(const pinch_statics *statics, const pinch_grasp *grasp,
                                          const pinch_statics_settings *settings);

/*
 * Solves the complementarity problem: condensed where that form exists, with u split in two non-negative parts
 * otherwise, as in the paper. On anything but convergence only result->solve and size are set.
 */
void pinch_static_solve_lcp(pinch_statics *statics, const pinch_static_model *model, const pinch_grasp *grasp,
                            const pinch_statics_settings *settings, pinch_finger_result *fingers,
                            pinch_statics_result *result);

#endif
