/*
 * The persistent manifold of one pair of geoms: contact points that live on from step to step with their elastic state.
 *
 * Colliders detect points afresh in each step, and some detect too few of them (ODE's capsule-box finds one, at
 * alternating ends). A detected point near a known one continues it. A known point that was not detected stays while it
 * still penetrates, has not drifted, and the bodies have not tilted against each other since it was last seen; Bullet
 * and PhysX do the same. When points come or go, the pair's resultant shear and torsion are carried over.
 */
#ifndef PINCH_CONTACTS_MANIFOLD_H
#define PINCH_CONTACTS_MANIFOLD_H

#include "contacts/manifold_point.h"

/* The most points of any manifold, and of one whose points share a stiffness. */
enum { PINCH_MANIFOLD_POINTS = 64, PINCH_SHARED_POINTS = 8 };

typedef struct pinch_manifold {
    int count;
    pinch_manifold_point *point;
} pinch_manifold;

/* Returns the weight of all points together: where they share one stiffness, each has its weight's part of it. */
static inline double pinch_manifold_weight(const pinch_manifold *manifold)
{
    double weight = 0;
    for (int k = 0; k < manifold->count; k++) weight += manifold->point[k].weight;
    return weight;
}

/* Does what pinch_manifold_update does where one known point goes on in the only one that was detected, as under most
 * fingertips. Returns false, and does nothing, where that is not so. */
bool pinch_manifold_continue(pinch_manifold *manifold, const pinch_pose pose[2], pinch_detected_point *points,
                             int count, const pinch_manifold_rules *rules);

/*
 * Brings the manifold up to date with the poses and the detected points, however many, and tells those their places;
 * where there are more than it holds, those that span the others (reduction.h). There must be room for
 * PINCH_MANIFOLD_POINTS points, or for the known and the detected ones together.
 */
void pinch_manifold_update(pinch_manifold *manifold, const pinch_pose pose[2], pinch_detected_point *points, int count,
                           const pinch_manifold_rules *rules);

#endif
