/*
 * Couplings of joint coordinates against closed forms: gears, mimics, tendons. Each under both steppers, with and
 * without a contact, with joints solved by Pinch and by ODE; and what becomes of them where an island is left to ODE.
 */
#include "support/cmocka_all.h"

#include <pinch/ode.h>
#include <string.h>

static const double H = 1e-3;

/* Who solves the joints. */
typedef enum solved_by { BY_PINCH = 0, WITHOUT_CONTACTS, BY_ODE, ALL_BY_ODE, SOLVED_BY_COUNT } solved_by;

enum { BODIES = 3 };

typedef struct rig {
    dWorldID world;
    pinch_ode *plugin;
    dBodyID body[BODIES];
    dJointID hinge[BODIES];
    dGeomID ball[BODIES], ground;
    double inertia[BODIES]; /* about z */
    solved_by by;
} rig;

/* Bodies on hinges about z through their centres: on the world, or each on the one before. */
static void rig_make(rig *r, solved_by by, pinch_ode_stepper stepper, bool chain)
{
    memset(r, 0, sizeof *r);
    r->by = by;
    r->world = dWorldCreate();
    dWorldSetCFM(r->world, 0);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = stepper;
    settings.joints_by_ode = by == BY_ODE;
    settings.ode_solves = by == ALL_BY_ODE;
    assert_int_equal(pinch_ode_create(r->world, &settings, &r->plugin), PINCH_OK);
    r->ground = dCreateSphere(NULL, 0.01);
    for (int i = 0; i < BODIES; i++) {
        dMass mass;
        r->body[i] = dBodyCreate(r->world);
        dMassSetBoxTotal(&mass, 0.2 + 0.1 * i, 0.1, 0.2, 0.3);
        r->inertia[i] = mass.I[10];
        dBodySetMass(r->body[i], &mass);
        dBodySetPosition(r->body[i], chain ? 0 : 0.5 * i, 0, 0.3 * i);
        dBodySetGyroscopicMode(r->body[i], 0);
        dBodySetFiniteRotationMode(r->body[i], 1); /* an angle grows by exactly h times its rate */
        r->hinge[i] = dJointCreateHinge(r->world, NULL);
        dJointAttach(r->hinge[i], r->body[i], chain && i > 0 ? r->body[i - 1] : NULL);
        dJointSetHingeAnchor(r->hinge[i], chain ? 0 : 0.5 * i, 0, 0.3 * i);
        dJointSetHingeAxis(r->hinge[i], 0, 0, 1);
        assert_int_equal(pinch_ode_note_joint(r->plugin, r->hinge[i]), PINCH_OK);
        r->ball[i] = dCreateSphere(NULL, 0.01);
        dGeomSetBody(r->ball[i], r->body[i]);
    }
}

static void rig_free(rig *r)
{
    pinch_ode_destroy(r->plugin);
    for (int i = 0; i < BODIES; i++) dGeomDestroy(r->ball[i]);
    dGeomDestroy(r->ground);
    dWorldDestroy(r->world);
}

/* The contact on the first body is open and carries nothing. */
static void rig_step(rig *r)
{
    dContact contact;
    memset(&contact, 0, sizeof contact);
    contact.surface.mode = dContactSoftCFM;
    contact.surface.soft_cfm = 1e6;
    contact.geom.normal[2] = 1;
    contact.geom.depth = 1e-15;
    contact.geom.g1 = r->ball[0];
    contact.geom.g2 = r->ground;
    memcpy(contact.geom.pos, dBodyGetPosition(r->body[0]), sizeof contact.geom.pos);
    if (r->by != WITHOUT_CONTACTS)
        assert_int_equal(pinch_ode_add_contact(r->plugin, &contact, r->body[0], NULL), PINCH_OK);
    assert_int_equal(pinch_ode_step(r->plugin, H), PINCH_OK);
}

static double angle(const rig *r, int k)
{
    return dJointGetHingeAngle(r->hinge[k]);
}

/* Quickstep's sweeps end early where ODE solves the joints. */
static double exactness(solved_by by, pinch_ode_stepper stepper)
{
    return by == ALL_BY_ODE ? 1e-2 : by == BY_ODE && stepper == PINCH_ODE_QUICKSTEP ? 1e-4 : 1e-10;
}

