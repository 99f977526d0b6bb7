/*
 * Motors, stops and dry friction of hinges against closed forms: a finger presses with its torque over the lever arm, a
 * stop bears what turns the link against it, and a hinge with friction holds up to its bound and no farther.
 */
#include "support/cmocka_all.h"

#include <ode/ode.h>

#include <math.h>
#include <pinch/ode.h>
#include <string.h>

static const double STEP = 1e-3, MASS = 0.05, REACH = 0.06, RADIUS = 0.01, DEPTH = 1e-4;

/* A link on a hinge about z slides with its round tip on a frictionless plane z = 0, which presses along the axis. */
typedef struct rig {
    dWorldID world;
    pinch_ode *plugin;
    dBodyID link;
    dJointID hinge;
    dGeomID tip, plane;
    dJointFeedback feedback;
    double inertia; /* about the axis */
    double arm[2];  /* from the link's centre to the anchor, when the last step began */
} rig;

static void rig_make(rig *r, pinch_ode_stepper stepper)
{
    memset(r, 0, sizeof *r);
    r->world = dWorldCreate();
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = stepper;
    assert_int_equal(pinch_ode_create(r->world, &settings, &r->plugin), PINCH_OK);
    dMass mass;
    dMassSetSphereTotal(&mass, MASS, RADIUS);
    r->inertia = mass.I[10] + MASS * REACH * REACH;
    r->link = dBodyCreate(r->world);
    dBodySetMass(r->link, &mass);
    dBodySetPosition(r->link, REACH, 0, RADIUS - DEPTH);
    r->hinge = dJointCreateHinge(r->world, NULL);
    dJointAttach(r->hinge, r->link, NULL);
    dJointSetHingeAnchor(r->hinge, 0, 0, RADIUS - DEPTH);
    dJointSetHingeAxis(r->hinge, 0, 0, 1);
    dJointSetFeedback(r->hinge, &r->feedback);
    r->tip = dCreateSphere(NULL, RADIUS);
    dGeomSetBody(r->tip, r->link);
    r->plane = dCreatePlane(NULL, 0, 0, 1, 0);
    pinch_material material = pinch_default_material();
    material.model = PINCH_CONTACT_FRICTIONLESS;
    assert_int_equal(pinch_ode_set_material(r->plugin, r->tip, &material), PINCH_OK);
}

static void rig_free(rig *r)
{
    pinch_ode_stats stats = pinch_ode_statistics(r->plugin);
    assert_int_equal(stats.unconverged_steps, 0);
    assert_int_equal(stats.joints_left, 0);
    assert_true(stats.joints_solved > 0);
    pinch_ode_destroy(r->plugin);
    dGeomDestroy(r->tip);
    dGeomDestroy(r->plane);
    dWorldDestroy(r->world);
}

static void rig_step(rig *r, dGeomID other, double torque)
{
    dContact contact;
    memset(&contact, 0, sizeof contact);
    if (dCollide(r->tip, other, 1, &contact.geom, sizeof contact.geom) == 1)
        assert_int_equal(pinch_ode_add_contact(r->plugin, &contact, r->link, NULL), PINCH_OK);
    dVector3 anchor;
    dJointGetHingeAnchor(r->hinge, anchor);
    for (int i = 0; i < 2; i++) r->arm[i] = anchor[i] - dBodyGetPosition(r->link)[i];
    dJointAddHingeTorque(r->hinge, torque);
    assert_int_equal(pinch_ode_step(r->plugin, STEP), PINCH_OK);
}

/* The torque about the hinge's axis that the joint exerts on the link: the feedback's, less that of the force in the
 * anchor. */
static double axis_torque(const rig *r)
{
    const double *f = r->feedback.f1;
    return r->feedback.t1[2] - (r->arm[0] * f[1] - r->arm[1] * f[0]);
}

