/*
 * What the macros of <pinch/ode_dropin.h> stand for. Each function is defined by its name in ODE, which its macro turns
 * into the name in Pinch.
 */
#include "dropin/calls.h"
#include "dropin/layer.h"

#define DEFINE_VALUE(type, name, ode_name, parameters, arguments)                                                      \
    type ode_name parameters                                                                                           \
    {                                                                                                                  \
        return pinch_layer_##name arguments;                                                                           \
    }
#define DEFINE_VOID(name, ode_name, parameters, arguments)                                                             \
    void ode_name parameters                                                                                           \
    {                                                                                                                  \
        pinch_layer_##name arguments;                                                                                  \
    }

/* The header's macros agree with the table: a macro that is missing or misspelt leaves a name undeclared here. */
#define PASTE(a, b)                              a##b
#define EXPAND_AND_PASTE(a, b)                   PASTE(a, b)
#define NAME_IN_PINCH(name, ode_name, ...)       in_table_pinch_dropin_##name,
#define NAME_OF_VALUE(type, name, ode_name, ...) NAME_IN_PINCH(name, ode_name, )
#define CHECK_MACRO(name, ode_name, ...)                                                                               \
    _Static_assert(EXPAND_AND_PASTE(in_table_, ode_name) == in_table_pinch_dropin_##name, "macro of " #name);
#define CHECK_MACRO_OF_VALUE(type, name, ode_name, ...) CHECK_MACRO(name, ode_name, )
enum { PINCH_DROPIN_CALLS(NAME_OF_VALUE, NAME_IN_PINCH) PINCH_DROPIN_OLDER_CALLS(NAME_IN_PINCH) };
PINCH_DROPIN_CALLS(CHECK_MACRO_OF_VALUE, CHECK_MACRO)
PINCH_DROPIN_OLDER_CALLS(CHECK_MACRO)

PINCH_DROPIN_CALLS(DEFINE_VALUE, DEFINE_VOID)
PINCH_DROPIN_OLDER_CALLS(DEFINE_VOID)
