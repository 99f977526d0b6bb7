/*
 * Where bodies and geoms are. ODE's setters normalize quaternions and make rotations of them, which changes last
 * digits: orientations are written into ODE's own memory, to the bit. Setters are called before, for what they do
 * besides.
 *
 * In simple and hash spaces the order in which pairs are found is that in which geoms have moved. It decides about the
 * order of new contacts, and so it is restored as well.
 */
#include "snapshot/archive.h"
#include "snapshot/snapshot.h"

#include "contacts/contact_store.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct body_state {
    double position[3], quaternion[4], rotation[12], velocity[6], force[6];
    bool enabled;
} body_state;

/* Geoms that belong to a body go with it; planes stay. */
typedef struct geom_state {
    double position[3], rotation[12];
    bool enabled, placed;
    int place; /* in its space; -1: in none, or in one whose order does not follow motions */
} geom_state;

typedef struct placed_geom {
    int place, index;
} placed_geom;

struct pinch_world_state {
    body_state *bodies;
    geom_state *geoms;
    placed_geom *order;   /* scratch, as many as geoms */
    unsigned long random; /* the seed of ODE's random numbers, with which quickstep orders its rows */
};

void pinch_world_state_free(pinch_world_state *state)
{
    if (!state) return;
    free(state->bodies);
    free(state->geoms);
    free(state->order);
    free(state);
}

static void read_body(dBodyID body, body_state *s)
{
    memcpy(s->position, dBodyGetPosition(body), sizeof s->position);
    memcpy(s->quaternion, dBodyGetQuaternion(body), sizeof s->quaternion);
    memcpy(s->rotation, dBodyGetRotation(body), sizeof s->rotation);
    memcpy(s->velocity, dBodyGetLinearVel(body), 3 * sizeof(double));
    memcpy(s->velocity + 3, dBodyGetAngularVel(body), 3 * sizeof(double));
    memcpy(s->force, dBodyGetForce(body), 3 * sizeof(double));
    memcpy(s->force + 3, dBodyGetTorque(body), 3 * sizeof(double));
    s->enabled = dBodyIsEnabled(body);
}

static void write_body(dBodyID body, const body_state *s)
{
    dBodySetPosition(body, s->position[0], s->position[1], s->position[2]); /* tells the geoms that they move */
    memcpy((dReal *)dBodyGetQuaternion(body), s->quaternion, sizeof s->quaternion);
    memcpy((dReal *)dBodyGetRotation(body), s->rotation, sizeof s->rotation);
    dBodySetLinearVel(body, s->velocity[0], s->velocity[1], s->velocity[2]);
    dBodySetAngularVel(body, s->velocity[3], s->velocity[4], s->velocity[5]);
    dBodySetForce(body, s->force[0], s->force[1], s->force[2]);
    dBodySetTorque(body, s->force[3], s->force[4], s->force[5]);
    if (s->enabled && !dBodyIsEnabled(body)) dBodyEnable(body);
    if (!s->enabled && dBodyIsEnabled(body)) dBodyDisable(body);
}

/* ---- geoms ---- */

static bool is_placed(dGeomID geom)
{
    return !dGeomGetBody(geom) && pinch_geom_has_pose(geom);
}

static bool has_order(dSpaceID space)
{
    return space && (dSpaceGetClass(space) == dSimpleSpaceClass || dSpaceGetClass(space) == dHashSpaceClass);
}

static void read_geom(dGeomID geom, geom_state *s)
{
    s->enabled = dGeomIsEnabled(geom);
    s->placed = is_placed(geom);
    s->place = -1;
    if (!s->placed) return;
    memcpy(s->position, dGeomGetPosition(geom), sizeof s->position);
    memcpy(s->rotation, dGeomGetRotation(geom), sizeof s->rotation);
}

/* Tells every geom its place in its space. A space is gone through once, when its first geom is met. */
static void read_places(const pinch_archive *a, geom_state *geoms)
{
    for (int i = 0; i < a->parts->geom_count; i++) {
        dSpaceID space = dGeomGetSpace(a->parts->geoms[i]);
        if (!has_order(space) || geoms[i].place >= 0) continue;
        for (int k = 0; k < dSpaceGetNumGeoms(space); k++) {
            dGeomID geom = dSpaceGetGeom(space, k);
            int index = pinch_item_index_get(&a->geoms, (pinch_item_keys){a->parts->geoms, sizeof geom, 0}, &geom);
            if (index >= 0) geoms[index].place = k;
        }
    }
}

static void write_geom(dGeomID geom, const geom_state *s)
{
    if (s->placed) {
        dGeomSetPosition(geom, s->position[0], s->position[1], s->position[2]);
        dGeomSetRotation(geom, s->rotation);
    }
    if (s->enabled && !dGeomIsEnabled(geom)) dGeomEnable(geom);
    if (!s->enabled && dGeomIsEnabled(geom)) dGeomDisable(geom);
}

static int by_place_from_the_end(const void *left, const void *right)
{
    const placed_geom *l = left, *r = right;
    return l->place != r->place ? (l->place < r->place) - (l->place > r->place) : l->index - r->index;
}

