/*
 * Steps of varying length, and contacts of varying stiffness and damping. What sticks by soft contacts keeps its place,
 * whether the program holds stiffness and damping, and gives ERP and CFM for each step, or holds ERP and CFM. A contact
 * that really becomes stiffer keeps its force. Short steps throw nothing.
 */
#include "support/cmocka_all.h"

#include <ode/ode.h>

#include <math.h>
#include <pinch/ode.h>
#include <string.h>

static const double LONG_STEP = 2e-3; /* s */
static const double SLOPE = 0.2, FRICTION = 0.6, STIFFNESS = 5000, DAMPING = 10;

/* A box on a slope, by tilted gravity. */
typedef struct slope {
    pinch_ode *plugin;
    dWorldID world;
    dSpaceID space;
    dBodyID box;
    dGeomID ground, geom;
    double stiffness, damping; /* of a contact, where it is soft */
    bool keeps_parameters;     /* those of a long step */
    bool hard;
} slope;

static slope make_slope(void)
{
    slope s = {.world = dWorldCreate(), .space = dSimpleSpaceCreate(NULL), .stiffness = STIFFNESS, .damping = DAMPING};
    pinch_ode_settings settings = pinch_ode_default_settings();
    assert_int_equal(pinch_ode_create(s.world, &settings, &s.plugin), PINCH_OK);
    dWorldSetGravity(s.world, 9.81 * sin(SLOPE), 0, -9.81 * cos(SLOPE));
    s.ground = dCreatePlane(s.space, 0, 0, 1, 0);
    s.geom = dCreateBox(s.space, 0.1, 0.1, 0.05);
    s.box = dBodyCreate(s.world);
    dMass mass;
    dMassSetBoxTotal(&mass, 0.4, 0.1, 0.1, 0.05);
    dBodySetMass(s.box, &mass);
    dGeomSetBody(s.geom, s.box);
    dBodySetPosition(s.box, 0, 0, 0.025);
    return s;
}

static void destroy(slope *s)
{
    assert_int_equal(pinch_ode_statistics(s->plugin).unconverged_steps, 0);
    pinch_ode_destroy(s->plugin);
    dSpaceDestroy(s->space);
    dWorldDestroy(s->world);
}

static void step(slope *s, double h)
{
    enum { MOST = 8 };
    dContact contact[MOST];
    int count = dCollide(s->geom, s->ground, MOST, &contact[0].geom, sizeof contact[0]);
    double of = s->keeps_parameters ? LONG_STEP : h, g = of * s->stiffness + s->damping;
    for (int k = 0; k < count; k++) {
        memset(&contact[k].surface, 0, sizeof contact[k].surface);
        contact[k].surface.mode = dContactApprox1 | (s->hard ? 0 : dContactSoftERP | dContactSoftCFM);
        contact[k].surface.mu = FRICTION;
        contact[k].surface.soft_erp = of * s->stiffness / g;
        contact[k].surface.soft_cfm = 1 / g;
        assert_int_equal(pinch_ode_add_contact(s->plugin, &contact[k], s->box, NULL), PINCH_OK);
    }
    assert_int_equal(pinch_ode_step(s->plugin, h), PINCH_OK);
}

/* Steps by a long and a short step, many times. */
static void step_in_turns(slope *s, double ratio, int turns)
{
    for (int k = 0; k < turns; k++) {
        step(s, LONG_STEP);
        step(s, LONG_STEP / ratio);
    }
}

static const double ratios[] = {1.01, 1.5, 2, 10};
enum { RATIOS = sizeof ratios / sizeof *ratios, SETTLE = 400, LONG = 1000 };

/* Returns how far (m) the box slides along the slope and into it while the steps vary. */
static double slide(bool keeps_parameters, bool hard, double ratio)
{
    slope s = make_slope();
    s.keeps_parameters = keeps_parameters;
    s.hard = hard;
    step_in_turns(&s, ratio, SETTLE);
    double x = dBodyGetPosition(s.box)[0], z = dBodyGetPosition(s.box)[2];
    step_in_turns(&s, ratio, LONG);
    double slid = hypot(dBodyGetPosition(s.box)[0] - x, dBodyGetPosition(s.box)[2] - z);
    assert_true(z > 0.024 && z < 0.025 + 1e-9);
    destroy(&s);
    return slid;
}

