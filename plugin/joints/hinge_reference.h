/*
 * What ODE keeps of a hinge and has no getter for: the axis in the frame of its second body, for hinges of which
 * joint_pose.h has noted nothing.
 *
 * The axis follows from the relative orientation q0 that the hinge measures its angle from, and that ODE takes together
 * with the axes: at that moment they were one, and axis2 = q0^-1 axis1. The angle's getter tells q0: with the
 * quaternions q1 and q2 of the bodies the angle a that it returns has
 *
 *     |cos(a/2)| = |<q1, r>|,   r = q2 q0^-1,
 *
 * so that four orientations of the first body give the four components of r. That body is turned for the getter alone,
 * in ODE's own memory, and put back to the bit. An axis found so that lies more than 2 mrad off the first body's when
 * first seen is not relied on before it comes nearer: the program may have set anchor and axes in different poses, or
 * with an offset, which changes q0 alone.
 */
#ifndef PINCH_JOINTS_HINGE_REFERENCE_H
#define PINCH_JOINTS_HINGE_REFERENCE_H

#include "util/key_map.h"
#include "util/list.h"

#include <ode/ode.h>

/* It belongs to one hinge as long as joint, bodies, axis and angle say that this is still the same one. */
typedef struct pinch_hinge_reference {
    dJointID joint;
    dBodyID body[2];  /* body[1] NULL: the static world */
    double axis1[3];  /* unit, in the frame of the first body; with `turn` it gives that in the second's */
    dQuaternion turn; /* q0, from the second body's frame to the first's; 0: not known */
    uint32_t seen;    /* the step it was last asked for, its last 32 bits */
    bool reliable;
} pinch_hinge_reference;

typedef struct pinch_hinge_references {
    pinch_hinge_reference *items;
    int count, room;
    pinch_item_index index;
} pinch_hinge_references;

/*
 * To find the axis, the joint's first body `body` is turned for a moment, and a kinematic body may belong to several
 * islands. So the reference of a hinge on a kinematic body is updated when it is added, by one thread; that of a hinge
 * on a dynamic body when its axis is asked for, by the thread that has its island.
 */

/* Finds or adds the reference of a hinge; *reference is -1 for other joints. Returns false when memory runs out. */
bool pinch_add_hinge_reference(pinch_hinge_references *references, dJointID joint, dBodyID body, long step,
                               int *reference);
/* Updates the reference of a hinge on a kinematic body in a step in which it is not added. */
void pinch_update_hinge(pinch_hinge_references *references, int reference, long step);
/* Keeps a reference, if there is one, that was not asked for up to this step because nothing has changed. */
void pinch_keep_hinge_reference(pinch_hinge_references *references, int reference, long step);
/* Returns the axis in the second body's frame, in axis2; NULL where it is not known or not reliable. */
const double *pinch_hinge_reference_axis(pinch_hinge_references *references, int reference, dBodyID body, long step,
                                         double axis2[3]);
/* Takes back what is known of hinges on bodies, or of a hinge. */
void pinch_hinge_references_forget_bodies(pinch_hinge_references *references, const pinch_key_map *bodies);
void pinch_hinge_references_forget_joint(pinch_hinge_references *references, dJointID joint);
/* Drops references that nobody has asked for in a long time. Returns false when memory runs out. */
bool pinch_sweep_hinge_references(pinch_hinge_references *references, long step);

#endif
