/*
 * A body at rest on a joint without contacts: its answer is reused as long as nothing changes that the joint's rows
 * depend on, and is found anew in the step after any such change.
 */
#include "support/cmocka_all.h"

#include <pinch/ode.h>
#include <string.h>

static const double H = 1e-3;
enum { SETTLING = 6000, STILL = 10 };

typedef struct rig {
    dWorldID world;
    pinch_ode *plugin;
    dBodyID body, base; /* the base is kinematic */
    dJointID joint;
} rig;

static const pinch_servo SERVO = {.target = 0.1, .kp = 5, .kd = 0.5, .max_force = 20};

static void servo(rig *r, int axis, const pinch_servo *law)
{
    assert_int_equal(pinch_ode_set_servo(r->plugin, r->joint, axis, law), PINCH_OK);
}

static void hinge(rig *r)
{
    r->joint = dJointCreateHinge(r->world, NULL);
    dJointAttach(r->joint, r->body, r->base);
    dJointSetHingeAnchor(r->joint, 1, 0, 0.1);
    dJointSetHingeAxis(r->joint, 1, 0, 0);
    servo(r, 0, &SERVO);
}

static void slider(rig *r)
{
    r->joint = dJointCreateSlider(r->world, NULL);
    dJointAttach(r->joint, r->body, r->base);
    dJointSetSliderAxis(r->joint, 0, 0, 1);
    const pinch_servo stiff = {.target = 0.01, .kp = 500, .kd = 50, .max_force = 50};
    servo(r, 0, &stiff);
}

static void universal(rig *r)
{
    r->joint = dJointCreateUniversal(r->world, NULL);
    dJointAttach(r->joint, r->body, r->base);
    dJointSetUniversalAnchor(r->joint, 1, 0, 0.1);
    dJointSetUniversalAxis1(r->joint, 1, 0, 0);
    dJointSetUniversalAxis2(r->joint, 0, 1, 0);
    servo(r, 0, &SERVO);
    servo(r, 1, &SERVO);
}

static void hinge2(rig *r)
{
    const dVector3 axis1 = {0, 0, 1}, axis2 = {1, 0, 0};
    r->joint = dJointCreateHinge2(r->world, NULL);
    dJointAttach(r->joint, r->body, r->base);
    dJointSetHinge2Anchor(r->joint, 1, 0, 0.1);
    dJointSetHinge2Axes(r->joint, axis1, axis2);
    servo(r, 0, &SERVO);
    servo(r, 1, &SERVO);
}

static void fixed(rig *r)
{
    r->joint = dJointCreateFixed(r->world, NULL);
    dJointAttach(r->joint, r->body, r->base);
    dJointSetFixed(r->joint);
}

static void make(rig *r, void (*tie)(rig *r), bool noted)
{
    dMass mass;
    r->world = dWorldCreate();
    dWorldSetGravity(r->world, 0, 0, -9.81);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = PINCH_ODE_QUICKSTEP;
    assert_int_equal(pinch_ode_create(r->world, &settings, &r->plugin), PINCH_OK);
    r->body = dBodyCreate(r->world);
    dMassSetBoxTotal(&mass, 0.2, 0.1, 0.2, 0.3);
    dBodySetMass(r->body, &mass);
    dBodySetPosition(r->body, 1, 0, 0); /* its coordinates have a rounding */
    r->base = dBodyCreate(r->world);
    dBodySetKinematic(r->base);
    dBodySetPosition(r->base, 1.02, 0.01, 0.3);
    tie(r);
    if (noted && tie != universal) /* ODE shows all of that */
        assert_int_equal(pinch_ode_note_joint(r->plugin, r->joint), PINCH_OK);
}

static void release(rig *r)
{
    pinch_ode_destroy(r->plugin);
    dWorldDestroy(r->world);
}

/* Returns how many of the steps were at rest. */
static long steps(rig *r, int count)
{
    pinch_ode_reset_statistics(r->plugin);
    for (int i = 0; i < count; i++) {
        assert_int_equal(pinch_ode_add_body(r->plugin, r->body), PINCH_OK);
        assert_int_equal(pinch_ode_step(r->plugin, H), PINCH_OK);
    }
    return pinch_ode_statistics(r->plugin).islands_at_rest;
}

static void hinge_stop(rig *r)
{
    dJointSetHingeParam(r->joint, dParamLoStop, dJointGetHingeAngle(r->joint) + 1e-9);
}

static void hinge_motor(rig *r)
{
    dJointSetHingeParam(r->joint, dParamFMax, 1e-9);
}

static void hinge_anchor(rig *r)
{
    dJointSetHingeAnchor(r->joint, 1, 0, 0.11);
}

static void hinge_axis(rig *r)
{
    dJointSetHingeAxis(r->joint, 1, 1e-6, 0);
}

static void slider_axis(rig *r)
{
    dJointSetSliderAxis(r->joint, 0, 1e-6, 1);
}

static void slider_stop(rig *r)
{
    dJointSetSliderParam(r->joint, dParamHiStop, dJointGetSliderPosition(r->joint));
}

static void universal_anchor(rig *r)
{
    dJointSetUniversalAnchor(r->joint, 1, 1e-6, 0.1);
}

static void universal_motor(rig *r)
{
    dJointSetUniversalParam(r->joint, dParamFMax2, 1e-9);
}

