/*
 * Any number of threads gives the same bits: in a world of many islands, grasps that hold and slip, stiff stacks and
 * jointed fingers; in heaps that are one island, whose loops the threads share; and where what is handed over is not
 * what it was in the step before.
 */
#include "support/cmocka_all.h"
#include "support/sanitized.h"

#include <pinch/ode.h>

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

enum { HANDS = 30, STACKS = 6, STEPS = 150, HANDS_AND_STACKS = HANDS + 2 * STACKS + HANDS / 3 };
enum { SIDE = 8, LAYERS = 6, HEAP = SIDE * SIDE * LAYERS, BODIES = HEAP, LARGE_ISLAND = 512 /* contacts */ };
enum { ROW = 20, YARD = 18 * ROW }; /* boxes that slide on the ground, each by itself */

/* Budgets of a solve: more than usual, so that few steps of heaps are left to ODE; so little that they are swept. */
static const double MUCH = 4e6, LITTLE = 1;

typedef struct program {
    dWorldID world;
    dSpaceID space;
    pinch_ode *plugin;
    dBodyID body[BODIES];
    int count, step;
    bool changes;   /* what is handed over */
    int goes_wrong; /* the step in which the program's look at a pair goes wrong once, 0: in none */
} program;

typedef enum heap_kind { BOXES, SPHERES, JOINTED_BOXES, SWEPT_BOXES } heap_kind;

enum { POINTS = 8 };

static double restitution; /* of all contacts that programs make */

static int look(void *context, dGeomID a, dGeomID b, int room, dContact *contact)
{
    (void)context;
    memset(contact, 0, sizeof *contact * (size_t)room);
    int count = dCollide(a, b, room, &contact[0].geom, sizeof contact[0]);
    for (int i = 0; i < count; i++) {
        contact[i].surface.mode = dContactApprox1;
        contact[i].surface.mu = 0.5;
        if (restitution > 0) contact[i].surface.mode |= dContactBounce;
        contact[i].surface.bounce = restitution;
    }
    return count;
}

static void swap_geoms(dContact *contact, int count)
{
    for (int i = 0; i < count; i++) {
        dContactGeom *g = &contact[i].geom;
        dGeomID first = g->g1;
        g->g1 = g->g2;
        g->g2 = first;
        for (int k = 0; k < 3; k++) g->normal[k] = -g->normal[k];
    }
}

/* A change of an even number holds for two steps. */
static int change_of(const program *p)
{
    return 2 * p->step / 3;
}

/* The same, but that one box or another has something else than in the step before. */
static int look_at_changes(void *context, dGeomID a, dGeomID b, int room, dContact *contact)
{
    const program *p = context;
    int count = look(NULL, a, b, room, contact), step = change_of(p);
    const int *number = dGeomGetData(dGeomGetBody(a) ? a : b);
    if (count < 2 || !number || !p->changes) return count;
    const dContact first = contact[0];
    for (int i = 0; i < count; i++) {
        dSurfaceParameters *surface = &contact[i].surface;
        if (step == 4) surface->mu = 0.4;
        if (step >= 6 && *number == 6) surface->mu = 0.06;
        if (step >= 8 && *number == 8 && i == 1) surface->mode |= dContactSoftCFM, surface->soft_cfm = 1e-5;
        if (step >= 10 && step < 13 && *number == 10) surface->mode |= dContactFDir1, contact[i].fdir1[step % 2] = 1;
        if (step == 12 && *number == 12) surface->mode |= dContactMotion1, surface->motion1 = 0.1;
        if (step == 14 && *number == 14) surface->mode |= dContactSlip1, surface->slip1 = 0.1;
    }
    if (step == 16 && *number == 16) contact[0] = contact[1], contact[1] = first; /* another order */
    if (step == 18 && *number == 18) swap_geoms(contact, count);
    if (step == 20 && *number == 20) contact[1].geom.depth = NAN;
    if (step == 22 && *number == 22) contact[1].geom.g1 = contact[1].geom.g2 = NULL;
    if (step == 24 && *number == 24) return 1;
    if (step == 26 && *number == 26) return 0;
    return count;
}

