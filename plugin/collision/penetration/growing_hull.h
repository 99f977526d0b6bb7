/* The convex hull of points that come one by one. */
#ifndef PINCH_FINGERTIP_GROWING_HULL_H
#define PINCH_FINGERTIP_GROWING_HULL_H

#include <stdbool.h>

enum { PINCH_HULL_POINTS = 320, PINCH_HULL_FACETS = 2 * PINCH_HULL_POINTS };

typedef struct pinch_hull_point {
    double x[3];
    double source[3]; /* the caller's: what the point is made of */
} pinch_hull_point;

/* A triangle, its corners counter-clockwise from outside; beside[k] is across the edge from corner k to the next. */
typedef struct pinch_hull_facet {
    int corner[3], beside[3];
    double normal[3]; /* unit, outward */
    double offset;    /* of its plane, along the normal; DBL_MAX: not part of the hull */
} pinch_hull_facet;

typedef struct pinch_growing_hull {
    double size; /* of all that may come, m: points to rounding in a facet's plane are in it */
    int points, facets, unused_count;
    int unused[PINCH_HULL_FACETS]; /* places of facets that are gone */
    pinch_hull_point point[PINCH_HULL_POINTS];
    pinch_hull_facet facet[PINCH_HULL_FACETS];
} pinch_growing_hull;

/* The hull of up to PINCH_HULL_POINTS points; false where they are as good as in one plane. */
bool pinch_hull_begin(pinch_growing_hull *hull, double size, const pinch_hull_point *points, int count);

/* Adds a point that is outside the facet. False: no room, or rounding spoils the hull. */
bool pinch_hull_add(pinch_growing_hull *hull, int facet, const pinch_hull_point *point);

/* The facet whose plane has the least offset; -1: none. */
int pinch_hull_nearest(const pinch_growing_hull *hull);

#endif
