/*
 * What `pinch exec` loads before a program's other libraries: the functions of ODE's that the drop-in layer stands
 * behind, and the one that closes ODE. Nothing else is exported.
 *
 * ODE is looked for when the program first calls one of them. Where it is an ODE that Pinch cannot work with, every
 * call goes to it as it came.
 */
#define _GNU_SOURCE /* RTLD_NEXT, dladdr */
#define PINCH_DROPIN_NO_MACROS

#include "dropin/calls.h"
#include "dropin/layer.h"
#include "preload/ode_functions.h"
#include "preload/report.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define OLDER_MEMBER(name, ode_name, parameters, arguments) void(*ode_##name) parameters;
typedef struct ode_calls {
    pinch_layer_calls layer;
    PINCH_DROPIN_OLDER_CALLS(OLDER_MEMBER)
    void (*ode_close)(void);
} ode_calls;

static ode_calls own;
static void (*destroy_world)(dWorldID world);
static pthread_mutex_t finding = PTHREAD_MUTEX_INITIALIZER;
static enum { NOT_LOOKED_FOR, SERVED, PASSED_ON } ode_is;
static atomic_int known; /* what ode_is, for those that read it without the lock */

static void destroy_world_and_report(dWorldID world)
{
    destroy_world(world);
    pinch_report_sometimes();
}

/*
 * Returns where the caller has ODE from: all that the program was started with, in the order in which its own calls are
 * resolved; the library that the caller is in, with those that it needs, where that was opened later; or libode.so.8,
 * whoever opened that.
 */
static void *library_of(void *caller)
{
    Dl_info info;
    if (dlsym(RTLD_NEXT, "dWorldCreate")) return RTLD_NEXT;
    void *library = dladdr(caller, &info) && info.dli_fname ? dlopen(info.dli_fname, RTLD_LAZY | RTLD_NOLOAD) : NULL;
    if (library && dlsym(library, "dWorldCreate")) return library;
    return dlopen("libode.so.8", RTLD_LAZY | RTLD_NOLOAD);
}

/* POSIX has a function's address be a void *. Returns false where the library has no such function. */
static bool find(void *library, const char *name, void *function)
{
    void *address = dlsym(library, name);
    memcpy(function, &address, sizeof address);
    return address;
}

#define FIND(place, ode_name)                                                                                          \
    if (!find(library, #ode_name, place) && !missing) missing = #ode_name;
#define FIND_VALUE(type, name, ode_name, parameters, arguments) FIND(&own.layer.ode_##name, ode_name)
#define FIND_VOID(name, ode_name, parameters, arguments)        FIND(&own.layer.ode_##name, ode_name)
#define FIND_OLDER(name, ode_name, parameters, arguments)       FIND(&own.ode_##name, ode_name)

/* Returns the name of a function that Pinch needs and the library does not have; NULL: it has all of them. */
static const char *find_functions(void *library)
{
    const char *missing = pinch_ode_functions_find(library);
    PINCH_DROPIN_CALLS(FIND_VALUE, FIND_VOID)
    PINCH_DROPIN_OLDER_CALLS(FIND_OLDER)
    FIND(&own.ode_close, dCloseODE)
    return missing;
}

/* Numbers of ODE's are of eight bytes here. */
static bool is_double(void *library)
{
    int (*check)(const char *token);
    return find(library, "dCheckConfiguration", &check) && check("ODE_double_precision");
}

static void serve(void)
{
    destroy_world = own.layer.ode_world_destroy;
    own.layer.ode_world_destroy = destroy_world_and_report;
    own.layer.stepped = pinch_report_sometimes;
    own.layer.backed_off = pinch_report_backoff;
    pinch_layer_set_calls(&own.layer);
}

static void find_ode(void *caller)
{
    void *library = library_of(caller);
    if (!library) {
        fputs("pinch exec: the program's ODE is not found\n", stderr);
        abort(); /* the call that has come here cannot go on */
    }
    const char *missing = find_functions(library);
    if (!is_double(library)) {
        ode_is = PASSED_ON;
        fputs("pinch exec: the program's ODE is not in double precision: it solves everything itself\n", stderr);
    } else if (missing) {
        ode_is = PASSED_ON;
        fprintf(stderr, "pinch exec: the program's ODE has no %s: it solves everything itself\n", missing);
    } else {
        ode_is = SERVED;
        serve();
    }
}

__attribute__((constructor)) static void enter(void)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    (void)pthread_once(&once, pinch_report_start);
}

/* Tells whether Pinch stands in for the ODE that the caller has. Other libraries' constructors may call ODE before this
 * one's has run. */
static bool served(void *caller)
{
    int is = atomic_load_explicit(&known, memory_order_acquire);
    if (is != NOT_LOOKED_FOR) return is == SERVED;
    enter();
    (void)pthread_mutex_lock(&finding);
    if (ode_is == NOT_LOOKED_FOR) find_ode(caller);
    (void)pthread_mutex_unlock(&finding);
    atomic_store_explicit(&known, ode_is, memory_order_release);
    return ode_is == SERVED;
}

__attribute__((destructor)) static void leave(void)
{
    pinch_report_end();
}

/* Programs have crashed while ODE closes, and after it. */
static void report_and_close(void)
{
    pinch_report_now();
    own.ode_close();
}

#define PRELOADED __attribute__((visibility("default")))
#define CALLER    __builtin_return_address(0)

/* A number in single precision is the lower half of a register for a number: it passes through as it is. */
#define PRELOAD_VALUE(type, name, ode_name, parameters, arguments)                                                     \
    PRELOADED type ode_name parameters                                                                                 \
    {                                                                                                                  \
        return served(CALLER) ? pinch_layer_##name arguments : own.layer.ode_##name arguments;                         \
    }
#define PRELOAD(function, passed_on, ode_name, parameters, arguments)                                                  \
    PRELOADED void ode_name parameters                                                                                 \
    {                                                                                                                  \
        if (served(CALLER))                                                                                            \
            function arguments;                                                                                        \
        else                                                                                                           \
            passed_on arguments;                                                                                       \
    }
#define PRELOAD_VOID(name, ode_name, parameters, arguments)                                                            \
    PRELOAD(pinch_layer_##name, own.layer.ode_##name, ode_name, parameters, arguments)
#define PRELOAD_OLDER(name, ode_name, parameters, arguments)                                                           \
    PRELOAD(pinch_layer_##name, own.ode_##name, ode_name, parameters, arguments)

PINCH_DROPIN_CALLS(PRELOAD_VALUE, PRELOAD_VOID)
PINCH_DROPIN_OLDER_CALLS(PRELOAD_OLDER)
PRELOAD(report_and_close, own.ode_close, dCloseODE, (void), ())
