#define _POSIX_C_SOURCE 200809L
#define PINCH_DROPIN_NO_MACROS

#include "dropin/state.h"

#include <pthread.h>
#include <stdatomic.h>

#define VALUE_CALL(type, name, ode_name, parameters, arguments) .ode_##name = ode_name,
#define VOID_CALL(name, ode_name, parameters, arguments)        .ode_##name = ode_name,
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations" /* programs may still call those */
static const pinch_layer_calls direct = {PINCH_DROPIN_CALLS(VALUE_CALL, VOID_CALL)};
#pragma GCC diagnostic pop
static const pinch_layer_calls *calls = &direct;

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_once_t once = PTHREAD_ONCE_INIT;
static pinch_layer_state state;

static void before_fork(void)
{
    pthread_mutex_lock(&lock);
}

static void after_fork(void)
{
    pthread_mutex_unlock(&lock);
}

static void start(void)
{
    state.settings = pinch_ode_default_settings();
    state.registry.joint_gone = pinch_layer_joint_gone;
    (void)pthread_atfork(before_fork, after_fork, after_fork);
}

pinch_layer_state *pinch_layer_lock(void)
{
    (void)pthread_once(&once, start);
    pthread_mutex_lock(&lock);
    return &state;
}

pinch_layer_state *pinch_layer_try_lock(void)
{
    return pthread_mutex_trylock(&lock) == 0 ? &state : NULL;
}

void pinch_layer_unlock(void)
{
    pthread_mutex_unlock(&lock);
}

void pinch_layer_set_calls(const pinch_layer_calls *own)
{
    calls = own;
}

const pinch_layer_calls *pinch_layer_own(void)
{
    return calls;
}

static _Thread_local dWorldID inside;

bool pinch_layer_is_inside(dWorldID world)
{
    return inside == world;
}

dWorldID pinch_layer_enter(dWorldID world)
{
    dWorldID before = inside;
    inside = world;
    return before;
}

/* Where something is out of scope at all, a contact with one of these bits in its mode is still in it. */
static atomic_int needed_mode;
static atomic_bool something_is_out;
static atomic_long out_of_scope;

void pinch_layer_update_scope(void)
{
    bool materials = false;
    for (const pinch_live_world *live = state.registry.worlds; live; live = live->next)
        materials = materials || live->materials.count > 0;
    atomic_store(&needed_mode, state.settings.scope == PINCH_ODE_SOFT_CONTACTS ? dContactSoftCFM : 0);
    atomic_store(&something_is_out, state.settings.scope != PINCH_ODE_ALL_CONTACTS && !materials);
}

bool pinch_layer_is_out_of_scope(int mode)
{
    if (!atomic_load_explicit(&something_is_out, memory_order_relaxed)) return false;
    if (mode & atomic_load_explicit(&needed_mode, memory_order_relaxed)) return false;
    atomic_fetch_add_explicit(&out_of_scope, 1, memory_order_relaxed);
    return true;
}

long pinch_layer_out_of_scope(void)
{
    return atomic_load(&out_of_scope);
}

void pinch_layer_reset_out_of_scope(void)
{
    atomic_store(&out_of_scope, 0);
}
