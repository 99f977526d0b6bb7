/*
 * Bodies are destroyed by calls that Pinch does not see: programs need not include <pinch/ode_dropin.h> for that. No
 * pointer to a destroyed body may be followed. Each of ODE's smaller blocks therefore has pages of its own here, which
 * nobody can read once it was given back.
 */
#define _DEFAULT_SOURCE /* MAP_ANONYMOUS */

#include "support/cmocka_all.h"

#include "support/draw.h"

#include <pinch/ode_dropin.h>

#include <ode/memory.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { LINKS = 16, STEPS = 400, LARGE = 4096 };

static void *allocate(size_t size)
{
    if (size > LARGE) return malloc(size);
    void *block = mmap(NULL, LARGE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return block == MAP_FAILED ? NULL : block;
}

/* What is closed stays in the address space, so that nothing else comes there. */
static void give_back(void *block, size_t size)
{
    if (size > LARGE)
        free(block);
    else if (block)
        assert_int_equal(mprotect(block, LARGE, PROT_NONE), 0);
}

static void *reallocate(void *block, size_t old_size, size_t size)
{
    void *bigger = allocate(size);
    if (block && bigger) memcpy(bigger, block, old_size < size ? old_size : size);
    if (block) give_back(block, old_size);
    return bigger;
}

typedef struct scene {
    dWorldID world;
    dSpaceID space;
    dJointGroupID contacts, hinges;
    dBodyID link[LINKS];
} scene;

static void near(void *data, dGeomID a, dGeomID b)
{
    scene *s = data;
    dContact contact[4];
    dBodyID body1 = dGeomGetBody(a), body2 = dGeomGetBody(b);
    if (body1 && body2) return; /* links touch the ground alone */
    memset(contact, 0, sizeof contact);
    int count = dCollide(a, b, 4, &contact[0].geom, sizeof *contact);
    for (int i = 0; i < count; i++) {
        contact[i].surface.mu = 0.5;
        dJointAttach(dJointCreateContact(s->world, s->contacts, &contact[i]), body1, body2);
    }
}

static void hinge(scene *s, dBodyID a, dBodyID b, dJointGroupID group)
{
    const dReal *p = dBodyGetPosition(a);
    dJointID joint = dJointCreateHinge(s->world, group);
    dJointAttach(joint, a, b);
    dJointSetHingeAnchor(joint, p[0] + 0.1, p[1], p[2]);
    dJointSetHingeAxis(joint, 0, 1, 0);
}

static void make_link(scene *s, int k, double height)
{
    dMass mass;
    dMassSetBoxTotal(&mass, 1, 0.18, 0.1, 0.1);
    s->link[k] = dBodyCreate(s->world);
    dBodySetMass(s->link[k], &mass);
    dBodySetPosition(s->link[k], 0.2 * k, 0, height);
    dGeomSetBody(dCreateBox(s->space, 0.18, 0.1, 0.1), s->link[k]);
}

/* A chain with every other hinge in a group. */
static void open_scene(scene *s, double height)
{
    memset(s, 0, sizeof *s);
    s->world = dWorldCreate();
    s->space = dSimpleSpaceCreate(NULL);
    s->contacts = dJointGroupCreate(0);
    s->hinges = dJointGroupCreate(0);
    dWorldSetGravity(s->world, 0, 0, -9.81);
    dCreatePlane(s->space, 0, 0, 1, 0);
    for (int k = 0; k < LINKS; k++) make_link(s, k, height);
    for (int k = 0; k + 1 < LINKS; k++) hinge(s, s->link[k], s->link[k + 1], k % 2 ? s->hinges : NULL);
}

static void close_scene(scene *s)
{
    dJointGroupDestroy(s->contacts);
    dJointGroupDestroy(s->hinges);
    dSpaceDestroy(s->space);
    dWorldDestroy(s->world);
}

static void step(scene *s, bool quick)
{
    dSpaceCollide(s->space, s, near);
    assert_true(quick ? dWorldQuickStep(s->world, 0.005) : dWorldStep(s->world, 0.005));
    dJointGroupEmpty(s->contacts);
    for (int k = 0; k < LINKS; k++)
        if (s->link[k]) assert_true(isfinite(dBodyGetPosition(s->link[k])[2]));
}

/* Links go and come, between steps and between the finding of contacts and a step. */
static void changing(bool quick)
{
    for (int seed = 0; seed < draw_count(300); seed++) {
        scene s;
        pinch_random random;
        pinch_random_seed(&random, (uint64_t)seed);
        open_scene(&s, seed % 2 ? 0.05 : 0.6);
        for (int n = 0; n < STEPS; n++) {
            int k = draw_index(&random, LINKS);
            if (n % 7 == 3) {
                if (draw_chance(&random, 0.5)) dSpaceCollide(s.space, &s, near);
                if (s.link[k]) {
                    dBodyDestroy(s.link[k]);
                    s.link[k] = NULL;
                } else {
                    make_link(&s, k, draw_uniform(&random, 0.05, 0.6));
                    if (k > 0 && s.link[k - 1]) hinge(&s, s.link[k - 1], s.link[k], k % 2 ? s.hinges : NULL);
                }
            }
            if (n == STEPS / 2) dJointGroupEmpty(s.hinges);
            step(&s, quick);
        }
        close_scene(&s);
    }
}

static void test_quickstep(void **state)
{
    (void)state;
    pinch_dropin_reset_statistics();
    changing(true);
    assert_true(pinch_dropin_statistics().ode.joints_solved > 0);
}

static void test_worldstep(void **state)
{
    (void)state;
    pinch_dropin_reset_statistics();
    changing(false);
    assert_true(pinch_dropin_statistics().ode.joints_solved > 0);
}

/* A body that is known from a joint of a touched one alone: where joints are ODE's, bodies are not handed over. */
static void test_known_from_a_joint(void **state)
{
    (void)state;
    scene s;
    pinch_ode_settings usual = pinch_dropin_settings(), settings = usual;
    settings.joints_by_ode = true;
    assert_int_equal(pinch_dropin_set_settings(&settings), PINCH_OK);
    open_scene(&s, 0.05);
    for (int k = 2; k < LINKS; k++) {
        dBodyDestroy(s.link[k]);
        s.link[k] = NULL;
    }
    dJointGroupEmpty(s.hinges);
    dBodySetPosition(s.link[1], 0.2, 0, 0.1); /* above the ground, on the hinge alone */
    dBodySetGravityMode(s.link[1], 0);
    for (int n = 0; n < 5; n++) step(&s, false);
    dBodyDestroy(s.link[1]);
    s.link[1] = NULL;
    for (int n = 0; n < 5; n++) step(&s, false);
    close_scene(&s);
    assert_int_equal(pinch_dropin_set_settings(&usual), PINCH_OK);
}

int main(void)
{
    dSetAllocHandler(allocate);
    dSetReallocHandler(reallocate);
    dSetFreeHandler(give_back);
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_quickstep),
        cmocka_unit_test(test_worldstep),
        cmocka_unit_test(test_known_from_a_joint),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
