/*
 * Several worlds at once, each stepped by a thread of its own, with a near callback that the program wrote: pads drop
 * out of the callback what it does not want, and give what they keep surfaces of their own. Different worlds share
 * nothing, so that no lock is needed. ODE wants two things for that: threads that are known to it, and for every world
 * a threading implementation of its own, because its default one is shared by all worlds.
 */
#include <pinch/ode.h>

#include <pthread.h>
#include <stdio.h>
#include <string.h>

enum { WORLDS = 4, STEPS = 1500, MOST_POINTS = 4 };

typedef struct trial {
    double slope; /* of gravity, as a part of the friction coefficient */
    dWorldID world;
    dThreadingImplementationID threading;
    dSpaceID space;
    pinch_ode *pinch;
    dGeomID floor, box, sensor;
    long seen; /* by the sensor, which touches nothing */
    double slid;
    pinch_status status;
} trial;

static void near_callback(void *data, dGeomID a, dGeomID b)
{
    trial *t = data;
    dContact contact[MOST_POINTS];
    memset(contact, 0, sizeof contact);
    int count = dCollide(a, b, MOST_POINTS, &contact[0].geom, sizeof contact[0]);
    if (a == t->sensor || b == t->sensor) {
        t->seen += count > 0;
        return;
    }
    for (int i = 0; i < count && t->status == PINCH_OK; i++) {
        contact[i].surface.mode = dContactApprox1;
        contact[i].surface.mu = 0.5;
        t->status = pinch_ode_add_contact(t->pinch, &contact[i], dGeomGetBody(a), dGeomGetBody(b));
    }
}

static void *run(void *data)
{
    trial *t = data;
    dAllocateODEDataForThread(dAllocateMaskAll);
    for (int i = 0; i < STEPS && t->status == PINCH_OK; i++) {
        dSpaceCollide(t->space, t, near_callback);
        if (t->status == PINCH_OK) t->status = pinch_ode_step(t->pinch, 0.001);
    }
    t->slid = dBodyGetPosition(dGeomGetBody(t->box))[0];
    dCleanupODEAllDataForThread();
    return NULL;
}

static void build(trial *t, double slope)
{
    dMass mass;
    pinch_ode_settings settings = pinch_ode_default_settings();
    memset(t, 0, sizeof *t);
    t->slope = slope;
    t->world = dWorldCreate();
    t->threading = dThreadingAllocateSelfThreadedImplementation();
    dWorldSetStepThreadingImplementation(t->world, dThreadingImplementationGetFunctions(t->threading), t->threading);
    t->space = dHashSpaceCreate(NULL);
    dWorldSetGravity(t->world, slope * 0.5 * 9.81, 0, -9.81);
    t->floor = dCreatePlane(t->space, 0, 0, 1, 0);
    t->sensor = dCreateSphere(t->space, 0.5);
    t->box = dCreateBox(t->space, 0.1, 0.1, 0.1);
    dBodyID body = dBodyCreate(t->world);
    dMassSetBoxTotal(&mass, 0.2, 0.1, 0.1, 0.1);
    dBodySetMass(body, &mass);
    dBodySetPosition(body, 0, 0, 0.05);
    dGeomSetBody(t->box, body);
    t->status = pinch_ode_create(t->world, &settings, &t->pinch);
}

int main(void)
{
    trial trials[WORLDS];
    pthread_t thread[WORLDS];
    int wrong = 0;
    dInitODE2(0);
    dAllocateODEDataForThread(dAllocateMaskAll);
    for (int i = 0; i < WORLDS; i++) build(&trials[i], 0.7 + 0.2 * i);
    for (int i = 0; i < WORLDS; i++) pthread_create(&thread[i], NULL, run, &trials[i]);
    for (int i = 0; i < WORLDS; i++) pthread_join(thread[i], NULL);
    for (int i = 0; i < WORLDS; i++) {
        trial *t = &trials[i];
        printf("at %.1f of the friction limit the box slides by %.6f m\n", t->slope, t->slid);
        wrong += t->status != PINCH_OK || (t->slope < 1 ? t->slid > 1e-4 : t->slid < 0.1 * (t->slope - 1)) || !t->seen;
        pinch_ode_destroy(t->pinch);
        dSpaceDestroy(t->space);
        dWorldDestroy(t->world);
        dThreadingFreeImplementation(t->threading);
    }
    dCloseODE();
    return wrong ? 1 : 0;
}
