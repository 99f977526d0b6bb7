/*
 * A hand on hinges holds a ball. The forces on every link must balance. Where ODE has a say in how the joints share a
 * load, it must get all of them.
 */
#include "support/cmocka_all.h"

#include <ode/ode.h>

#include <pinch/ode.h>
#include <string.h>

static const double STEP = 1e-3;

/* Three fingers of two hinged links about a ball. */
enum { FINGERS = 3, HAND_JOINTS = 2 * FINGERS };

typedef struct hand {
    dWorldID world;
    pinch_ode *plugin;
    dBodyID ball, link[HAND_JOINTS];
    dJointID hinge[HAND_JOINTS];
    dJointFeedback feedback[HAND_JOINTS];
    dGeomID ball_geom, tip[FINGERS];
} hand;

static void add_link(hand *h, int k, double c, double s, double reach)
{
    dMass mass;
    bool first = k % 2 == 0;
    dMassSetCapsuleTotal(&mass, 0.03, 3, 0.006, 0.05);
    h->link[k] = dBodyCreate(h->world);
    dBodySetMass(h->link[k], &mass);
    dBodySetPosition(h->link[k], reach * c, reach * s, first ? -0.075 : -0.025);
    h->hinge[k] = dJointCreateHinge(h->world, NULL);
    if (first) /* to the world, one of them the other way round */
        dJointAttach(h->hinge[k], k == 0 ? NULL : h->link[k], k == 0 ? h->link[k] : NULL);
    else
        dJointAttach(h->hinge[k], h->link[k], h->link[k - 1]);
    dJointSetHingeAnchor(h->hinge[k], reach * c, reach * s, first ? -0.1 : -0.05);
    dJointSetHingeAxis(h->hinge[k], s, -c, 0);
    dJointSetFeedback(h->hinge[k], &h->feedback[k]);
}

static void hand_make(hand *h, pinch_ode_stepper stepper)
{
    const double radius = 0.03, tip = 0.01;
    memset(h, 0, sizeof *h);
    h->world = dWorldCreate();
    dWorldSetGravity(h->world, 0, 0, -9.81);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = stepper;
    assert_int_equal(pinch_ode_create(h->world, &settings, &h->plugin), PINCH_OK);
    dMass mass;
    dMassSetSphereTotal(&mass, 0.1, radius);
    h->ball = dBodyCreate(h->world);
    dBodySetMass(h->ball, &mass);
    h->ball_geom = dCreateSphere(NULL, radius);
    dGeomSetBody(h->ball_geom, h->ball);
    pinch_material material = pinch_default_material();
    for (int finger = 0; finger < FINGERS; finger++) {
        double angle = 2 * M_PI * finger / FINGERS, c = cos(angle), s = sin(angle);
        add_link(h, 2 * finger, c, s, radius + tip);
        add_link(h, 2 * finger + 1, c, s, radius + tip);
        h->tip[finger] = dCreateSphere(NULL, tip);
        dGeomSetBody(h->tip[finger], h->link[2 * finger + 1]);
        dGeomSetOffsetPosition(h->tip[finger], 0, 0, 0.025);
        assert_int_equal(pinch_ode_set_material(h->plugin, h->tip[finger], &material), PINCH_OK);
    }
}

static void hand_free(hand *h)
{
    pinch_ode_destroy(h->plugin);
    dGeomDestroy(h->ball_geom);
    for (int k = 0; k < FINGERS; k++) dGeomDestroy(h->tip[k]);
    dWorldDestroy(h->world);
}

static void hand_touch(hand *h)
{
    for (int finger = 0; finger < FINGERS; finger++) {
        dContact contact;
        memset(&contact, 0, sizeof contact);
        if (dCollide(h->ball_geom, h->tip[finger], 1, &contact.geom, sizeof contact.geom) == 1)
            assert_int_equal(pinch_ode_add_contact(h->plugin, &contact, h->ball, h->link[2 * finger + 1]), PINCH_OK);
    }
}

