/*
 * Nothing is allocated inside a step once a scene has been running. The linker sends this program's calls of the
 * allocator through a counter, those of libpinch and libpinch_ode included; ODE's own calls are not counted.
 */
#include "support/cmocka_all.h"

#include "../demos/bench/allocations.h"
#include "support/block.h"
#include "support/draw.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static long allocations_of(block *b, dJointID slider, int steps)
{
    pinch_random random;
    pinch_random_seed(&random, 2);
    long before = allocations_counted();
    for (int step = 0; step < steps; step++) {
        /* tossed about: contacts come and go, sticking and slipping */
        double up = draw_uniform(&random, -4, 6), y = draw_uniform(&random, -2, 2), x = draw_uniform(&random, -2, 2);
        double turn_y = draw_uniform(&random, -0.05, 0.05), turn_x = draw_uniform(&random, -0.05, 0.05);
        dBodyAddForce(b->body, x, y, up);
        dBodyAddTorque(b->body, turn_x, turn_y, 0);
        if (step % 50 == 25) dJointDisable(slider);
        if (step % 50 == 0) dJointEnable(slider);
        if (step % 97 == 0) {
            dBodySetPosition(b->body, 0, 0, 0.0199);
            dBodySetLinearVel(b->body, 0, 0, 0);
        }
        block_step(b, 1e-3);
    }
    return allocations_counted() - before;
}

static void test_a_running_scene_allocates_nothing(void **state)
{
    (void)state;
    pinch_material m = pinch_default_material();
    m.model = PINCH_CONTACT_SOFT;
    block b;
    long start = allocations_counted();
    block_make(&b, &m, 0);
    assert_true(allocations_counted() > start); /* the counters do count */
    dBodyID rail = dBodyCreate(b.world);
    dBodySetPosition(rail, 0, 0, 0.1);
    dJointID slider = dJointCreateSlider(b.world, NULL);
    dJointAttach(slider, b.body, rail);
    dJointSetSliderAxis(slider, 0, 0, 1);
    assert_true(allocations_of(&b, slider, 1000) > 0);
    assert_int_equal(allocations_of(&b, slider, 3000), 0);
    pinch_ode_stats stats = pinch_ode_statistics(b.plugin);
    assert_true(stats.contacts_solved > 1000 && stats.memory > 0);
    block_free(&b);
}

/* Columns of cubes side by side, each pressed into its neighbours by a tenth of a millimetre. */
enum { COLUMNS = 7, ROWS = 6 };
typedef struct wall {
    dWorldID world;
    dSpaceID space;
    pinch_ode *plugin;
    dBodyID body[COLUMNS * ROWS];
} wall;

static void wall_put_up(wall *w)
{
    for (int i = 0; i < COLUMNS * ROWS; i++) {
        dBodySetPosition(w->body[i], 0.0999 * (i % COLUMNS), 0, 0.0999 * (i / COLUMNS));
        dBodySetQuaternion(w->body[i], (dQuaternion){1, 0, 0, 0});
        dBodySetLinearVel(w->body[i], 0, 0, 0);
        dBodySetAngularVel(w->body[i], 0, 0, 0);
    }
}

static void wall_contact(void *data, dGeomID g1, dGeomID g2)
{
    wall *w = data;
    dContact contact[8];
    int count = dCollide(g1, g2, 8, &contact[0].geom, sizeof *contact);
    for (int i = 0; i < count; i++) {
        contact[i].surface = (dSurfaceParameters){.mode = dContactApprox1, .mu = 0.5};
        assert_int_equal(pinch_ode_add_contact(w->plugin, &contact[i], dGeomGetBody(g1), dGeomGetBody(g2)), PINCH_OK);
    }
}

static void wall_steps(wall *w, int count, bool touching)
{
    for (int step = 0; step < count; step++) {
        if (touching) dSpaceCollide(w->space, w, wall_contact);
        assert_int_equal(pinch_ode_step(w->plugin, 1e-4), PINCH_OK);
    }
}

/* What solves needed is given back when no step has needed it for a while; of a scene that goes to and fro it is kept
 * after a few rounds. */
