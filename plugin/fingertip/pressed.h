#ifndef PINCH_FINGERTIP_PRESSED_H
#define PINCH_FINGERTIP_PRESSED_H

#include "core.h"

/* Where a plane at right angles to `d` touches a core, and two directions in the plane; `low` and `high` bound what of
 * the plane there is, from `x` along each (m). In the core's axes. */
typedef struct pinch_pressed {
    double d[3], x[3], t[2][3];
    double low[2], high[2];
} pinch_pressed;

/* The plane without bounds at the unit vector d. False for cores that have no flat spots, or have faces for them. */
bool pinch_press(const pinch_core *core, const double d[3], pinch_pressed *at);

/* Four points in the plane that stand for the pressure of a pad pressed in by `depth` (m, > 0): they have its middle
 * and its spread. */
void pinch_pressed_points(const pinch_core *core, const pinch_pressed *at, double depth, double points[4][3]);

/* Two along t[0] alone, for the side of a cylinder or an edge. */
void pinch_pressed_line(const pinch_core *core, const pinch_pressed *at, double depth, double points[2][3]);

#endif
