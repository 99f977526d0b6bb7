#ifndef PINCH_FINGERTIP_WRITE_CONTACTS_H
#define PINCH_FINGERTIP_WRITE_CONTACTS_H

#include "touches.h"

/* As ODE's contacts, `skip` bytes apart, at most `room`; returns how many. */
int pinch_write_contacts(const pinch_tip_touches *touches, dGeomID g1, dGeomID g2, int room, dContactGeom *contacts,
                         int skip);

#endif
