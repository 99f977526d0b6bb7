/* Under force control the normal force is exactly the drive's, in every step in which the finger touches. */
#include "support/cmocka_all.h"

#include <pinch/ode.h>
#include <string.h>

static const double STEP = 1e-3;

/* A cube of 4 cm on a static anvil on its right, pushed from the left by a driven tip. No gravity. */
typedef struct press {
    dWorldID world;
    pinch_ode *plugin;
    dBodyID cube, driver;
    dGeomID cube_geom, tip, anvil;
} press;

static const double AXIS[3] = {1, 0, 0};

static void press_make(press *p, dGeomID tip, double tip_reach, double gap)
{
    memset(p, 0, sizeof *p);
    p->world = dWorldCreate();
    p->cube = dBodyCreate(p->world);
    dMass mass;
    dMassSetBoxTotal(&mass, 0.1, 0.04, 0.04, 0.04);
    dBodySetMass(p->cube, &mass);
    p->cube_geom = dCreateBox(NULL, 0.04, 0.04, 0.04);
    dGeomSetBody(p->cube_geom, p->cube);
    p->anvil = dCreateBox(NULL, 0.02, 0.2, 0.2);
    dGeomSetPosition(p->anvil, 0.03, 0, 0);
    p->tip = tip;
    p->driver = dBodyCreate(p->world);
    dBodySetKinematic(p->driver);
    dGeomSetBody(tip, p->driver);
    dBodySetPosition(p->driver, -0.02 - tip_reach - gap, 0, 0);
    pinch_ode_settings settings = pinch_ode_default_settings();
    pinch_material m = pinch_default_material();
    assert_int_equal(pinch_ode_create(p->world, &settings, &p->plugin), PINCH_OK);
    assert_int_equal(pinch_ode_set_material(p->plugin, p->tip, &m), PINCH_OK);
    m.damping[0] = 60;
    assert_int_equal(pinch_ode_set_material(p->plugin, p->anvil, &m), PINCH_OK);
}

static void press_free(press *p)
{
    pinch_ode_destroy(p->plugin);
    dGeomDestroy(p->cube_geom);
    dGeomDestroy(p->tip);
    dGeomDestroy(p->anvil);
    dWorldDestroy(p->world);
}

static void collide(press *p, dGeomID a, dGeomID b)
{
    dContactGeom found[8];
    int count = dCollide(a, b, 8, found, sizeof found[0]);
    for (int i = 0; i < count; i++) {
        dContact contact;
        memset(&contact, 0, sizeof contact);
        contact.geom = found[i];
        assert_int_equal(
            pinch_ode_add_contact(p->plugin, &contact, dGeomGetBody(found[i].g1), dGeomGetBody(found[i].g2)), PINCH_OK);
    }
}

static void press_step(press *p)
{
    collide(p, p->tip, p->cube_geom);
    collide(p, p->cube_geom, p->anvil);
    assert_int_equal(pinch_ode_step(p->plugin, STEP), PINCH_OK);
}

/* Force of the driven tip along the axis, and how many of its points are loaded. */
static double driver_force(const press *p, int *points)
{
    const pinch_ode_contact *list;
    int count;
    double sum = 0;
    *points = 0;
    assert_int_equal(pinch_ode_contacts(p->plugin, &list, &count), PINCH_OK);
    for (int i = 0; i < count; i++) {
        if (list[i].geom1 != p->tip && list[i].geom2 != p->tip) continue;
        sum += (list[i].geom1 == p->tip ? -1 : 1) * list[i].force[0];
        *points += list[i].normal_force > 0;
    }
    return sum;
}

static void test_exact_force_with_any_number_of_points(void **state)
{
    (void)state;
    static const double reach[2] = {0.01, 0.005};
    for (int flat = 0; flat < 2; flat++) {
        press p;
        press_make(&p, flat ? dCreateBox(NULL, 0.01, 0.03, 0.03) : dCreateSphere(NULL, 0.01), reach[flat], -1e-6);
        assert_int_equal(pinch_ode_set_drive(p.plugin, p.driver, AXIS, 5), PINCH_OK);
        int touching = 0, points, most = 0;
        for (int step = 0; step < 1000; step++) {
            press_step(&p);
            double force = driver_force(&p, &points);
            if (points > most) most = points;
            if (points == 0) continue;
            touching++;
            assert_close(force, 5, 1e-9); /* the balance of a drive is solved to 1e-10 of the forces, here some 10 N */
        }
        assert_true(touching > 990);
        assert_int_equal(most, flat ? 4 : 1);
        pinch_ode_stats stats = pinch_ode_statistics(p.plugin);
        assert_int_equal(stats.unconverged_steps, 0);
        assert_close(dCalcVectorLength3(dBodyGetLinearVel(p.cube)), 0, 1e-12); /* settled between tip and anvil */
        assert_close(dCalcVectorLength3(dBodyGetLinearVel(p.driver)), 0, 1e-12);
        press_free(&p);
    }
}

