/*
 * The paces that keep energy small: hard contacts that push bodies out of each other against joints, and joints that
 * ODE solves in Pinch's place.
 */
#include "support/cmocka_all.h"

#include <ode/ode.h>

#include <math.h>
#include <pinch/ode.h>
#include <string.h>

static const double STEP = 1e-3;

static dWorldID make_world(pinch_ode_settings settings, pinch_ode **plugin)
{
    dWorldID world = dWorldCreate();
    assert_int_equal(pinch_ode_create(world, &settings, plugin), PINCH_OK);
    return world;
}

static dBodyID make_body(dWorldID world, double mass, double size, double x)
{
    dMass m;
    dBodyID body = dBodyCreate(world);
    dMassSetBoxTotal(&m, mass, size, size, size);
    dBodySetMass(body, &m);
    dBodySetPosition(body, x, 0, 0);
    return body;
}

static void add_contact(pinch_ode *plugin, dBodyID body, double x, double depth)
{
    dContact contact;
    memset(&contact, 0, sizeof contact);
    contact.geom.pos[0] = x;
    contact.geom.normal[1] = 1;
    contact.geom.depth = depth;
    assert_int_equal(pinch_ode_add_contact(plugin, &contact, body, NULL), PINCH_OK);
}

/*
 * A hinge about z all but locks the normal y of a contact beside it: where the contact's arm is e, it moves at the
 * velocity w with the energy I (w/e)^2 / 2 of the moment of inertia I. That is I/(m e^2) times what w costs by itself.
 */
static double energy_of_push(double arm)
{
    static const double MASS = 1, SIZE = 0.2, DEPTH = 0.002;
    pinch_ode *plugin;
    dWorldID world = make_world(pinch_ode_default_settings(), &plugin);
    dBodyID body = make_body(world, MASS, SIZE, 0);
    dJointID hinge = dJointCreateHinge(world, NULL);
    dJointAttach(hinge, body, NULL);
    dJointSetHingeAnchor(hinge, 0, 0, 0);
    dJointSetHingeAxis(hinge, 0, 0, 1);
    add_contact(plugin, body, arm, DEPTH);
    assert_int_equal(pinch_ode_step(plugin, STEP), PINCH_OK);
    assert_int_equal(pinch_ode_statistics(plugin).joints_solved, 1);
    const double inertia = MASS * SIZE * SIZE / 6, spin = dBodyGetAngularVel(body)[2];
    pinch_ode_destroy(plugin);
    dWorldDestroy(world);
    return 0.5 * inertia * spin * spin;
}

static void test_a_locked_contact_does_not_throw(void **state)
{
    (void)state;
    const double inertia = 0.2 * 0.2 / 6, push = 0.2 * 0.002 / STEP, asked = 0.5 * push * push;
    /* far from the hinge it comes out as ODE has it */
    assert_close(energy_of_push(0.08), 0.5 * inertia * pow(push / 0.08, 2), 1e-3 * asked);
    /* close by it would have 6,700 times the energy that it asks for */
    assert_true(0.5 * inertia * pow(push / 1e-3, 2) > 6000 * asked);
    double least = energy_of_push(1e-3);
    assert_true(least > 0 && least <= 2.01 * asked); /* and a part of a step's fall */
}

/* Two balls close a loop between two bodies, which were torn apart by 10 mm. A solver with one iteration finds no
 * answer to the first step, nor to some later ones, so that ODE solves the island, and alone would close it at more
 * than 1 m/s. Joints and world have their ERP again after each step. */
static void test_ode_closes_at_the_pace(void **state)
{
    (void)state;
    static const double ERP[2] = {0.3, 0.6};
    pinch_ode *plugin;
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = PINCH_ODE_WORLDSTEP;
    settings.solver.max_iterations = 1;
    dWorldID world = make_world(settings, &plugin);
    dWorldSetERP(world, 0.25);
    dBodyID body[2] = {make_body(world, 1, 0.1, 0), make_body(world, 1, 0.1, 0.2)};
    dJointID ball[2];
    for (int k = 0; k < 2; k++) {
        ball[k] = dJointCreateBall(world, NULL);
        dJointAttach(ball[k], body[0], body[1]);
        dJointSetBallAnchor(ball[k], 0.1, 0.02 * k, 0);
        dJointSetBallParam(ball[k], dParamERP, ERP[k]);
    }
    dBodySetPosition(body[1], 0.21, 0, 0);
    double fastest = 0;
    for (int step = 0; step < 20; step++) {
        for (int k = 0; k < 4; k++) add_contact(plugin, body[k / 2], 0.2 * (k / 2) + 0.04 * (k % 2), 1e-5);
        dBodyAddForce(body[0], 1 + step % 3, -20, 0.3);
        assert_int_equal(pinch_ode_step(plugin, STEP), PINCH_OK);
        for (int k = 0; k < 2; k++) assert_true(dJointGetBallParam(ball[k], dParamERP) == ERP[k]);
        assert_true(dWorldGetERP(world) == 0.25);
        assert_true(pinch_ode_statistics(plugin).fallback_islands >= 1);
        fastest = fmax(fastest, fabs(dBodyGetLinearVel(body[1])[0]));
    }
    assert_true(fastest < 0.1);
    pinch_ode_destroy(plugin);
    dWorldDestroy(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_locked_contact_does_not_throw),
        cmocka_unit_test(test_ode_closes_at_the_pace),
    };
    dInitODE2(0);
    int failed = cmocka_run_group_tests_name("paces", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
