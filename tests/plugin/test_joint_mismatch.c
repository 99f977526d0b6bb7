/*
 * ODE's own step must arrive at what the contact solver predicts. This holds for every joint that Pinch knows, however
 * it is attached, with motors and stops, while contacts act. The test measures it by the bodies' velocities and not by
 * the plugin's statistics.
 */
#include "support/cmocka_all.h"

#include "support/joint_rig.h"

#include <pinch/ode.h>
#include <string.h>

static const double STEP = 1e-3;

typedef struct point_motion {
    double linear[3], angular[3];
} point_motion;

/* The velocity that the body has now, at a point given relative to where it was. */
static point_motion motion_of(dBodyID body, const double *was, const double *point)
{
    point_motion m;
    memset(&m, 0, sizeof m);
    if (!body) return m;
    const double *v = dBodyGetLinearVel(body), *w = dBodyGetAngularVel(body);
    double arm[3];
    for (int i = 0; i < 3; i++) arm[i] = point[i] - was[i];
    dCalcVectorCross3(m.linear, w, arm);
    for (int i = 0; i < 3; i++) {
        m.linear[i] += v[i];
        m.angular[i] = w[i];
    }
    return m;
}

/*
 * One step with a contact; the largest difference between the relative velocity solved for and the one that came out,
 * m/s at the contact. *force: the contact's normal force.
 */
static double step_and_compare(joint_rig *r, double *force)
{
    dContact contact;
    memset(&contact, 0, sizeof contact);
    if (dCollide(r->geom, r->tip, 1, &contact.geom, sizeof contact.geom) == 1)
        assert_int_equal(pinch_ode_add_contact(r->plugin, &contact, r->body[0], r->tip_body), PINCH_OK);
    double was[2][3];
    for (int i = 0; i < 3; i++) {
        was[0][i] = dBodyGetPosition(r->body[0])[i];
        was[1][i] = dBodyGetPosition(r->tip_body)[i];
    }
    assert_int_equal(pinch_ode_solve(r->plugin, STEP), PINCH_OK);
    const pinch_ode_contact *list;
    pinch_ode_contact solved[8];
    int count;
    pinch_ode_contacts(r->plugin, &list, &count);
    assert_in_range(count, 0, 8);
    memcpy(solved, list, sizeof *list * (size_t)count);
    assert_int_equal(pinch_ode_advance(r->plugin, STEP), PINCH_OK);
    double most = 0;
    *force = 0;
    for (int k = 0; k < count; k++) {
        int first = solved[k].geom1 == r->geom ? 0 : 1;
        point_motion m1 = motion_of(first == 0 ? r->body[0] : r->tip_body, was[first], solved[k].position);
        point_motion m2 = motion_of(first == 0 ? r->tip_body : r->body[0], was[1 - first], solved[k].position);
        for (int i = 0; i < 3; i++)
            most = fmax(most, fabs(m1.linear[i] - m2.linear[i] - solved[k].relative_velocity[i]));
        *force += solved[k].normal_force;
    }
    return most;
}

/*
 * From a joint without errors: rounding. Velocities of 1 m/s, forces of 100 N on 0.1 kg and a conditioning of 1e3 of
 * the joint rows (lever arms of a few millimetres): 1e-11 m/s.
 */
static void test_first_step_is_exact(void **state)
{
    (void)state;
    int wrong = 0, cases = 0, touched = 0;
    for (int k = 0; k < joint_kind_count; k++)
        for (joint_partner with = 0; with < JOINT_PARTNERS; with++)
            for (int swapped = 0; swapped < 2; swapped++)
                for (joint_variant v = 0; v < JOINT_VARIANTS; v++) {
                    const joint_kind *kind = &joint_kinds[k];
                    if (!joint_rig_possible(kind, with, swapped, v) || !kind->known) continue;
                    double worst = 0, force, pressed = 0;
                    for (uint64_t seed = 1; seed <= 5; seed++) {
                        joint_rig r;
                        joint_rig_make(&r, seed, with, 0.5, true);
                        dJointID j = joint_rig_attach(kind, &r, with, swapped);
                        joint_rig_set(kind, j, v);
                        worst = fmax(worst, step_and_compare(&r, &force));
                        pinch_ode_stats stats = pinch_ode_statistics(r.plugin);
                        worst = fmax(worst, fmax(stats.step_mismatch, 0.1 * stats.step_mismatch_angular));
                        pressed = fmax(pressed, force);
                        assert_int_equal(stats.fallback_islands, 0);
                        assert_int_equal(stats.joints_unmodelled, 0);
                        joint_rig_free(&r);
                    }
                    cases++;
                    touched += pressed > 0 || joint_rig_leaps(kind, with, swapped);
                    if (worst <= 1e-11) continue;
                    wrong++;
                    print_error("%s with %s%s, %s: off by %g m/s\n", kind->name, joint_partner_names[with],
                                swapped ? " (swapped)" : "", joint_variant_names[v], worst);
                }
    assert_true(cases > 350);
    assert_int_equal(touched, cases);
    assert_int_equal(wrong, 0);
}

/* In motion ODE corrects errors of position, which are known to rounding, and with them the motion of up to 100 steps.
 */
static void test_motion_is_exact(void **state)
{
    (void)state;
    int wrong = 0;
    for (int k = 0; k < joint_kind_count; k++)
        for (joint_partner with = 0; with < JOINT_PARTNERS; with++)
            for (int swapped = 0; swapped < 2; swapped++) {
                const joint_kind *kind = &joint_kinds[k];
                if (!joint_rig_possible(kind, with, swapped, JOINT_FREE) || !kind->known) continue;
                for (uint64_t seed = 1; seed <= 3; seed++) {
                    joint_rig r;
                    double force, worst = 0;
                    joint_rig_make(&r, seed, with, 0.05, true);
                    dWorldSetGravity(r.world, 0, 0, 0);
                    joint_rig_attach(kind, &r, with, swapped);
                    for (int step = 0; step < joint_rig_steps(kind, with, swapped, 100); step++) {
                        worst = fmax(worst, step_and_compare(&r, &force));
                    }
                    pinch_ode_stats stats = pinch_ode_statistics(r.plugin);
                    static const double most = 1e-10; /* rad/s; a tenth of it in m/s */
                    if (stats.step_mismatch_angular > most || fmax(worst, stats.step_mismatch) > 0.1 * most) {
                        wrong++;
                        print_error("%s with %s%s, seed %d: off by %g m/s at the contact, %g m/s, %g rad/s\n",
                                    kind->name, joint_partner_names[with], swapped ? " (swapped)" : "", (int)seed,
                                    worst, stats.step_mismatch, stats.step_mismatch_angular);
                    }
                    assert_int_equal(stats.fallback_islands, 0);
                    joint_rig_free(&r);
                }
            }
    assert_int_equal(wrong, 0);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_first_step_is_exact),
        cmocka_unit_test(test_motion_is_exact),
    };
    int failed = cmocka_run_group_tests_name("joints against ODE's step", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