/* A motor that runs at its largest torque presses the tip against a wall with torque over lever arm. */
static void test_a_finger_presses_with_its_torque(void **state)
{
    (void)state;
    for (pinch_ode_stepper stepper = 0; stepper < 2; stepper++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            const double torque = 0.35;
            rig r;
            rig_make(&r, stepper);
            dGeomID wall = dCreatePlane(NULL, 0.3, -sign, 0, 0.3 * REACH - RADIUS + DEPTH);
            dJointSetHingeParam(r.hinge, dParamFMax, torque);
            dJointSetHingeParam(r.hinge, dParamVel, sign * 5);
            for (int step = 0; step < 3000; step++) rig_step(&r, wall, 0);
            const pinch_ode_contact *list;
            int count;
            assert_int_equal(pinch_ode_contacts(r.plugin, &list, &count), PINCH_OK);
            assert_int_equal(count, 1);
            const double *x = list[0].position, *n = list[0].normal;
            double arm = x[0] * n[1] - x[1] * n[0];
            double towards = list[0].body1 == r.link ? 1 : -1;
            assert_true(fabs(arm) > 0.5 * REACH);
            assert_close(list[0].normal_force * fabs(arm), torque, 1e-9 * torque);
            assert_true(towards * arm * sign < 0);
            dGeomDestroy(wall);
            rig_free(&r);
        }
    }
}

/* What turns the link against its stop is borne by the stop. */
static void test_a_stop_bears_the_torque(void **state)
{
    (void)state;
    for (pinch_ode_stepper stepper = 0; stepper < 2; stepper++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            rig r;
            rig_make(&r, stepper);
            dJointSetHingeParam(r.hinge, dParamLoStop, -0.2);
            dJointSetHingeParam(r.hinge, dParamHiStop, 0.2);
            for (int step = 0; step < 2000; step++) rig_step(&r, r.plane, sign * 0.02);
            assert_close(axis_torque(&r), -sign * 0.02, 1e-10);
            assert_close(dJointGetHingeAngleRate(r.hinge), 0, 1e-10);
            assert_close(dJointGetHingeAngle(r.hinge), sign * 0.2, 1e-6);
            rig_free(&r);
        }
    }
}

/* Hangs the hinge on a body that turns slowly about the same axis, so that the last digit of the angle changes. */
static void hang_on_turning_body(rig *r)
{
    dBodyID base = dBodyCreate(r->world);
    dBodySetKinematic(base);
    dBodySetPosition(base, 0, 0, RADIUS - DEPTH);
    dBodySetAngularVel(base, 0, 0, 0.3);
    dJointAttach(r->hinge, r->link, base);
    dJointSetHingeAnchor(r->hinge, 0, 0, RADIUS - DEPTH);
    dJointSetHingeAxis(r->hinge, 0, 0, 1);
    assert_int_equal(pinch_ode_note_joint(r->plugin, r->hinge), PINCH_OK);
}

/* A link that leans on its stop stays there, whichever way the last digit of its angle falls. */
static void test_a_link_leans_on_its_stop(void **state)
{
    (void)state;
    enum { STOPS = 12, COMES_TO_REST = 800, RESTS = 400 };
    for (int k = 0; k < STOPS; k++) {
        rig r;
        double stop = k < STOPS - 1 ? 0.1 + 0.137 * k : M_PI / 2, sign = k % 2 ? -1 : 1;
        rig_make(&r, PINCH_ODE_WORLDSTEP);
        hang_on_turning_body(&r);
        dJointSetHingeParam(r.hinge, dParamLoStop, -stop);
        dJointSetHingeParam(r.hinge, dParamHiStop, stop);
        for (int step = 0; step < COMES_TO_REST; step++) rig_step(&r, r.plane, sign * 0.02);
        for (int step = 0; step < RESTS; step++) {
            rig_step(&r, r.plane, sign * 0.02);
            assert_close(dJointGetHingeAngleRate(r.hinge), 0, 1e-9);
        }
        rig_free(&r);
    }
}

/* The stop is there, too, for a link that the rounding of a step has moved off it, by far more than the last digit. */
static void test_a_stop_acts_across_rounding(void **state)
{
    (void)state;
    for (pinch_ode_stepper stepper = 0; stepper < 2; stepper++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            rig r;
            rig_make(&r, stepper);
            for (double gap = 1e-15; gap < 1e-11; gap *= 10) {
                double stop = dJointGetHingeAngle(r.hinge) + sign * gap;
                dJointSetHingeParam(r.hinge, dParamLoStop, sign < 0 ? stop : -0.3);
                dJointSetHingeParam(r.hinge, dParamHiStop, sign < 0 ? 0.3 : stop);
                rig_step(&r, r.plane, sign * 0.02);
                assert_close(dJointGetHingeAngleRate(r.hinge), 0, 2 * gap / STEP + 1e-10);
                assert_close(axis_torque(&r), -sign * 0.02, 1e-6);
            }
            rig_free(&r);
        }
    }
}

