/*
 * The persistent manifold of one geom pair: contact points that live on from step to step with their elastic state.
 *
 * Colliders return points afresh each step, some too few (ODE's capsule-box one, at alternating ends). A fresh point
 * near a known one continues it; a known point that was not returned stays while it still penetrates, has not drifted
 * and the bodies have not tilted against each other since it was last seen. (The technique of Bullet and PhysX.) When
 * points come or go, the pair's resultant shear and torsion are carried over.
 */
#ifndef PINCH_PLUGIN_MANIFOLD_H
#define PINCH_PLUGIN_MANIFOLD_H

#include "contacts/surface.h"

#include <stdbool.h>

enum {
    PINCH_MANIFOLD_POINTS = 8,
    PINCH_MANIFOLD_FRESH = 64 /* of one pair in one step; what a collider returns beyond is not looked at */
};

/* Position and rotation (ODE's 3 x 4 rows) of a geom. */
typedef struct pinch_pose {
    const double *position, *rotation;
} pinch_pose;

/* A contact point as a collider returns it, already in the pair's canonical order. */
typedef struct pinch_fresh_point {
    double position[3], normal[3]; /* m; unit, into geom 1 */
    double depth;                  /* m */
    int taken;                     /* index of the contact that was handed over */
    int point;                     /* out: its place in the manifold, -1: none */
} pinch_fresh_point;

/* What a point of a pair without a material has besides. */
typedef struct pinch_own_law {
    double tangent1[3];   /* the first friction direction when it was last handed over, world */
    double compliance[3]; /* see pinch_contact */
    double floor;
    int hold;
    int surface; /* index of its surface parameters */
} pinch_own_law;

/* And one whose surface has rolling friction, behind its own law. */
typedef struct pinch_rolling {
    double rolled[3], moment[3]; /* elastic rotation and last moment about the tangents, world, rad, N m */
} pinch_rolling;

typedef struct pinch_manifold_point {
    double anchor[2][3];      /* the touching points in the two geoms' frames */
    double seen_normal[2][3]; /* the normal in the two geoms' frames when the collider last returned the point */
    double position[3], normal[3], depth;
    double elastic[3];  /* elastic tangential displacement, world, m */
    double twist;       /* elastic rotation about the normal, rad */
    double friction[3]; /* last friction force on body 1, world, N: the warm start */
    double normal_force, torsion;
    bool slipping;      /* in the last step: kinetic friction counts */
    bool rolls;         /* `own` is followed by a pinch_rolling */
    pinch_own_law *own; /* NULL: the pair has a material, or the point is new */
} pinch_manifold_point;

/* NULL: it has no rolling friction */
static inline pinch_rolling *pinch_rolling_of(const pinch_manifold_point *point)
{
    return point->rolls ? (pinch_rolling *)(point->own + 1) : NULL;
}

typedef struct pinch_manifold {
    int count;
    pinch_manifold_point *point;
} pinch_manifold;

/*
 * Brings the manifold up to date with the poses and the fresh points, at most PINCH_MANIFOLD_FRESH, and tells those
 * their places. There must be room for PINCH_MANIFOLD_POINTS points, or for those there are and the fresh ones.
 * Distances in m. steady: where bodies have moved against each other by less than this since the last step, their
 * points stay; 0: each goes to where the collider finds it. most: points at most, 1 to PINCH_MANIFOLD_POINTS. shared:
 * its points share one stiffness, and the resultant shear lives on when they change; otherwise new points start without
 * any.
 */
void pinch_manifold_update(pinch_manifold *manifold, const pinch_pose pose[2], pinch_fresh_point *points,
                           int point_count, double merge_distance, double steady, double stale_tilt, bool shared,
                           int most);

#endif
