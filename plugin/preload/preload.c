/*
 * What `pinch exec` loads before a program's other libraries: the functions of ODE's that the drop-in layer stands
 * behind, and the one that closes ODE. Nothing else is exported.
 */
#define _GNU_SOURCE /* RTLD_NOLOAD */
#define PINCH_DROPIN_NO_MACROS

#include "dropin/calls.h"
#include "dropin/layer.h"
#include "preload/report.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

static pinch_layer_calls own;
static void (*destroy_world)(dWorldID world);
static void (*close_ode)(void);
static pthread_once_t once = PTHREAD_ONCE_INIT;
static atomic_bool found;

/* POSIX has a function's address be a void *. */
static void find(void *library, const char *name, void *function)
{
    void *address = dlsym(library, name);
    if (!address) abort(); /* no libode.so.8 is without them */
    memcpy(function, &address, sizeof address);
}

static void destroy_world_and_report(dWorldID world)
{
    destroy_world(world);
    pinch_report_sometimes();
}

#define FIND_VALUE(type, name, ode_name, parameters, arguments) find(library, #ode_name, &own.ode_##name);
#define FIND_VOID(name, ode_name, parameters, arguments)        find(library, #ode_name, &own.ode_##name);

/* RTLD_NEXT would not see an ODE that came with a dlopen of local scope. */
static void find_ode(void)
{
    void *library = dlopen("libode.so.8", RTLD_LAZY | RTLD_NOLOAD);
    if (!library) library = dlopen("libode.so.8", RTLD_LAZY);
    if (!library) abort(); /* this library is linked with it */
    PINCH_DROPIN_CALLS(FIND_VALUE, FIND_VOID)
    find(library, "dCloseODE", &close_ode);
    destroy_world = own.ode_world_destroy;
    own.ode_world_destroy = destroy_world_and_report;
    pinch_layer_set_calls(&own);
    pinch_report_start();
    atomic_store_explicit(&found, true, memory_order_release);
}

/* Other libraries' constructors may call ODE before this one's has run. */
__attribute__((constructor)) static void ready(void)
{
    if (!atomic_load_explicit(&found, memory_order_acquire)) (void)pthread_once(&once, find_ode);
}

__attribute__((destructor)) static void leave(void)
{
    pinch_report_end();
}

/* Programs have crashed while ODE closes, and after it. */
static void report_and_close(void)
{
    pinch_report_now();
    close_ode();
}

#define PRELOADED __attribute__((visibility("default")))

#define PRELOAD_VALUE(type, name, ode_name, parameters, arguments)                                                     \
    PRELOADED type ode_name parameters                                                                                 \
    {                                                                                                                  \
        ready();                                                                                                       \
        return pinch_layer_##name arguments;                                                                           \
    }
#define PRELOAD(function, ode_name, parameters, arguments)                                                             \
    PRELOADED void ode_name parameters                                                                                 \
    {                                                                                                                  \
        ready();                                                                                                       \
        function arguments;                                                                                            \
    }
#define PRELOAD_VOID(name, ode_name, parameters, arguments) PRELOAD(pinch_layer_##name, ode_name, parameters, arguments)

PINCH_DROPIN_CALLS(PRELOAD_VALUE, PRELOAD_VOID)
PINCH_DROPIN_OLDER_CALLS(PRELOAD_VOID)
PRELOAD(report_and_close, dCloseODE, (void), ())
