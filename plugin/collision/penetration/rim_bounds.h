/* Bounds on the overlap where two rims meet. */
#ifndef PINCH_FINGERTIP_RIM_CELLS_H
#define PINCH_FINGERTIP_RIM_CELLS_H

#include "rim_frame.h"
#include "side_and_rim.h"

/* A part of the region: which rims, and a range of angles to either axis. */
typedef struct pinch_rim_cell {
    int side[2], piece[2];
    double bound; /* no overlap in it is less */
    double n[3];  /* where the bound is, or near it (unit, in the frame) */
} pinch_rim_cell;

enum { PINCH_RIM_CELLS = 144 }; /* all of them */

/* The parts in which the overlap may be less than `limit`; count. */
int pinch_rim_cells(const pinch_rim_frame *frame, double limit, pinch_rim_cell cells[PINCH_RIM_CELLS]);

/* Does it reach to the normal of A's cap (`which` 0) or B's (1)? */
bool pinch_rim_cell_at_cap(const pinch_rim_cell *cell, int which);

/* Can something straight meet that rim of a body across it (pinch_side_and_rim) with less overlap than `limit`? */
bool pinch_rim_may_beat(const pinch_across *across, const pinch_core *body, int rim, double limit);

#endif
