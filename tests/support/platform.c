#include "support/platform.h"

#include "support/random.h"

#include <math.h>
#include <ode/ode.h>
#include <string.h>

const char *platform_versions(void)
{
    return PINCH_PLATFORM;
}

/* FNV-1a */
static void add(uint64_t *hash, double value)
{
    unsigned char bytes[sizeof value];
    memcpy(bytes, &value, sizeof bytes);
    for (size_t i = 0; i < sizeof bytes; i++) *hash = (*hash ^ bytes[i]) * 1099511628211u;
}

static void add_functions(uint64_t *hash)
{
    pinch_random random;
    pinch_random_seed(&random, 1);
    for (int k = 0; k < 20000; k++) {
        double x = 20 * pinch_random_uniform(&random) - 10, unit = pinch_random_uniform(&random);
        add(hash, sin(x));
        add(hash, cos(x));
        add(hash, tan(x));
        add(hash, acos(unit));
        add(hash, atan2(unit, x));
        add(hash, exp(x));
        add(hash, log(unit));
        add(hash, pow(unit, x));
        add(hash, hypot(unit, x));
    }
}

/* A box and a capsule fall on a cylinder, and ODE's own step holds them. */
static void add_world(uint64_t *hash)
{
    dWorldID world = dWorldCreate();
    dJointGroupID contacts = dJointGroupCreate(0);
    dWorldSetGravity(world, 0.3, 0.1, -9.81);
    dGeomID geom[3] = {dCreateBox(NULL, 0.1, 0.2, 0.3), dCreateCapsule(NULL, 0.05, 0.2), dCreateCylinder(NULL, 1, 0.2)};
    for (int i = 0; i < 2; i++) {
        dMass mass;
        dBodyID body = dBodyCreate(world);
        dMassSetBoxTotal(&mass, 0.5, 0.1, 0.2, 0.3);
        dBodySetMass(body, &mass);
        dBodySetPosition(body, 0.3 * i, 0, 0.35);
        dBodySetAngularVel(body, 1 + i, 2, 3);
        dGeomSetBody(geom[i], body);
    }
    for (int step = 0; step < 500; step++) {
        for (int i = 0; i < 3; i++) {
            dContactGeom found[8];
            dGeomID a = geom[i], b = geom[(i + 1) % 3];
            int count = dCollide(a, b, 8, found, sizeof found[0]);
            for (int k = 0; k < count; k++) {
                dContact contact;
                memset(&contact, 0, sizeof contact);
                contact.geom = found[k];
                contact.surface.mode = dContactApprox1;
                contact.surface.mu = 0.5;
                dJointAttach(dJointCreateContact(world, contacts, &contact), dGeomGetBody(a), dGeomGetBody(b));
            }
        }
        dWorldStep(world, 1e-3);
        dJointGroupEmpty(contacts);
        for (int i = 0; i < 2; i++) {
            for (int k = 0; k < 3; k++) add(hash, dGeomGetPosition(geom[i])[k]);
            for (int k = 0; k < 12; k++) add(hash, k % 4 == 3 ? 0 : dGeomGetRotation(geom[i])[k]);
        }
    }
    for (int i = 0; i < 3; i++) dGeomDestroy(geom[i]);
    dJointGroupDestroy(contacts);
    dWorldDestroy(world);
}

uint64_t platform_fingerprint(void)
{
    uint64_t hash = 14695981039346656037u;
    add_functions(&hash);
    add_world(&hash);
    return hash;
}
