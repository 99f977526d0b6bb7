/* Settings and materials that are set, and what is read back. */
#include "dropin/state.h"
#include "ode_internal.h"

#include <math.h>
#include <string.h>

pinch_status pinch_dropin_set_settings(const pinch_ode_settings *wanted)
{
    pinch_status status = pinch_check_settings(wanted);
    if (status != PINCH_OK) return status;
    pinch_layer_state *state = pinch_layer_lock();
    state->settings = *wanted;
    pinch_layer_update_scope();
    pinch_layer_unlock();
    return PINCH_OK;
}

pinch_ode_settings pinch_dropin_settings(void)
{
    pinch_layer_state *state = pinch_layer_lock();
    pinch_ode_settings now = state->settings;
    pinch_layer_unlock();
    return now;
}

static bool keep_material(pinch_live_world *live, dGeomID geom, const pinch_material *material)
{
    int i = 0, count = live->materials.count;
    while (i < count && live->materials.items[i].geom != geom) i++;
    if (!material) {
        if (i < count) live->materials.items[i] = live->materials.items[--live->materials.count];
        return true;
    }
    if (!PINCH_RESERVE(live->materials, i + 1)) return false;
    if (i == count) live->materials.count++;
    live->materials.items[i] = (pinch_layer_material){geom, *material};
    return true;
}

/* Makes the world busy, so that its plugin is the caller's until it is released. Returns NULL where that cannot be. */
static pinch_live_world *seize(dWorldID world, pinch_ode_settings *wanted)
{
    pinch_layer_state *state = pinch_layer_lock();
    pinch_live_world *live = world ? pinch_registry_world(&state->registry, world) : NULL;
    if (live && live->busy) live = NULL;
    if (live) live->busy = true;
    *wanted = state->settings;
    pinch_layer_unlock();
    return live;
}

pinch_status pinch_dropin_set_material(dWorldID world, dGeomID geom, const pinch_material *material)
{
    pinch_ode_settings wanted;
    pinch_layer_state *state;
    pinch_live_world *live = seize(world, &wanted);
    if (!live) return PINCH_INVALID_ARGUMENT;
    pinch_status status = PINCH_OUT_OF_MEMORY;
    if (pinch_layer_have_plugin(live, &wanted)) status = pinch_ode_set_material(live->plugin, geom, material);
    if (status == PINCH_OK && !keep_material(live, geom, material)) {
        (void)pinch_ode_set_material(live->plugin, geom, NULL);
        status = PINCH_OUT_OF_MEMORY;
    }
    pinch_layer_release(live, NULL);
    state = pinch_layer_lock();
    if (material && status == PINCH_OK) pinch_registry_note_geom(&state->registry, geom);
    pinch_layer_update_scope();
    pinch_layer_unlock();
    return status;
}

pinch_status pinch_dropin_contacts(dWorldID world, const pinch_ode_contact **list, int *count)
{
    if (!world || !list || !count) return PINCH_INVALID_ARGUMENT;
    *list = NULL;
    *count = 0;
    pinch_layer_state *state = pinch_layer_lock();
    pinch_live_world *live = pinch_registry_find_world(&state->registry, world);
    pinch_status status = live && live->plugin ? pinch_ode_contacts(live->plugin, list, count) : PINCH_OK;
    pinch_layer_unlock();
    return status;
}

pinch_status pinch_dropin_geom_load(dWorldID world, dGeomID geom, dGeomID partner, const double about[3],
                                    pinch_ode_load *load)
{
    if (!world || !geom || !load) return PINCH_INVALID_ARGUMENT;
    pinch_layer_state *state = pinch_layer_lock();
    pinch_live_world *live = pinch_registry_find_world(&state->registry, world);
    pinch_status status = PINCH_OK;
    *load = (pinch_ode_load){.slip_margin = NAN, .least_margin = NAN};
    if (live && live->plugin)
        status = partner ? pinch_ode_pair_load(live->plugin, geom, partner, about, load)
                         : pinch_ode_geom_load(live->plugin, geom, about, load);
    pinch_layer_unlock();
    return status;
}

/* The memory of a world that is being stepped counts as it was when it was last asked for. */
static pinch_dropin_stats sum_of_worlds(const pinch_layer_state *state)
{
    pinch_dropin_stats sum = state->registry.ended;
    for (pinch_live_world *live = state->registry.worlds; live; live = live->next) {
        if (!live->busy && live->plugin) live->current = pinch_ode_statistics(live->plugin);
        pinch_layer_add_stats(&sum, &live->stats);
        pinch_layer_add_plugin_stats(&sum.ode, &live->current);
        sum.worlds++;
    }
    sum.contacts_out_of_scope = pinch_layer_out_of_scope();
    return sum;
}

pinch_dropin_stats pinch_dropin_statistics(void)
{
    const pinch_layer_state *state = pinch_layer_lock();
    pinch_dropin_stats sum = sum_of_worlds(state);
    pinch_layer_unlock();
    return sum;
}

bool pinch_layer_statistics_now(pinch_dropin_stats *stats, pinch_ode_settings *settings)
{
    const pinch_layer_state *state = pinch_layer_try_lock();
    if (!state) return false;
    *stats = sum_of_worlds(state);
    *settings = state->settings;
    pinch_layer_unlock();
    return true;
}

void pinch_dropin_reset_statistics(void)
{
    pinch_layer_state *state = pinch_layer_lock();
    memset(&state->registry.ended, 0, sizeof state->registry.ended);
    for (pinch_live_world *live = state->registry.worlds; live; live = live->next) {
        memset(&live->stats, 0, sizeof live->stats);
        memset(&live->current, 0, sizeof live->current);
        if (live->busy)
            live->to_reset = true;
        else if (live->plugin)
            pinch_ode_reset_statistics(live->plugin);
    }
    pinch_layer_reset_out_of_scope();
    pinch_layer_unlock();
}

int pinch_dropin_write_statistics(char *text, size_t size)
{
    pinch_dropin_stats stats = pinch_dropin_statistics();
    pinch_ode_settings now = pinch_dropin_settings();
    return pinch_layer_write_statistics(&stats, &now, text, size);
}
