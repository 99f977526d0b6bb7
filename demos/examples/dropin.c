/*
 * A plain ODE program: a stack of boxes on a plane, with contact joints and dWorldQuickStep. The one line about Pinch
 * is the include: with it the calls go through Pinch, and the stack stands without creeping. Without it, and without
 * libpinch_ode, this is an ODE program like any other.
 */
#include <pinch/ode_dropin.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { BOXES = 5, MOST_POINTS = 8 };

static dWorldID world;
static dJointGroupID contacts;

static void near_callback(void *data, dGeomID a, dGeomID b)
{
    dContact contact[MOST_POINTS];
    (void)data;
    memset(contact, 0, sizeof contact);
    int count = dCollide(a, b, MOST_POINTS, &contact[0].geom, sizeof contact[0]);
    for (int i = 0; i < count; i++) {
        contact[i].surface.mode = dContactApprox1 | dContactSoftERP | dContactSoftCFM;
        contact[i].surface.mu = 0.6;
        contact[i].surface.soft_erp = 0.2;
        contact[i].surface.soft_cfm = 1e-5;
        dJointAttach(dJointCreateContact(world, contacts, &contact[i]), dGeomGetBody(a), dGeomGetBody(b));
    }
}

int main(void)
{
    dBodyID box[BOXES];
    double x[BOXES], farthest = 0;
    dInitODE();
    world = dWorldCreate();
    contacts = dJointGroupCreate(0);
    dSpaceID space = dHashSpaceCreate(NULL);
    dWorldSetGravity(world, 1, 0, -9.81); /* leans, so that quickstep's stack creeps */
    dCreatePlane(space, 0, 0, 1, 0);
    for (int i = 0; i < BOXES; i++) {
        dMass mass;
        box[i] = dBodyCreate(world);
        dMassSetBoxTotal(&mass, 1, 0.2, 0.2, 0.1);
        dBodySetMass(box[i], &mass);
        dBodySetPosition(box[i], 0, 0, 0.05 + 0.1 * i);
        dGeomSetBody(dCreateBox(space, 0.2, 0.2, 0.1), box[i]);
    }
    for (int step = 0; step < 3000; step++) {
        if (step == 2000)
            for (int i = 0; i < BOXES; i++) x[i] = dBodyGetPosition(box[i])[0];
        dSpaceCollide(space, NULL, near_callback);
        dWorldQuickStep(world, 0.002);
        dJointGroupEmpty(contacts);
    }
    for (int i = 0; i < BOXES; i++) farthest = fmax(farthest, fabs(dBodyGetPosition(box[i])[0] - x[i]));
    printf("in the last two seconds no box crept farther than %.3g um; the top one is at %.9f m\n", 1e6 * farthest,
           dBodyGetPosition(box[BOXES - 1])[0]);
    dJointGroupDestroy(contacts);
    dSpaceDestroy(space);
    dWorldDestroy(world);
    dCloseODE();
    return farthest < 1e-9 ? 0 : 1;
}
