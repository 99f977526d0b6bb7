#ifndef PINCH_FINGERTIP_H
#define PINCH_FINGERTIP_H

#include <ode/ode.h>
#include <pinch/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * Contact geometry that ODE does not do well enough for a fingertip. ODE's sphere-convex goes through an iterative
 * method that is off by 7e-7 m on a plain face and jumps from step to step; this is exact.
 */

/* A convex polyhedron in the arrays that dCreateConvex takes, in the geom's own coordinates. */
typedef struct pinch_convex {
    const double *planes;     /* 4 per face: unit outward normal, offset (m) */
    unsigned plane_count;     /* >= 4 */
    const double *points;     /* 3 per vertex, m */
    const unsigned *polygons; /* per face: number of corners, then their indices, counter-clockwise from outside */
} pinch_convex;

/*
 * The contact of a sphere and a convex polyhedron: `convex_geom` is the dConvexClass geom made of `convex`'s arrays.
 * Fills *contact with g1 = sphere, g2 = convex_geom: normal into the sphere, depth, position half way through the
 * overlap; returns the number of contacts, 0 or 1. Where the centre is inside, the face that is nearest decides.
 */
PINCH_API int pinch_collide_sphere_convex(dGeomID sphere, dGeomID convex_geom, const pinch_convex *convex,
                                          dContactGeom *contact);

#ifdef __cplusplus
}
#endif
#endif
