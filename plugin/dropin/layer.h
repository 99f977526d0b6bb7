/*
 * The drop-in layer: what an ODE program calls, with Pinch in between. One layer serves the header's macros and the
 * preloaded library; they differ in where ODE's own functions are found.
 */
#ifndef PINCH_DROPIN_LAYER_H
#define PINCH_DROPIN_LAYER_H

#include "dropin/calls.h"

#include <pinch/ode_dropin.h>

/* ODE's own functions, as members ode_joint_attach and so on. */
#define PINCH_LAYER_VALUE_MEMBER(type, name, ode_name, parameters, arguments) type(*ode_##name) parameters;
#define PINCH_LAYER_VOID_MEMBER(name, ode_name, parameters, arguments)        void(*ode_##name) parameters;
typedef struct pinch_layer_calls {
    PINCH_DROPIN_CALLS(PINCH_LAYER_VALUE_MEMBER, PINCH_LAYER_VOID_MEMBER)
    void (*stepped)(void); /* called after each step that the statistics count; may be NULL */
    /* Called once for a world, when something in it was first left to ODE for more than a step; may be NULL. */
    void (*backed_off)(long step);
} pinch_layer_calls;

/* To be called before any other function of the layer. The table must stay. */
void pinch_layer_set_calls(const pinch_layer_calls *calls);

/* What the layer does in their place: pinch_layer_joint_attach and so on. */
#define PINCH_LAYER_VALUE(type, name, ode_name, parameters, arguments) type pinch_layer_##name parameters;
#define PINCH_LAYER_VOID(name, ode_name, parameters, arguments)        void pinch_layer_##name parameters;
PINCH_DROPIN_CALLS(PINCH_LAYER_VALUE, PINCH_LAYER_VOID)
PINCH_DROPIN_OLDER_CALLS(PINCH_LAYER_VOID)

/* statistics.c */
void pinch_layer_add_plugin_stats(pinch_ode_stats *sum, const pinch_ode_stats *more);
void pinch_layer_add_stats(pinch_dropin_stats *sum, const pinch_dropin_stats *more);
/* Allocates nothing and takes no lock, after the first call of pinch_layer_plain_numbers. */
int pinch_layer_write_statistics(const pinch_dropin_stats *stats, const pinch_ode_settings *settings, char *text,
                                 size_t size);

/* Prepares numbers with a decimal point, whatever the program's language. Returns false when memory runs out. */
bool pinch_layer_plain_numbers(void);

/* readout.c: for the handler of a signal. Returns false where the layer is at work just then. */
bool pinch_layer_statistics_now(pinch_dropin_stats *stats, pinch_ode_settings *settings);

#endif
