/* A corner or a rim's lowest point that alone is pressed into a flat face. */
#ifndef PINCH_FINGERTIP_LONE_POINT_H
#define PINCH_FINGERTIP_LONE_POINT_H

#include "hull_first.h"

/* Whose point that is (0: A's, 1: B's), and the point in A's axes; -1: there is more to be looked at. `depth`: of the
 * point, skins included (m). */
int pinch_lone_point(const pinch_core_pair *pair, const pinch_contact_normal *normal, const pinch_least_face faces[2],
                     double depth, double point[3]);

#endif
