/* The ODE scene that loader.c opens as a module. The program itself does not know ODE. */
#include <ode/ode.h>

int module_run(int steps);

int module_run(int steps)
{
    dInitODE();
    dWorldID world = dWorldCreate();
    dWorldSetGravity(world, 0, 0, -9.81);
    dSpaceID space = dSimpleSpaceCreate(NULL);
    dGeomID ground = dCreatePlane(space, 0, 0, 1, 0), ball = dCreateSphere(space, 0.5);
    dBodyID body = dBodyCreate(world);
    dJointGroupID contacts = dJointGroupCreate(0);
    dGeomSetBody(ball, body);
    dBodySetPosition(body, 0, 0, 0.5);
    for (int i = 0; i < steps; i++) {
        dContact contact = {.surface = {.mode = dContactApprox1, .mu = 0.5}};
        if (dCollide(ground, ball, 1, &contact.geom, sizeof contact) == 1)
            dJointAttach(dJointCreateContact(world, contacts, &contact), dGeomGetBody(contact.geom.g1),
                         dGeomGetBody(contact.geom.g2));
        dWorldQuickStep(world, 0.01);
        dJointGroupEmpty(contacts);
    }
    double height = dBodyGetPosition(body)[2];
    dJointGroupDestroy(contacts);
    dSpaceDestroy(space);
    dWorldDestroy(world);
    dCloseODE();
    return height > 0.49 && height < 0.51 ? 0 : 1;
}