/* q1 = m q0 + c. A torque on the first turns both: w0' = torque / (I0 + m^2 I1), and the gear exerts I1 m w0'. */
static void test_gear(void **state)
{
    (void)state;
    enum { STEPS = 2000 }; /* some turns */
    static const double RATIO[] = {-1, 2.5, 0.2}, TORQUE = 5e-3;
    for (pinch_ode_stepper stepper = PINCH_ODE_WORLDSTEP; stepper <= PINCH_ODE_QUICKSTEP; stepper++)
        for (solved_by by = 0; by < SOLVED_BY_COUNT; by++)
            for (int k = 0; k < 3; k++) {
                rig r;
                int gear;
                double m = RATIO[k], off = 0, force_off = 0, turned = 0, most = exactness(by, stepper);
                rig_make(&r, by, stepper, false);
                const pinch_coupling_term terms[] = {{r.hinge[1], 0, 1}, {r.hinge[0], 0, -m}};
                pinch_servo rigid = {.target = 0, .kp = INFINITY, .max_force = INFINITY};
                assert_int_equal(pinch_ode_couple(r.plugin, terms, 2, &rigid, &gear), PINCH_OK);
                double rate = TORQUE / (r.inertia[0] + m * m * r.inertia[1]);
                for (int step = 0; step < STEPS; step++) {
                    double position, force;
                    dJointAddHingeTorque(r.hinge[0], TORQUE);
                    rig_step(&r);
                    assert_int_equal(pinch_ode_coupling_state(r.plugin, gear, &position, &force), PINCH_OK);
                    turned += remainder(angle(&r, 0) - turned, 2 * M_PI);
                    off = fmax(off, fabs(remainder(angle(&r, 1) - m * turned, 2 * M_PI)));
                    force_off = fmax(force_off, fabs(force - r.inertia[1] * m * rate));
                }
                double turned_off = fabs(turned / (rate * H * H * STEPS * (STEPS + 1) / 2) - 1);
                bool good = off <= most && turned_off <= (by == ALL_BY_ODE ? 1 : most * 100) &&
                            (by == ALL_BY_ODE || force_off <= most);
                if (!good)
                    print_error("stepper %d, by %d, ratio %g: angles off by %g, force by %g, turn by %g\n", stepper, by,
                                m, off, force_off, turned_off);
                assert_true(good);
                rig_free(&r);
            }
}

/* A tendon over the three hinges of a chain, each with a spring of its own, comes to rest where kp (target - x) a_i is
 * what each spring bears; at its bound it pulls by exactly that. */
static void test_tendon_at_rest(void **state)
{
    (void)state;
    static const double A[BODIES] = {1, 0.7, -0.4}, SPRING[BODIES] = {0.9, 0.6, 0.5};
    for (pinch_ode_stepper stepper = PINCH_ODE_WORLDSTEP; stepper <= PINCH_ODE_QUICKSTEP; stepper++)
        for (solved_by by = 0; by < BY_ODE; by++)
            for (int bounded = 0; bounded < 2; bounded++) {
                rig r;
                int tendon;
                double position, force, x = 0, off = 0, spin = 0;
                pinch_coupling_term terms[BODIES];
                rig_make(&r, by, stepper, true);
                for (int i = 0; i < BODIES; i++) {
                    pinch_servo spring = {.kp = SPRING[i], .kd = 0.08, .max_force = INFINITY};
                    assert_int_equal(pinch_ode_set_servo(r.plugin, r.hinge[i], 0, &spring), PINCH_OK);
                    terms[i] = (pinch_coupling_term){r.hinge[i], 0, A[i]};
                }
                pinch_servo law = {.target = 0.5, .kp = 3, .kd = 0.05, .max_force = bounded ? 0.15 : INFINITY};
                assert_int_equal(pinch_ode_couple(r.plugin, terms, BODIES, &law, &tendon), PINCH_OK);
                for (int step = 0; step < 12000; step++) rig_step(&r);
                assert_int_equal(pinch_ode_coupling_state(r.plugin, tendon, &position, &force), PINCH_OK);
                for (int i = 0; i < BODIES; i++) {
                    double q, torque;
                    assert_int_equal(pinch_ode_servo_state(r.plugin, r.hinge[i], 0, &q, &torque), PINCH_OK);
                    x += A[i] * angle(&r, i);
                    off = fmax(off, fmax(fabs(torque + A[i] * force), fabs(torque + SPRING[i] * angle(&r, i))));
                    spin = fmax(spin, dCalcVectorLength3(dBodyGetAngularVel(r.body[i])));
                }
                double expected = bounded ? 0.15 : law.kp * (law.target - x);
                bool good = fabs(force - expected) <= (bounded ? 0 : 1e-10) && off <= 1e-10 && spin <= 1e-10;
                if (!good)
                    print_error("stepper %d, by %d, bounded %d: force %.17g of %.17g, torques off by %g, w %g\n",
                                stepper, by, bounded, force, expected, off, spin);
                assert_true(good);
                rig_free(&r);
            }
}

