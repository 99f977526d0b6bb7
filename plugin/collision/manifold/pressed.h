/* A pad pressed on a superellipsoid where that is flat: middle and spread of the pressure. */
#ifndef PINCH_FINGERTIP_PRESSED_H
#define PINCH_FINGERTIP_PRESSED_H

#include "collision/shape/convex_shape.h"

/* In the core's axes. The pad's surface sinks away from the plane at right angles to d by slope.(y - highest) at y. */
typedef struct pinch_pressed {
    const pinch_core *core;
    double d[3], x[3]; /* the plane touches the core at x, the point farthest along d */
    double t[2][3];    /* unit, in the plane, at right angles to each other */
    double depth;      /* m, to which the core is pressed in there */
    double slope[3];   /* in the plane; 0: the pad is parallel to it */
    double highest[3]; /* where the pad meets the plane; of no matter without a slope */
} pinch_pressed;

/* How far the pad reaches from r, a point of the plane, along the unit vector t of it; NULL: for ever. */
typedef void (*pinch_pad_bounds)(const void *pad, const double r[3], const double t[3], double *low, double *high);

/* A parallel pad at the unit vector d. False for cores that have no flat spots, or have faces for them. */
bool pinch_press(const pinch_core *core, const double d[3], double depth, pinch_pressed *pressed);

/* Four points in the plane that stand for the pressure. */
void pinch_pressed_points(const pinch_pressed *pressed, pinch_pad_bounds bounds, const void *pad, double points[4][3]);

/* Two along t[0], for a pad that is a line there through r, a point of the plane. */
void pinch_pressed_line(const pinch_pressed *pressed, const double r[3], double low, double high, double points[2][3]);

#endif