static void offer(void *data, dGeomID a, dGeomID b)
{
    program *p = data;
    dContact contact[POINTS];
    int count = look_at_changes(p, a, b, POINTS, contact);
    for (int i = 0; i < count; i++)
        assert_int_equal(pinch_ode_add_contact(p->plugin, &contact[i], dGeomGetBody(a), dGeomGetBody(b)), PINCH_OK);
}

/* Of the last body, when other contacts have been taken over. */
static int look_and_fail(void *context, dGeomID a, dGeomID b, int room, dContact *contact)
{
    const program *p = context;
    dBodyID last = p->body[p->count - 1];
    return dGeomGetBody(a) == last || dGeomGetBody(b) == last ? -1 : look_at_changes(context, a, b, room, contact);
}

/* Some threads find the contacts, others get them from a near callback. */
static void collide(program *p, int threads)
{
    if (threads % 2 == 0 && p->step > 0 && p->step == p->goes_wrong)
        assert_int_equal(pinch_ode_collide(p->plugin, p->space, POINTS, look_and_fail, p), PINCH_INVALID_ARGUMENT);
    if (threads % 2)
        assert_int_equal(pinch_ode_each_pair(p->plugin, p->space, p, offer), PINCH_OK);
    else
        assert_int_equal(pinch_ode_collide(p->plugin, p->space, POINTS, look_at_changes, p), PINCH_OK);
}

static dBodyID add_box(program *p, double side, double mass, double x, double y, double z)
{
    dBodyID body = p->body[p->count++] = dBodyCreate(p->world);
    dMass m;
    dMassSetBoxTotal(&m, mass, side, side, side);
    dBodySetMass(body, &m);
    dBodySetPosition(body, x, y, z);
    dGeomSetBody(dCreateBox(p->space, side, side, side), body);
    return body;
}

static void add_tip(program *p, const pinch_material *material, dBodyID body, double x, double y, double z)
{
    dGeomID tip = dCreateSphere(p->space, 0.01);
    dGeomSetCategoryBits(tip, 2);
    dGeomSetCollideBits(tip, 1);
    if (body) dGeomSetBody(tip, body);
    if (body)
        dGeomSetOffsetPosition(tip, x, y, z);
    else
        dGeomSetPosition(tip, x, y, z);
    assert_int_equal(pinch_ode_set_material(p->plugin, tip, material), PINCH_OK);
}

/* Every third hand is too weak and slips; every third has a finger on a hinge. */
static void add_hand(program *p, int k)
{
    double x = 0.3 * k, reach = 0.025 + 0.01 - (k % 3 == 1 ? 1e-5 : 5e-4);
    pinch_material material = pinch_default_material();
    material.model = k % 2 ? PINCH_CONTACT_SOFT : PINCH_CONTACT_HARD;
    add_box(p, 0.05, 0.2, x, 0, 1);
    add_tip(p, &material, NULL, x - reach, 0.01, 1);
    add_tip(p, &material, NULL, x - reach, -0.01, 1);
    if (k % 3 != 2) {
        add_tip(p, &material, NULL, x + reach, 0, 1);
        return;
    }
    dBodyID link = p->body[p->count++] = dBodyCreate(p->world);
    dMass m;
    dMassSetSphereTotal(&m, 0.1, 0.02);
    dBodySetMass(link, &m);
    dBodySetPosition(link, x + reach, 0, 0.96);
    dJointID hinge = dJointCreateHinge(p->world, NULL);
    dJointAttach(hinge, link, NULL);
    dJointSetHingeAnchor(hinge, x + reach, 0, 0.9);
    dJointSetHingeAxis(hinge, 0, -1, 0);
    dJointSetHingeParam(hinge, dParamVel, 0.5);
    dJointSetHingeParam(hinge, dParamFMax, 0.5);
    add_tip(p, &material, link, 0, 0, 0.04);
}

static void start(program *p, int threads, pinch_ode_stepper stepper, double budget)
{
    memset(p, 0, sizeof *p);
    restitution = 0;
    p->world = dWorldCreate();
    p->space = dSimpleSpaceCreate(NULL);
    dWorldSetGravity(p->world, 0, 0, -9.81);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.threads = threads;
    settings.stepper = stepper;
    settings.solver.budget = budget;
    assert_int_equal(pinch_ode_create(p->world, &settings, &p->plugin), PINCH_OK);
}

