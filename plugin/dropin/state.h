/* What the layer keeps, under its one lock. */
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
void pinch_layer_unlock(void);

/* ODE's own functions */
const pinch_layer_calls *pinch_layer_own(void);

/*
 * Is a contact of this mode ODE's from the start? So it is outside of settings.scope as long as no geom has a material.
 * Counts it where it is. Takes no lock, and only the time of a look: where nothing is in scope, nothing is to be paid.
 */
bool pinch_layer_is_out_of_scope(int mode);
long pinch_layer_out_of_scope(void); /* how many there were */
void pinch_layer_reset_out_of_scope(void);
/* After the settings, or which geoms have a material, have changed; under the lock. */
void pinch_layer_update_scope(void);

/* Tells whether Pinch is stepping this world in this thread. Contacts made for it and steps of it are then Pinch's own.
 */
bool pinch_layer_is_inside(dWorldID world);
/* Notes the world that Pinch steps in this thread from here on, and returns the one before; NULL for none. */
dWorldID pinch_layer_enter(dWorldID world);
/* steps.c: the world's plugin, made where there is none; false: no memory. For whoever has made it busy. */
bool pinch_layer_have_plugin(pinch_live_world *live, const pinch_ode_settings *settings);
/* steps.c: the world is busy no more; geoms destroyed meanwhile, in other threads or in callbacks, are forgotten. Adds
 * `done` (or NULL) to the world's statistics. Takes the lock. */
void pinch_layer_release(pinch_live_world *live, const pinch_dropin_stats *done);
/* lives.c, under the lock, of a world that is not busy */
void pinch_layer_forget_geom(pinch_live_world *live, dGeomID geom);

#endif