static void test_stiffness_and_damping_are_kept(void **state)
{
    (void)state;
    for (int k = 0; k < RATIOS; k++) assert_true(slide(false, false, ratios[k]) < 1e-12);
}

static void test_erp_and_cfm_are_kept(void **state)
{
    (void)state;
    for (int k = 0; k < RATIOS; k++) assert_true(slide(true, false, ratios[k]) < 1e-9);
}

static void test_hard_contacts(void **state)
{
    (void)state;
    for (int k = 0; k < RATIOS; k++) assert_true(slide(false, true, ratios[k]) < 1e-9);
}

/* Lets the slope be level, and returns by how much (m) the box springs back. */
static double spring_back(slope *s, double h)
{
    double x = dBodyGetPosition(s->box)[0];
    dWorldSetGravity(s->world, 0, 0, -9.81 * cos(SLOPE));
    for (int k = 0; k < SETTLE; k++) step(s, h);
    return x - dBodyGetPosition(s->box)[0];
}

/* What the weight along the slope does: four contacts shear, with two thirds of the stiffness, and as it pulls above
 * them the box tilts. */
static double sheared(void)
{
    return 0.4 * 9.81 * sin(SLOPE) / (4 * pinch_ode_default_settings().tangential_ratio * STIFFNESS);
}

static double tilted(void)
{
    static const double HEIGHT = 0.025, ARM = 0.05;
    return HEIGHT * (HEIGHT * 0.4 * 9.81 * sin(SLOPE)) / (4 * STIFFNESS * ARM * ARM);
}

/* The shear of a box that sticks is what its weight makes of it, however the steps vary. */
static void test_the_shear_is_that_of_the_stiffness(void **state)
{
    (void)state;
    for (int k = 0; k < RATIOS; k++) {
        slope s = make_slope();
        step_in_turns(&s, ratios[k], SETTLE);
        assert_close(spring_back(&s, LONG_STEP) / (sheared() + tilted()), 1, 1e-3);
        destroy(&s);
    }
}

/* A contact of twice the stiffness would push the box back by half of its shear. Its force stays instead, and the box
 * comes back by half of its tilt alone. */
static void test_what_becomes_stiffer_keeps_its_force(void **state)
{
    (void)state;
    slope s = make_slope();
    for (int k = 0; k < SETTLE; k++) step(&s, LONG_STEP);
    double x = dBodyGetPosition(s.box)[0];
    s.stiffness *= 2;
    for (int k = 0; k < SETTLE; k++) step(&s, LONG_STEP);
    assert_close((x - dBodyGetPosition(s.box)[0]) / (0.5 * tilted()), 1, 0.05);
    destroy(&s);
}

/* Damping is no stiffness: what is damped more, or in turns more and less, stays where it is. */
static void test_what_is_damped_more_stays(void **state)
{
    (void)state;
    slope s = make_slope();
    for (int k = 0; k < SETTLE; k++) step(&s, LONG_STEP);
    double x = dBodyGetPosition(s.box)[0];
    for (int k = 0; k < LONG; k++) {
        s.damping = k % 2 ? DAMPING : 10 * DAMPING;
        step(&s, LONG_STEP);
    }
    assert_close(dBodyGetPosition(s.box)[0], x, 1e-9);
    destroy(&s);
}

/* What sleeps meanwhile remembers the step that it was last solved in. */
static void test_steps_change_while_it_sleeps(void **state)
{
    (void)state;
    enum { ROUNDS = 10, AWAKE = 100 };
    static const double steps[] = {20e-3, 1e-3};
    slope s = make_slope();
    for (int k = 0; k < SETTLE; k++) step(&s, steps[1]);
    double x = dBodyGetPosition(s.box)[0];
    for (int i = 0; i < ROUNDS; i++)
        for (int k = 0; k < 2; k++) {
            dBodyDisable(s.box);
            step(&s, steps[1 - k]);
            step(&s, steps[k]);
            dBodyEnable(s.box);
            for (int j = 0; j < AWAKE; j++) step(&s, steps[k]);
        }
    assert_close(dBodyGetPosition(s.box)[0], x, 1e-9);
    destroy(&s);
}

/* One very short step, as frame loops leave them over. What a contact has sunk in by in long steps is no reason to
 * push it out within a short one: the box hops by less than a millimetre. */
