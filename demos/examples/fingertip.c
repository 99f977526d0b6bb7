/*
 * Fingertips of a shape of their own: two flat capsules, as robot hands have them, hold a cylinder by its side. Their
 * geoms are of Pinch's class and work with dCollide like any other. The tips are kinematic and stand 0.4 mm inside the
 * cylinder; how far they press is their stiffness times that.
 */
#include <pinch/fingertip.h>
#include <pinch/ode.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TIPS = 2, MOST_POINTS = 8 };

typedef struct scene {
    pinch_ode *pinch;
    dGeomID tip[TIPS], object;
} scene;

static void check(pinch_status status)
{
    if (status == PINCH_OK) return;
    fprintf(stderr, "fingertip: %s\n", pinch_status_text(status));
    exit(1);
}

static void near_callback(void *data, dGeomID a, dGeomID b)
{
    scene *s = data;
    dContact contact[MOST_POINTS];
    if (a != s->object && b != s->object) return;
    memset(contact, 0, sizeof contact);
    int count = dCollide(a, b, MOST_POINTS, &contact[0].geom, sizeof contact[0]);
    for (int i = 0; i < count; i++)
        check(pinch_ode_add_contact(s->pinch, &contact[i], dGeomGetBody(a), dGeomGetBody(b)));
}

static void add_tip(dWorldID world, dSpaceID space, scene *s, int i)
{
    const double radius = 0.008, object = 0.03, closing = 0.0004;
    pinch_tip shape = pinch_default_tip(PINCH_TIP_FLAT_CAPSULE); /* along z: a half ball at the top, flat below */
    shape.size[0] = radius;
    shape.size[1] = 0.02;
    check(pinch_create_tip(space, &shape, &s->tip[i]));

    dBodyID base = dBodyCreate(world);
    dBodySetKinematic(base);
    dBodySetPosition(base, (i ? 1 : -1) * (object + radius - closing), 0, 0);
    dGeomSetBody(s->tip[i], base);

    pinch_material material = pinch_default_material();
    material.model = PINCH_CONTACT_SOFT;
    material.friction = material.friction_kinetic = 0.9;
    check(pinch_ode_set_material(s->pinch, s->tip[i], &material));
}

int main(void)
{
    scene s;
    dMass mass;
    dInitODE();
    dWorldID world = dWorldCreate();
    dSpaceID space = dHashSpaceCreate(NULL);
    pinch_ode_settings settings = pinch_ode_default_settings();
    dWorldSetGravity(world, 0, 0, -9.81);
    check(pinch_ode_create(world, &settings, &s.pinch));
    for (int i = 0; i < TIPS; i++) add_tip(world, space, &s, i);

    dBodyID cylinder = dBodyCreate(world);
    dMassSetCylinderTotal(&mass, 0.3, 3, 0.03, 0.1);
    dBodySetMass(cylinder, &mass);
    s.object = dCreateCylinder(space, 0.03, 0.1);
    dGeomSetBody(s.object, cylinder);

    for (int step = 0; step < 2000; step++) {
        dSpaceCollide(space, &s, near_callback);
        check(pinch_ode_step(s.pinch, 0.001));
    }
    for (int i = 0; i < TIPS; i++) {
        pinch_ode_load load;
        check(pinch_ode_geom_load(s.pinch, s.tip[i], NULL, &load));
        printf("tip %d: %d points, force (%.6f, %.6f, %.6f) N, margin %.4f, %s\n", i, load.points, load.force[0],
               load.force[1], load.force[2], load.slip_margin, pinch_contact_state_text(load.state));
    }
    const double *p = dBodyGetPosition(cylinder);
    printf("the cylinder has sunk by %.6f mm\n", -1e3 * p[2]);
    int held = p[2] > -0.001;
    pinch_ode_destroy(s.pinch);
    dSpaceDestroy(space);
    dWorldDestroy(world);
    dCloseODE();
    pinch_close_tips();
    return held ? 0 : 1;
}