/* Presses with 2 N a finger, springs about the posture; returns what is left of a link's linear momentum balance, N. */
static double hand_step(hand *h)
{
    double before[HAND_JOINTS][3], most = 0;
    for (int k = 0; k < HAND_JOINTS; k++) {
        double angle = dJointGetHingeAngle(h->hinge[k]), rate = dJointGetHingeAngleRate(h->hinge[k]);
        double press = (k == 0 ? -1 : 1) * 2 * 0.05 * (2 - k % 2);
        dJointAddHingeTorque(h->hinge[k], press - 0.5 * angle - 5e-3 * rate);
        memcpy(before[k], dBodyGetLinearVel(h->link[k]), sizeof before[k]);
    }
    hand_touch(h);
    assert_int_equal(pinch_ode_step(h->plugin, STEP), PINCH_OK);
    const pinch_ode_contact *list;
    int count;
    assert_int_equal(pinch_ode_contacts(h->plugin, &list, &count), PINCH_OK);
    for (int k = 0; k < HAND_JOINTS; k++) {
        double left[3] = {0, 0, 0.03 * 9.81};
        for (int i = 0; i < 3; i++) {
            left[i] += 0.03 * (dBodyGetLinearVel(h->link[k])[i] - before[k][i]) / STEP - h->feedback[k].f1[i];
            if (k % 2 == 0) left[i] -= h->feedback[k + 1].f2[i];
            for (int c = 0; c < count; c++) {
                if (list[c].body1 == h->link[k]) left[i] -= list[c].force[i];
                if (list[c].body2 == h->link[k]) left[i] += list[c].force[i];
            }
            most = fmax(most, fabs(left[i]));
        }
    }
    return most;
}

/* The ball comes to rest in the hand, and every link's forces balance: contacts, feedback, weight. */
static void test_hand(void **state)
{
    (void)state;
    for (pinch_ode_stepper stepper = 0; stepper < 2; stepper++) {
        hand h;
        hand_make(&h, stepper);
        double left = 0;
        for (int step = 0; step < 3000; step++) left = fmax(left, hand_step(&h));
        pinch_ode_stats stats = pinch_ode_statistics(h.plugin);
        const double *v = dBodyGetLinearVel(h.ball), *x = dBodyGetPosition(h.ball);
        assert_true(left < 1e-9);
        assert_true(dCalcVectorLength3(v) < 1e-12 && fabs(x[2]) < 1e-3);
        assert_int_equal(stats.joints_solved, 3000 * HAND_JOINTS);
        assert_true(stats.step_mismatch < 1e-10 && stats.step_mismatch_angular < 1e-8);
        hand_free(&h);
    }
}

/* A hinge that is there twice holds what it held alone: its rows depend on each other, and share the load. */
static void test_doubled_hinge(void **state)
{
    (void)state;
    for (pinch_ode_stepper stepper = 0; stepper < 2; stepper++) {
        hand once, twice;
        dVector3 anchor, axis;
        dJointFeedback single, half[2];
        hand_make(&once, stepper);
        hand_make(&twice, stepper);
        dJointID more = dJointCreateHinge(twice.world, NULL);
        dJointAttach(more, twice.link[3], twice.link[2]);
        dJointGetHingeAnchor(twice.hinge[3], anchor);
        dJointGetHingeAxis(twice.hinge[3], axis);
        dJointSetHingeAnchor(more, anchor[0] + 0.01 * axis[0], anchor[1] + 0.01 * axis[1], anchor[2]);
        dJointSetHingeAxis(more, axis[0], axis[1], axis[2]);
        dJointSetFeedback(once.hinge[3], &single);
        dJointSetFeedback(twice.hinge[3], &half[0]);
        dJointSetFeedback(more, &half[1]);
        for (int step = 0; step < 2000; step++) {
            (void)hand_step(&once);
            (void)hand_step(&twice);
        }
        pinch_ode_stats stats = pinch_ode_statistics(twice.plugin);
        assert_int_equal(stats.joints_left, 0);
        assert_int_equal(stats.fallback_islands, 0);
        assert_int_equal(stats.joints_solved, 2000 * (HAND_JOINTS + 1));
        assert_true(stats.step_mismatch < 1e-10);
        double load = dCalcVectorLength3(single.f1);
        int sign = dJointGetBody(once.hinge[3], 0) == once.link[3] ? 1 : -1;
        for (int i = 0; i < 3; i++) {
            const double *x = dBodyGetPosition(once.ball), *y = dBodyGetPosition(twice.ball);
            double sum = half[1].f1[i] + (sign > 0 ? half[0].f1[i] : half[0].f2[i]);
            double alone = sign > 0 ? single.f1[i] : single.f2[i];
            assert_true(fabs(x[i] - y[i]) < 1e-9);
            assert_true(fabs(sum - alone) < 1e-6 * load);
        }
        assert_true(load > 0 && dCalcVectorLength3(half[0].f1) < load && dCalcVectorLength3(half[1].f1) < load);
        hand_free(&once);
        hand_free(&twice);
    }
}