/* A pendulum's weight turns a second wheel by a mimic, against a spring there: q1 = -2 q0 + 0.1 at rest to 1e-12, and
 * the mimic bears what the spring does. */
static void test_mimic_at_rest(void **state)
{
    (void)state;
    for (pinch_ode_stepper stepper = PINCH_ODE_WORLDSTEP; stepper <= PINCH_ODE_QUICKSTEP; stepper++)
        for (solved_by by = 0; by < BY_ODE; by++) {
            rig r;
            int mimic;
            double position, force, q, torque;
            rig_make(&r, by, stepper, false);
            dWorldSetGravity(r.world, 0, -9.81, 0);
            dJointSetHingeAnchor(r.hinge[0], -0.1, 0, 0);
            assert_int_equal(pinch_ode_note_joint(r.plugin, r.hinge[0]), PINCH_OK);
            pinch_servo spring = {.kp = 1, .kd = 0.1, .max_force = INFINITY};
            assert_int_equal(pinch_ode_set_servo(r.plugin, r.hinge[1], 0, &spring), PINCH_OK);
            const pinch_coupling_term terms[] = {{r.hinge[1], 0, 1}, {r.hinge[0], 0, 2}};
            pinch_servo rigid = {.target = 0.1, .kp = INFINITY, .max_force = INFINITY};
            assert_int_equal(pinch_ode_couple(r.plugin, terms, 2, &rigid, &mimic), PINCH_OK);
            for (int step = 0; step < 12000; step++) rig_step(&r);
            assert_int_equal(pinch_ode_coupling_state(r.plugin, mimic, &position, &force), PINCH_OK);
            assert_int_equal(pinch_ode_servo_state(r.plugin, r.hinge[1], 0, &q, &torque), PINCH_OK);
            double tied = fabs(angle(&r, 1) + 2 * angle(&r, 0) - 0.1), load = 0.2 * 9.81 * 0.1 * cos(angle(&r, 0));
            bool good = tied <= 1e-12 && fabs(force + torque) <= 1e-10 && fabs(2 * force - load) <= 1e-10;
            if (!good)
                print_error("stepper %d, by %d: tie off by %g, force %.15g, spring %.15g, load %.15g\n", stepper, by,
                            tied, force, torque, load);
            assert_true(good);
            rig_free(&r);
        }
}

/* Two jaws on sliders, one the mimic of the other, close on a ball that lies off the middle, and hold it. The servo's
 * force is that of both jaws, and each has half of it. */