static void make_hands(program *p, heap_kind none, int threads)
{
    (void)none;
    start(p, threads, PINCH_ODE_WORLDSTEP, MUCH);
    for (int k = 0; k < HANDS; k++) add_hand(p, k);
    dGeomSetCollideBits(dCreatePlane(p->space, 0, 0, 1, 0), 1);
    for (int k = 0; k < STACKS; k++) {
        add_box(p, 0.1, 1, 0.5 * k, 2, 0.05);
        add_box(p, 0.1, 1 + k, 0.5 * k + 0.01 * k, 2, 0.15);
    }
    assert_int_equal(p->count, HANDS_AND_STACKS);
}

/* Bodies lie closely in a pit, so that they are one island from the first steps on, and settle. */
static void make_heap(program *p, heap_kind kind, int threads)
{
    const double size = 0.2, pitch = (kind == SPHERES ? 0.995 : 1.01) * size, half = 0.5 * (SIDE + 0.2) * pitch;
    start(p, threads, PINCH_ODE_QUICKSTEP, kind == SWEPT_BOXES ? LITTLE : MUCH);
    dWorldSetCFM(p->world, 1e-5);
    dCreatePlane(p->space, 0, 0, 1, 0);
    for (int k = 0; k < 4; k++) dCreatePlane(p->space, k < 2 ? 1 - 2 * k : 0, k < 2 ? 0 : 5 - 2 * k, 0, -half);
    for (int k = 0; k < HEAP; k++) {
        int layer = k / (SIDE * SIDE), place = k % (SIDE * SIDE);
        double x = (place % SIDE - 0.5 * (SIDE - 1)) * pitch, y = (place / SIDE - 0.5 * (SIDE - 1)) * pitch;
        double shift = 0.1 * size * sin(1.7 * layer), z = (layer + 0.52) * 0.97 * size;
        dBodyID body = kind == SPHERES ? dBodyCreate(p->world) : add_box(p, size, 1, x + shift, y - shift, z);
        if (kind == SPHERES) {
            p->body[p->count++] = body;
            dBodySetPosition(body, x + shift, y - shift, z);
            dGeomSetBody(dCreateSphere(p->space, 0.5 * size), body);
        }
        dQuaternion turn;
        dQFromAxisAndAngle(turn, sin(k), cos(2.0 * k), sin(3.0 * k), 0.05);
        dBodySetQuaternion(body, turn);
        if (kind != JOINTED_BOXES || k % 4 != 1) continue;
        dJointID ball = dJointCreateBall(p->world, NULL);
        dJointAttach(ball, p->body[k - 1], body);
        dJointSetBallAnchor(ball, x + shift - 0.5 * pitch, y - shift, z);
    }
}

/* Most of the contacts that are found on it are between geoms that do not move. */
static void make_floor_of_boxes(program *p, heap_kind none, int threads)
{
    enum { ALONG = 20 };
    (void)none;
    start(p, threads, PINCH_ODE_QUICKSTEP, MUCH);
    for (int k = 0; k < ALONG * ALONG; k++)
        dGeomSetPosition(dCreateBox(p->space, 1.01, 1.01, 1), k / ALONG, k % ALONG, -0.5);
    for (int k = 0; k < ALONG; k++) dBodySetLinearVel(add_box(p, 0.1, 1, k, 0.3 * k, 0.05 - 1e-5), 0.3, 0.1, 0);
}

static void make_yard(program *p, heap_kind none, int threads)
{
    static int number[YARD];
    (void)none;
    start(p, threads, PINCH_ODE_QUICKSTEP, MUCH);
    p->changes = true;
    dCreatePlane(p->space, 0, 0, 1, 0);
    for (int k = 0; k < YARD; k++) {
        dBodyID body = add_box(p, 0.1, 1, 0.5 * (k % ROW), 0.5 * (k / ROW), 0.05 - 1e-5);
        number[k] = k;
        dGeomSetData(dBodyGetFirstGeom(body), &number[k]);
        if (k % 3 > 0) dBodySetLinearVel(body, 0.3 * (k % 3), 0.1, 0);
    }
}

