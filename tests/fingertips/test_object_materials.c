/*
 * Objects that say what they are of: they give way in series with the fingertips, and the smaller friction counts, in
 * runs by Pinch and by ODE's solvers, in the statics, and in what is left of the friction limit.
 */
#include "support/cmocka_all.h"

#include "support/scene_run.h"

#include "common/vector.h"
#include "scenes/grasp.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const double CLOSING = 5e-4, STIFFNESS = 1e4; /* m, N/m */

/* A cube of 50 mm and `mass`, pinched along x by two fingers as `finger` has them. */
static scene *pinched(double mass, const char *object, const char *finger, const char *more)
{
    char text[4096];
    int used = snprintf(text, sizeof text,
                        "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.05, "
                        "0.05, 0.05]}, \"mass\": %g%s}, \"fingers\": [",
                        mass, object);
    for (int side = 0; side < 2; side++)
        used += snprintf(text + used, sizeof text - (size_t)used,
                         "%s{\"point\": [%g, 0, 0], \"normal\": [%d, 0, 0], \"closing\": %g, %s}", side ? ", " : "",
                         side ? 0.025 : -0.025, side ? -1 : 1, CLOSING, finger);
    snprintf(text + used, sizeof text - (size_t)used, "], \"simulation\": {\"step\": 0.001, \"duration\": 2}%s}", more);
    return scene_from_text(text);
}

static const char HARD[] = "\"model\": \"hard\", \"stiffness\": {\"normal\": 1e4, \"tangential\": 5e3}, \"damping\": "
                           "{\"normal\": 20, \"tangential\": 20}, \"friction\": 0.5";
static const char SOFT[] = "\"model\": \"soft\", \"stiffness\": {\"normal\": 1e4, \"torsional\": 2}, \"damping\": "
                           "{\"normal\": 20, \"tangential\": 20, \"torsional\": 0.01}, \"friction\": 0.5, "
                           "\"torsional_friction\": 0.003";
/* A pad of 20 mm, whose corners are sqrt(2) cm from its middle. */
static const char PAD[] = "\"model\": \"hard\", \"stiffness\": {\"normal\": 1e4}, \"damping\": {\"normal\": 20, "
                          "\"tangential\": 20}, \"friction\": 0.5, \"tip\": {\"type\": \"box\", \"size\": [0.01, 0.02, "
                          "0.02]}";

static const double WEIGHT = 0.1 * 9.81; /* N */

static void test_the_object_gives_way_and_its_friction_counts(void **state)
{
    (void)state;
    scene *s = pinched(0.1, ", \"stiffness\": {\"normal\": 1e4, \"tangential\": 1e4}, \"friction\": 0.2", HARD, "");
    world *w = world_of(s);
    world_run_until(w, 2);
    pinch_finger fingers[2];
    pinch_finger_result results[2];
    pinch_grasp grasp;
    pinch_statics *statics;
    pinch_statics_result result;
    pinch_statics_settings settings = pinch_default_statics_settings();
    scene_static_grasp(s, fingers, &grasp);
    assert_int_equal(pinch_statics_create(2, 0, &statics), PINCH_OK);
    assert_int_equal(pinch_statics_solve(statics, &grasp, &settings, results, &result), PINCH_OK);
    double normal = 0.5 * STIFFNESS * CLOSING, give = 0.5 * WEIGHT / (1 / (1 / 5e3 + 1 / 1e4));
    for (int i = 0; i < 2; i++) {
        const world_finger *f = &w->fingers[i];
        assert_close(f->state.normal_force, normal, 1e-9);
        assert_close(results[i].r[0], normal, 1e-9);
        assert_close(scene_norm(f->state.elastic), give, 1e-9);
        assert_close(world_normal_displacement(w, f), normal / STIFFNESS, 1e-12);
        assert_close(world_slip_margin(w, f), 1 - 0.5 * WEIGHT / (0.2 * normal), 1e-6);
        assert_close(world_least_margin(w, f), 1 - 0.5 * WEIGHT / (0.2 * normal), 1e-6);
        assert_close(results[i].slip_margin, 1 - 0.5 * WEIGHT / (0.2 * normal), 1e-6);
    }
    assert_close(result.translation[2], -give, 1e-9);
    pinch_statics_destroy(statics);
    world_free(w);
    scene_free(s);
}

/* 2 * 0.5 * 2.5 N bear the weight; 2 * 0.1 * 2.5 N do not. */
static void test_every_solver_is_told(void **state)
{
    (void)state;
    static const char *const objects[] = {", \"stiffness\": {\"normal\": 1e4}, \"friction\": 0.9",
                                          ", \"stiffness\": {\"normal\": 1e4}, \"friction\": 0.1"};
    for (int solver = WORLD_PINCH; solver <= WORLD_WORLDSTEP; solver++) {
        for (int k = 0; k < 2; k++) {
            scene *s = pinched(0.1, objects[k], HARD, "");
            world_settings settings = world_default_settings(s);
            world *w;
            char error[256];
            settings.contact_solver = (world_solver)solver;
            assert_int_equal(world_create(s, &settings, &w, error), WORLD_OK);
            world_run_until(w, 0.5);
            bool held = dBodyGetPosition(w->object)[2] > -0.01;
            assert_int_equal(held, k == 0);
            if (held) assert_close(w->fingers[0].state.normal_force, 2.5, 0.01);
            world_free(w);
            scene_free(s);
        }
    }
}

static const char TURN[] = ", \"gravity\": [0, 0, 0], \"schedule\": [{\"time\": 0, \"torque\": [0, 0, 0]}, {\"time\": "
                           "0.5, \"torque\": [0, 0, 0]}, {\"time\": 1, \"torque\": [%.17g, 0, 0]}]";

