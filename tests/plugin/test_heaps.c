/*
 * Heaps, pyramids and towers of boxes with ODE's own contacts. Those that are too large, or too dear, to be solved are
 * swept, and pyramids split before. They come to rest all the same, nothing is left to ODE, and what is not verified
 * counts as not converged.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/sanitized.h"

#include <math.h>
#include <pinch/ode.h>
#include <string.h>

enum { BOXES = 100, SIDE = 5, COURSES = 24, MOST_BOXES = COURSES * (COURSES + 1) / 2, POINTS = 8 };
static const double STEP = 0.01, SIZE = 0.2, HALF = 0.7, CFM = 1e-5;

typedef struct heap {
    dWorldID world;
    dSpaceID space;
    pinch_ode *plugin;
    double step; /* s */
    int count;
    dBodyID body[MOST_BOXES];
} heap;

static void ground_make(heap *p, const pinch_ode_settings *settings)
{
    p->world = dWorldCreate();
    p->space = dHashSpaceCreate(NULL);
    p->step = STEP;
    p->count = 0;
    dWorldSetGravity(p->world, 0, 0, -9.81);
    assert_int_equal(pinch_ode_create(p->world, settings, &p->plugin), PINCH_OK);
    dCreatePlane(p->space, 0, 0, 1, 0);
}

static dBodyID add_box(heap *p, double x, double y, double z)
{
    dMass mass;
    dBodyID body = p->body[p->count++] = dBodyCreate(p->world);
    dMassSetBoxTotal(&mass, 1, SIZE, SIZE, SIZE);
    dBodySetMass(body, &mass);
    dGeomSetBody(dCreateBox(p->space, SIZE, SIZE, SIZE), body);
    dBodySetPosition(body, x, y, z);
    return body;
}

/* Drops layers of boxes, each a little turned and shifted against the last, into a pit. */
static void heap_make(heap *p, const pinch_ode_settings *settings)
{
    ground_make(p, settings);
    dWorldSetCFM(p->world, CFM);
    for (int side = 0; side < 4; side++)
        dCreatePlane(p->space, side < 2 ? 1 - 2 * side : 0, side < 2 ? 0 : 5 - 2 * side, 0, -HALF);
    for (int k = 0; k < BOXES; k++) {
        dMatrix3 turned;
        int layer = k / (SIDE * SIDE), x = k % SIDE, y = k / SIDE % SIDE;
        dBodyID body =
            add_box(p, 0.26 * (x - 2) + 0.02 * (layer % 3), 0.26 * (y - 2) - 0.02 * (layer % 2), 0.2 + 0.3 * layer);
        dRFromAxisAndAngle(turned, 1, 2, 3, 0.3 * (k % 7));
        dBodySetRotation(body, turned);
    }
}

/* Lays courses of boxes whose centres are so far apart, each with one box less than the one below it. */
static void pyramid_make(heap *p, const pinch_ode_settings *settings, int courses, double apart)
{
    ground_make(p, settings);
    for (int course = 0; course < courses; course++)
        for (int k = 0; k < courses - course; k++)
            (void)add_box(p, apart * (k - 0.5 * (courses - course - 1)), 0,
                          SIZE * (course + 0.5) - 1e-6 * (course + 1));
}

static void near_callback(void *data, dGeomID a, dGeomID b)
{
    heap *p = data;
    dContactGeom found[POINTS];
    int count = dCollide(a, b, POINTS, found, sizeof found[0]);
    for (int i = 0; i < count; i++) {
        dContact contact;
        memset(&contact, 0, sizeof contact);
        contact.geom = found[i];
        contact.surface.mode = dContactApprox1;
        contact.surface.mu = 0.5;
        assert_int_equal(pinch_ode_add_contact(p->plugin, &contact, dGeomGetBody(a), dGeomGetBody(b)), PINCH_OK);
    }
}

