#ifndef PINCH_HANDS_INERTIA_H
#define PINCH_HANDS_INERTIA_H

#include "hand.h"

/* Masses, their inertias, and those of solid shapes. */

/* The mass, given in the axes of `frame`, in the axes of the outer frame. */
void mass_in_outer(const hand_pose *frame, const hand_mass *mass, hand_mass *out);
/* sum += more; both in the same frame. */
void mass_add(hand_mass *sum, const hand_mass *more);

/* The eigenvalues of a symmetric matrix in decreasing order, and the eigenvectors as the columns of a rotation. */
void inertia_principal(const double inertia[9], double values[3], double axes[9]);
/* axes * diag(values) * axes^T */
void inertia_from_principal(const double values[3], const double axes[9], double inertia[9]);
void inertia_quaternion(const double axes[9], double q[4]);

/* Is there a body with this inertia? Its moments are not negative, and none is larger than the sum of the other two by
 * more than this part. */
bool inertia_is_possible(const double inertia[9], double part);
/* Inertias come as decimal numbers of a few digits. A body as thin as a sheet has one moment equal to the sum of the
 * other two, and rounding may put it above by this part of it. */
static const double INERTIA_DIGITS = 1e-5;

/* The volume (m^3) of a solid geom that is no mesh, or its surface (m^2) where `shell` is true; and the moments of
 * inertia at mass 1 about its axes. */
double geom_volume(hand_geom_type type, const double size[3], bool shell);
void geom_moments(hand_geom_type type, const double size[3], bool shell, double moments[3]);

#endif
