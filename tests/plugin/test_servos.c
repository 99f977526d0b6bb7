/*
 * Servos against closed forms: the rate of every coordinate, the implicit spring and damper step by step, rest, and the
 * bound. Each under both steppers, with and without a contact that has Pinch solve the joint, with Pinch's solve and
 * with ODE's.
 */
#include "support/cmocka_all.h"

#include <pinch/ode.h>
#include <string.h>

static const double H = 1e-3;

/* Who solves the joint. */
typedef enum solved_by { BY_PINCH = 0, BY_ODE, WITHOUT_CONTACTS, SOLVED_BY_COUNT } solved_by;

typedef struct rig {
    dWorldID world;
    pinch_ode *plugin;
    dBodyID body[2];
    dGeomID ball, ground;
    solved_by by;
} rig;

static void rig_make(rig *r, solved_by by, pinch_ode_stepper stepper)
{
    dMass mass;
    memset(r, 0, sizeof *r);
    r->by = by;
    r->world = dWorldCreate();
    dWorldSetCFM(r->world, 0);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = stepper;
    settings.joints_by_ode = by == BY_ODE;
    assert_int_equal(pinch_ode_create(r->world, &settings, &r->plugin), PINCH_OK);
    for (int i = 0; i < 2; i++) {
        r->body[i] = dBodyCreate(r->world);
        dMassSetBoxTotal(&mass, 0.2, 0.1, 0.2, 0.3);
        dBodySetMass(r->body[i], &mass);
        dBodySetPosition(r->body[i], 0.1 * i, 0.05 * i, 0.2 * i);
        dBodySetGyroscopicMode(r->body[i], 0);
        dBodySetFiniteRotationMode(r->body[i], 1); /* an angle grows by exactly h times its rate */
    }
    r->ball = dCreateSphere(NULL, 0.01);
    r->ground = dCreateSphere(NULL, 0.01);
    dGeomSetBody(r->ball, r->body[0]);
}

static void rig_free(rig *r)
{
    pinch_ode_destroy(r->plugin);
    dGeomDestroy(r->ball);
    dGeomDestroy(r->ground);
    dWorldDestroy(r->world);
}

/* The contact is open: it has Pinch look at the island, and carries nothing. */
static void rig_step(rig *r)
{
    dContact contact;
    memset(&contact, 0, sizeof contact);
    contact.surface.mode = dContactSoftCFM;
    contact.surface.soft_cfm = 1e6;
    contact.geom.normal[2] = 1;
    contact.geom.depth = 1e-15;
    contact.geom.g1 = r->ball;
    contact.geom.g2 = r->ground;
    memcpy(contact.geom.pos, dBodyGetPosition(r->body[0]), sizeof contact.geom.pos);
    if (r->by != WITHOUT_CONTACTS)
        assert_int_equal(pinch_ode_add_contact(r->plugin, &contact, r->body[0], NULL), PINCH_OK);
    assert_int_equal(pinch_ode_step(r->plugin, H), PINCH_OK);
}

/* Quickstep's sweeps end early where ODE solves the joint. */
static double exactness(solved_by by, pinch_ode_stepper stepper)
{
    return by != BY_PINCH && stepper == PINCH_ODE_QUICKSTEP ? 1e-2 : 1e-10;
}

/* ---- the rates of coordinates ---- */

typedef struct kind {
    const char *name;
    int axis;
    dJointID (*make)(rig *r, dBodyID a, dBodyID b);
    dReal (*position)(dJointID joint);
    bool needs_two;
} kind;

static dJointID hinge(rig *r, dBodyID a, dBodyID b)
{
    dJointID j = dJointCreateHinge(r->world, NULL);
    dJointAttach(j, a, b);
    dJointSetHingeAnchor(j, 0.02, 0, 0.1);
    dJointSetHingeAxis(j, 0.6, 0, 0.8);
    return j;
}

static dJointID slider(rig *r, dBodyID a, dBodyID b)
{
    dJointID j = dJointCreateSlider(r->world, NULL);
    dJointAttach(j, a, b);
    dJointSetSliderAxis(j, 0.6, 0, 0.8);
    return j;
}

