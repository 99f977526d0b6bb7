/* What the layer keeps under its one lock. */
#ifndef PINCH_DROPIN_STATE_H
#define PINCH_DROPIN_STATE_H

#include "dropin/layer.h"
#include "dropin/registry.h"

/*
 * The lock is held for moments and never while ODE is called: where ODE is interposed, it calls back. A world's plugin
 * belongs to whoever made its world busy under the lock.
 */
typedef struct pinch_layer_state {
    pinch_registry registry;
    pinch_ode_settings settings;
} pinch_layer_state;

pinch_layer_state *pinch_layer_lock(void);
/* Returns NULL where somebody has the lock. */
pinch_layer_state *pinch_layer_try_lock(void);
void pinch_layer_unlock(void);

/* ODE's own functions */
const pinch_layer_calls *pinch_layer_own(void);

/*
 * Tells whether a contact of this mode is ODE's from the start, and counts it where it is. That is so outside of
 * settings.scope as long as no geom has a material. Takes no lock and hardly any time, because a program whose contacts
 * are all out of scope should not pay for Pinch.
 */
bool pinch_layer_is_out_of_scope(int mode);
/* Returns how many there were. */
long pinch_layer_out_of_scope(void);
void pinch_layer_reset_out_of_scope(void);
/* To be called under the lock when the settings have changed, or which geoms have a material. */
void pinch_layer_update_scope(void);

/* Tells whether Pinch is stepping this world in this thread. Contacts made for it and steps of it are then Pinch's own.
 */
bool pinch_layer_is_inside(dWorldID world);
/* Notes the world that Pinch steps in this thread from here on, and returns the one before; NULL for none. */
dWorldID pinch_layer_enter(dWorldID world);
/* steps.c: makes the world's plugin where there is none, for whoever has made the world busy. Returns false when memory
 * runs out. */
bool pinch_layer_have_plugin(pinch_live_world *live, const pinch_ode_settings *settings);
/* steps.c: ends the world's being busy, forgets geoms destroyed meanwhile in other threads or in callbacks, and adds
 * `done`, which may be NULL, to the world's statistics. Takes the lock. */
void pinch_layer_release(pinch_live_world *live, const pinch_dropin_stats *done);
/* lives.c: notes a joint that is no contact joint, and returns it. */
dJointID pinch_layer_note_joint(dWorldID world, dJointGroupID group, dJointID joint);
/* lives.c: forgets something in a world that is not busy. To be called under the lock. */
void pinch_layer_forget(pinch_live_world *live, const pinch_layer_gone *gone);
/* lives.c: a joint that is no contact joint is destroyed. To be called under the lock. */
void pinch_layer_joint_gone(pinch_live_world *live, dJointID joint);

#endif
