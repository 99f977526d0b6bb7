/*
 * Compares the joint forces of Pinch's own solve with those of ODE's worldstep, which solves the same rows once more.
 * The bodies must move alike and the joints report alike, whatever the program does to them meanwhile.
 */
#include "support/cmocka_all.h"

#include "support/joint_rig.h"

#include <string.h>

static const double STEP = 1e-3;

/* The same rig twice: the joints by Pinch, and by ODE. */
typedef struct twins {
    joint_rig rig[2];
    dJointID joint[2];
    dJointFeedback feedback[2];
    double velocity_off, feedback_off; /* largest difference so far, relative where the numbers are large */
} twins;

static void twins_make(twins *t, const joint_kind *kind, uint64_t seed, joint_partner with, bool swapped,
                       joint_variant v)
{
    memset(t, 0, sizeof *t);
    for (int k = 0; k < 2; k++) {
        joint_rig_make(&t->rig[k], seed, with, 0.2, k == 1);
        t->joint[k] = joint_rig_attach(kind, &t->rig[k], with, swapped);
        joint_rig_set(kind, t->joint[k], v);
        dJointSetFeedback(t->joint[k], &t->feedback[k]);
    }
}

static void twins_free(twins *t)
{
    for (int k = 0; k < 2; k++) joint_rig_free(&t->rig[k]);
}

static void copy_state(dBodyID from, dBodyID to)
{
    const double *x = dBodyGetPosition(from), *v = dBodyGetLinearVel(from), *w = dBodyGetAngularVel(from);
    dBodySetPosition(to, x[0], x[1], x[2]);
    dBodySetQuaternion(to, dBodyGetQuaternion(from));
    dBodySetLinearVel(to, v[0], v[1], v[2]);
    dBodySetAngularVel(to, w[0], w[1], w[2]);
}

/* The tip goes along with the body, always 0.1 mm deep. */
static void press(joint_rig *r)
{
    const double *x = dBodyGetPosition(r->body[0]), *v = dBodyGetLinearVel(r->body[0]), *n = r->tip_normal;
    dBodySetPosition(r->tip_body, x[0] - 0.0299 * n[0], x[1] - 0.0299 * n[1], x[2] - 0.0299 * n[2]);
    dBodySetLinearVel(r->tip_body, v[0], v[1], v[2]);
    dBodySetAngularVel(r->tip_body, 0, 0, 0);
    dContact contact;
    memset(&contact, 0, sizeof contact);
    assert_int_equal(dCollide(r->geom, r->tip, 1, &contact.geom, sizeof contact.geom), 1);
    assert_int_equal(pinch_ode_add_contact(r->plugin, &contact, r->body[0], r->tip_body), PINCH_OK);
}

static double off(const double *a, const double *b)
{
    double most = 0;
    for (int i = 0; i < 3; i++) most = fmax(most, fabs(a[i] - b[i]) / fmax(1, fabs(b[i])));
    return most;
}

/* One step of both from the same state. */
static void twins_step(twins *t)
{
    for (int k = 0; k < 2; k++)
        if (t->rig[0].body[k]) copy_state(t->rig[0].body[k], t->rig[1].body[k]);
    for (int k = 0; k < 2; k++) {
        press(&t->rig[k]);
        assert_int_equal(pinch_ode_step(t->rig[k].plugin, STEP), PINCH_OK);
    }
    for (int k = 0; k < 2 && t->rig[0].body[k]; k++) {
        double linear = off(dBodyGetLinearVel(t->rig[0].body[k]), dBodyGetLinearVel(t->rig[1].body[k]));
        double angular = off(dBodyGetAngularVel(t->rig[0].body[k]), dBodyGetAngularVel(t->rig[1].body[k]));
        t->velocity_off = fmax(t->velocity_off, fmax(linear, angular));
    }
    const dJointFeedback *f = t->feedback;
    t->feedback_off = fmax(t->feedback_off, fmax(off(f[0].f1, f[1].f1), off(f[0].t1, f[1].t1)));
    t->feedback_off = fmax(t->feedback_off, fmax(off(f[0].f2, f[1].f2), off(f[0].t2, f[1].t2)));
}

