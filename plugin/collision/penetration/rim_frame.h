/* Two round cores in the frame of their axes: z along A's, y across both, x across y and z. */
#ifndef PINCH_FINGERTIP_RIM_FRAME_H
#define PINCH_FINGERTIP_RIM_FRAME_H

#include "collision/shape/contact_normal.h"

typedef struct pinch_rim_frame {
    const pinch_core_pair *pair;
    double axis[3][3];   /* x, y and z in A's axes */
    double sine, cosine; /* B's axis is (sine, 0, cosine); sine >= 0 */
    double m[3];         /* from A's middle to B's */
} pinch_rim_frame;

/* False where the axes are parallel: no rims meet but along caps and sides. */
bool pinch_rim_frame_of(const pinch_core_pair *pair, pinch_rim_frame *frame);

/* A cap in the sum of two discs: how far the other rim's point is inside its border, and the overlap along its normal,
 * both of these rims alone. */
typedef struct pinch_rim_cap {
    double inside, overlap;
} pinch_rim_cap;

/* A's cap and B's on these sides along both axes (the signs of the normal's parts along them). */
void pinch_rim_caps(const pinch_rim_frame *frame, const int side[2], pinch_rim_cap caps[2]);

/* Is the overlap of these rims at least `limit`, from the cap's normal to the angle of this cosine (>= 0) and sine from
 * it? The flat disc around the point bounds it (face_first.c) by overlap cos t + inside sin t, which is concave. */
static inline bool pinch_rim_cap_is_less(const pinch_rim_cap *cap, double cosine, double sine, double limit)
{
    return cap->inside > 0 && cap->overlap >= limit && cosine >= 0 &&
           cap->overlap * cosine + cap->inside * sine >= limit;
}

/* Newton's method for the rims on these sides, from n (unit, in the frame), which it moves; takes what it ends in, if
 * that is less. Gives up next to `known` (unit, in the frame; may be NULL): it would end there. False where the end is
 * not between these rims or it has not settled. */
bool pinch_descend_on_rims(const pinch_rim_frame *frame, const int side[2], const double *known, double n[3],
                           pinch_contact_normal *best);

#endif