/* Returns the speed of the fastest box after so many steps, m/s. */
static double run(heap *p, int steps)
{
    for (int step = 0; step < steps; step++) {
        dSpaceCollide(p->space, p, near_callback);
        assert_int_equal(pinch_ode_step(p->plugin, p->step), PINCH_OK);
    }
    double fastest = 0;
    for (int k = 0; k < p->count; k++) fastest = fmax(fastest, dCalcVectorLength3(dBodyGetLinearVel(p->body[k])));
    return fastest;
}

static void heap_free(heap *p)
{
    pinch_ode_destroy(p->plugin);
    dSpaceDestroy(p->space);
    dWorldDestroy(p->world);
}

/* Drops boxes of random sizes and directions into a pit. */
static void mixed_heap_make(heap *p, const pinch_ode_settings *settings, int boxes)
{
    static const double MEAN = 0.1, PIT = 0.54, DENSITY = 500;
    pinch_random random;
    pinch_random_seed(&random, 1);
    ground_make(p, settings);
    for (int side = 0; side < 4; side++)
        dCreatePlane(p->space, side < 2 ? 1 - 2 * side : 0, side < 2 ? 0 : 5 - 2 * side, 0, -PIT);
    for (int k = 0; k < boxes; k++) {
        dMatrix3 turned;
        dMass mass;
        double size[3], axis[3];
        for (int i = 0; i < 3; i++) {
            size[i] = MEAN * draw_uniform(&random, 0.5, 1.5);
            axis[i] = draw_uniform(&random, -0.5, 0.5);
        }
        dBodyID body = p->body[p->count++] = dBodyCreate(p->world);
        dMassSetBox(&mass, DENSITY, size[0], size[1], size[2]);
        dBodySetMass(body, &mass);
        dGeomSetBody(dCreateBox(p->space, size[0], size[1], size[2]), body);
        dBodySetPosition(body, 2 * MEAN * (k % 5 - 2), 2 * MEAN * (k / 5 % 5 - 2), MEAN + 2 * MEAN * (k / 25));
        dRFromAxisAndAngle(turned, axis[0], axis[1], axis[2], draw_uniform(&random, 0, 6.28));
        dBodySetRotation(body, turned);
    }
}

/* No solve of more than a few boxes is within this budget: while the heap moves, it is swept. */
static void test_swept_heaps_come_to_rest(void **state)
{
    (void)state;
    heap p;
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = PINCH_ODE_QUICKSTEP;
    settings.solver.budget = 300;
    heap_make(&p, &settings);
    int steps = SANITIZED ? 300 : 1000;
    double fastest = run(&p, steps);
    pinch_ode_stats stats = pinch_ode_statistics(p.plugin);
    assert_true(stats.swept_islands > 100 && stats.unconverged_steps > 50);
    assert_true(stats.unconverged_steps < stats.swept_islands); /* near rest, what sweeps find is verified */
    assert_true(stats.fallback_islands == 0 && stats.contacts_left == 0);
    assert_true(stats.step_mismatch < 1e-9);
    assert_true(fastest < (SANITIZED ? 0.1 : 1e-9));
    for (int k = 0; k < BOXES; k++) assert_true(dBodyGetPosition(p.body[k])[2] > 0.4 * SIZE);
    heap_free(&p);
}

/* Of a pyramid that is higher than sweeps reach, the load gets down to the ground in one step: it stands as built. */
static void test_a_tall_pyramid_stands(void **state)
{
    (void)state;
    heap p;
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = PINCH_ODE_QUICKSTEP;
    settings.solver.budget = 300;
    pyramid_make(&p, &settings, COURSES, 1.1 * SIZE); /* they do not touch their neighbours */
    double start[MOST_BOXES][3];
    for (int k = 0; k < p.count; k++) memcpy(start[k], dBodyGetPosition(p.body[k]), sizeof start[k]);
    double fastest = run(&p, SANITIZED ? 20 : 60);
    pinch_ode_stats stats = pinch_ode_statistics(p.plugin);
    assert_true(stats.swept_islands > 0 && stats.unconverged_steps == stats.swept_islands);
    assert_true(stats.fallback_islands == 0 && stats.contacts_left == 0 && stats.too_soft_islands == 0);
    assert_true(fastest < (SANITIZED ? 1e-3 : 1e-4));
    for (int k = 0; k < p.count; k++)
        for (int i = 0; i < 3; i++) assert_true(fabs(dBodyGetPosition(p.body[k])[i] - start[k][i]) < 1e-4);
    heap_free(&p);
}

