/* The reserves of a grasp by direction of its load. */
#include "grasp_quality.h"

#include <string.h>

pinch_status grasp_directions_find(pinch_statics *statics, const pinch_grasp *grasp,
                                   const pinch_statics_settings *settings, double force, grasp_directions *found)
{
    *found = (grasp_directions){.count = grasp->planar ? 4 : 6, .force = force};
    for (int k = 0; k < found->count; k++) {
        grasp_direction *d = &found->of[k];
        pinch_grasp loaded = *grasp;
        pinch_static_limits limits;
        d->direction[k / 2] = k % 2 ? -1.0 : 1.0;
        memset(loaded.wrench, 0, sizeof loaded.wrench);
        loaded.wrench[k / 2] = force * d->direction[k / 2];
        pinch_status status = pinch_statics_least_closing(statics, &loaded, settings, &d->least_closing);
        if (status == PINCH_OK) status = pinch_statics_limits(statics, &loaded, settings, &limits);
        if (status != PINCH_OK) return status;
        d->smallest_friction = limits.smallest_friction;
        d->largest_load_factor = limits.largest_load_factor;
    }
    return PINCH_OK;
}
