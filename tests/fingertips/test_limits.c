/* Friction drops when it slips, fingers yield, and events report what was too much. */
#include "support/cmocka_all.h"

#include "support/scene_run.h"

#include <stdio.h>

/* A box of 0.5 kg between two long pads, above and below, that press with 5 N; it is pushed along x. */
static scene *sliding_scene(const char *friction, const char *schedule, double step, double duration)
{
    char text[4096];
    int used = snprintf(text, sizeof text,
                        "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0], \"object\": {\"shape\": {\"type\": "
                        "\"box\", \"size\": [0.04, 0.04, 0.04]}, \"mass\": 0.5}, \"fingers\": [");
    for (int side = 0; side < 2; side++)
        used += snprintf(text + used, sizeof text - (size_t)used,
                         "%s{\"point\": [0, 0, %g], \"normal\": [0, 0, %d], \"tip\": {\"type\": \"box\", \"size\": "
                         "[0.01, 2, 2]}, \"model\": \"hard\", \"stiffness\": {\"normal\": 20000, \"tangential\": "
                         "13300}, \"damping\": {\"normal\": 60, \"tangential\": 40}, \"friction\": %s, %s\"ramp\": "
                         "0.2}",
                         side ? ", " : "", side ? 0.02 : -0.02, side ? -1 : 1, friction,
                         side ? "\"normal_force\": 5, " : "");
    snprintf(text + used, sizeof text - (size_t)used,
             "], \"schedule\": [%s], \"simulation\": {\"step\": %.17g, \"duration\": %.17g}}", schedule, step,
             duration);
    return scene_from_text(text);
}

/*
 * 5 N on either side, static friction 0.6, kinetic 0.4: 6 N hold, 4 N brake. The push grows slowly and lets go at 6 N,
 * then stays at 5 N: (5 - 4) N on 0.5 kg. At 2 N it slows down by 4 m/s^2, stops, and holds again up to 5.9 N.
 */
static void test_static_and_kinetic(void **state)
{
    (void)state;
    static const double steps[] = {5e-4, 1e-3, 2e-3};
    for (int k = 0; k < 3; k++) {
        scene *s =
            sliding_scene("{\"static\": 0.6, \"kinetic\": 0.4}",
                          "{\"time\": 0.5, \"force\": [0, 0, 0]}, {\"time\": 2.5, \"force\": [6.2, 0, 0]}, "
                          "{\"time\": 2.5, \"force\": [5, 0, 0]}, {\"time\": 3, \"force\": [5, 0, 0]}, {\"time\": "
                          "3, \"force\": [2, 0, 0]}, {\"time\": 3.6, \"force\": [2, 0, 0]}, {\"time\": 4.6, "
                          "\"force\": [5.9, 0, 0]}",
                          steps[k], 5);
        world *w = world_of(s);
        double slipped_at = NAN, before = NAN;
        while (w->steps < lround(2.5 / steps[k])) {
            assert_int_equal(world_advance(w), WORLD_OK);
            if (isnan(slipped_at) && w->fingers[0].state.slip_total > 0) slipped_at = w->loads.v[SCENE_FORCE][0];
        }
        world_run_until(w, 2.7); /* jerk and shear have died away */
        before = dBodyGetLinearVel(w->object)[0];
        world_run_until(w, 2.9);
        double faster = (dBodyGetLinearVel(w->object)[0] - before) / 0.2;
        assert_int_equal(w->fingers[0].state.state, PINCH_CONTACT_SLIP);
        assert_close(dCalcVectorLength3(w->fingers[0].state.tangential_force), 0.4 * 5, 1e-9);
        world_run_until(w, 3.05);
        before = dBodyGetLinearVel(w->object)[0];
        world_run_until(w, 3.15);
        double slower = (dBodyGetLinearVel(w->object)[0] - before) / 0.1;
        print_message("step %g s: slips at %.4f N, gains %.5f m/s^2, loses %.5f m/s^2\n", steps[k], slipped_at, faster,
                      -slower);
        /* the ramp rises by 3.1 N/s; its shear lags by the dampers' time, 3 ms */
        assert_close(slipped_at, 6, 3.1 * (0.003 + steps[k]));
        assert_close(faster, (5 - 4) / 0.5, 1e-3 * 2);
        assert_close(slower, (2 - 4) / 0.5, 1e-3 * 4);
        world_run_until(w, 3.6);
        while (w->time < 4 && fabs(dBodyGetLinearVel(w->object)[0]) > 1e-6)
            assert_int_equal(world_advance(w), WORLD_OK);
        assert_true(w->time < 4);
        double slip = w->fingers[0].state.slip_total;
        world_run_until(w, 5);
        assert_close(w->fingers[0].state.slip_total, slip, 0); /* 5.9 N are more than kinetic friction, and it holds */
        assert_close(dCalcVectorLength3(w->fingers[0].state.tangential_force), 5.9 / 2, 1e-6);
        assert_int_equal(w->fingers[0].state.state, PINCH_CONTACT_STICK);
        world_free(w);
        scene_free(s);
    }
}

