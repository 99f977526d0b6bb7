/* Bodies under force control. */
#include "plugin.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

static pinch_item_keys keys_of(const pinch_ode *p)
{
    return PINCH_ITEM_KEYS(p->drives, pinch_drive, body);
}

int pinch_drive_of(const pinch_ode *p, dBodyID body)
{
    return pinch_item_index_get(&p->drive_index, keys_of(p), pinch_key_of_pointer(body));
}

/* The last one takes its place. */
static void remove_drive(pinch_ode *p, int index)
{
    p->drives.items[index] = p->drives.items[--p->drives.count];
    pinch_item_index_clear(&p->drive_index);
    for (int i = 0; i < p->drives.count; i++) /* cannot fail: it has been larger */
        (void)pinch_item_index_add(&p->drive_index, keys_of(p), pinch_key_of_pointer(p->drives.items[i].body), i);
}

static pinch_drive *add_drive(pinch_ode *p, dBodyID body)
{
    int index = p->drives.count;
    if (!PINCH_RESERVE(p->drives, index + 1) ||
        !pinch_item_index_add(&p->drive_index, keys_of(p), pinch_key_of_pointer(body), index))
        return NULL;
    pinch_drive *drive = &p->drives.items[p->drives.count++];
    memset(drive, 0, sizeof *drive);
    drive->body = body;
    return drive;
}

pinch_status pinch_ode_set_drive(pinch_ode *p, dBodyID body, const double axis[3], double force)
{
    if (!p || !body || !isfinite(force) || force < 0 || p->solved) return PINCH_INVALID_ARGUMENT;
    int index = pinch_drive_of(p, body);
    if (force == 0) {
        if (index < 0) return PINCH_OK;
        pinch_expect_nothing(p);
        remove_drive(p, index);
        return PINCH_OK;
    }
    if (!axis || !dBodyIsKinematic(body) || !(fabs(pinch_v3_norm(axis) - 1) < 1e-6)) return PINCH_INVALID_ARGUMENT;
    pinch_drive *drive = index < 0 ? add_drive(p, body) : &p->drives.items[index];
    if (!drive) return PINCH_OUT_OF_MEMORY;
    if (drive->force == force && memcmp(drive->axis, axis, sizeof drive->axis) == 0) return PINCH_OK;
    pinch_expect_nothing(p);
    drive->force = force;
    pinch_v3_copy(drive->axis, axis);
    return PINCH_OK;
}

bool pinch_drives_run_away(const pinch_ode *p, const pinch_island *island, double h)
{
    for (int i = 0; i < island->pair_count && p->drives.count > 0; i++) {
        const pinch_pair *pair = &p->pairs.items[p->pair_of.items[island->first_pair + i]];
        double size = fmin(p->geoms.items[pair->geom[0]].size, p->geoms.items[pair->geom[1]].size);
        for (int side = 0; side < 2; side++) {
            if (pair->step_body[side] < 0) continue;
            const pinch_step_body *b = &p->bodies.items[pair->step_body[side]];
            if (b->drive >= 0 && !(h * fabs(pinch_v3_dot(b->velocity, p->drives.items[b->drive].axis)) <= size))
                return true;
        }
    }
    return false;
}