static void universal_stop(rig *r)
{
    dJointSetUniversalParam(r->joint, dParamLoStop1, dJointGetUniversalAngle1(r->joint) + 1e-9);
}

static void hinge2_motor(rig *r)
{
    dJointSetHinge2Param(r->joint, dParamFMax2, 1e-9);
}

static void hinge2_suspension(rig *r)
{
    dJointSetHinge2Param(r->joint, dParamSuspensionCFM, 0.01);
}

static void fixed_cfm(rig *r)
{
    dJointSetFixedParam(r->joint, dParamCFM, 1e-6);
}

/* The pose is another one as soon as it is noted. */
static void fixed_again(rig *r)
{
    dBodySetPosition(r->base, 1.02, 0.01, 0.4);
    dJointSetFixed(r->joint);
    assert_int_equal(pinch_ode_note_joint(r->plugin, r->joint), PINCH_OK);
    dBodySetPosition(r->base, 1.02, 0.01, 0.3);
}

static void new_target(rig *r)
{
    pinch_servo law = SERVO;
    law.target += 1e-12;
    servo(r, 0, &law);
}

static void new_bound(rig *r)
{
    pinch_servo law = SERVO;
    law.max_force = 21;
    servo(r, 0, &law);
}

static void no_servo(rig *r)
{
    servo(r, 0, NULL);
}

static void base_turns(rig *r)
{
    dBodySetAngularVel(r->base, 0, 1e-9, 0);
}

static void base_steps_aside(rig *r)
{
    dBodySetPosition(r->base, 1.02 + 1e-9, 0.01, 0.3);
}

static const struct change {
    const char *name;
    void (*tie)(rig *r);
    void (*act)(rig *r);
} CHANGES[] = {
    {"a hinge's stop", hinge, hinge_stop},
    {"a hinge's motor", hinge, hinge_motor},
    {"a hinge's anchor", hinge, hinge_anchor},
    {"a hinge's axis", hinge, hinge_axis},
    {"a slider's axis", slider, slider_axis},
    {"a slider's stop", slider, slider_stop},
    {"a universal's anchor", universal, universal_anchor},
    {"a universal's motor", universal, universal_motor},
    {"a universal's stop", universal, universal_stop},
    {"a hinge-2's motor", hinge2, hinge2_motor},
    {"a hinge-2's suspension", hinge2, hinge2_suspension},
    {"a fixed joint's compliance", fixed, fixed_cfm},
    {"a fixed joint's pose", fixed, fixed_again},
    {"a servo's target", hinge, new_target},
    {"a servo's bound", universal, new_bound},
    {"a servo less", hinge2, no_servo},
    {"a base that turns", hinge, base_turns},
    {"a base that turns, a fixed joint", fixed, base_turns},
    {"a base that has been moved", slider, base_steps_aside},
};

static void check(const struct change *change, bool noted)
{
    rig r;
    print_message("%s%s\n", change->name, noted ? "" : ", not noted");
    make(&r, change->tie, noted);
    (void)steps(&r, SETTLING);
    assert_int_equal(steps(&r, STILL), STILL);
    change->act(&r);
    assert_int_equal(steps(&r, 1), 0);
    release(&r);
}

static void test_what_rows_depend_on(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof CHANGES / sizeof *CHANGES; k++) check(&CHANGES[k], true);
}

/* The axis of such a hinge is found out from its angle. */
static void test_hinges_that_were_not_noted(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof CHANGES / sizeof *CHANGES; k++)
        if (CHANGES[k].tie == hinge) check(&CHANGES[k], false);
}

/* What is set and has no effect leaves the rows as they are, and the body at rest. */
static void test_what_they_do_not_depend_on(void **state)
{
    (void)state;
    rig r;
    make(&r, hinge, true);
    (void)steps(&r, SETTLING);
    assert_int_equal(steps(&r, STILL), STILL);
    dJointSetHingeParam(r.joint, dParamVel, 3);
    dJointSetHingeParam(r.joint, dParamHiStop, 3);
    assert_int_equal(steps(&r, STILL), STILL);
    release(&r);
}

/* While the body is at rest it is disabled in ODE's step. From a kinematic body ODE would come to it by their joint and
 * enable it, from the world it would not; either way it stays where it is, and nobody sees that anything was disabled.
 */
static void test_ode_leaves_what_rests(void **state)
{
    (void)state;
    rig r;
    make(&r, hinge, false);
    for (int tied = 0; tied < 3; tied++) {
        dVector3 place;
        dJointAttach(r.joint, r.body, tied % 2 ? r.base : NULL);
        dJointSetHingeAnchor(r.joint, 1, 0, 0.1);
        dJointSetHingeAxis(r.joint, 1, 0, 0);
        assert_int_equal(pinch_ode_note_joint(r.plugin, r.joint), PINCH_OK);
        assert_int_equal(steps(&r, 1), 0);
        (void)steps(&r, SETTLING);
        memcpy(place, dBodyGetPosition(r.body), sizeof place);
        assert_int_equal(steps(&r, STILL), STILL);
        assert_memory_equal(dBodyGetPosition(r.body), place, sizeof place);
        assert_true(dBodyIsEnabled(r.body) && dJointIsEnabled(r.joint));
    }
    release(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_rows_depend_on), cmocka_unit_test(test_hinges_that_were_not_noted),
        cmocka_unit_test(test_what_they_do_not_depend_on), cmocka_unit_test(test_ode_leaves_what_rests)};
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
