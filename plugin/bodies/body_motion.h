/*
 * The motion of a body that nothing ties to others: forces, velocities, a new pose.
 *
 * Where Pinch has found all forces on a body, joints included, what is left for ODE is to integrate, one body after the
 * other. This does the same, to the bit, and by as many threads as there are islands. dWorldStep and dWorldQuickStep
 * differ in how they solve joints alone; a body without any moves alike under both.
 */
#ifndef PINCH_BODIES_BODY_MOTION_H
#define PINCH_BODIES_BODY_MOTION_H

#include <ode/ode.h>
#include <stdbool.h>

/* ODE keeps the inverse of an inertia and does not show it. It is computed again only where the inertia is another. */
typedef struct pinch_inverse_inertia {
    bool known;
    dMatrix3 inertia, inverse; /* in the body's frame */
} pinch_inverse_inertia;

/* Tells whether the body is awake and stays so. Others are not moved here: ODE counts their idle steps. */
bool pinch_body_stays_awake(dBodyID body);
/* Tells whether, besides, ODE's step would do nothing with the body but integrate. Joints before first_joint are known
 * to be disabled. */
bool pinch_body_moves_alone(dBodyID body, int first_joint);

/*
 * Does to the body what ODE's step of h seconds does, but for telling its geoms, which pinch_tell_geoms does, and its
 * moved callback. It touches nothing but the body, so that each body may be moved by a thread of its own.
 */
void pinch_move_body(dBodyID body, const double gravity[3], double h, pinch_inverse_inertia *inverse);

/* Tells the body's geoms, and the spaces that they are in, that it has moved. In simple and hash spaces the order in
 * which geoms are told decides about that of pairs. */
void pinch_tell_geoms(dBodyID body);

#endif
