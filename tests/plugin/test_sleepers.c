/*
 * Two boxes on a hinge must go to sleep together and wake together. Pinch solves the hinge, so that ODE does not see
 * what ties them. The plugin's step is made in one call, and in two.
 */
#include "support/cmocka_all.h"

#include <pinch/ode.h>

static const double STEP = 0.01, SIDE = 0.2;

typedef struct couple {
    dWorldID world;
    pinch_ode *plugin;
    dBodyID body[2];
    dGeomID box[2], ground;
} couple;

static void make(couple *c)
{
    c->world = dWorldCreate();
    dWorldSetGravity(c->world, 0, 0, -9.81);
    dWorldSetAutoDisableFlag(c->world, 1);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.scope = PINCH_ODE_ALL_CONTACTS;
    assert_int_equal(pinch_ode_create(c->world, &settings, &c->plugin), PINCH_OK);
    c->ground = dCreatePlane(NULL, 0, 0, 1, 0);
    for (int i = 0; i < 2; i++) {
        dMass mass;
        c->body[i] = dBodyCreate(c->world);
        dMassSetBoxTotal(&mass, 1 + i, SIDE, SIDE, SIDE);
        dBodySetMass(c->body[i], &mass);
        dBodySetPosition(c->body[i], 1.5 * SIDE * i, 0, 0.5 * SIDE);
        c->box[i] = dCreateBox(NULL, SIDE, SIDE, SIDE);
        dGeomSetBody(c->box[i], c->body[i]);
    }
    dJointID hinge = dJointCreateHinge(c->world, NULL);
    dJointAttach(hinge, c->body[0], c->body[1]);
    dJointSetHingeAnchor(hinge, 0.75 * SIDE, 0, 0.5 * SIDE);
    dJointSetHingeAxis(hinge, 0, 1, 0);
}

static void destroy(couple *c)
{
    for (int i = 0; i < 2; i++) dGeomDestroy(c->box[i]);
    dGeomDestroy(c->ground);
    pinch_ode_destroy(c->plugin);
    dWorldDestroy(c->world);
}

static void step(couple *c, bool in_two)
{
    for (int i = 0; i < 2; i++) {
        dContact contact[4] = {{.surface = {.mode = 0}}};
        int count = dCollide(c->box[i], c->ground, 4, &contact[0].geom, sizeof contact[0]);
        for (int k = 0; k < count; k++) {
            contact[k].surface.mode = dContactApprox1;
            contact[k].surface.mu = 0.5;
            assert_int_equal(pinch_ode_add_contact(c->plugin, &contact[k], c->body[i], NULL), PINCH_OK);
        }
    }
    if (in_two) {
        assert_int_equal(pinch_ode_solve(c->plugin, STEP), PINCH_OK);
        assert_int_equal(pinch_ode_advance(c->plugin, STEP), PINCH_OK);
    } else {
        assert_int_equal(pinch_ode_step(c->plugin, STEP), PINCH_OK);
    }
}

static void test_together(void **state)
{
    (void)state;
    for (int in_two = 0; in_two < 2; in_two++) {
        couple c;
        make(&c);
        for (int i = 0; i < 200; i++) step(&c, in_two);
        assert_true(pinch_ode_statistics(c.plugin).joints_solved > 0);
        assert_int_equal(pinch_ode_statistics(c.plugin).joints_left, 0);
        assert_false(dBodyIsEnabled(c.body[0]) || dBodyIsEnabled(c.body[1]));
        dBodyEnable(c.body[0]);
        dBodySetLinearVel(c.body[0], 0, 0, 0.5);
        step(&c, in_two);
        assert_true(dBodyIsEnabled(c.body[0]) && dBodyIsEnabled(c.body[1]));
        destroy(&c);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_together)};
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