static void test_mimic_jaws_hold_a_ball(void **state)
{
    (void)state;
    for (pinch_ode_stepper stepper = PINCH_ODE_WORLDSTEP; stepper <= PINCH_ODE_QUICKSTEP; stepper++) {
        dWorldID world = dWorldCreate();
        dWorldSetGravity(world, 0, 0, -9.81);
        pinch_ode *plugin;
        pinch_ode_settings settings = pinch_ode_default_settings();
        settings.stepper = stepper;
        assert_int_equal(pinch_ode_create(world, &settings, &plugin), PINCH_OK);
        dMass mass;
        dBodyID jaw[2], ball = dBodyCreate(world);
        dGeomID geom[3] = {dCreateBox(NULL, 0.02, 0.1, 0.1), dCreateBox(NULL, 0.02, 0.1, 0.1),
                           dCreateSphere(NULL, 0.02)};
        dJointID slider[2];
        dMassSetSphereTotal(&mass, 0.1, 0.02);
        dBodySetMass(ball, &mass);
        dBodySetPosition(ball, 0.003, 0, 0);
        dGeomSetBody(geom[2], ball);
        pinch_material material = pinch_default_material();
        for (int k = 0; k < 2; k++) {
            jaw[k] = dBodyCreate(world);
            dMassSetBoxTotal(&mass, 0.2, 0.02, 0.1, 0.1);
            dBodySetMass(jaw[k], &mass);
            dBodySetPosition(jaw[k], k ? 0.035 : -0.035, 0, 0);
            dGeomSetBody(geom[k], jaw[k]);
            slider[k] = dJointCreateSlider(world, NULL);
            dJointAttach(slider[k], jaw[k], NULL);
            dJointSetSliderAxis(slider[k], 1, 0, 0);
            assert_int_equal(pinch_ode_note_joint(plugin, slider[k]), PINCH_OK);
            assert_int_equal(pinch_ode_set_material(plugin, geom[k], &material), PINCH_OK);
        }
        int mimic;
        const pinch_coupling_term terms[] = {{slider[1], 0, 1}, {slider[0], 0, 1}};
        pinch_servo rigid = {.kp = INFINITY, .max_force = INFINITY};
        pinch_servo servo = {.target = 0.02, .kp = 800, .kd = 40, .max_force = 12};
        assert_int_equal(pinch_ode_couple(plugin, terms, 2, &rigid, &mimic), PINCH_OK);
        assert_int_equal(pinch_ode_set_servo(plugin, slider[0], 0, &servo), PINCH_OK);
        dBodySetGravityMode(ball, 0);
        double before[3];
        for (int step = 0; step < 6000; step++) {
            if (step == 1000) dBodySetGravityMode(ball, 1);
            if (step == 5000) memcpy(before, dBodyGetPosition(ball), sizeof before);
            for (int k = 0; k < 2; k++) {
                dContact contact;
                memset(&contact, 0, sizeof contact);
                if (dCollide(geom[2], geom[k], 1, &contact.geom, sizeof contact.geom) == 1)
                    assert_int_equal(pinch_ode_add_contact(plugin, &contact, ball, jaw[k]), PINCH_OK);
            }
            assert_int_equal(pinch_ode_step(plugin, H), PINCH_OK);
        }
        const pinch_ode_contact *list;
        int count;
        double x, f, q, driven, creep = 0;
        assert_int_equal(pinch_ode_contacts(plugin, &list, &count), PINCH_OK);
        assert_int_equal(pinch_ode_coupling_state(plugin, mimic, &x, &f), PINCH_OK);
        assert_int_equal(pinch_ode_servo_state(plugin, slider[0], 0, &q, &driven), PINCH_OK);
        assert_int_equal(count, 2);
        for (int i = 0; i < 3; i++) creep = fmax(creep, fabs(dBodyGetPosition(ball)[i] - before[i]));
        double off = fmax(fabs(list[0].normal_force - driven / 2), fabs(list[1].normal_force - driven / 2));
        pinch_ode_stats stats = pinch_ode_statistics(plugin);
        bool good = fabs(x) <= 1e-12 && off <= 1e-9 && fabs(f + driven / 2) <= 1e-9 && creep <= 1e-12 &&
                    stats.fallback_islands == 0 && stats.unconverged_steps == 0 && driven > 1;
        if (!good)
            print_error("stepper %d: mimic off by %g, forces %g and %g, drive %g, tie %g, creep %g, %ld fallbacks\n",
                        stepper, x, list[0].normal_force, list[1].normal_force, driven, f, creep,
                        stats.fallback_islands);
        assert_true(good);
        pinch_ode_destroy(plugin);
        for (int k = 0; k < 3; k++) dGeomDestroy(geom[k]);
        dWorldDestroy(world);
    }
}