/* Where ODE has a say in how joints share a load, it gets them all. */
static void test_left_to_ode(void **state)
{
    (void)state;
    enum { LOOSE_CONTACT = 0, ANOTHER_TYPE, CASES };
    for (int kind = 0; kind < CASES; kind++) {
        hand h;
        hand_make(&h, PINCH_ODE_WORLDSTEP);
        dJointGroupID group = dJointGroupCreate(0);
        if (kind == ANOTHER_TYPE) dJointAttach(dJointCreatePR(h.world, NULL), h.ball, NULL);
        for (int step = 0; step < 20; step++) {
            if (kind == LOOSE_CONTACT) { /* the program's own, which it has not handed over */
                dContact contact;
                memset(&contact, 0, sizeof contact);
                contact.geom.normal[2] = 1;
                contact.geom.depth = 1e-6;
                dJointAttach(dJointCreateContact(h.world, group, &contact), h.ball, NULL);
            }
            hand_step(&h);
            dJointGroupEmpty(group);
        }
        pinch_ode_stats stats = pinch_ode_statistics(h.plugin);
        assert_int_equal(stats.joints_solved, 0);
        assert_true(stats.joints_left >= 20 * HAND_JOINTS);
        dJointGroupDestroy(group);
        hand_free(&h);
    }
}

/* A joint that is gone when ODE steps carries nothing, and the others are ODE's for that step. */
static void test_joint_destroyed_after_the_solve(void **state)
{
    (void)state;
    hand h;
    hand_make(&h, PINCH_ODE_WORLDSTEP);
    for (int step = 0; step < 20; step++) hand_step(&h);
    pinch_ode_reset_statistics(h.plugin);
    hand_touch(&h);
    assert_int_equal(pinch_ode_solve(h.plugin, STEP), PINCH_OK);
    dJointDestroy(h.hinge[5]);
    assert_int_equal(pinch_ode_advance(h.plugin, STEP), PINCH_OK);
    pinch_ode_stats stats = pinch_ode_statistics(h.plugin);
    assert_int_equal(stats.joints_solved, 0);
    assert_int_equal(stats.joints_left, HAND_JOINTS);
    for (int k = 0; k < HAND_JOINTS - 1; k++) assert_true(dJointIsEnabled(h.hinge[k]));
    hand_touch(&h);
    assert_int_equal(pinch_ode_step(h.plugin, STEP), PINCH_OK);
    stats = pinch_ode_statistics(h.plugin);
    assert_true(stats.joints_solved > 0);
    hand_free(&h);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_hand),
        cmocka_unit_test(test_doubled_hinge),
        cmocka_unit_test(test_left_to_ode),
        cmocka_unit_test(test_joint_destroyed_after_the_solve),
    };
    int failed = cmocka_run_group_tests_name("a jointed hand", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
