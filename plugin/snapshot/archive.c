#include "snapshot/archive.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

enum { NONE = -1, GONE = -2 }; /* in place of a thing's place */

void pinch_archive_fail(pinch_archive *a, pinch_status status)
{
    if (a->status == PINCH_OK) a->status = status;
}

static pinch_item_keys handles(const void *list)
{
    return (pinch_item_keys){list, sizeof(void *), 0};
}

/* Indexes a list of handles. The list is complete before the index is used: a handle that comes twice is found. */
static void index_parts(pinch_archive *a, pinch_item_index *index, const void *list, int count)
{
    _Static_assert(sizeof(void *) == sizeof(uint64_t), "handles are keys");
    for (int i = 0; i < count && a->status == PINCH_OK; i++) {
        uintptr_t handle;
        memcpy(&handle, (const unsigned char *)list + (size_t)i * sizeof handle, sizeof handle);
        if (!handle || pinch_item_index_get(index, handles(list), &handle) >= 0)
            pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
        else if (!pinch_item_index_add(index, handles(list), &handle, i))
            pinch_archive_fail(a, PINCH_OUT_OF_MEMORY);
    }
}

static pinch_archive begin(const pinch_ode_parts *parts, bool reading, void *bytes, size_t size)
{
    pinch_archive a = {.reading = reading, .bytes = bytes, .size = size, .parts = parts};
    bool lists = parts->body_count >= 0 && parts->geom_count >= 0 && parts->joint_count >= 0 &&
                 (parts->bodies || parts->body_count == 0) && (parts->geoms || parts->geom_count == 0) &&
                 (parts->joints || parts->joint_count == 0);
    if (!lists) {
        pinch_archive_fail(&a, PINCH_INVALID_ARGUMENT);
        return a;
    }
    index_parts(&a, &a.bodies, parts->bodies, parts->body_count);
    index_parts(&a, &a.geoms, parts->geoms, parts->geom_count);
    index_parts(&a, &a.joints, parts->joints, parts->joint_count);
    return a;
}

pinch_archive pinch_archive_write(const pinch_ode_parts *parts, void *bytes, size_t size)
{
    return begin(parts, false, bytes, size);
}

pinch_archive pinch_archive_read(const pinch_ode_parts *parts, const void *bytes, size_t size)
{
    return begin(parts, true, (void *)bytes, size); /* it is not written to */
}

void pinch_archive_end(pinch_archive *a)
{
    pinch_item_index_free(&a->bodies);
    pinch_item_index_free(&a->geoms);
    pinch_item_index_free(&a->joints);
}

void pinch_archive_bytes(pinch_archive *a, void *value, size_t size)
{
    if (size == 0) return;
    if (a->bytes && size > a->size - a->at) pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
    if (a->status != PINCH_OK) {
        if (a->reading) memset(value, 0, size);
        return;
    }
    if (a->reading)
        memcpy(value, a->bytes + a->at, size);
    else if (a->bytes)
        memcpy(a->bytes + a->at, value, size);
    a->at += size;
}

void pinch_archive_flag(pinch_archive *a, bool *value)
{
    unsigned char byte = 0;
    if (!a->reading) memcpy(&byte, value, 1); /* what is no flag is found out, too */
    PINCH_ARCHIVE(a, byte);
    if (byte > 1) pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
    *value = byte == 1;
}

void pinch_archive_place(pinch_archive *a, int *place, int count, bool or_none)
{
    int32_t number = a->reading ? 0 : *place;
    PINCH_ARCHIVE(a, number);
    bool legal = (number >= 0 && number < count) || (or_none && number == NONE);
    if (!legal) pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
    if (a->reading) *place = legal ? number : or_none ? NONE : 0;
}

void pinch_archive_count(pinch_archive *a, int *count, size_t least, int most)
{
    int32_t number = a->reading ? 0 : *count;
    PINCH_ARCHIVE(a, number);
    bool legal = number >= 0 && number <= most && (!a->reading || (size_t)number <= (a->size - a->at) / least);
    if (!legal) pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
    if (a->reading) *count = legal ? number : 0;
}

