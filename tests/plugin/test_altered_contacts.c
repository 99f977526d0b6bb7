/*
 * Programs change contacts before they hand them over: they allow a slop, add a margin, or drop some. A body rests
 * where the depths that were handed over have it rest, whether the collider finds one of its points or all.
 */
#include "support/cmocka_all.h"

#include <math.h>
#include <pinch/ode.h>
#include <string.h>

enum { CONTACTS = 16 };

static const double STEP = 1e-3, FRICTION = 0.5, GRAVITY = 9.81, SIZE = 0.02; /* s, 1, m/s^2, m */

typedef struct scene {
    dWorldID world;
    dSpaceID space;
    pinch_ode *plugin;
    double slop; /* m: is taken off every depth, and what is not deeper then is not handed over */
    bool gaps;   /* it is handed over nevertheless */
} scene;

static void make(scene *s, double slop)
{
    pinch_ode_settings settings = pinch_ode_default_settings();
    *s = (scene){.world = dWorldCreate(), .space = dSimpleSpaceCreate(NULL), .slop = slop};
    assert_int_equal(pinch_ode_create(s->world, &settings, &s->plugin), PINCH_OK);
}

static void end(scene *s)
{
    pinch_ode_destroy(s->plugin);
    dSpaceDestroy(s->space);
    dWorldDestroy(s->world);
}

static dBodyID add_body(scene *s, dGeomID geom, double mass, double x, double z)
{
    dMass m;
    dBodyID body = dBodyCreate(s->world);
    dMassSetBoxTotal(&m, mass, 2 * SIZE, 2 * SIZE, 2 * SIZE);
    dBodySetMass(body, &m);
    dGeomSetBody(geom, body);
    dBodySetPosition(body, x, 0, z);
    return body;
}

/* A capsule or a box that lies along y, with SIZE to its sides. */
static dBodyID add_object(scene *s, bool capsule, double mass, double z)
{
    dMatrix3 lying;
    dGeomID geom =
        capsule ? dCreateCapsule(s->space, SIZE, 3 * SIZE) : dCreateBox(s->space, 2 * SIZE, 2 * SIZE, 3 * SIZE);
    dBodyID body = add_body(s, geom, mass, 0, z);
    dRFromAxisAndAngle(lying, 1, 0, 0, 0.5 * M_PI);
    dBodySetRotation(body, lying);
    return body;
}

static void near(void *context, dGeomID a, dGeomID b)
{
    scene *s = context;
    dContact c[CONTACTS];
    int found = dCollide(a, b, CONTACTS, &c[0].geom, sizeof c[0]);
    for (int k = 0; k < found; k++) {
        memset(&c[k].surface, 0, sizeof c[k].surface);
        c[k].surface.mode = dContactApprox1 | dContactSoftERP | dContactSoftCFM;
        c[k].surface.mu = FRICTION;
        c[k].surface.soft_erp = 0.2;
        c[k].surface.soft_cfm = 1e-6;
        c[k].geom.depth -= s->slop;
        if (c[k].geom.depth > 0 || s->gaps)
            assert_int_equal(pinch_ode_add_contact(s->plugin, &c[k], dGeomGetBody(a), dGeomGetBody(b)), PINCH_OK);
    }
}

static void step(scene *s)
{
    dSpaceCollide(s->space, s, near);
    assert_int_equal(pinch_ode_step(s->plugin, STEP), PINCH_OK);
}

static void add_ground(scene *s, const pinch_material *material)
{
    dGeomID ground = dCreateBox(s->space, 1, 1, 0.2);
    dGeomSetPosition(ground, 0, 0, -0.1);
    if (material) assert_int_equal(pinch_ode_set_material(s->plugin, ground, material), PINCH_OK);
}

/* With `material`, the body lies deeper by what that gives way. */
static void check_rests(bool capsule, double slop, const pinch_material *material)
{
    static const double MASS = 0.1, SETTLED = 1e-7;
    const pinch_ode_contact *list;
    int count;
    scene s;
    make(&s, slop);
    dWorldSetGravity(s.world, 0, 0, -GRAVITY);
    add_ground(&s, material);
    s.gaps = material != NULL;
    dBodyID body = add_object(&s, capsule, MASS, SIZE);
    for (int i = 0; i < 2000; i++) step(&s);
    double gives = material ? MASS * GRAVITY / material->stiffness[0] : 0, z = dBodyGetPosition(body)[2];
    assert_close(z, SIZE - slop - gives, SETTLED);
    for (int i = 0; i < 100; i++) {
        double force = 0;
        step(&s);
        assert_int_equal(pinch_ode_contacts(s.plugin, &list, &count), PINCH_OK);
        assert_int_equal(count, capsule ? 2 : 4);
        for (int k = 0; k < count; k++) force += list[k].force[2] * (list[k].body1 == body ? 1 : -1);
        assert_close(force, MASS * GRAVITY, 1e-6);
        assert_close(dBodyGetPosition(body)[2], z, 1e-9);
    }
    end(&s);
}

static void test_rests_as_deep_as_the_slop(void **state)
{
    (void)state;
    pinch_material material = pinch_default_material();
    for (int k = 0; k < 4; k++) {
        double slop = k / 2 ? 1e-4 : 1e-5;
        check_rests(k % 2, slop, NULL);
        check_rests(k % 2, slop, &material);
    }
}

/* Returns what the jaws press with, in N: the mean of both. */
static double normal_force(scene *s)
{
    const pinch_ode_contact *list;
    int count;
    double force = 0;
    assert_int_equal(pinch_ode_contacts(s->plugin, &list, &count), PINCH_OK);
    for (int k = 0; k < count; k++) force += 0.5 * fabs(list[k].normal_force);
    return force;
}

/* Two jaws on sliders, whose motors press with a force, hold a body by friction. */
static void test_jaws_hold_with_a_slop(void **state)
{
    (void)state;
    static const double FORCE = 10;
    for (int k = 0; k < 4; k++) {
        bool capsule = k % 2;
        double slop = k / 2 ? 1e-4 : 0, mass = 0.8 * 2 * FRICTION * FORCE / GRAVITY;
        scene s;
        make(&s, slop);
        dBodyID object = add_object(&s, capsule, mass, 0);
        for (int side = -1; side <= 1; side += 2) {
            double x = side * (1.5 * SIZE - 0.5 * slop);
            dBodyID jaw = add_body(&s, dCreateBox(s.space, SIZE, 6 * SIZE, 3 * SIZE), 0.2, x, 0);
            dJointID slider = dJointCreateSlider(s.world, NULL);
            dJointAttach(slider, jaw, NULL);
            dJointSetSliderAxis(slider, 1, 0, 0);
            dJointSetSliderParam(slider, dParamFMax, FORCE);
            dJointSetSliderParam(slider, dParamVel, -side * 0.1);
        }
        for (int i = 0; i < 1000; i++) step(&s);
        dWorldSetGravity(s.world, 0, 0, -GRAVITY);
        for (int i = 0; i < 1000; i++) {
            step(&s);
            if (i > 500) assert_close(normal_force(&s), FORCE, 1e-6);
        }
        assert_close(dBodyGetPosition(object)[2], 0, 1e-6);
        end(&s);
    }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rests_as_deep_as_the_slop),
        cmocka_unit_test(test_jaws_hold_with_a_slop),
    };
    int failed = cmocka_run_group_tests_name("altered contacts", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
