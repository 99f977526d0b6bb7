/* The contact normal of two cores: the unit vector of least overlap. */
#ifndef PINCH_FINGERTIP_CONTACT_NORMAL_H
#define PINCH_FINGERTIP_CONTACT_NORMAL_H

#include "shape_pair.h"

typedef struct pinch_contact_normal {
    double normal[3]; /* unit, into A */
    double overlap;   /* of the cores along it, skins left out, m */
} pinch_contact_normal;

/* Takes n, if the overlap along it is less. */
static inline void pinch_offer_normal(const pinch_core_pair *pair, const double n[3], pinch_contact_normal *best)
{
    double overlap = pinch_pair_overlap(pair, n);
    if (!(overlap < best->overlap)) return;
    best->overlap = overlap;
    for (int i = 0; i < 3; i++) best->normal[i] = n[i];
}

/* An axis, and how far both bodies, each its own mirror image, reach along it together; the normal is the one of +-n
 * that leads from B's middle towards A's. Taken if better by `bonus`. */
static inline void pinch_offer_axis(const pinch_core_pair *pair, const double n[3], double reach, double bonus,
                                    pinch_contact_normal *best)
{
    double along = n[0] * pair->p[0] + n[1] * pair->p[1] + n[2] * pair->p[2], overlap = reach - fabs(along);
    if (!(overlap < best->overlap - bonus)) return;
    double sign = along > 0 ? -1 : 1;
    best->overlap = overlap;
    for (int i = 0; i < 3; i++) best->normal[i] = sign * n[i];
}

#endif
