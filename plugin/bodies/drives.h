/* Bodies under force control: kinematic bodies that are driven along an axis without inertia. */
#ifndef PINCH_BODIES_DRIVES_H
#define PINCH_BODIES_DRIVES_H

#include "util/list.h"

#include <pinch/ode.h>

typedef struct pinch_drive {
    dBodyID body;
    double axis[3], force; /* unit, world; N */
    double speed;          /* along the axis, as solved for in the last step, m/s */
} pinch_drive;

typedef struct pinch_drives {
    pinch_drive *items;
    int count, room;
    pinch_item_index index;
} pinch_drives;

/* Returns the index of a body's drive, -1 where it has none. */
int pinch_drive_of(const pinch_drives *drives, dBodyID body);
/* As pinch_ode_set_drive. *changed tells whether a drive came, went or has other values now. */
pinch_status pinch_drives_set(pinch_drives *drives, dBodyID body, const double axis[3], double force, bool *changed);
/* Puts a driven body back to the velocity that its owner prescribed. */
void pinch_drive_stop(const pinch_drive *drive);

#endif
