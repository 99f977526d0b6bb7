/*
 * A body has a hundred contact joints and a few joints that hold other bodies. These are made before the contacts,
 * between them and after them, switched off and taken away. Beside it the contacts of an equal body are handed over
 * without joints of their own, and the two must move alike.
 */
#include "support/cmocka_all.h"

#include <pinch/ode.h>

#include <math.h>
#include <string.h>

enum { FEET = 100, LOADS = 3, STEPS = 60 };
static const double STEP = 0.005, FOOT = 0.05, SPACING = 0.12;

typedef struct raft {
    dWorldID world;
    pinch_ode *plugin;
    dGeomID foot[FEET], ground;
    dBodyID body, load[LOADS];
    dJointID tie[LOADS], contact[FEET];
} raft;

static void make(raft *r)
{
    dMass mass;
    memset(r, 0, sizeof *r);
    r->world = dWorldCreate();
    dWorldSetGravity(r->world, 0, 0, -9.81);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.scope = PINCH_ODE_ALL_CONTACTS;
    assert_int_equal(pinch_ode_create(r->world, &settings, &r->plugin), PINCH_OK);
    r->body = dBodyCreate(r->world);
    dMassSetBoxTotal(&mass, 2, 1.2, 1.2, 0.1);
    dBodySetMass(r->body, &mass);
    dBodySetPosition(r->body, 0, 0, FOOT - 1e-4);
    r->ground = dCreatePlane(NULL, 0, 0, 1, 0);
    for (int i = 0; i < FEET; i++) {
        r->foot[i] = dCreateSphere(NULL, FOOT);
        dGeomSetBody(r->foot[i], r->body);
        dGeomSetOffsetPosition(r->foot[i], SPACING * (i % 10 - 4.5), SPACING * (i / 10 - 4.5), 0);
    }
    for (int k = 0; k < LOADS; k++) {
        r->load[k] = dBodyCreate(r->world);
        dMassSetSphereTotal(&mass, 0.3 + 0.1 * k, 0.05);
        dBodySetMass(r->load[k], &mass);
        dBodySetPosition(r->load[k], 0.3 * (k - 1), 0.1 * k, 0.4);
        dBodySetLinearVel(r->load[k], 0.5 - 0.3 * k, 0.2 * k, 0);
    }
}

static void destroy(raft *r)
{
    for (int i = 0; i < FEET; i++) dGeomDestroy(r->foot[i]);
    dGeomDestroy(r->ground);
    pinch_ode_destroy(r->plugin);
    dWorldDestroy(r->world);
}

static void tie(raft *r, int k)
{
    r->tie[k] = dJointCreateBall(r->world, NULL);
    dJointAttach(r->tie[k], r->body, r->load[k]);
    dJointSetBallAnchor(r->tie[k], 0.3 * (k - 1), 0.1 * k, 0.2);
}

static void contact_of(const raft *r, int foot, dContact *contact)
{
    memset(contact, 0, sizeof *contact);
    contact->surface.mode = dContactApprox1 | dContactSoftERP | dContactSoftCFM;
    contact->surface.mu = 0.4;
    contact->surface.soft_erp = 0.4;
    contact->surface.soft_cfm = 1e-4;
    assert_int_equal(dCollide(r->foot[foot], r->ground, 1, &contact->geom, sizeof contact->geom), 1);
}

/* Joints made once, and handed over with what the collider says now. */
static void hand_over_joints(raft *r, int first, int end)
{
    for (int i = first; i < end; i++) {
        dContact contact;
        contact_of(r, i, &contact);
        if (!r->contact[i]) {
            r->contact[i] = dJointCreateContact(r->world, NULL, &contact);
            dJointAttach(r->contact[i], r->body, NULL);
        }
        assert_int_equal(pinch_ode_add_joint(r->plugin, r->contact[i], &contact), PINCH_OK);
    }
}

static void hand_over(raft *r)
{
    for (int i = 0; i < FEET; i++) {
        dContact contact;
        contact_of(r, i, &contact);
        assert_int_equal(pinch_ode_add_contact(r->plugin, &contact, r->body, NULL), PINCH_OK);
    }
}

static void step(raft *r)
{
    assert_int_equal(pinch_ode_step(r->plugin, STEP), PINCH_OK);
}

static void expect_alike(const raft *a, const raft *b, int step)
{
    for (int k = -1; k < LOADS; k++) {
        const double *x = dBodyGetPosition(k < 0 ? a->body : a->load[k]);
        const double *y = dBodyGetPosition(k < 0 ? b->body : b->load[k]);
        for (int i = 0; i < 3; i++)
            if (!(fabs(x[i] - y[i]) < 1e-9)) fail_msg("step %d, body %d: off by %g m", step, k, x[i] - y[i]);
    }
}

/* What the program does to its joints meanwhile. */
static void change(raft *r, int step)
{
    if (step == 20) dJointDisable(r->tie[0]);
    if (step == 30) dJointEnable(r->tie[0]);
    if (step == 40) dJointDestroy(r->tie[1]);
}

static void test_other_joints_among_contacts(void **state)
{
    (void)state;
    raft joints, none;
    make(&joints);
    make(&none);
    for (int i = 0; i < STEPS; i++) {
        if (i == 0) tie(&joints, 0); /* the end of the list */
        hand_over_joints(&joints, 0, FEET / 2);
        if (i == 0) tie(&joints, 1); /* its middle */
        hand_over_joints(&joints, FEET / 2, FEET);
        if (i == 10) tie(&joints, 2); /* its beginning */
        hand_over(&none);
        for (int k = 0; k < LOADS; k++)
            if (i == (k < 2 ? 0 : 10)) tie(&none, k);
        change(&joints, i);
        change(&none, i);
        step(&joints);
        step(&none);
        expect_alike(&joints, &none, i);
    }
    assert_true(pinch_ode_statistics(joints.plugin).contacts_solved == (long)FEET * STEPS);
    assert_true(pinch_ode_statistics(joints.plugin).joints_solved > 2 * (STEPS - 10));
    destroy(&joints);
    destroy(&none);
}

/* What is not handed over, ODE must not see: half of them are taken away. */
static void switch_contacts(raft *r, const bool *comes)
{
    for (int k = 0; k < FEET; k++) {
        if (!r->contact[k]) continue;
        if (comes[k]) {
            dJointEnable(r->contact[k]);
        } else if (k % 2) {
            dJointDisable(r->contact[k]);
        } else {
            dJointDestroy(r->contact[k]);
            r->contact[k] = NULL;
        }
    }
}

/* A contact joint that the program has switched off is none; contacts that come and go leave the others' count right.
 */
static void test_fewer_contacts_again(void **state)
{
    (void)state;
    raft joints, none;
    make(&joints);
    make(&none);
    tie(&joints, 0);
    tie(&none, 0);
    for (int i = 0; i < STEPS; i++) {
        bool comes[FEET] = {false};
        for (int k = 0; k < (i < 20 ? FEET : i < 40 ? 3 : FEET / 2); k++) comes[37 * k % FEET] = true;
        switch_contacts(&joints, comes);
        for (int foot = 0; foot < FEET; foot++) {
            dContact contact;
            if (!comes[foot]) continue;
            contact_of(&none, foot, &contact);
            assert_int_equal(pinch_ode_add_contact(none.plugin, &contact, none.body, NULL), PINCH_OK);
            hand_over_joints(&joints, foot, foot + 1);
        }
        step(&joints);
        step(&none);
        expect_alike(&joints, &none, i);
    }
    destroy(&joints);
    destroy(&none);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_other_joints_among_contacts),
                                       cmocka_unit_test(test_fewer_contacts_again)};
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
