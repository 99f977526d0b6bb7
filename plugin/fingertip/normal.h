/* The contact normal of two cores: the unit vector of least overlap. */
#ifndef PINCH_FINGERTIP_NORMAL_H
#define PINCH_FINGERTIP_NORMAL_H

#include "contact_normal.h"
#include "gjk.h"

/* The normal of least overlap; false where the bodies, skins included, are apart. */
bool pinch_find_normal(const pinch_core_pair *pair, pinch_tip_stats *stats, pinch_contact_normal *found);

typedef enum pinch_closed {
    PINCH_CLOSED_UNKNOWN = 0, /* no closed form for this pair as it lies */
    PINCH_CLOSED_FOUND
} pinch_closed;

/* closed.c: pairs whose normal has a closed form */
pinch_closed pinch_closed_normal(const pinch_core_pair *pair, pinch_contact_normal *found);

/* separating_axes.c: over all axes at which the overlap of two polytopes can be least; false where there are more edges
 * than there is room for. */
bool pinch_separating_axes(const pinch_core_pair *pair, pinch_contact_normal *best);

/* refine.c: improves a normal near the optimum with Newton's method; `simplex` from GJK, NULL: none. Never makes the
 * overlap larger. */
void pinch_refine_normal(const pinch_core_pair *pair, const pinch_gjk_result *simplex, pinch_contact_normal *best);

/* deep.c: least overlap of cores that penetrate each other, by descents from many directions. */
void pinch_descend(const pinch_core_pair *pair, pinch_tip_stats *stats, pinch_contact_normal *best);

/* libccd.c: libccd's answer for two cores that overlap; false when it has none. */
bool pinch_ask_libccd(const pinch_core_pair *pair, pinch_tip_stats *stats, double normal[3]);

#endif