static dReal height(void *data, int x, int z)
{
    (void)data;
    return 0.02 * ((7 * x + 3 * z) % 5);
}

static dHeightfieldDataID field_data;

/* A slab on a height field, which has ODE move it to and fro while they collide, and boxes on the slab. */
static void make_field(program *p, heap_kind none, int threads)
{
    enum { ALONG = 14 };
    (void)none;
    start(p, threads, PINCH_ODE_QUICKSTEP, MUCH);
    dMatrix3 upright;
    dRFromAxisAndAngle(upright, 1, 0, 0, 0.5 * M_PI);
    dGeomSetRotation(dCreateHeightfield(p->space, field_data, 1), upright);
    dBodyID slab = dBodyCreate(p->world);
    dMass m;
    dMassSetBoxTotal(&m, 70, 8, 8, 0.4);
    dBodySetMass(slab, &m);
    dGeomID geom = dCreateBox(p->space, 8, 8, 0.4);
    dGeomSetBody(geom, slab);
    dBodySetPosition(slab, 0, 0, 0.28);
    p->body[p->count++] = slab;
    for (int k = 0; k < ALONG * ALONG; k++)
        add_box(p, 0.4, 10, 0.55 * (k % ALONG - ALONG / 2), 0.55 * (k / ALONG - ALONG / 2), 0.68);
}

static void make_yard_that_fails(program *p, heap_kind none, int threads)
{
    make_yard(p, none, threads);
    p->changes = false;
    p->goes_wrong = 8;
}

/* Boxes in pairs strike the ground and each other. */
static void make_bouncing_pairs(program *p, heap_kind none, int threads)
{
    (void)none;
    start(p, threads, PINCH_ODE_QUICKSTEP, MUCH);
    restitution = 0.7;
    dCreatePlane(p->space, 0, 0, 1, 0);
    for (int k = 0; k < YARD; k++) {
        dBodyID body = add_box(p, 0.1, 1 + k % 3, 0.5 * (k / 2 % ROW), 0.5 * (k / 2 / ROW), 0.051 + 0.102 * (k % 2));
        dBodySetLinearVel(body, sin(5.0 * k), cos(7.0 * k), -2);
        dBodySetAngularVel(body, 0, 0, sin(3.0 * k));
    }
}

/* What the program changes besides the contacts. */
static void change_world(program *p)
{
    pinch_material material = pinch_default_material();
    int change = change_of(p);
    dBodyID body = p->body[change];
    dGeomID geom = dBodyGetFirstGeom(body);
    switch (p->step % 3 == 0 ? change : -1) {
    case 30:
        dBodySetKinematic(body);
        break;
    case 32:
        dBodySetDynamic(p->body[30]);
        break;
    case 34:
        assert_int_equal(pinch_ode_set_material(p->plugin, geom, &material), PINCH_OK);
        break;
    case 36:
        assert_int_equal(pinch_ode_set_material(p->plugin, dBodyGetFirstGeom(p->body[34]), NULL), PINCH_OK);
        break;
    case 38:
        assert_int_equal(pinch_ode_forget_geom(p->plugin, geom), PINCH_OK);
        break;
    case 40:
        dBodySetPosition(body, 0.1, -1, 0.0499);
        break;
    case 42:
        dGeomDisable(geom);
        break;
    case 44:
        dGeomSetBody(dBodyGetFirstGeom(p->body[42]), NULL);
        break;
    case 46:
        dGeomDestroy(geom);
        break;
    case 48:
        material.hertz_modulus = 1e6;
        assert_int_equal(pinch_ode_set_material(p->plugin, geom, &material), PINCH_OK);
        break;
    default:
        break;
    }
    if (change == 28) /* contacts before those that are found together, and the same pairs once more */
        for (int k = 0; k < 2; k++) assert_int_equal(pinch_ode_each_pair(p->plugin, p->space, p, offer), PINCH_OK);
}

typedef struct test_world {
    void (*make)(program *p, heap_kind kind, int threads);
    heap_kind kind;
    int steps;
    double step; /* s */
} test_world;

