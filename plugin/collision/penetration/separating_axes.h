#ifndef PINCH_FINGERTIP_SEPARATING_AXES_H
#define PINCH_FINGERTIP_SEPARATING_AXES_H

#include "hull_face_test.h"

/* Over all axes at which the overlap of two polytopes can be least; false where there are more edges than there is room
 * for. `faces`: those of a pair with a hull, and `best` the better one (pinch_hull_first); NULL for others. */
bool pinch_separating_axes(const pinch_core_pair *pair, pinch_least_face *faces, pinch_contact_normal *best);

#endif