static void test_scratch_is_given_back(void **state)
{
    (void)state;
    enum { ROUNDS = 12, LAST = 4, FIRST = 4, TOUCHING = 20, FREE = 40 };
    wall w = {.world = dWorldCreate(), .space = dSimpleSpaceCreate(NULL)};
    pinch_ode_settings settings = pinch_ode_default_settings();
    assert_int_equal(pinch_ode_create(w.world, &settings, &w.plugin), PINCH_OK);
    for (int i = 0; i < COLUMNS * ROWS; i++) {
        dMass mass;
        w.body[i] = dBodyCreate(w.world);
        dMassSetBoxTotal(&mass, 1, 0.1, 0.1, 0.1);
        dBodySetMass(w.body[i], &mass);
        dGeomSetBody(dCreateBox(w.space, 0.1, 0.1, 0.1), w.body[i]);
    }
    long allocations[ROUNDS];
    for (int round = 0; round < ROUNDS; round++) {
        long before = allocations_counted();
        wall_put_up(&w);
        wall_steps(&w, FIRST, true);
        size_t most = pinch_ode_statistics(w.plugin).memory;
        wall_steps(&w, TOUCHING - FIRST, true);
        wall_steps(&w, FREE, false);
        size_t left = pinch_ode_statistics(w.plugin).memory;
        allocations[round] = allocations_counted() - before;
        if (round == 0) assert_true(left < 0.6 * (double)most);
    }
    assert_true(allocations[0] > 0);
    for (int round = ROUNDS - LAST; round < ROUNDS; round++) assert_int_equal(allocations[round], 0);
    pinch_ode_stats stats = pinch_ode_statistics(w.plugin);
    assert_true(stats.contacts_solved > ROUNDS * TOUCHING * COLUMNS * ROWS && stats.contacts_left == 0);
    pinch_ode_destroy(w.plugin);
    dSpaceDestroy(w.space);
    dWorldDestroy(w.world);
}

/* The same for surface parameters, friction directions and rolling friction that change in every step. */
static void test_surfaces_come_and_go(void **state)
{
    (void)state;
    enum { STEPS = 800, POINTS = 8 };
    block b;
    block_make(&b, NULL, 0);
    pinch_ode_destroy(b.plugin);
    pinch_ode_settings settings = pinch_ode_default_settings(); /* all contacts */
    assert_int_equal(pinch_ode_create(b.world, &settings, &b.plugin), PINCH_OK);
    size_t memory = 0;
    long before = 0;
    for (int step = 0; step < STEPS; step++) {
        dContact contact[POINTS];
        int count = dCollide(b.cube, b.table, POINTS, &contact[0].geom, sizeof *contact);
        for (int i = 0; i < count; i++) {
            contact[i].surface =
                (dSurfaceParameters){.mode = dContactApprox1 | dContactFDir1, .mu = 0.5 + 1e-4 * (step + i)};
            contact[i].fdir1[0] = cos(0.01 * step);
            contact[i].fdir1[1] = sin(0.01 * step);
            contact[i].fdir1[2] = 0;
            if (step % 3 == 0) contact[i].surface.mode |= dContactRolling;
            if (step % 3 == 0) contact[i].surface.rho = 1e-3;
            assert_int_equal(pinch_ode_add_contact(b.plugin, &contact[i], dGeomGetBody(contact[i].geom.g1),
                                                   dGeomGetBody(contact[i].geom.g2)),
                             PINCH_OK);
        }
        assert_int_equal(pinch_ode_step(b.plugin, 1e-3), PINCH_OK);
        if (step == STEPS / 2) {
            memory = pinch_ode_statistics(b.plugin).memory;
            before = allocations_counted();
        }
    }
    pinch_ode_stats stats = pinch_ode_statistics(b.plugin);
    assert_int_equal(allocations_counted(), before);
    assert_int_equal(stats.memory, memory);
    assert_true(stats.contacts_solved > 3 * STEPS / 2 && stats.contacts_left == 0);
    assert_true(fabs(block_normal_force(&b) - 1) < 1e-6); /* 0.1 kg */
    block_free(&b);
}

/* Materials that nobody has any more leave their places to others. */
static void test_materials_come_and_go(void **state)
{
    (void)state;
    enum { GEOMS = 50, ROUNDS = 20 };
    dWorldID world = dWorldCreate();
    pinch_ode_settings settings = pinch_ode_default_settings();
    pinch_ode *plugin;
    dGeomID geom[GEOMS];
    assert_int_equal(pinch_ode_create(world, &settings, &plugin), PINCH_OK);
    for (int k = 0; k < GEOMS; k++) geom[k] = dCreateSphere(NULL, 0.01);
    size_t memory = 0;
    for (int round = 0; round < ROUNDS; round++) {
        for (int k = 0; k < GEOMS; k++) { /* all of a kind in every other round, all different in the others */
            pinch_material m = pinch_default_material();
            m.stiffness[0] = 1e4 + round + (round % 2 ? 100 * k : 0);
            assert_int_equal(pinch_ode_set_material(plugin, geom[k], round % 4 == 2 ? NULL : &m), PINCH_OK);
        }
        if (round == 8) memory = pinch_ode_statistics(plugin).memory;
    }
    assert_int_equal(pinch_ode_statistics(plugin).memory, memory);
    pinch_ode_destroy(plugin);
    for (int k = 0; k < GEOMS; k++) dGeomDestroy(geom[k]);
    dWorldDestroy(world);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_running_scene_allocates_nothing), cmocka_unit_test(test_scratch_is_given_back),
        cmocka_unit_test(test_surfaces_come_and_go), cmocka_unit_test(test_materials_come_and_go)};
    int failed = cmocka_run_group_tests_name("allocation", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