static dJointID universal(rig *r, dBodyID a, dBodyID b)
{
    dJointID j = dJointCreateUniversal(r->world, NULL);
    dJointAttach(j, a, b);
    dJointSetUniversalAnchor(j, 0.02, 0, 0.1);
    dJointSetUniversalAxis1(j, 0.6, 0, 0.8);
    dJointSetUniversalAxis2(j, 0, 1, 0);
    return j;
}

static dJointID hinge2(rig *r, dBodyID a, dBodyID b)
{
    const dVector3 axis1 = {0.6, 0, 0.8}, axis2 = {0, 1, 0};
    dJointID j = dJointCreateHinge2(r->world, NULL);
    dJointAttach(j, a, b);
    dJointSetHinge2Anchor(j, 0.02, 0, 0.1);
    dJointSetHinge2Axes(j, axis1, axis2);
    return j;
}

static dJointID pr(rig *r, dBodyID a, dBodyID b)
{
    dJointID j = dJointCreatePR(r->world, NULL);
    dJointAttach(j, a, b);
    dJointSetPRAxis1(j, 0, 1, 0);
    dJointSetPRAxis2(j, 0.6, 0, 0.8);
    dJointSetPRAnchor(j, 0.02, 0, 0.1);
    return j;
}

static dJointID pu(rig *r, dBodyID a, dBodyID b)
{
    dJointID j = dJointCreatePU(r->world, NULL);
    dJointAttach(j, a, b);
    dJointSetPUAxis1(j, 0.6, 0, 0.8);
    dJointSetPUAxis2(j, 0, 1, 0);
    dJointSetPUAxis3(j, 0.8, 0, -0.6);
    dJointSetPUAnchor(j, 0.02, 0, 0.1);
    return j;
}

static dJointID piston(rig *r, dBodyID a, dBodyID b)
{
    dJointID j = dJointCreatePiston(r->world, NULL);
    dJointAttach(j, a, b);
    dJointSetPistonAxis(j, 0.6, 0, 0.8);
    dJointSetPistonAnchor(j, 0.02, 0, 0.1);
    return j;
}

static const kind kinds[] = {
    {"hinge", 0, hinge, dJointGetHingeAngle, false},
    {"slider", 0, slider, dJointGetSliderPosition, false},
    {"universal 1", 0, universal, dJointGetUniversalAngle1, false},
    {"universal 2", 1, universal, dJointGetUniversalAngle2, false},
    {"hinge-2 1", 0, hinge2, dJointGetHinge2Angle1, true},
    {"hinge-2 2", 1, hinge2, dJointGetHinge2Angle2, true},
    {"PR 2", 1, pr, dJointGetPRAngle, true},
    {"PU 1", 0, pu, dJointGetPUAngle1, true},
    {"PU 2", 1, pu, dJointGetPUAngle2, true},
    {"piston 1", 0, piston, dJointGetPistonPosition, true},
    {"piston 2", 1, piston, dJointGetPistonAngle, true},
};

/* A damper without give moves the coordinate at its rate. The first step goes h times that far, to the second order of
 * the turn. */
static void test_every_coordinate_goes_at_its_rate(void **state)
{
    (void)state;
    int wrong = 0;
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
        for (int partner = 0; partner < 3; partner++) /* two bodies, the world behind and before */
            for (solved_by by = 0; by < SOLVED_BY_COUNT; by++) {
                static const double RATE = 0.002;
                if (partner > 0 && kinds[k].needs_two) continue;
                rig r;
                rig_make(&r, by, PINCH_ODE_WORLDSTEP);
                dWorldSetGravity(r.world, 0, 0, 0);
                dJointID j = kinds[k].make(&r, partner == 2 ? NULL : r.body[0],
                                           partner == 0   ? r.body[1]
                                           : partner == 2 ? r.body[0]
                                                          : NULL);
                (void)pinch_ode_note_joint(r.plugin, j);
                pinch_servo servo = pinch_default_servo();
                servo.kd = 1e9;
                servo.rate = RATE;
                assert_int_equal(pinch_ode_set_servo(r.plugin, j, kinds[k].axis, &servo), PINCH_OK);
                double before = kinds[k].position(j);
                rig_step(&r);
                double gone = kinds[k].position(j) - before;
                pinch_ode_stats stats = pinch_ode_statistics(r.plugin);
                if (!(fabs(gone - H * RATE) < 1e-6 * H * RATE) || stats.joints_solved != (by == BY_PINCH)) {
                    print_error("%s, partner %d, by %d: %g of %g, %ld solved\n", kinds[k].name, partner, by, gone,
                                H * RATE, stats.joints_solved);
                    wrong++;
                }
                rig_free(&r);
            }
    assert_int_equal(wrong, 0);
}

