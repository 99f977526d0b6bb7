#ifndef PINCH_COLLISION_REFINE_H
#define PINCH_COLLISION_REFINE_H

#include "collision/distance/distance.h"
#include "collision/shape/shape_pair.h"

/* Improves a normal near the optimum with Newton's method. `simplex` is GJK's last, or NULL. The overlap becomes no
 * larger, except by rounding. Returns true where the search has ended: Newton's method has settled, or a face gives the
 * normal. */
bool pinch_refine_normal(const pinch_shape_pair *pair, const pinch_gjk_result *simplex, pinch_contact_normal *best);

#endif
