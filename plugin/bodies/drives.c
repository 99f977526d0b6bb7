#include "bodies/drives.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

static pinch_item_keys keys_of(const pinch_drives *drives)
{
    return PINCH_ITEM_KEYS(*drives, pinch_drive, body);
}

int pinch_drive_of(const pinch_drives *drives, dBodyID body)
{
    return pinch_item_index_get(&drives->index, keys_of(drives), pinch_key_of_pointer(body));
}

/* The last drive takes the place of the one that goes. */
static void remove_drive(pinch_drives *drives, int index)
{
    drives->items[index] = drives->items[--drives->count];
    (void)pinch_item_index_rebuild(&drives->index, keys_of(drives), drives->count); /* it has been larger */
}

static pinch_drive *add_drive(pinch_drives *drives, dBodyID body)
{
    int index = drives->count;
    if (!PINCH_RESERVE(*drives, index + 1) ||
        !pinch_item_index_add(&drives->index, keys_of(drives), pinch_key_of_pointer(body), index))
        return NULL;
    pinch_drive *drive = &drives->items[drives->count++];
    memset(drive, 0, sizeof *drive);
    drive->body = body;
    return drive;
}

pinch_status pinch_drives_set(pinch_drives *drives, dBodyID body, const double axis[3], double force, bool *changed)
{
    int index = pinch_drive_of(drives, body);
    *changed = false;
    if (force == 0) {
        *changed = index >= 0;
        if (index >= 0) remove_drive(drives, index);
        return PINCH_OK;
    }
    if (!axis || !dBodyIsKinematic(body) || !(fabs(pinch_v3_norm(axis) - 1) < 1e-6)) return PINCH_INVALID_ARGUMENT;
    pinch_drive *drive = index < 0 ? add_drive(drives, body) : &drives->items[index];
    if (!drive) return PINCH_OUT_OF_MEMORY;
    if (drive->force == force && memcmp(drive->axis, axis, sizeof drive->axis) == 0) return PINCH_OK;
    *changed = true;
    drive->force = force;
    pinch_v3_copy(drive->axis, axis);
    return PINCH_OK;
}

void pinch_drive_stop(const pinch_drive *drive)
{
    const double *v = dBodyGetLinearVel(drive->body), s = drive->speed;
    dBodySetLinearVel(drive->body, v[0] - s * drive->axis[0], v[1] - s * drive->axis[1], v[2] - s * drive->axis[2]);
}