/* ---- spring and damper ---- */

/* The step response: I (w+ - w) = h clamp(kp (target - q - h w+) + kd (rate - w+)), q+ = q + h w+. */
static void test_step_response(void **state)
{
    (void)state;
    for (pinch_ode_stepper stepper = PINCH_ODE_WORLDSTEP; stepper <= PINCH_ODE_QUICKSTEP; stepper++)
        for (solved_by by = 0; by < SOLVED_BY_COUNT; by++)
            for (int bounded = 0; bounded < 2; bounded++) {
                rig r;
                double q = 0, w = 0, off = 0;
                rig_make(&r, by, stepper);
                dWorldSetGravity(r.world, 0, 0, 0);
                dJointID j = dJointCreateHinge(r.world, NULL);
                dJointAttach(j, r.body[0], NULL);
                dJointSetHingeAnchor(j, 0, 0, 0);
                dJointSetHingeAxis(j, 0, 0, 1);
                assert_int_equal(pinch_ode_note_joint(r.plugin, j), PINCH_OK);
                dMass mass;
                dBodyGetMass(r.body[0], &mass);
                double inertia = mass.I[10];
                pinch_servo servo = {.target = 0.7, .kp = 5, .kd = 0.01, .max_force = bounded ? 0.4 : INFINITY};
                assert_int_equal(pinch_ode_set_servo(r.plugin, j, 0, &servo), PINCH_OK);
                for (int step = 0; step < 500; step++) {
                    double g = H * servo.kp + servo.kd, trial = servo.kp * (servo.target - q) - g * w;
                    double force = trial / (1 + H * g / inertia), shown, position;
                    force = fmin(fmax(force, -servo.max_force), servo.max_force);
                    rig_step(&r);
                    assert_int_equal(pinch_ode_servo_state(r.plugin, j, 0, &position, &shown), PINCH_OK);
                    off = fmax(off, fmax(fabs(shown - force), fabs(position - q)));
                    w += H * force / inertia;
                    q += H * w;
                    off = fmax(off, fabs(dBodyGetAngularVel(r.body[0])[2] - w) / 10);
                }
                if (off > exactness(by, stepper))
                    print_error("stepper %d, by %d, bounded %d: off by %g\n", stepper, by, bounded, off);
                assert_true(off <= exactness(by, stepper));
                rig_free(&r);
            }
}

/* An arm of 0.1 m hangs on a servo, beside a bound or within it. At rest the torque is kp (target - q), and the weight
 * turns the arm by that; at its bound it is the bound. */