/* Two tips close by 1 mm with 2e4 N/m; the second yields at 8 N, far below the 10 N that springs would give. */
static scene *yielding_scene(const char *tip, const char *more)
{
    char text[4096];
    snprintf(text, sizeof text,
             "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, -1], \"object\": {\"shape\": {\"type\": \"box\", "
             "\"size\": [0.04, 0.04, 0.04]}, \"mass\": 0.1}, \"fingers\": ["
             "{\"name\": \"a\", \"point\": [-0.02, 0, 0], \"normal\": [1, 0, 0], \"tip\": %s, \"model\": \"hard\", "
             "\"stiffness\": {\"normal\": 20000}, \"damping\": {\"normal\": 40, \"tangential\": 20}, \"friction\": "
             "0.6, \"closing\": 0.001, \"ramp\": 0.5},"
             "{\"name\": \"b\", \"point\": [0.02, 0, 0], \"normal\": [-1, 0, 0], \"tip\": %s, \"model\": \"hard\", "
             "\"stiffness\": {\"normal\": 20000}, \"damping\": {\"normal\": 40, \"tangential\": 20}, \"friction\": "
             "0.6, \"closing\": 0.001, \"ramp\": 0.5, \"max_force\": 8}]%s, \"simulation\": {\"duration\": 3}}",
             tip, tip, more);
    return scene_from_text(text);
}

static void test_yields(void **state)
{
    (void)state;
    static const char *const tips[] = {"{\"type\": \"sphere\", \"radius\": 0.01}",
                                       "{\"type\": \"box\", \"size\": [0.01, 0.03, 0.03]}",
                                       "{\"type\": \"capsule\", \"radius\": 0.005, \"length\": 0.02}"};
    for (int k = 0; k < 3; k++) {
        scene *s = yielding_scene(tips[k], "");
        world *w = world_of(s);
        double most = 0, damping = 0;
        while (w->time < 3) {
            assert_int_equal(world_advance(w), WORLD_OK);
            most = fmax(most, w->fingers[1].state.normal_force);
            assert_true(w->ledger.damping >= damping - 1e-12 * w->ledger.work_size);
            assert_true(fabs(w->ledger.closure) <= fmax(1e-9, 1e-6 * w->ledger.work_size));
            damping = w->ledger.damping;
        }
        print_message("yields: at most %.12f N, %.6f N in the end, the other %.6f N\n", most,
                      w->fingers[1].state.normal_force, w->fingers[0].state.normal_force);
        assert_true(most <= 8 + 1e-9);
        assert_close(w->fingers[1].state.normal_force, 8, 1e-9);
        assert_int_equal(w->fingers[1].state.state, PINCH_CONTACT_YIELD);
        assert_close(w->fingers[0].state.normal_force, 8, 1e-6);
        assert_true(w->fingers[0].state.state == PINCH_CONTACT_STICK);
        assert_int_equal(pinch_ode_statistics(w->plugin).unconverged_steps, 0);
        world_free(w);
        scene_free(s);
    }
}

/*
 * Crush: at the first step whose force is over the limit, with that force. Slip and dropped: a grip of 8 N and friction
 * 0.6 under a push that passes 9.6 N loses the box.
 */
static void test_events(void **state)
{
    (void)state;
    scene *s = yielding_scene("{\"type\": \"box\", \"size\": [0.01, 0.03, 0.03]}",
                              ", \"schedule\": [{\"time\": 1, \"force\": [0, 0, 0]}, {\"time\": 2, \"force\": [0, 12, "
                              "0]}]");
    s->fingers[0].damage_max_force = 5;
    s->fingers[1].damage_max_slip = 0.001;
    world *w = world_of(s);
    simulation *run = simulation_start(w);
    double crushed = NAN, crush = NAN, slipped = NAN, slip = NAN, touched = NAN;
    while (w->steps < simulation_steps(run)) {
        assert_int_equal(simulation_step(run), WORLD_OK);
        const world_finger_state *a = &w->fingers[0].state, *b = &w->fingers[1].state;
        if (isnan(crushed) && a->normal_force > 5) crushed = w->time, crush = a->normal_force;
        if (isnan(slipped) && b->slip_total > 0.001) slipped = w->time, slip = b->slip_total;
        if (a->points > 0 || b->points > 0) touched = w->time;
    }
    simulation_result r;
    simulation_finish(run, &r);
    assert_int_equal(r.event_count, 3);
    const struct {
        simulation_event_type type;
        const char *name;
        int finger;
        double time, value, limit, slack;
    } expected[3] = {{EVENT_CRUSH, "crush", 0, crushed, crush, 5, 0},
                     {EVENT_SLIP, "slip", 1, slipped, slip, 0.001, 0},
                     {EVENT_DROPPED, "dropped", -1, touched + 0.05, 0, 0, 0.0021}}; /* gone for 50 ms */
    for (int i = 0; i < 3; i++) {
        assert_int_equal(r.events[i].type, expected[i].type);
        assert_string_equal(simulation_event_name(r.events[i].type), expected[i].name);
        assert_int_equal(r.events[i].finger, expected[i].finger);
        assert_close(r.events[i].time, expected[i].time, expected[i].slack);
        if (i < 2) assert_close(r.events[i].value, expected[i].value, 0);
        assert_close(r.events[i].limit, expected[i].limit, 0);
    }
    assert_true(r.events[2].value > 0 && isfinite(r.events[2].value));
    print_message("crush at %.3f s, %.4f N; slip at %.3f s, %.3g m; dropped at %.3f s, %.3g m away\n", r.events[0].time,
                  r.events[0].value, r.events[1].time, r.events[1].value, r.events[2].time, r.events[2].value);
    simulation_free(&r);
    world_free(w);
    scene_free(s);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_static_and_kinetic), cmocka_unit_test(test_yields),
                                       cmocka_unit_test(test_events)};
    int failed = cmocka_run_group_tests_name("limits", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
