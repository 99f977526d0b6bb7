#ifndef PINCH_FINGERTIP_SEPARATING_AXES_H
#define PINCH_FINGERTIP_SEPARATING_AXES_H

#include "contact_normal.h"

/* Over all axes at which the overlap of two polytopes can be least; false where there are more edges than there is room
 * for. */
bool pinch_separating_axes(const pinch_core_pair *pair, pinch_contact_normal *best);

#endif
