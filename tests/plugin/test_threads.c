/*
 * Any number of threads gives the same bits, in a world of grasps that hold and slip, stiff stacks and jointed fingers.
 */
#include "support/cmocka_all.h"

#include <pinch/ode.h>

#include <stdlib.h>
#include <string.h>

enum { HANDS = 30, STACKS = 6, STEPS = 150, BODIES = HANDS + 2 * STACKS + HANDS / 3 };

typedef struct program {
    dWorldID world;
    dSpaceID space;
    pinch_ode *plugin;
    dBodyID body[BODIES];
    int count;
} program;

static void offer(void *data, dGeomID a, dGeomID b)
{
    program *p = data;
    dContact contact[8];
    memset(contact, 0, sizeof contact);
    int count = dCollide(a, b, 8, &contact[0].geom, sizeof contact[0]);
    for (int i = 0; i < count; i++) {
        contact[i].surface.mode = dContactApprox1;
        contact[i].surface.mu = 0.5;
        assert_int_equal(pinch_ode_add_contact(p->plugin, &contact[i], dGeomGetBody(a), dGeomGetBody(b)), PINCH_OK);
    }
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

static void make(program *p, int threads)
{
    memset(p, 0, sizeof *p);
    p->world = dWorldCreate();
    p->space = dSimpleSpaceCreate(NULL);
    dWorldSetGravity(p->world, 0, 0, -9.81);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.threads = threads;
    assert_int_equal(pinch_ode_create(p->world, &settings, &p->plugin), PINCH_OK);
    for (int k = 0; k < HANDS; k++) add_hand(p, k);
    dGeomSetCollideBits(dCreatePlane(p->space, 0, 0, 1, 0), 1);
    for (int k = 0; k < STACKS; k++) {
        add_box(p, 0.1, 1, 0.5 * k, 2, 0.05);
        add_box(p, 0.1, 1 + k, 0.5 * k + 0.01 * k, 2, 0.15);
    }
    assert_int_equal(p->count, BODIES);
}

/* Every state of every step. */
static uint64_t run(int threads, pinch_ode_stats *stats)
{
    program p;
    uint64_t hash = 14695981039346656037u;
    make(&p, threads);
    for (int step = 0; step < STEPS; step++) {
        dSpaceCollide(p.space, &p, offer);
        assert_int_equal(pinch_ode_step(p.plugin, 1e-3), PINCH_OK);
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

static void test_any_number_of_threads_gives_the_same_bits(void **state)
{
    (void)state;
    pinch_ode_stats one, more;
    uint64_t expected = run(1, &one);
    assert_true(one.islands > HANDS * STEPS && one.fallback_islands == 0);
    const int threads[] = {2, 3, 8};
    for (int k = 0; k < 3; k++) {
        assert_true(run(threads[k], &more) == expected);
        one.memory = more.memory = 0; /* each thread has scratch of its own */
        assert_memory_equal(&one, &more, sizeof one);
    }
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
        cmocka_unit_test(test_threads_out_of_range_are_refused),
    };
    int failed = cmocka_run_group_tests_name("threads", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