/* A geom that is added to a space comes first there. */
static void restore_order(const pinch_ode_parts *parts, const pinch_world_state *state)
{
    int count = 0;
    for (int i = 0; i < parts->geom_count; i++)
        if (state->geoms[i].place >= 0 && has_order(dGeomGetSpace(parts->geoms[i])))
            state->order[count++] = (placed_geom){state->geoms[i].place, i};
    qsort(state->order, (size_t)count, sizeof *state->order, by_place_from_the_end);
    for (int k = 0; k < count; k++) {
        dGeomID geom = parts->geoms[state->order[k].index];
        dSpaceID space = dGeomGetSpace(geom);
        dSpaceRemove(space, geom);
        dSpaceAdd(space, geom);
    }
}

/* ---- the archive ---- */

static bool all_finite(const double *values, int count)
{
    for (int i = 0; i < count; i++)
        if (!isfinite(values[i])) return false;
    return true;
}

static void archive_body(pinch_archive *a, body_state *s)
{
    PINCH_ARCHIVE(a, s->position);
    PINCH_ARCHIVE(a, s->quaternion);
    for (int row = 0; row < 3; row++) /* a matrix of ODE's has a fourth column that nobody sets */
        pinch_archive_bytes(a, s->rotation + 4 * row, 3 * sizeof(double));
    PINCH_ARCHIVE(a, s->velocity);
    PINCH_ARCHIVE(a, s->force);
    pinch_archive_flag(a, &s->enabled);
    if (a->reading && !(all_finite(s->position, 3) && all_finite(s->quaternion, 4) && all_finite(s->rotation, 12) &&
                        all_finite(s->velocity, 6) && all_finite(s->force, 6)))
        pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
}

static void archive_geom(pinch_archive *a, geom_state *s)
{
    pinch_archive_flag(a, &s->enabled);
    pinch_archive_flag(a, &s->placed);
    PINCH_ARCHIVE(a, s->place);
    if (!s->placed) return;
    PINCH_ARCHIVE(a, s->position);
    for (int row = 0; row < 3; row++) pinch_archive_bytes(a, s->rotation + 4 * row, 3 * sizeof(double));
    if (a->reading && !(all_finite(s->position, 3) && all_finite(s->rotation, 12)))
        pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
}

static pinch_world_state *new_state(const pinch_ode_parts *parts)
{
    pinch_world_state *state = calloc(1, sizeof *state);
    if (!state) return NULL;
    state->bodies = calloc((size_t)parts->body_count + 1, sizeof *state->bodies);
    state->geoms = calloc((size_t)parts->geom_count + 1, sizeof *state->geoms);
    state->order = calloc((size_t)parts->geom_count + 1, sizeof *state->order);
    if (state->bodies && state->geoms && state->order) return state;
    pinch_world_state_free(state);
    return NULL;
}

static void read_world(const pinch_archive *a, pinch_world_state *state)
{
    for (int i = 0; i < a->parts->body_count; i++) read_body(a->parts->bodies[i], &state->bodies[i]);
    for (int i = 0; i < a->parts->geom_count; i++) read_geom(a->parts->geoms[i], &state->geoms[i]);
    read_places(a, state->geoms);
    state->random = dRandGetSeed();
}

/* The parts have to be those of the archive: as many of each, geoms on bodies where there were such. */
static void archive_state(pinch_archive *a, pinch_world_state *state)
{
    int32_t counts[3] = {a->parts->body_count, a->parts->geom_count, a->parts->joint_count}, were[3];
    memcpy(were, counts, sizeof were);
    PINCH_ARCHIVE(a, were);
    if (memcmp(were, counts, sizeof were) != 0) pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
    for (int i = 0; i < counts[0] && a->status == PINCH_OK; i++) archive_body(a, &state->bodies[i]);
    for (int i = 0; i < counts[1] && a->status == PINCH_OK; i++) {
        archive_geom(a, &state->geoms[i]);
        if (state->geoms[i].placed != is_placed(a->parts->geoms[i])) pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
    }
    PINCH_ARCHIVE(a, state->random);
}

/* Which geoms have moved since they were last looked at cannot be read. Where none has, the next one that moves comes
 * first in its space, in the world that was saved as in the one that is restored. */
void pinch_clean_spaces(const pinch_ode_parts *parts)
{
    for (int i = 0; i < parts->geom_count; i++) {
        dSpaceID space = dGeomGetSpace(parts->geoms[i]);
        if (has_order(space)) dSpaceClean(space);
    }
}

void pinch_archive_world(pinch_archive *a, pinch_world_state **state)
{
    pinch_world_state *now = a->status == PINCH_OK ? new_state(a->parts) : NULL;
    if (!now) {
        pinch_archive_fail(a, PINCH_OUT_OF_MEMORY);
        return;
    }
    if (!a->reading) read_world(a, now);
    archive_state(a, now);
    if (a->reading)
        *state = now;
    else
        pinch_world_state_free(now);
}

void pinch_restore_world(const pinch_ode_parts *parts, const pinch_world_state *state)
{
    for (int i = 0; i < parts->body_count; i++) write_body(parts->bodies[i], &state->bodies[i]);
    for (int i = 0; i < parts->geom_count; i++) write_geom(parts->geoms[i], &state->geoms[i]);
    restore_order(parts, state);
    pinch_clean_spaces(parts);
    dRandSetSeed(state->random);
}