void pinch_archive_list(pinch_archive *a, void **items, int *count, int *room, size_t item_size, size_t least)
{
    pinch_archive_count(a, count, least, INT_MAX);
    if (!a->reading || *count == 0) return;
    if (pinch_list_reserve(items, room, *count, item_size)) {
        memset(*items, 0, (size_t)*count * item_size);
        return;
    }
    *count = 0;
    pinch_archive_fail(a, PINCH_OUT_OF_MEMORY);
}

void pinch_archive_index(pinch_archive *a, pinch_item_index *index, pinch_item_keys keys, int count)
{
    for (int i = 0; i < count && a->reading && a->status == PINCH_OK; i++) {
        const unsigned char *key = (const unsigned char *)keys.items + (size_t)i * keys.size + keys.offset;
        if (pinch_item_index_get(index, keys, key) >= 0)
            pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
        else if (!pinch_item_index_add(index, keys, key, i))
            pinch_archive_fail(a, PINCH_OUT_OF_MEMORY);
    }
}

/* ---- handles ---- */

/* Odd addresses at the end of memory: things are aligned, and nothing is there. */
static const uintptr_t FIRST_GONE = UINTPTR_MAX - ((uintptr_t)1 << 32);

bool pinch_archive_is_gone(const void *handle)
{
    return (uintptr_t)handle > FIRST_GONE;
}

/* What may come in place of a thing of the parts. */
typedef struct otherwise {
    bool none, gone;
} otherwise;

/* Archives a handle, a pointer of some type at `at`, as its place. An address that nothing can have is made of where
 * it stands in the archive, which no other handle does. */
static void archive_handle(pinch_archive *a, void *at, const void *list, int count, const pinch_item_index *index,
                           otherwise also)
{
    uintptr_t handle;
    int32_t place = NONE;
    memcpy(&handle, at, sizeof handle);
    if (!a->reading && handle) {
        place = pinch_item_index_get(index, handles(list), &handle);
        if (place < 0) place = GONE;
    }
    uintptr_t gone = FIRST_GONE + 2 + 2 * (a->at & 0x3fffffff); /* odd, as FIRST_GONE is */
    PINCH_ARCHIVE(a, place);
    bool legal = (place >= 0 && place < count) || (place == NONE && also.none) || (place == GONE && also.gone);
    if (!legal) pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
    if (!a->reading) return;
    handle = legal && place == GONE ? gone : 0;
    if (legal && place >= 0)
        memcpy(&handle, (const unsigned char *)list + (size_t)place * sizeof handle, sizeof handle);
    memcpy(at, &handle, sizeof handle);
}

static const otherwise ANYTHING = {true, true};

void pinch_archive_body(pinch_archive *a, dBodyID *body, bool or_none)
{
    archive_handle(a, body, a->parts->bodies, a->parts->body_count, &a->bodies, (otherwise){.none = or_none});
}

void pinch_archive_geom(pinch_archive *a, dGeomID *geom, bool or_none)
{
    archive_handle(a, geom, a->parts->geoms, a->parts->geom_count, &a->geoms, (otherwise){.none = or_none});
}

void pinch_archive_joint(pinch_archive *a, dJointID *joint)
{
    archive_handle(a, joint, a->parts->joints, a->parts->joint_count, &a->joints, (otherwise){false, false});
}

void pinch_archive_old_body(pinch_archive *a, dBodyID *body)
{
    archive_handle(a, body, a->parts->bodies, a->parts->body_count, &a->bodies, ANYTHING);
}

void pinch_archive_old_geom(pinch_archive *a, dGeomID *geom)
{
    archive_handle(a, geom, a->parts->geoms, a->parts->geom_count, &a->geoms, ANYTHING);
}

void pinch_archive_old_joint(pinch_archive *a, dJointID *joint)
{
    archive_handle(a, joint, a->parts->joints, a->parts->joint_count, &a->joints, ANYTHING);
}