/* A light link that a torque drives hard against its stop runs into it by a step's way, comes back to it against the
 * torque, and stays there. */
static void test_a_slam_into_a_stop(void **state)
{
    (void)state;
    static const double TORQUES[] = {0.5, 3, 7}, LENGTH = 0.1, STOP = 0.3;
    for (pinch_ode_stepper stepper = 0; stepper < 2; stepper++) {
        for (int k = 0; k < 6; k++) {
            rig r;
            dMass mass;
            double sign = k % 2 ? -1 : 1, beyond = 0;
            rig_make(&r, stepper);
            dJointSetHingeParam(r.hinge, dParamFMax, 0.5); /* dry friction */
            dBodyID second = dBodyCreate(r.world);
            dMassSetSphereTotal(&mass, 4 * MASS, RADIUS);
            dBodySetMass(second, &mass);
            dBodySetPosition(second, REACH + LENGTH, 0, RADIUS - DEPTH);
            dJointID joint = dJointCreateHinge(r.world, NULL);
            dJointAttach(joint, second, r.link);
            dJointSetHingeAnchor(joint, REACH, 0, RADIUS - DEPTH);
            dJointSetHingeAxis(joint, 0, 0, 1);
            dJointSetHingeParam(joint, dParamLoStop, -STOP);
            dJointSetHingeParam(joint, dParamHiStop, STOP);
            for (int step = 0; step < 1500; step++) {
                dJointAddHingeTorque(joint, sign * TORQUES[k / 2]);
                rig_step(&r, r.plane, 0);
                beyond = fmax(beyond, sign * dJointGetHingeAngle(joint) - STOP);
                if (step > 500) assert_close(sign * dJointGetHingeAngle(joint), STOP, 1e-9);
            }
            assert_true(beyond > 1e-3); /* it has been beyond */
            dBodyDestroy(second);
            dJointDestroy(joint);
            rig_free(&r);
        }
    }
}

/* Dry friction, a motor that wants speed 0, holds what is less than its bound, and slips with the rest beyond it. */
static void test_dry_friction_slips_at_its_bound(void **state)
{
    (void)state;
    const double bound = 0.01;
    static const double PART[] = {0.5, 1 - 1e-9, 1 + 1e-9, 1.001, 3};
    for (pinch_ode_stepper stepper = 0; stepper < 2; stepper++) {
        for (size_t i = 0; i < sizeof PART / sizeof *PART; i++) {
            for (int sign = -1; sign <= 1; sign += 2) {
                rig r;
                rig_make(&r, stepper);
                dJointSetHingeParam(r.hinge, dParamFMax, bound);
                int steps = PART[i] < 2 ? 200 : 1; /* what moves fast leaves the tangent that its step goes along */
                for (int step = 0; step < steps; step++) rig_step(&r, r.plane, sign * PART[i] * bound);
                double beyond = fmax(0, PART[i] - 1) * bound, rate = dJointGetHingeAngleRate(r.hinge);
                assert_close(sign * rate, steps * STEP * beyond / r.inertia, 1e-10 * (1 + fabs(rate)));
                if (beyond > 0) assert_true(sign * rate > 0);
                assert_close(axis_torque(&r), -sign * fmin(PART[i], 1) * bound, 1e-10 * bound);
                rig_free(&r);
            }
        }
    }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_finger_presses_with_its_torque),
        cmocka_unit_test(test_a_stop_bears_the_torque),
        cmocka_unit_test(test_a_link_leans_on_its_stop),
        cmocka_unit_test(test_a_stop_acts_across_rounding),
        cmocka_unit_test(test_a_slam_into_a_stop),
        cmocka_unit_test(test_dry_friction_slips_at_its_bound),
    };
    int failed = cmocka_run_group_tests_name("limits of joints", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