static void test_a_very_short_step_throws_nothing(void **state)
{
    (void)state;
    static const double shorts[] = {1e-5, 1e-6, 1e-7, 1e-9, 1e-12}, FRAME = 1e-2, DEEPEST = 1e-5;
    for (int i = 0; i < 5; i++) {
        slope s = make_slope();
        s.hard = true;
        for (int k = 0; k < SETTLE; k++) step(&s, FRAME);
        double x = dBodyGetPosition(s.box)[0], z = dBodyGetPosition(s.box)[2];
        step(&s, shorts[i]);
        assert_true(dBodyGetLinearVel(s.box)[2] < 10 * sqrt(2 * 9.81 * DEEPEST));
        for (int k = 0; k < SETTLE; k++) step(&s, FRAME);
        assert_close(dBodyGetPosition(s.box)[0], x, 1e-3);
        assert_close(dBodyGetPosition(s.box)[2], z, DEEPEST);
        destroy(&s);
    }
}

/* Returns the largest speed (m/s) of a box in some steps. */
static double fastest_of(slope *s, double h, int steps)
{
    double fastest = 0;
    for (int k = 0; k < steps; k++) {
        const double *v = dBodyGetLinearVel(s->box);
        step(s, h);
        fastest = fmax(fastest, sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
    }
    return fastest;
}

/* The depth in which a box rests bears its load, and is no overlap: the box leaves short steps, be it one or some, at
 * no more than the depth would have it come up with in a long one. */
static void test_what_rests_leaves_short_steps_slowly(void **state)
{
    (void)state;
    enum { SOME = 20 };
    static const double frames[] = {1e-3, 2e-3, 5e-3, 1e-2}, shorts[] = {1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-12};
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 7; k++) {
            slope s = make_slope();
            s.hard = true;
            for (int n = 0; n < SETTLE; n++) step(&s, frames[i]);
            double x = dBodyGetPosition(s.box)[0], z = dBodyGetPosition(s.box)[2];
            assert_true(fastest_of(&s, shorts[k], 1) < 1e-4);
            assert_true(fastest_of(&s, frames[i], SETTLE) < 1e-4);
            assert_true(fastest_of(&s, shorts[k], SOME) < 1e-4);
            assert_true(fastest_of(&s, frames[i], SETTLE) < 1e-4);
            assert_close(dBodyGetPosition(s.box)[0], x, 1e-8);
            assert_close(dBodyGetPosition(s.box)[2], z, 1e-8);
            assert_int_equal(pinch_ode_statistics(s.plugin).fallback_islands, 0);
            destroy(&s);
        }
}

/* What is really in the ground comes out of it, however steps vary, and after one in which a program hangs as well: by
 * the speed that takes it out against gravity or that of a fiftieth of its size at most, and within a second. */
static void test_overlaps_come_up_however_steps_vary(void **state)
{
    (void)state;
    static const double depths[] = {1e-3, 5e-3, 0.015}, firsts[] = {1e-2, 2e-3, 0.5};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            slope s = make_slope();
            s.hard = true;
            dWorldSetGravity(s.world, 0, 0, -9.81);
            dBodySetPosition(s.box, 0, 0, 0.025);
            step(&s, firsts[k]);
            dBodySetPosition(s.box, 0, 0, 0.025 - depths[i]);
            dBodySetLinearVel(s.box, 0, 0, 0);
            double fastest = 0;
            for (int n = 0; n < 1000; n++)
                fastest = fmax(fastest, fastest_of(&s, n % 20 ? 1e-3 : n % 40 ? 1e-7 : 5e-3, 1));
            assert_true(fastest < sqrt(2 * 9.81 * depths[i]) + 0.12);
            assert_close(dBodyGetPosition(s.box)[2], 0.025, 1e-6);
            destroy(&s);
        }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_stiffness_and_damping_are_kept),
        cmocka_unit_test(test_erp_and_cfm_are_kept),
        cmocka_unit_test(test_hard_contacts),
        cmocka_unit_test(test_the_shear_is_that_of_the_stiffness),
        cmocka_unit_test(test_what_becomes_stiffer_keeps_its_force),
        cmocka_unit_test(test_what_is_damped_more_stays),
        cmocka_unit_test(test_steps_change_while_it_sleeps),
        cmocka_unit_test(test_a_very_short_step_throws_nothing),
        cmocka_unit_test(test_what_rests_leaves_short_steps_slowly),
        cmocka_unit_test(test_overlaps_come_up_however_steps_vary),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