/* A pulsating force is followed in the very step that it is set for. */
static void test_force_follows_at_once(void **state)
{
    (void)state;
    press p;
    press_make(&p, dCreateSphere(NULL, 0.01), 0.01, -1e-6);
    for (int step = 0; step < 500; step++) {
        double wanted = 5 + 3 * sin(0.05 * step);
        int points;
        assert_int_equal(pinch_ode_set_drive(p.plugin, p.driver, AXIS, wanted), PINCH_OK);
        press_step(&p);
        double force = driver_force(&p, &points);
        assert_int_equal(points, 1);
        assert_close(force, wanted, 1e-9);
    }
    press_free(&p);
}

/* What rests under a drive is solved anew for another force, and not where the force was only told once more. */
static void test_another_force_ends_rest(void **state)
{
    (void)state;
    press p;
    press_make(&p, dCreateSphere(NULL, 0.01), 0.01, -1e-6);
    assert_int_equal(pinch_ode_set_drive(p.plugin, p.driver, AXIS, 5), PINCH_OK);
    for (int step = 0; step < 1500; step++) press_step(&p);
    const double forces[] = {5, 7, 7};
    const bool rests[] = {true, false, true};
    for (int k = 0; k < 3; k++) {
        int points;
        if (k == 2)
            for (int step = 0; step < 1500; step++) press_step(&p);
        long before = pinch_ode_statistics(p.plugin).islands_at_rest;
        assert_int_equal(pinch_ode_set_drive(p.plugin, p.driver, AXIS, 4), PINCH_OK);
        assert_int_equal(pinch_ode_set_drive(p.plugin, p.driver, AXIS, forces[k]), PINCH_OK);
        press_step(&p);
        assert_close(driver_force(&p, &points), forces[k], 1e-9);
        assert_int_equal(pinch_ode_statistics(p.plugin).islands_at_rest - before, rests[k]);
    }
    press_free(&p);
}

/* The base's own motion comes on top: it moves across at 5 cm/s and the force stays; it does not drift along. */
static void test_base_moves(void **state)
{
    (void)state;
    press p;
    press_make(&p, dCreateSphere(NULL, 0.01), 0.01, -1e-6);
    pinch_material m = pinch_default_material();
    m.friction = m.friction_kinetic = 0.1;
    assert_int_equal(pinch_ode_set_material(p.plugin, p.tip, &m), PINCH_OK);
    assert_int_equal(pinch_ode_set_drive(p.plugin, p.driver, AXIS, 5), PINCH_OK);
    for (int step = 0; step < 500; step++) press_step(&p);
    double y = dBodyGetPosition(p.driver)[1];
    dBodySetLinearVel(p.driver, 0, 0.05, 0);
    for (int step = 0; step < 100; step++) {
        int points;
        press_step(&p);
        assert_close(driver_force(&p, &points), 5, 1e-9);
        assert_close(dBodyGetLinearVel(p.driver)[1], 0.05, 0); /* as its owner set it */
        assert_close(dBodyGetLinearVel(p.driver)[0], 0, 0);    /* the drive's part is taken off again */
    }
    assert_close(dBodyGetPosition(p.driver)[1] - y, 0.005, 1e-12);
    const pinch_ode_contact *list;
    int count;
    assert_int_equal(pinch_ode_contacts(p.plugin, &list, &count), PINCH_OK);
    for (int i = 0; i < count; i++)
        if (list[i].geom1 == p.tip || list[i].geom2 == p.tip) assert_int_equal(list[i].state, PINCH_CONTACT_SLIP);
    press_free(&p);
}

