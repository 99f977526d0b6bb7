/*
 * The order in which geoms were first seen, which is that of their pairs. Neighbours are found anew.
 *
 * What is remembered of a space may have been destroyed since. Addresses are therefore compared with the parts, and
 * nothing else is done with them.
 */
#include "snapshot/archive.h"
#include "snapshot/snapshot.h"

#include <limits.h>
#include <stdlib.h>

/* An inner space is archived as one of the parts' geoms in it. Returns NULL where `geom` is none. */
static dGeomID member_of(const pinch_archive *a, dGeomID geom)
{
    const pinch_ode_parts *parts = a->parts;
    if (pinch_item_index_get(&a->geoms, (pinch_item_keys){parts->geoms, sizeof geom, 0}, &geom) >= 0) return NULL;
    for (int i = 0; i < parts->geom_count; i++)
        if ((dGeomID)dGeomGetSpace(parts->geoms[i]) == geom) return parts->geoms[i];
    return NULL;
}

static void archive_near_geom(pinch_archive *a, dGeomID *geom)
{
    dGeomID member = a->reading ? NULL : member_of(a, *geom);
    bool is_space = member != NULL;
    if (is_space) *geom = member;
    pinch_archive_flag(a, &is_space);
    pinch_archive_old_geom(a, geom);
    if (!a->reading || !is_space || pinch_archive_is_gone(*geom) || a->status != PINCH_OK) return;
    *geom = (dGeomID)dGeomGetSpace(*geom);
    if (!*geom) pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
}

static dSpaceID space_of(const dGeomID *geoms, int count)
{
    for (int i = 0; i < count; i++)
        if (!pinch_archive_is_gone(geoms[i])) return dGeomGetSpace(geoms[i]);
    return NULL;
}

static void archive_near_space(pinch_archive *a, pinch_near_pairs *near, int number)
{
    enum { LEAST = 2 /* bytes of a geom */ };
    int count = a->reading ? 0 : pinch_near_count(near, number);
    pinch_archive_count(a, &count, LEAST, INT_MAX - 1);
    dGeomID *geoms = calloc((size_t)count + 1, sizeof *geoms);
    if (!geoms) {
        pinch_archive_fail(a, PINCH_OUT_OF_MEMORY);
        return;
    }
    for (int i = 0; i < count && a->status == PINCH_OK; i++) {
        if (!a->reading) geoms[i] = pinch_near_geom(near, number, i);
        archive_near_geom(a, &geoms[i]);
    }
    dSpaceID space = a->reading && a->status == PINCH_OK ? space_of(geoms, count) : NULL;
    if (space) {
        pinch_status status = pinch_near_remember(near, space, geoms, count);
        if (status != PINCH_OK) pinch_archive_fail(a, status);
    }
    free(geoms);
}

void pinch_archive_near(pinch_archive *a, pinch_near_pairs *near)
{
    enum { LEAST = 4 /* bytes of a space */ };
    if (!a->reading) pinch_near_drop_forgotten(near);
    int count = near->spaces.count;
    pinch_archive_count(a, &count, LEAST, PINCH_NEAR_MOST_SPACES);
    for (int k = 0; k < count && a->status == PINCH_OK; k++) archive_near_space(a, near, k);
}