/* Every state of every step. */
static uint64_t run(const test_world *world, int threads, pinch_ode_stats *stats)
{
    program p;
    uint64_t hash = 14695981039346656037u;
    dRandSetSeed(1); /* quickstep draws from it for islands that are left to it */
    world->make(&p, world->kind, threads);
    for (p.step = 0; p.step < world->steps; p.step++) {
        if (p.changes) change_world(&p);
        collide(&p, threads);
        assert_int_equal(pinch_ode_step(p.plugin, world->step), PINCH_OK);
        for (int k = 0; k < p.count; k++) {
            double state[13];
            memcpy(state, dBodyGetPosition(p.body[k]), 3 * sizeof *state);
            memcpy(state + 3, dBodyGetQuaternion(p.body[k]), 4 * sizeof *state);
            memcpy(state + 7, dBodyGetLinearVel(p.body[k]), 3 * sizeof *state);
            memcpy(state + 10, dBodyGetAngularVel(p.body[k]), 3 * sizeof *state);
            const unsigned char *bytes = (const unsigned char *)state;
            for (size_t i = 0; i < sizeof state; i++) hash = (hash ^ bytes[i]) * 1099511628211u;
        }
    }
    *stats = pinch_ode_statistics(p.plugin);
    pinch_ode_destroy(p.plugin);
    dSpaceDestroy(p.space);
    dWorldDestroy(p.world);
    return hash;
}

/* Returns the statistics of one thread. With sanitizers, one other number stands for all. */
static pinch_ode_stats same_with_any_number(const test_world *world)
{
    pinch_ode_stats one, more;
    uint64_t expected = run(world, 1, &one);
    const int threads[] = {2, 3, 4};
    for (int k = 0; k < (SANITIZED ? 1 : 3); k++) {
        assert_true(run(world, threads[k], &more) == expected);
        one.memory = more.memory = 0; /* each thread has scratch of its own */
        assert_memory_equal(&one, &more, sizeof one);
    }
    return one;
}

static void test_any_number_of_threads_gives_the_same_bits(void **state)
{
    (void)state;
    const test_world hands = {make_hands, BOXES, STEPS, 1e-3};
    pinch_ode_stats one = same_with_any_number(&hands);
    assert_true(one.islands > HANDS * STEPS && one.fallback_islands == 0);
}

static pinch_ode_stats test_heap(heap_kind kind)
{
    const test_world heap = {make_heap, kind, kind == JOINTED_BOXES ? 2 : SANITIZED ? 3 : 5, 0.01};
    pinch_ode_stats one = same_with_any_number(&heap);
    assert_true(one.points_high_water > LARGE_ISLAND && one.islands > one.fallback_islands);
    return one;
}

static void test_a_heap_of_boxes(void **state)
{
    (void)state;
    (void)test_heap(BOXES);
}

static void test_a_heap_of_spheres(void **state)
{
    (void)state;
    (void)test_heap(SPHERES);
}

static void test_a_heap_of_jointed_boxes(void **state)
{
    (void)state;
    (void)test_heap(JOINTED_BOXES);
}

static void test_a_heap_that_is_swept(void **state)
{
    (void)state;
    assert_true(test_heap(SWEPT_BOXES).swept_islands > 0);
}

static void test_boxes_that_bounce(void **state)
{
    (void)state;
    const test_world pairs = {make_bouncing_pairs, BOXES, SANITIZED ? 10 : 40, 5e-3};
    pinch_ode_stats one = same_with_any_number(&pairs);
    assert_true(one.islands > YARD && one.fallback_islands == 0);
}

static void test_a_slab_on_a_height_field(void **state)
{
    (void)state;
    enum { SAMPLES = 61 };
    const test_world field = {make_field, BOXES, SANITIZED ? 6 : 15, 1e-2};
    field_data = dGeomHeightfieldDataCreate();
    dGeomHeightfieldDataBuildCallback(field_data, NULL, height, 20, 20, SAMPLES, SAMPLES, 1, 0, 1, 0);
    dGeomHeightfieldDataSetBounds(field_data, -1, 1);
    (void)same_with_any_number(&field);
    dGeomHeightfieldDataDestroy(field_data);
}

