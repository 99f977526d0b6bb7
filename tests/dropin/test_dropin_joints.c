/*
 * Chains of jointed boxes are stepped with quickstep, whose sweeps do not bring them to rest. Where Pinch solves the
 * joints the chains lie still; where it cannot, they are no worse than without Pinch.
 */
#include "support/cmocka_all.h"

#include <ode/ode.h>

#include <math.h>
#include <pinch/ode_dropin.h>
#include <string.h>

enum { LINKS = 10, STEPS = 400, LAST = 50 };
static const double H = 0.01, LENGTH = 0.25;

typedef enum link_kind { FIXED = 0, SLIDER, HINGE, BALL, UNSEEN } link_kind;

typedef struct chain {
    dWorldID world;
    dSpaceID space;
    dJointGroupID contacts;
    dBodyID body[LINKS];
    bool with_pinch;
} chain;

/* A fixed joint whose making Pinch has not seen: it stays ODE's. */
#undef dJointSetFixed
static void set_fixed_unseen(dJointID joint)
{
    dJointSetFixed(joint);
}
#define dJointSetFixed pinch_dropin_joint_set_fixed

static dJointID make_link(link_kind kind, dWorldID world, dBodyID a, dBodyID b, double x)
{
    dJointID joint;
    switch (kind) {
    case FIXED:
        joint = dJointCreateFixed(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetFixed(joint);
        return joint;
    case SLIDER:
        joint = dJointCreateSlider(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetSliderAxis(joint, 1, 0, 0);
        dJointSetSliderParam(joint, dParamLoStop, -0.05);
        dJointSetSliderParam(joint, dParamHiStop, 0.05);
        return joint;
    case HINGE:
        joint = dJointCreateHinge(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetHingeAnchor(joint, x, 0, 0.5);
        dJointSetHingeAxis(joint, 0, 1, 0);
        return joint;
    case BALL:
        joint = dJointCreateBall(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetBallAnchor(joint, x, 0, 0.5);
        return joint;
    default:
        joint = dJointCreateFixed(world, NULL);
        dJointAttach(joint, a, b);
        set_fixed_unseen(joint);
        return joint;
    }
}

static void make(chain *c, link_kind kind, double mass_ratio, bool sleepy, bool with_pinch)
{
    c->with_pinch = with_pinch;
    c->world = dWorldCreate();
    c->space = dHashSpaceCreate(NULL);
    c->contacts = dJointGroupCreate(0);
    dWorldSetGravity(c->world, 0, 0, -9.81);
    dWorldSetAutoDisableFlag(c->world, sleepy);
    dCreatePlane(c->space, 0, 0, 1, 0);
    for (int i = 0; i < LINKS; i++) {
        dMass mass;
        c->body[i] = dBodyCreate(c->world);
        dMassSetBoxTotal(&mass, i % 2 ? mass_ratio : 1, 0.2, 0.15, 0.1);
        dBodySetMass(c->body[i], &mass);
        dBodySetPosition(c->body[i], LENGTH * i, 0, 0.5);
        dGeomSetBody(dCreateBox(c->space, 0.2, 0.15, 0.1), c->body[i]);
        if (i > 0) (void)make_link(kind, c->world, c->body[i - 1], c->body[i], LENGTH * i - 0.5 * LENGTH);
    }
}

static void destroy(chain *c)
{
    dJointGroupDestroy(c->contacts);
    dSpaceDestroy(c->space);
    dWorldDestroy(c->world);
}

#undef dJointCreateContact
#undef dWorldQuickStep
static dJointID contact_joint(const chain *c, const dContact *contact)
{
    return c->with_pinch ? pinch_dropin_joint_create_contact(c->world, c->contacts, contact)
                         : dJointCreateContact(c->world, c->contacts, contact);
}

static int quick_step(const chain *c)
{
    return c->with_pinch ? pinch_dropin_world_quick_step(c->world, H) : dWorldQuickStep(c->world, H);
}

static void near_callback(void *data, dGeomID a, dGeomID b)
{
    const chain *c = data;
    dContact contact[8];
    memset(contact, 0, sizeof contact);
    if (dGeomGetBody(a) && dGeomGetBody(b)) return;
    int count = dCollide(a, b, 8, &contact[0].geom, sizeof contact[0]);
    for (int i = 0; i < count; i++) {
        contact[i].surface.mode = dContactApprox1;
        contact[i].surface.mu = 0.5;
        dJointAttach(contact_joint(c, &contact[i]), dGeomGetBody(a), dGeomGetBody(b));
    }
}

static double fastest(const chain *c)
{
    double most = 0;
    for (int i = 0; i < LINKS; i++) most = fmax(most, dCalcVectorLength3(dBodyGetLinearVel(c->body[i])));
    return most;
}

/* The fastest that a link is in the last steps; *peak: in all. */
static double run(chain *c, double *peak)
{
    double last = 0;
    *peak = 0;
    dRandSetSeed(1);
    for (int i = 0; i < STEPS; i++) {
        dSpaceCollide(c->space, c, near_callback);
        assert_int_equal(quick_step(c), 1);
        dJointGroupEmpty(c->contacts);
        *peak = fmax(*peak, fastest(c));
        if (i >= STEPS - LAST) last = fmax(last, fastest(c));
    }
    return last;
}

static const double MASS_RATIO[] = {1, 10, 100};
static const double FALL = 3.0; /* m/s, from where they begin */

static void chains_come_to_rest(void **state)
{
    (void)state;
    for (link_kind kind = 0; kind < UNSEEN; kind++)
        for (int m = 0; m < 3; m++)
            for (int sleepy = 0; sleepy < 2; sleepy++) {
                chain c;
                double peak;
                pinch_dropin_reset_statistics();
                make(&c, kind, MASS_RATIO[m], sleepy, true);
                double last = run(&c, &peak);
                pinch_ode_stats stats = pinch_dropin_statistics().ode;
                if (!(last < 1e-9) || !(peak < 2 * FALL))
                    fail_msg("joint %d, masses 1 to %g, sleepy %d: %g m/s, at most %g", kind, MASS_RATIO[m], sleepy,
                             last, peak);
                assert_int_equal(stats.joints_left, 0);
                assert_true(stats.step_mismatch < 1e-9);
                for (int i = 0; i < LINKS && sleepy; i++) assert_false(dBodyIsEnabled(c.body[i]));
                destroy(&c);
            }
}

/* A push at one end of a chain that has gone to sleep wakes all of it: its joints are not seen by ODE, but tie. */
static void a_sleeping_chain_wakes(void **state)
{
    (void)state;
    chain c;
    double peak;
    make(&c, HINGE, 1, true, true);
    (void)run(&c, &peak);
    assert_false(dBodyIsEnabled(c.body[LINKS - 1]));
    dBodyEnable(c.body[0]);
    dBodySetLinearVel(c.body[0], 0, 0, 1);
    for (int i = 0; i < 3; i++) {
        dSpaceCollide(c.space, &c, near_callback);
        assert_int_equal(quick_step(&c), 1);
        dJointGroupEmpty(c.contacts);
    }
    assert_true(dBodyIsEnabled(c.body[LINKS - 1]));
    destroy(&c);
}

/* Joints that stay ODE's, whose sweeps leave more than the contacts can bear: after some tries it gets it all. */
static void what_stays_odes_is_no_worse(void **state)
{
    (void)state;
    for (int m = 0; m < 3; m++) {
        chain with, without;
        double peak, native_peak;
        pinch_dropin_reset_statistics();
        make(&with, UNSEEN, MASS_RATIO[m], false, true);
        make(&without, UNSEEN, MASS_RATIO[m], false, false);
        double last = run(&with, &peak), native = run(&without, &native_peak);
        pinch_ode_stats stats = pinch_dropin_statistics().ode;
        print_message("masses 1 to %g: %g m/s, without Pinch %g; %ld of %d islands left\n", MASS_RATIO[m], last, native,
                      stats.fallback_islands, STEPS);
        assert_true(stats.fallback_islands > STEPS / 2);
        assert_true(last < 4 * native + 0.01 && peak < 4 * native_peak);
        destroy(&with);
        destroy(&without);
    }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chains_come_to_rest),
        cmocka_unit_test(a_sleeping_chain_wakes),
        cmocka_unit_test(what_stays_odes_is_no_worse),
    };
    int failed = cmocka_run_group_tests_name("joints in a drop-in", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