/* Velocities of 1 m/s and 100 rad/s, forces of 1 to 1000 N, lever arms of millimetres: 1e-9 of them. */
static void test_every_joint(void **state)
{
    (void)state;
    int wrong = 0, cases = 0;
    for (int k = 0; k < joint_kind_count; k++)
        for (joint_partner with = 0; with < JOINT_PARTNERS; with++)
            for (int swapped = 0; swapped < 2; swapped++)
                for (joint_variant v = 0; v < JOINT_VARIANTS; v++) {
                    const joint_kind *kind = &joint_kinds[k];
                    if (!joint_rig_possible(kind, with, swapped, v)) continue;
                    const int steps = joint_rig_steps(kind, with, swapped, 50), left = kind->known ? 0 : steps;
                    for (uint64_t seed = 1; seed <= 2; seed++) {
                        twins t;
                        twins_make(&t, kind, seed, with, swapped, v);
                        for (int step = 0; step < steps; step++) twins_step(&t);
                        pinch_ode_stats stats = pinch_ode_statistics(t.rig[0].plugin);
                        pinch_ode_stats other = pinch_ode_statistics(t.rig[1].plugin);
                        assert_int_equal(stats.fallback_islands, 0);
                        assert_int_equal(stats.joints_solved, steps - left);
                        assert_int_equal(stats.joints_left, left);
                        assert_int_equal(other.joints_solved, 0);
                        assert_true(dJointIsEnabled(t.joint[0]));
                        cases++;
                        bool compared = kind->known && !joint_rig_mends(kind, with, swapped);
                        if (compared && !(t.velocity_off < 1e-9 && t.feedback_off < 1e-9)) {
                            wrong++;
                            print_error("%s with %s%s, %s, seed %d: velocities off by %g, feedback by %g\n", kind->name,
                                        joint_partner_names[with], swapped ? " (swapped)" : "", joint_variant_names[v],
                                        (int)seed, t.velocity_off, t.feedback_off);
                        }
                        twins_free(&t);
                    }
                }
    assert_true(cases > 700);
    assert_int_equal(wrong, 0);
}

static const joint_kind *kind_named(const char *name)
{
    for (int k = 0; k < joint_kind_count; k++)
        if (strcmp(joint_kinds[k].name, name) == 0) return &joint_kinds[k];
    fail();
    return NULL;
}

/* A joint may have no row until it meets a stop, which it then leaves as fast as in ODE. */
static void test_stops_that_come_into_reach(void **state)
{
    (void)state;
    for (uint64_t seed = 20; seed <= 22; seed += 2)
        for (int swapped = 0; swapped < 2; swapped++) {
            twins t;
            twins_make(&t, kind_named("Euler motor"), seed, JOINT_TWO_BODIES, swapped, JOINT_FREE);
            for (int step = 0; step < 50; step++) twins_step(&t);
            assert_true(t.velocity_off < 1e-9);
            twins_free(&t);
        }
}

/* What programs do to a hinge between steps. */
static void interfere(twins *t, int step, joint_partner with)
{
    for (int k = 0; k < 2; k++) {
        joint_rig *r = &t->rig[k];
        dBodyID other = with == JOINT_STATIC_WORLD ? NULL : r->body[1];
        const double *x = dBodyGetPosition(r->body[0]);
        switch (step) {
        case 20:
            dJointSetHingeAxis(t->joint[k], 0.6, 0, 0.8);
            break;
        case 40:
            dJointAttach(t->joint[k], other, r->body[0]);
            dJointSetHingeAnchor(t->joint[k], x[0], x[1] + 0.03, x[2]);
            dJointSetHingeAxis(t->joint[k], 0, 1, 0);
            break;
        case 60: /* most likely to come back in the same place of memory */
            dJointDestroy(t->joint[k]);
            t->joint[k] = dJointCreateHinge(r->world, NULL);
            dJointAttach(t->joint[k], r->body[0], other);
            dJointSetHingeAnchor(t->joint[k], x[0] + 0.02, x[1], x[2]);
            dJointSetHingeAxis(t->joint[k], 0, -0.8, 0.6);
            dJointSetFeedback(t->joint[k], &t->feedback[k]);
            break;
        case 80:
            dJointSetHingeParam(t->joint[k], dParamFMax, 0.01);
            dJointSetHingeParam(t->joint[k], dParamVel, 2);
            break;
        case 100:
            dJointDisable(t->joint[k]);
            memset(&t->feedback[k], 0, sizeof t->feedback[k]);
            break;
        case 120: /* apart by now: the hinge pulls them together */
            dJointEnable(t->joint[k]);
            break;
        case 400: /* not where it was measured from: the angle alone changes */
            dJointSetHingeAxisOffset(t->joint[k], 0, 0, 1, 0.3);
            break;
        default:
            break;
        }
    }
}

static void test_joints_that_change(void **state)
{
    (void)state;
    for (joint_partner with = 0; with < JOINT_PARTNERS; with++) {
        twins t;
        twins_make(&t, kind_named("hinge"), 11, with, false, JOINT_FREE);
        for (int step = 0; step < 500; step++) {
            interfere(&t, step, with);
            if (step == 101) assert_false(dJointIsEnabled(t.joint[0]));
            twins_step(&t);
            if (t.velocity_off > 1e-9 || t.feedback_off > 1e-8)
                print_error("%s, step %d: velocities off by %g, feedback by %g\n", joint_partner_names[with], step,
                            t.velocity_off, t.feedback_off);
            assert_true(t.velocity_off <= 1e-9 && t.feedback_off <= 1e-8);
        }
        pinch_ode_stats stats = pinch_ode_statistics(t.rig[0].plugin);
        assert_int_equal(stats.joints_solved, 380);
        assert_int_equal(stats.joints_left, 100); /* an offset of the angle hides where the second axis is */
        twins_free(&t);
    }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_joint),
        cmocka_unit_test(test_stops_that_come_into_reach),
        cmocka_unit_test(test_joints_that_change),
    };
    int failed = cmocka_run_group_tests_name("joint forces", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