/* The same gear twice, and a third coupling that follows from them, share what they carry. */
static void test_dependent_couplings(void **state)
{
    (void)state;
    rig r;
    int gear[3];
    rig_make(&r, WITHOUT_CONTACTS, PINCH_ODE_WORLDSTEP, false);
    const pinch_coupling_term terms[] = {{r.hinge[1], 0, 1}, {r.hinge[0], 0, -2}};
    const pinch_coupling_term twice[] = {{r.hinge[1], 0, 3}, {r.hinge[0], 0, -6}};
    pinch_servo rigid = {.kp = INFINITY, .max_force = INFINITY};
    for (int k = 0; k < 3; k++)
        assert_int_equal(pinch_ode_couple(r.plugin, k < 2 ? terms : twice, 2, &rigid, &gear[k]), PINCH_OK);
    double sum = 0, rate = 2e-4 / (r.inertia[0] + 4 * r.inertia[1]);
    for (int step = 0; step < 500; step++) {
        dJointAddHingeTorque(r.hinge[0], 2e-4);
        rig_step(&r);
    }
    for (int k = 0; k < 3; k++) {
        double x, f;
        assert_int_equal(pinch_ode_coupling_state(r.plugin, gear[k], &x, &f), PINCH_OK);
        sum += (k < 2 ? 1 : 3) * f;
    }
    assert_true(fabs(sum - 2 * r.inertia[1] * rate) <= 1e-10);
    assert_true(fabs(angle(&r, 1) - 2 * angle(&r, 0)) <= 1e-9);
    assert_int_equal(pinch_ode_statistics(r.plugin).fallback_islands, 0);
    rig_free(&r);
}

static void test_wrong_calls(void **state)
{
    (void)state;
    rig r;
    int number;
    double x, f;
    rig_make(&r, BY_PINCH, PINCH_ODE_WORLDSTEP, false);
    dJointID ball = dJointCreateBall(r.world, NULL);
    pinch_servo law = {.kp = 1, .max_force = 1};
    const pinch_coupling_term good[] = {{r.hinge[0], 0, 1}, {r.hinge[1], 0, 1}};
    const pinch_coupling_term bad[] = {
        {NULL, 0, 1}, {ball, 0, 1}, {r.hinge[0], 1, 1}, {r.hinge[0], 0, 0}, {r.hinge[0], 0, NAN}};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        assert_int_equal(pinch_ode_couple(r.plugin, &bad[k], 1, &law, &number), PINCH_INVALID_ARGUMENT);
    const pinch_servo wrong[] = {{.kp = -1, .max_force = 1},
                                 {.kp = 1, .kd = NAN, .max_force = 1},
                                 {.kp = 1},
                                 {.kp = INFINITY, .target = INFINITY, .max_force = 1},
                                 {.kp = NAN, .max_force = 1}};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++)
        assert_int_equal(pinch_ode_couple(r.plugin, good, 2, &wrong[k], &number), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_couple(r.plugin, good, 0, &law, &number), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_couple(r.plugin, good, PINCH_COUPLING_TERMS + 1, &law, &number), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_couple(NULL, good, 2, &law, &number), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_set_coupling(r.plugin, 0, &law), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_couple(r.plugin, good, 2, &law, &number), PINCH_OK);
    assert_int_equal(pinch_ode_coupling_state(r.plugin, number, &x, &f), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_set_coupling(r.plugin, number, &wrong[0]), PINCH_INVALID_ARGUMENT);
    rig_step(&r);
    assert_int_equal(pinch_ode_coupling_state(r.plugin, number, &x, &f), PINCH_OK);
    assert_int_equal(pinch_ode_solve(r.plugin, H), PINCH_OK);
    assert_int_equal(pinch_ode_set_coupling(r.plugin, number, NULL), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_advance(r.plugin, H), PINCH_OK);
    dJointDisable(r.hinge[1]); /* it does not act meanwhile */
    rig_step(&r);
    assert_int_equal(pinch_ode_coupling_state(r.plugin, number, &x, &f), PINCH_OK);
    assert_true(f == 0);
    dJointEnable(r.hinge[1]);
    assert_int_equal(pinch_ode_set_coupling(r.plugin, number, NULL), PINCH_OK);
    assert_int_equal(pinch_ode_set_coupling(r.plugin, number, NULL), PINCH_INVALID_ARGUMENT);
    dJointDestroy(r.hinge[1]);
    rig_step(&r);
    rig_free(&r);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gear),
        cmocka_unit_test(test_tendon_at_rest),
        cmocka_unit_test(test_mimic_at_rest),
        cmocka_unit_test(test_mimic_jaws_hold_a_ball),
        cmocka_unit_test(test_dependent_couplings),
        cmocka_unit_test(test_wrong_calls),
    };
    int failed = cmocka_run_group_tests_name("couplings", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