static void test_rest_and_bound(void **state)
{
    (void)state;
    for (pinch_ode_stepper stepper = PINCH_ODE_WORLDSTEP; stepper <= PINCH_ODE_QUICKSTEP; stepper++)
        for (solved_by by = 0; by < SOLVED_BY_COUNT; by++)
            for (int bounded = 0; bounded < 2; bounded++) {
                rig r;
                double position, force;
                rig_make(&r, by, stepper);
                dWorldSetGravity(r.world, 0, 0, -9.81);
                dBodySetPosition(r.body[1], 5, 0, 0);
                dBodySetKinematic(r.body[1]);
                dJointID j = dJointCreateHinge(r.world, NULL);
                dJointAttach(j, r.body[0], NULL);
                dJointSetHingeAnchor(j, -0.1, 0, 0);
                dJointSetHingeAxis(j, 0, 1, 0);
                assert_int_equal(pinch_ode_note_joint(r.plugin, j), PINCH_OK);
                double weight = 0.2 * 9.81;
                pinch_servo servo = {.target = -0.05, .kp = 20, .kd = 0.3, .max_force = bounded ? 0.1 : 5};
                assert_int_equal(pinch_ode_set_servo(r.plugin, j, 0, &servo), PINCH_OK);
                for (int stop = 0; stop < 2 && bounded; stop++) { /* holds what the servo does not */
                    dJointSetHingeParam(j, dParamLoStop, 0.02);
                    dJointSetHingeParam(j, dParamHiStop, 0.02);
                }
                for (int step = 0; step < 2000; step++) rig_step(&r);
                assert_int_equal(pinch_ode_servo_state(r.plugin, j, 0, &position, &force), PINCH_OK);
                double q = dJointGetHingeAngle(j), most = exactness(by, stepper);
                double expected = bounded ? -0.1 : servo.kp * (servo.target - q);
                double load = bounded ? expected : -0.1 * weight * cos(q);
                if (fabs(force - expected) > most || fabs(force - load) > most ||
                    dCalcVectorLength3(dBodyGetAngularVel(r.body[0])) > most)
                    print_error("stepper %d, by %d, bounded %d: force %.15g, spring %.15g, load %.15g, w %g\n", stepper,
                                by, bounded, force, expected, load, dCalcVectorLength3(dBodyGetAngularVel(r.body[0])));
                assert_true(fabs(force - expected) <= most && fabs(force - load) <= most);
                assert_true(dCalcVectorLength3(dBodyGetAngularVel(r.body[0])) <= most);
                rig_free(&r);
            }
}

static void test_wrong_calls(void **state)
{
    (void)state;
    rig r;
    double position, force;
    rig_make(&r, BY_PINCH, PINCH_ODE_WORLDSTEP);
    dJointID j = hinge(&r, r.body[0], r.body[1]), ball = dJointCreateBall(r.world, NULL);
    dJointAttach(ball, r.body[0], r.body[1]);
    dJointDisable(ball);
    pinch_servo servo = pinch_default_servo();
    servo.kp = 1;
    assert_int_equal(pinch_ode_set_servo(NULL, j, 0, &servo), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_set_servo(r.plugin, NULL, 0, &servo), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_set_servo(r.plugin, ball, 0, &servo), PINCH_INVALID_ARGUMENT);
    for (int axis = -1; axis < 4; axis++)
        assert_int_equal(pinch_ode_set_servo(r.plugin, j, axis, &servo), axis ? PINCH_INVALID_ARGUMENT : PINCH_OK);
    assert_int_equal(pinch_ode_servo_state(r.plugin, j, 0, &position, &force), PINCH_INVALID_ARGUMENT);
    const pinch_servo wrong[] = {{.kp = -1, .max_force = 1},
                                 {.kd = NAN, .max_force = 1},
                                 {.max_force = 0},
                                 {.target = INFINITY, .max_force = 1},
                                 {.max_force = NAN}};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++)
        assert_int_equal(pinch_ode_set_servo(r.plugin, j, 0, &wrong[k]), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_solve(r.plugin, H), PINCH_OK);
    assert_int_equal(pinch_ode_set_servo(r.plugin, j, 0, &servo), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_advance(r.plugin, H), PINCH_OK);
    assert_int_equal(pinch_ode_servo_state(r.plugin, j, 0, &position, &force), PINCH_OK);
    assert_int_equal(pinch_ode_set_servo(r.plugin, j, 0, NULL), PINCH_OK);
    assert_int_equal(pinch_ode_set_servo(r.plugin, j, 0, NULL), PINCH_OK);
    assert_int_equal(pinch_ode_servo_state(r.plugin, j, 0, &position, &force), PINCH_INVALID_ARGUMENT);
    rig_free(&r);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_coordinate_goes_at_its_rate),
        cmocka_unit_test(test_step_response),
        cmocka_unit_test(test_rest_and_bound),
        cmocka_unit_test(test_wrong_calls),
    };
    int failed = cmocka_run_group_tests_name("servos", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
