/* The parts of two cores' surfaces at a contact: `which` 0 is A's at -n, 1 is B's at n; all in A's axes. */
#ifndef PINCH_FINGERTIP_CONTACT_PARTS_H
#define PINCH_FINGERTIP_CONTACT_PARTS_H

#include "collision/shape/shape_pair.h"
#include "collision/shape/feature.h"
#include "collision/penetration/hull_face_test.h"
#include "touch.h"

/* The direction out of the core, in its own axes. */
void pinch_outward(const pinch_core_pair *pair, int which, const double n[3], double d[3]);

/* What is exactly there, of a face the first corner or of a cap the centre; of hulls it may be known, the face and the
 * corner in it. */
void pinch_exact_part(const pinch_core_pair *pair, int which, const double n[3], const pinch_least_face faces[2],
                      pinch_core_part *part);

/* Is that a face of which one point alone has been given? */
static inline bool pinch_is_known_face(const pinch_core_part *part)
{
    return part->face && part->count == 1;
}

/* All its corners. */
void pinch_all_corners(const pinch_core_pair *pair, int which, const double n[3], const pinch_core_part *known,
                       pinch_core_part *part);

/* The face or line that is nearest to that, `exact` being what is there exactly. */
void pinch_nearest_part(const pinch_core_pair *pair, int which, const double n[3], const pinch_core_part *exact,
                        pinch_core_part *part);

/* The contact point of a point x of core `which` that is `depth` deep along n (skins included, m). */
void pinch_touch_at(const pinch_core_pair *pair, int which, const double x[3], const double n[3], double depth,
                    pinch_touch *touch);

#endif