/*
 * Neighbours that touch share whole faces, and ODE's collider returns the crossings of their coincident edges, which
 * rounding decides. The pyramid comes to rest all the same, to the bit.
 */
static void test_touching_neighbours_rest(void **state)
{
    (void)state;
    enum { FEW = 10, STEPS = 300, LAST = 10 };
    heap p;
    pinch_ode_settings settings = pinch_ode_default_settings();
    pyramid_make(&p, &settings, FEW, SIZE);
    (void)run(&p, STEPS);
    pinch_ode_reset_statistics(p.plugin);
    double fastest = run(&p, LAST);
    assert_int_equal(pinch_ode_statistics(p.plugin).islands_at_rest, LAST);
    assert_true(fastest == 0);
    heap_free(&p);
}

/* Under dWorldStep, which is asked for its direct method, ODE's own contacts take over instead. */
static void test_worldstep_sweeps_nothing(void **state)
{
    (void)state;
    heap p;
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = PINCH_ODE_WORLDSTEP;
    settings.solver.budget = 300;
    heap_make(&p, &settings);
    (void)run(&p, 30);
    pinch_ode_stats stats = pinch_ode_statistics(p.plugin);
    assert_true(stats.swept_islands == 0 && stats.fallback_islands > 0);
    heap_free(&p);
}

/* A budget changes nothing where solves stay within it. */
static void test_small_heaps_are_solved(void **state)
{
    (void)state;
    heap p;
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = PINCH_ODE_QUICKSTEP;
    heap_make(&p, &settings);
    (void)run(&p, 100);
    assert_int_equal(pinch_ode_statistics(p.plugin).swept_islands, 0);
    heap_free(&p);
}

/* While boxes fall onto each other, Newton's method fails in most steps. All the same nearly all steps have an answer
 * in which contacts are as stiff as they should be. */
static void test_a_falling_heap_is_solved(void **state)
{
    (void)state;
    enum { MIXED = 140 };
    heap p;
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = PINCH_ODE_QUICKSTEP;
    mixed_heap_make(&p, &settings, MIXED);
    p.step = 0.02;
    int steps = SANITIZED ? 25 : 50;
    (void)run(&p, steps);
    pinch_ode_stats stats = pinch_ode_statistics(p.plugin);
    print_message("%ld of %d steps have not converged, at most %ld contacts\n", (long)stats.unconverged_steps, steps,
                  (long)stats.points_high_water);
    assert_true(stats.points_high_water > 300);
    assert_true(stats.unconverged_steps <= steps / 10 && stats.fallback_islands == 0);
    heap_free(&p);
}

/*
 * A tower whose boxes begin in each other comes up to its height, and stands. It may not come up at once, as the top
 * would be thrown, and contacts near the ground give way under its load by about what they push at first: if they
 * pushed more slowly than that, it would sink for as long as it stands.
 */
static void test_a_sunk_tower_comes_up(void **state)
{
    (void)state;
    enum { TALL = 80 };
    static const double OVERLAP = 1e-3;
    heap p;
    pinch_ode_settings settings = pinch_ode_default_settings();
    ground_make(&p, &settings);
    for (int k = 0; k < TALL; k++) (void)add_box(&p, 0, 0, SIZE * (k + 0.5) - OVERLAP * k);
    double least = 0;
    for (int step = 0; step < 300; step++) {
        (void)run(&p, 1);
        least = fmin(least, dBodyGetLinearVel(p.body[TALL - 1])[2]);
    }
    assert_true(least > -0.05);
    assert_true(run(&p, 1) < 1e-3);
    for (int k = 0; k < TALL; k++) {
        const double *at = dBodyGetPosition(p.body[k]);
        assert_close(at[2], SIZE * (k + 0.5), 1e-4 * (k + 1));
        assert_true(fabs(at[0]) < 1e-4 && fabs(at[1]) < 1e-4);
    }
    assert_int_equal(pinch_ode_statistics(p.plugin).unconverged_steps, 0);
    heap_free(&p);
}

