/* The resultant shear and torsion of a manifold, which live on when its points change. */
#ifndef PINCH_PLUGIN_MANIFOLD_SHEAR_H
#define PINCH_PLUGIN_MANIFOLD_SHEAR_H

#include "contacts/manifold.h"

/*
 * The shear state of a set of points that share one stiffness equally, about its centre: mean displacement, mean moment
 * of the displacements about the mean normal, mean twist, mean squared radius.
 */
typedef struct pinch_shear_state {
    double centre[3], normal[3], mean[3];
    double moment, twist, radius2;
} pinch_shear_state;

pinch_shear_state pinch_shear_of(const pinch_manifold_point *points, int count);

/*
 * Carries the resultant over to a changed set: new points take the rigid shear that fits the old ones best (least
 * squares: mean and moment), then all points get the rigid shear that restores the resultant force and the moment about
 * the normal exactly. `old` is the state before, `added` how many points at the end are new.
 */
void pinch_shear_carry_over(pinch_manifold *m, int added, const pinch_shear_state *old, double merge_distance);

#endif
