/*
 * What goes to sleep by ODE's thresholds, and when. Pinch solves contacts and hinges, so that ODE does not see what
 * ties bodies, and it is Pinch that puts them to sleep.
 */
#include "support/cmocka_all.h"

#include <math.h>
#include <pinch/ode.h>

static const double STEP = 0.01, SIDE = 0.2;

typedef struct couple {
    dWorldID world;
    pinch_ode *plugin;
    dBodyID body[2];
    dGeomID box[2], ground;
    double friction;
} couple;

static void make(couple *c)
{
    c->friction = 0.5;
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
            contact[k].surface.mu = c->friction;
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

/* Two boxes on a hinge go to sleep together and wake together. The plugin's step is made in one call, and in two. */
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

/* Returns the step, of the first 100, in which one of the boxes is disabled. */
static int falls_asleep_in(couple *c)
{
    for (int i = 0; i < 100; i++) {
        step(c, false);
        if (!dBodyIsEnabled(c->body[0])) return i;
    }
    return -1;
}

/* All boxes are to have been slow for the steps, the time and the samples that they are to, the slowest as well as the
 * most patient. */
static void test_when(void **state)
{
    (void)state;
    couple c;
    make(&c);
    dBodySetAutoDisableSteps(c.body[1], 30);
    int first = falls_asleep_in(&c);
    assert_true(first >= 29 && first <= 60);
    step(&c, false);
    dBodyEnable(c.body[0]);
    dBodySetAutoDisableSteps(c.body[1], 10);
    dBodySetAutoDisableTime(c.body[0], 0.455);
    assert_int_equal(falls_asleep_in(&c), 45); /* after 46 steps */
    destroy(&c);

    make(&c);
    dBodySetAutoDisableAverageSamplesCount(c.body[1], 0); /* ODE's way of saying never */
    assert_int_equal(falls_asleep_in(&c), -1);
    dBodySetAutoDisableAverageSamplesCount(c.body[1], 25);
    first = falls_asleep_in(&c);
    assert_true(first >= 33 && first <= 35); /* ten steps, from the first mean on */
    destroy(&c);
}

/* Until they sleep, boxes are not stopped: they slide on below the thresholds, on ground without friction. */
static void test_nothing_is_stopped_alone(void **state)
{
    (void)state;
    static const double SLOW = 5e-3;
    couple c;
    make(&c);
    dBodySetAutoDisableSteps(c.body[1], 1000); /* keeps both awake */
    for (int i = 0; i < 2; i++) dBodySetLinearVel(c.body[i], 0, SLOW, 0);
    c.friction = 0;
    for (int i = 0; i < 200; i++) step(&c, i % 2);
    for (int i = 0; i < 2; i++) assert_close(dBodyGetLinearVel(c.body[i])[1], SLOW, 1e-9);
    destroy(&c);
}

/* A push in any step moves the boxes, also in the one in which they would have gone to sleep. */
static void test_a_push_is_not_lost(void **state)
{
    (void)state;
    for (int before = 5; before < 25; before++) {
        couple c;
        make(&c);
        for (int i = 0; i < before; i++) step(&c, false);
        dBodyEnable(c.body[0]);
        dBodyAddForce(c.body[0], 0, 300, 0);
        step(&c, false);
        assert_true(dBodyGetLinearVel(c.body[0])[1] > 0.3);
        destroy(&c);
    }
}

/* Boxes that a joint ties to a kinematic body stay awake as long as that does, and on the ground. */
static void test_tied_to_a_kinematic_body(void **state)
{
    (void)state;
    for (int known = 0; known < 2; known++) {
        couple c;
        make(&c);
        dBodyID stand = dBodyCreate(c.world);
        dBodySetKinematic(stand);
        dBodySetAutoDisableFlag(stand, 0);
        dBodySetPosition(stand, 0, 2 * SIDE, 0.5 * SIDE);
        dJointID tie = known ? dJointCreateHinge(c.world, NULL) : dJointCreateNull(c.world, NULL);
        dJointAttach(tie, c.body[0], stand);
        if (known) dJointSetHingeAxis(tie, 0, 0, 1);
        for (int i = 0; i < 200; i++) {
            step(&c, false);
            assert_true(dBodyIsEnabled(c.body[0]) && dBodyIsEnabled(c.body[1]));
            assert_true(i < 50 || fabs(dBodyGetLinearVel(c.body[0])[2]) < 1e-6);
        }
        dBodyDisable(stand);
        assert_in_range(falls_asleep_in(&c), 0, 30);
        for (int i = 0; i < 50; i++) step(&c, false);
        assert_close(dBodyGetPosition(c.body[0])[2], 0.5 * SIDE, 1e-4);
        destroy(&c);
    }
}

/* A program that enables a body in each step keeps it awake but for a few steps, and its pushes are not saved up for
 * the step after those. Left alone, the body goes to sleep as soon as others once it has moved. */
static void test_kept_awake(void **state)
{
    (void)state;
    couple c;
    int asleep = 0;
    double fastest = 0;
    make(&c);
    for (int i = 0; i < 2000; i++) {
        for (int k = 0; k < 2; k++) dBodyEnable(c.body[k]);
        dBodyAddForce(c.body[1], 0, 0.9 * c.friction * 2 * 9.81, 0); /* of what the box on the ground bears */
        step(&c, false);
        asleep += !dBodyIsEnabled(c.body[0]);
        fastest = fmax(fastest, dBodyGetLinearVel(c.body[1])[1]);
    }
    assert_in_range(asleep, 1, 8); /* after 10, 20, 40, ... steps */
    assert_true(fastest < 1e-3);
    dBodyEnable(c.body[0]);
    dBodySetLinearVel(c.body[0], 0, 0.1, 0);
    assert_in_range(falls_asleep_in(&c), 9, 60);
    destroy(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_together),
                                       cmocka_unit_test(test_when),
                                       cmocka_unit_test(test_nothing_is_stopped_alone),
                                       cmocka_unit_test(test_a_push_is_not_lost),
                                       cmocka_unit_test(test_tied_to_a_kinematic_body),
                                       cmocka_unit_test(test_kept_awake)};
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