/* Boxes that touch exactly, or nearly, fall onto each other one by one, and are faster and deeper in each other the
 * higher they are. They come up, and none goes higher than it was laid. */
static void test_a_falling_stack_does_not_hop(void **state)
{
    (void)state;
    enum { TALL = 30, FEW = 10 };
    static const double HEIGHTS[] = {0, 1e-6, 1}; /* m, above the ground; those of the gaps are as large, up to 1e-6 */
    for (int k = 0; k < 3; k++) {
        heap p;
        int boxes = HEIGHTS[k] < 1 ? TALL : FEW;
        double gap = fmin(HEIGHTS[k], 1e-6), highest = 0;
        pinch_ode_settings settings = pinch_ode_default_settings();
        ground_make(&p, &settings);
        for (int i = 0; i < boxes; i++) (void)add_box(&p, 0, 0, HEIGHTS[k] + (SIZE + gap) * i + 0.5 * SIZE);
        double lain = SIZE * (boxes - 0.5), lowest = lain;
        for (int step = 0; step < 400; step++) {
            (void)run(&p, 1);
            double top = dBodyGetPosition(p.body[boxes - 1])[2];
            lowest = fmin(lowest, top);
            if (lowest < lain - 0.02) highest = fmax(highest, top); /* it has come down */
        }
        assert_true(lowest < lain - 0.02);
        assert_true(highest < lain + 1e-3);
        assert_close(dBodyGetPosition(p.body[boxes - 1])[2], lain, 1e-3);
        assert_true(run(&p, 1) < 1e-3);
        heap_free(&p);
    }
}

/* A pyramid whose boxes may go to sleep is solved as if they could not, and sleeps as soon as all of them are slow. */
static void test_a_pyramid_goes_to_sleep(void **state)
{
    (void)state;
    enum { SOON = 150 };
    heap p;
    pinch_ode_settings settings = pinch_ode_default_settings();
    ground_make(&p, &settings);
    dWorldSetAutoDisableFlag(p.world, 1);
    for (int course = 0; course < 16; course++)
        for (int k = 0; k < 16 - course; k++)
            (void)add_box(&p, 1.05 * SIZE * (k - 0.5 * (15 - course)), 0, SIZE * (course + 0.5));
    (void)run(&p, SOON);
    for (int k = 0; k < p.count; k++) {
        assert_false(dBodyIsEnabled(p.body[k]));
        assert_true(dBodyGetAutoDisableLinearThreshold(p.body[k]) == dWorldGetAutoDisableLinearThreshold(p.world));
        assert_true(dBodyGetAutoDisableAngularThreshold(p.body[k]) == dWorldGetAutoDisableAngularThreshold(p.world));
    }
    assert_close(dBodyGetPosition(p.body[p.count - 1])[2], 15.5 * SIZE, 1e-3);
    assert_int_equal(pinch_ode_statistics(p.plugin).unconverged_steps, 0);
    heap_free(&p);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_swept_heaps_come_to_rest), cmocka_unit_test(test_a_tall_pyramid_stands),
        cmocka_unit_test(test_touching_neighbours_rest), cmocka_unit_test(test_worldstep_sweeps_nothing),
        cmocka_unit_test(test_small_heaps_are_solved),   cmocka_unit_test(test_a_falling_heap_is_solved),
        cmocka_unit_test(test_a_sunk_tower_comes_up),    cmocka_unit_test(test_a_falling_stack_does_not_hop),
        cmocka_unit_test(test_a_pyramid_goes_to_sleep)};
    int failed = cmocka_run_group_tests_name("heaps", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