static world *turned(const char *object, const char *finger, double torque, scene **s)
{
    char more[512];
    snprintf(more, sizeof more, TURN, torque);
    *s = pinched(0.2, object, finger, more);
    world *w = world_of(*s);
    world_run_until(w, 2);
    return w;
}

/* An object that says nothing about turning does not take a soft finger's resistance to it away. */
static void test_soft_fingers_stay_soft(void **state)
{
    (void)state;
    static const char *const objects[] = {"", ", \"stiffness\": {\"normal\": 1e4}, \"friction\": 0.5"};
    for (int k = 0; k < 2; k++) {
        scene *s;
        double normal = (k ? 0.5 : 1) * STIFFNESS * CLOSING, limit = 2 * 0.003 * normal;
        world *w = turned(objects[k], SOFT, 0.98 * limit, &s);
        assert_close(fabs(w->fingers[0].state.torsional_moment), 0.49 * limit, 1e-6 * limit);
        assert_close(world_least_margin(w, &w->fingers[0]), 0.02, 1e-4);
        assert_true(w->fingers[0].state.slip_total == 0);
        assert_close(dCalcVectorLength3(dBodyGetAngularVel(w->object)), 0, 1e-6);
        world_free(w);
        scene_free(s);
        w = turned(objects[k], SOFT, 1.02 * limit, &s);
        assert_true(dCalcVectorLength3(dBodyGetAngularVel(w->object)) > 0.1);
        assert_close(world_least_margin(w, &w->fingers[0]), 0, 1e-9);
        world_free(w);
        scene_free(s);
    }
}

/* The path slipped is that on which friction loses what it has lost: of a pad that turns about its middle as of a soft
 * point that does, though neither has a tangential force. */
static void test_turning_is_slip(void **state)
{
    (void)state;
    static const char *const fingers[] = {PAD, SOFT};
    const double normal = STIFFNESS * CLOSING, limits[] = {2 * 0.5 * normal * 0.01 * sqrt(2), 2 * 0.003 * normal};
    for (int k = 0; k < 2; k++) {
        scene *s;
        world *w = turned("", fingers[k], 0.98 * limits[k], &s);
        for (int i = 0; i < 2; i++) {
            assert_close(world_least_margin(w, &w->fingers[i]), 0.02, 1e-3);
            assert_true(w->fingers[i].state.slip_total == 0);
        }
        world_free(w);
        scene_free(s);
        w = turned("", fingers[k], 1.02 * limits[k], &s);
        double path = w->fingers[0].state.slip_total + w->fingers[1].state.slip_total;
        assert_true(path > 1e-3);
        assert_close(path * 0.5 * normal, w->ledger.friction, 0.02 * w->ledger.friction);
        for (int i = 0; i < 2; i++) {
            assert_close(scene_norm(w->fingers[i].state.tangential_force), 0, 1e-3);
            assert_close(world_least_margin(w, &w->fingers[i]), 0, 1e-9);
        }
        world_free(w);
        scene_free(s);
    }
}

static void test_sliding_at_kinetic_friction_leaves_no_margin(void **state)
{
    (void)state;
    scene *s = pinched(1, "",
                       "\"model\": \"hard\", \"stiffness\": {\"normal\": 1e4}, \"damping\": {\"normal\": 20, "
                       "\"tangential\": 20}, \"friction\": {\"static\": 0.5, \"kinetic\": 0.3}",
                       "");
    world *w = world_of(s);
    world_run_until(w, 0.05);
    const world_finger *f = &w->fingers[0];
    assert_int_equal(f->state.state, PINCH_CONTACT_SLIP);
    assert_close(world_least_margin(w, f), 0, 1e-9);
    assert_close(world_slip_margin(w, f), 0.4, 1e-6); /* of the static coefficient */
    world_free(w);
    scene_free(s);
}

/* F = 4/3 E sqrt(R) d^(3/2), d = closing; 2/5 F d is stored in each finger, and what the time step takes vanishes with
 * the step. */
static void test_hertz(void **state)
{
    (void)state;
    static const double MODULUS = 1e6, RADIUS = 0.02;
    static const char FINGER[] = "\"model\": \"hard\", \"stiffness\": {\"normal\": 1e4, \"hertz\": 1e6}, \"damping\": "
                                 "{\"normal\": 20, \"tangential\": 20}, \"friction\": 0.5, \"ramp\": 0.2, \"tip\": "
                                 "{\"type\": \"sphere\", \"radius\": 0.02}";
    double force = 4.0 / 3 * MODULUS * sqrt(RADIUS) * pow(CLOSING, 1.5), lost[2];
    for (int k = 0; k < 2; k++) {
        scene *s = pinched(0.1, "", FINGER, ", \"gravity\": [0, 0, 0]");
        s->step = k ? 1e-4 : 1e-3;
        world *w = world_of(s);
        world_run_until(w, 1);
        assert_close(w->fingers[0].state.normal_force, force, 1e-9 * force);
        assert_close(world_normal_displacement(w, &w->fingers[0]), CLOSING, 1e-12);
        assert_close(w->ledger.elastic, 2 * 0.4 * force * CLOSING, 1e-9 * force * CLOSING);
        lost[k] = fabs(w->ledger.integrator);
        world_free(w);
        scene_free(s);
    }
    assert_true(lost[1] < 0.11 * lost[0]);
    assert_true(lost[0] < 0.01 * force * CLOSING);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_object_gives_way_and_its_friction_counts),
        cmocka_unit_test(test_every_solver_is_told),
        cmocka_unit_test(test_soft_fingers_stay_soft),
        cmocka_unit_test(test_turning_is_slip),
        cmocka_unit_test(test_sliding_at_kinetic_friction_leaves_no_margin),
        cmocka_unit_test(test_hertz),
    };
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
