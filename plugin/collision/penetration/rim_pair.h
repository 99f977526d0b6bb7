#ifndef PINCH_COLLISION_RIM_PAIR_H
#define PINCH_COLLISION_RIM_PAIR_H

#include "collision/shape/shape_pair.h"
#include "rim_line.h"

/* Two round shapes whose rims meet: the normal has two unknowns. The frame has z along A's axis, y across both axes,
 * and x across y and z. */

typedef struct pinch_rim_frame {
    const pinch_shape_pair *pair;
    double axis[3][3];   /* x, y and z in A's axes */
    double sine, cosine; /* B's axis is (sine, 0, cosine), and sine >= 0 */
    double m[3];         /* from A's middle to B's */
} pinch_rim_frame;

/* Returns false where the axes are parallel. Rims then meet only along caps and sides. */
bool pinch_rim_frame_of(const pinch_shape_pair *pair, pinch_rim_frame *frame);

/* A cap in the Minkowski sum of two discs: how far the other rim's point is inside its border, and the overlap of these
 * two rims along its normal. */
typedef struct pinch_rim_cap {
    double inside, overlap;
} pinch_rim_cap;

/* Finds A's cap and B's on these sides along both axes. The sides are the signs of the normal's components along
 * them. */
void pinch_rim_caps(const pinch_rim_frame *frame, const int side[2], pinch_rim_cap caps[2]);

/* Tells whether the overlap of these rims is at least `limit` from the cap's normal to the angle of this cosine (>= 0)
 * and sine. The flat disc around the point bounds it (see face_test.c) by overlap cos t + inside sin t, which is
 * concave. */
static inline bool pinch_rim_cap_is_less(const pinch_rim_cap *cap, double cosine, double sine, double limit)
{
    return cap->inside > 0 && cap->overlap >= limit && cosine >= 0 &&
           cap->overlap * cosine + cap->inside * sine >= limit;
}

/* A cell is a part of the region of normals: which rims meet, and a range of angles to either axis. */
typedef struct pinch_rim_cell {
    int side[2], piece[2];
    double bound; /* no overlap in the cell is less */
    double n[3];  /* where the bound is taken, or near it (unit, in the frame) */
} pinch_rim_cell;

enum { PINCH_RIM_CELLS = 144 }; /* the number of all cells */

/* Finds the cells in which the overlap may be less than `limit`. Returns their number. */
int pinch_rim_cells(const pinch_rim_frame *frame, double limit, pinch_rim_cell cells[PINCH_RIM_CELLS]);

/* Tells whether the cell extends to the normal of A's cap (`which` 0) or B's (1). */
bool pinch_rim_cell_at_cap(const pinch_rim_cell *cell, int which);

/* Tells whether a straight line can meet that rim of a body across it (pinch_rim_line_normal) with less overlap than
 * `limit`. */
bool pinch_rim_may_beat(const pinch_rim_line *across, const pinch_shape *body, int rim, double limit);

/* Tells whether the overlap of two rims changes by nothing to rounding, as at a minimum. */
bool pinch_rim_pair_is_level(const pinch_shape_pair *pair, const pinch_contact_normal *at);

/* A rim certificate: returns true only if a local minimum of two sharp cylinders' overlap, where two rims meet, is
 * certain to be the least of all. */
bool pinch_rim_pair_certificate(const pinch_shape_pair *pair, const pinch_contact_normal *at);

/* Does the same where the side of A (`which` 0) or B (1) meets the other's rim. */
bool pinch_side_and_rim_certificate(const pinch_shape_pair *pair, int which, const pinch_contact_normal *at);

/* Goes from the normal of a face or side into the region where two rims meet, if that leads down. Returns false where
 * it does and Newton's method has not settled. */
bool pinch_descend_into_rims(const pinch_rim_frame *frame, const pinch_contact_normal *start,
                             pinch_contact_normal *best);

/* Searches all of the region. `from` is the best face or side, from which pinch_descend_into_rims has started
 * already. */
void pinch_search_rim_pairs(const pinch_rim_frame *frame, const pinch_contact_normal *from, pinch_contact_normal *best);

#endif
