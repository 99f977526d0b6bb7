#ifndef PINCH_STATICS_FEASIBILITY_H
#define PINCH_STATICS_FEASIBILITY_H

#include "statics/model.h"

typedef enum pinch_feasibility {
    PINCH_FEASIBLE,   /* forces inside the limits balance the wrench */
    PINCH_INFEASIBLE, /* a twist proves that none do */
    PINCH_UNKNOWN_FEASIBILITY
} pinch_feasibility;

/* Can any forces inside the friction limits balance the wrench? The proof that none can goes to twist[6] (SI) and has
 * passed pinch_statics_proves_infeasible. */
pinch_feasibility pinch_static_feasibility(const pinch_static_model *model, const pinch_grasp *grasp,
                                           const pinch_statics_settings *settings, double twist[6]);

#endif