/* It pushes through: without an anvil it accelerates the cube as the force says, without its own mass. */
static void test_pushes_a_free_body(void **state)
{
    (void)state;
    press p;
    press_make(&p, dCreateSphere(NULL, 0.01), 0.01, -1e-6);
    dGeomSetPosition(p.anvil, 1, 0, 0);
    assert_int_equal(pinch_ode_set_drive(p.plugin, p.driver, AXIS, 0.5), PINCH_OK);
    for (int step = 0; step < 50; step++) press_step(&p);
    assert_close(dBodyGetLinearVel(p.cube)[0], 0.5 / 0.1 * 0.05, 1e-9);
    press_free(&p);
}

static void test_stays_where_it_touches_nothing(void **state)
{
    (void)state;
    press p;
    int points;
    press_make(&p, dCreateSphere(NULL, 0.01), 0.01, 0.01); /* 1 cm away */
    assert_int_equal(pinch_ode_set_drive(p.plugin, p.driver, AXIS, 5), PINCH_OK);
    double x = dBodyGetPosition(p.driver)[0];
    for (int step = 0; step < 100; step++) press_step(&p);
    assert_close(dBodyGetPosition(p.driver)[0], x, 0);
    assert_close(driver_force(&p, &points), 0, 0);
    /* touch, then the cube is taken away faster than the tip can follow in a step */
    dBodySetPosition(p.driver, -0.03, 0, 0);
    assert_int_equal(pinch_ode_forget_geom(p.plugin, p.tip), PINCH_OK);
    for (int step = 0; step < 100; step++) press_step(&p);
    assert_close(driver_force(&p, &points), 5, 1e-9);
    assert_int_equal(pinch_ode_forget_geom(p.plugin, p.cube_geom), PINCH_OK);
    dBodySetPosition(p.cube, 0, 1, 0);
    x = dBodyGetPosition(p.driver)[0];
    for (int step = 0; step < 100; step++) press_step(&p);
    assert_close(dBodyGetPosition(p.driver)[0], x, 0);
    assert_close(driver_force(&p, &points), 0, 0);
    press_free(&p);
}

static void test_a_drive_ends(void **state)
{
    (void)state;
    press p;
    int points;
    press_make(&p, dCreateSphere(NULL, 0.01), 0.01, -1e-6);
    assert_int_equal(pinch_ode_set_drive(p.plugin, p.driver, AXIS, 5), PINCH_OK);
    for (int step = 0; step < 500; step++) press_step(&p);
    assert_int_equal(pinch_ode_set_drive(p.plugin, p.driver, AXIS, 0), PINCH_OK);
    double x = dBodyGetPosition(p.driver)[0];
    for (int step = 0; step < 100; step++) press_step(&p);
    assert_close(dBodyGetPosition(p.driver)[0], x, 0); /* a fixed base again: its spring keeps the force */
    assert_close(driver_force(&p, &points), 5, 1e-9);
    press_free(&p);
}

static void test_illegal_drives_are_refused(void **state)
{
    (void)state;
    press p;
    press_make(&p, dCreateSphere(NULL, 0.01), 0.01, 0);
    const double long_axis[3] = {2, 0, 0}, no_axis[3] = {0, 0, 0}, nan_axis[3] = {NAN, 0, 0};
    assert_int_equal(pinch_ode_set_drive(NULL, p.driver, AXIS, 1), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_set_drive(p.plugin, NULL, AXIS, 1), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_set_drive(p.plugin, p.driver, NULL, 1), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_set_drive(p.plugin, p.driver, long_axis, 1), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_set_drive(p.plugin, p.driver, no_axis, 1), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_set_drive(p.plugin, p.driver, nan_axis, 1), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_set_drive(p.plugin, p.driver, AXIS, -1), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_set_drive(p.plugin, p.driver, AXIS, NAN), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_set_drive(p.plugin, p.driver, AXIS, INFINITY), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_set_drive(p.plugin, p.cube, AXIS, 1), PINCH_INVALID_ARGUMENT); /* has inertia */
    press_free(&p);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_force_with_any_number_of_points),
        cmocka_unit_test(test_force_follows_at_once),
        cmocka_unit_test(test_another_force_ends_rest),
        cmocka_unit_test(test_base_moves),
        cmocka_unit_test(test_pushes_a_free_body),
        cmocka_unit_test(test_stays_where_it_touches_nothing),
        cmocka_unit_test(test_a_drive_ends),
        cmocka_unit_test(test_illegal_drives_are_refused),
    };
    int failed = cmocka_run_group_tests_name("force control", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
