/*
 * An archive: numbers and handles of ODE's things, written one behind the other and read back in the same order.
 *
 * The same function walks through a structure for both, so that the two cannot differ:
 *
 *     writing    the values are appended, or only counted where the archive has no bytes
 *     reading    the values are replaced by those of the archive, each list gets the room it needs
 *
 * Bodies, geoms and joints are archived as their places in the lists of a pinch_ode_parts. After the first thing that
 * goes wrong, `status` says so, nothing more is written, and what is read is 0.
 */
#ifndef PINCH_SNAPSHOT_ARCHIVE_H
#define PINCH_SNAPSHOT_ARCHIVE_H

#include "util/list.h"

#include <pinch/ode.h>

typedef struct pinch_archive {
    bool reading;
    unsigned char *bytes; /* NULL: only counts */
    size_t size, at;      /* of the bytes there are, or that there is room for; of those done */
    pinch_status status;
    const pinch_ode_parts *parts;
    pinch_item_index bodies, geoms, joints; /* writing: where things are in these lists */
} pinch_archive;

/* Makes an archive for writing (NULL, 0: for counting), or one for reading. Frees it with pinch_archive_end. Of parts
 * that are listed twice, or NULL, the status tells. */
pinch_archive pinch_archive_write(const pinch_ode_parts *parts, void *bytes, size_t size);
pinch_archive pinch_archive_read(const pinch_ode_parts *parts, const void *bytes, size_t size);
void pinch_archive_end(pinch_archive *a);

/* Takes note of a failure; the first one stays. */
void pinch_archive_fail(pinch_archive *a, pinch_status status);

void pinch_archive_bytes(pinch_archive *a, void *value, size_t size);
#define PINCH_ARCHIVE(a, value) pinch_archive_bytes((a), &(value), sizeof(value))
void pinch_archive_flag(pinch_archive *a, bool *value);
/* An index into `count` things; where `or_none`, also -1. */
void pinch_archive_place(pinch_archive *a, int *place, int count, bool or_none);
/* A number of things each of which takes at least `least` bytes, between 0 and `most`. */
void pinch_archive_count(pinch_archive *a, int *count, size_t least, int most);

/* A list's count, and when reading the room for as many items, all 0. Each takes at least `least` bytes. */
void pinch_archive_list(pinch_archive *a, void **items, int *count, int *room, size_t item_size, size_t least);
#define PINCH_ARCHIVE_LIST(a, list, least)                                                                             \
    pinch_archive_list((a), (void **)&(list).items, &(list).count, &(list).room, sizeof *(list).items, (least))
/* Indexes a list that was read. */
void pinch_archive_index(pinch_archive *a, pinch_item_index *index, pinch_item_keys keys, int count);

/* Handles of things that are in the parts; NULL where `or_none`. */
void pinch_archive_body(pinch_archive *a, dBodyID *body, bool or_none);
void pinch_archive_geom(pinch_archive *a, dGeomID *geom, bool or_none);
void pinch_archive_joint(pinch_archive *a, dJointID *joint);

/* Handles that are only compared: a thing that is not in the parts may have been destroyed. What is read for it is an
 * address that nothing can have, another one for each. */
void pinch_archive_old_body(pinch_archive *a, dBodyID *body);
void pinch_archive_old_geom(pinch_archive *a, dGeomID *geom);
void pinch_archive_old_joint(pinch_archive *a, dJointID *joint);
/* Tells whether a handle that was read is such an address. */
bool pinch_archive_is_gone(const void *handle);

#endif
