/*
 * What ODE keeps of a hinge and has no getter for: the axis in the frame of its second body.
 *
 * It follows from the relative orientation q0 that the hinge measures its angle from, which ODE takes together with the
 * axes: then they were one, and axis2 = q0^-1 axis1. The angle's getter tells q0: with the quaternions q1 and q2 of the
 * bodies the angle a that it returns has
 *
 *     |cos(a/2)| = |<q1, r>|,   r = q2 q0^-1,
 *
 * so that four orientations of the first body give the four components of r. That body is turned for the getter alone,
 * in ODE's own memory, and put back to the bit. An axis read so that lies more than 2 mrad off the first body's when
 * first seen is not relied on before it comes nearer: the program may have set anchor and axes in different poses, or
 * with an offset, which changes q0 alone.
 */
#ifndef PINCH_PLUGIN_JOINT_REFERENCE_H
#define PINCH_PLUGIN_JOINT_REFERENCE_H

#include <ode/ode.h>
#include <stdbool.h>
#include <stdint.h>

/* Of one hinge, as long as joint, bodies, axis and angle say that it is still the same one. */
typedef struct pinch_joint_reference {
    dJointID joint;
    dBodyID body[2];  /* body[1] NULL: the static world */
    double axis1[3];  /* unit, in the frame of the first body; with `turn` it gives that in the second's */
    dQuaternion turn; /* q0, from the second body's frame to the first's; 0: not known */
    uint32_t seen;    /* the step it was last asked for, its last 32 bits */
    bool reliable;
} pinch_joint_reference;

#endif
