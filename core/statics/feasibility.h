#ifndef PINCH_STATICS_FEASIBILITY_H
#define PINCH_STATICS_FEASIBILITY_H

#include "statics/model.h"

typedef enum pinch_feasibility {
    PINCH_FEASIBLE,         /* forces inside the limits balance the wrench */
    PINCH_MAYBE_INFEASIBLE, /* none were found; `direction` is the candidate for the proof */
} pinch_feasibility;

/* Can any forces inside the friction limits balance the model's wrench? direction[freedoms], model units. */
pinch_feasibility pinch_static_feasibility(const pinch_static_model *model, double *direction);

#endif
