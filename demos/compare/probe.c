#include "probe.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void copy_body(dBodyID from, dBodyID to)
{
    const double *x = dBodyGetPosition(from), *v = dBodyGetLinearVel(from), *w = dBodyGetAngularVel(from);
    dBodySetPosition(to, x[0], x[1], x[2]);
    dBodySetQuaternion(to, dBodyGetQuaternion(from));
    dBodySetLinearVel(to, v[0], v[1], v[2]);
    dBodySetAngularVel(to, w[0], w[1], w[2]);
}

static void copy_state(const world *from, world *to)
{
    copy_body(from->object, to->object);
    for (int i = 0; i < from->finger_count; i++) {
        copy_body(from->fingers[i].body, to->fingers[i].body);
        if (from->fingers[i].rail && to->fingers[i].rail) copy_body(from->fingers[i].rail, to->fingers[i].rail);
    }
    to->steps = from->steps;
    to->time = from->time;
}

static dBodyID body_in(const world *from, const world *to, dBodyID body)
{
    if (body == from->object) return to->object;
    for (int i = 0; i < from->finger_count; i++)
        if (from->fingers[i].body == body) return to->fingers[i].body;
    return NULL;
}

static dGeomID geom_in(const world *from, const world *to, dGeomID geom)
{
    for (int i = 0; i < from->geom_count; i++)
        if (from->geoms[i] == geom) return to->geoms[i];
    return to->object_geom;
}

/* The same contacts among the other world's bodies. */
static bool give(const world *from, world *to, const probe_contacts *contacts)
{
    world_contact *list = calloc((size_t)contacts->count + 1, sizeof *list);
    if (!list) return false;
    for (int k = 0; k < contacts->count; k++) {
        world_contact *c = &list[k];
        *c = contacts->contacts[k];
        c->material = &contacts->materials[k];
        c->contact.geom.g1 = geom_in(from, to, c->contact.geom.g1);
        c->contact.geom.g2 = geom_in(from, to, c->contact.geom.g2);
        for (int side = 0; side < 2; side++) c->body[side] = body_in(from, to, c->body[side]);
    }
    bool given = world_give_contacts(to, list, contacts->count);
    free(list);
    return given;
}

bool probe_step(const world *w, const world_settings *settings, const probe_contacts *contacts, double *force)
{
    char error[256];
    world *probe;
    if (world_create(w->scene, settings, &probe, error) != WORLD_OK) return false;
    copy_state(w, probe);
    dRandSetSeed(0);
    bool given = give(w, probe, contacts);
    world_status status = given ? world_step(probe) : WORLD_NO_MEMORY;
    for (int k = 0; k < contacts->count; k++) {
        const world_contact *c = &probe->contacts[k];
        for (int i = 0; i < 3; i++) /* attached as (0, body), ODE writes the force on the body first */
            force[3 * k + i] = status == WORLD_OK ? (c->body[0] ? 1 : -1) * c->feedback.f1[i] : NAN;
    }
    world_destroy(probe);
    return given && status != WORLD_NO_MEMORY;
}