static void test_contacts_that_change(void **state)
{
    (void)state;
    const test_world yard = {make_yard, BOXES, SANITIZED ? 76 : 84, 5e-3};
    pinch_ode_stats one = same_with_any_number(&yard);
    assert_true(one.islands > 50L * YARD && one.contacts_malformed > 0);
}

static void test_contacts_that_are_not_taken(void **state)
{
    (void)state;
    const test_world level = {make_floor_of_boxes, BOXES, 6, 5e-3};
    assert_true(same_with_any_number(&level).contacts_malformed > 0);
}

static void test_a_look_that_fails(void **state)
{
    (void)state;
    const test_world yard = {make_yard_that_fails, BOXES, 12, 5e-3};
    assert_true(same_with_any_number(&yard).islands > 10L * YARD);
}

static int look_too_far(void *context, dGeomID a, dGeomID b, int room, dContact *contact)
{
    (void)look(context, a, b, room, contact);
    return room + *(const int *)context;
}

static int look_at_nothing(void *context, dGeomID a, dGeomID b, int room, dContact *contact)
{
    (void)a, (void)b, (void)room, (void)contact;
    atomic_fetch_add((atomic_int *)context, 1);
    return 0;
}

static void test_a_collision_that_goes_wrong(void **state)
{
    (void)state;
    program p;
    make_heap(&p, BOXES, 2);
    dSpaceID inner = dSimpleSpaceCreate(p.space);
    int beyond[2] = {1, -POINTS - 1};
    atomic_int pairs[2] = {0, 0};
    for (int round = 0; round < 2; round++) { /* by one thread, then by two */
        for (int k = 0; k < 2; k++)
            assert_int_equal(pinch_ode_collide(p.plugin, p.space, POINTS, look_too_far, &beyond[k]),
                             PINCH_INVALID_ARGUMENT);
        assert_int_equal(pinch_ode_collide(p.plugin, p.space, 1, look_at_nothing, &pairs[round]), PINCH_OK);
        for (int k = 0; k < HEAP / 2 && round == 0; k++) { /* there are no more pairs with them in an inner space */
            dGeomID geom = dBodyGetFirstGeom(p.body[2 * k]);
            dSpaceRemove(p.space, geom);
            dSpaceAdd(inner, geom);
        }
    }
    assert_true(pairs[0] > HEAP && pairs[1] > 0 && pairs[1] < pairs[0]);
    assert_int_equal(pinch_ode_collide(NULL, p.space, 1, look_at_nothing, pairs), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_collide(p.plugin, NULL, 1, look_at_nothing, pairs), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_collide(p.plugin, p.space, 0, look_at_nothing, pairs), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_ode_collide(p.plugin, p.space, 1, NULL, pairs), PINCH_INVALID_ARGUMENT);
    pinch_ode_destroy(p.plugin);
    dSpaceDestroy(p.space);
    dWorldDestroy(p.world);
}

static void test_threads_out_of_range_are_refused(void **state)
{
    (void)state;
    dWorldID world = dWorldCreate();
    pinch_ode *plugin;
    pinch_ode_settings settings = pinch_ode_default_settings();
    const int wrong[] = {0, -1, PINCH_ODE_MOST_THREADS + 1};
    for (int k = 0; k < 3; k++) {
        settings.threads = wrong[k];
        assert_int_equal(pinch_ode_create(world, &settings, &plugin), PINCH_INVALID_ARGUMENT);
    }
    dWorldDestroy(world);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_any_number_of_threads_gives_the_same_bits),
        cmocka_unit_test(test_a_heap_of_boxes),
        cmocka_unit_test(test_a_heap_of_spheres),
        cmocka_unit_test(test_a_heap_of_jointed_boxes),
        cmocka_unit_test(test_a_heap_that_is_swept),
        cmocka_unit_test(test_boxes_that_bounce),
        cmocka_unit_test(test_a_slab_on_a_height_field),
        cmocka_unit_test(test_contacts_that_change),
        cmocka_unit_test(test_contacts_that_are_not_taken),
        cmocka_unit_test(test_a_look_that_fails),
        cmocka_unit_test(test_a_collision_that_goes_wrong),
        cmocka_unit_test(test_threads_out_of_range_are_refused),
    };
    int failed = cmocka_run_group_tests_name("threads", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
