/* Compares every line of the energy ledger with a closed form, in scenes where it has one. */
#include "support/cmocka_all.h"

#include "support/scene_run.h"

#include <stdio.h>
#include <string.h>

/* A box of 0.5 kg between long pads above and below: one fixed, one pressing with `press` N. */
static scene *between_pads(const char *press, double friction, const char *schedule, double step, double duration)
{
    char text[4096];
    int used = snprintf(text, sizeof text,
                        "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0], \"object\": {\"shape\": {\"type\": "
                        "\"box\", \"size\": [0.04, 0.04, 0.04]}, \"mass\": 0.5}, \"fingers\": [");
    for (int side = 0; side < 2; side++)
        used += snprintf(text + used, sizeof text - (size_t)used,
                         "%s{\"point\": [0, 0, %g], \"normal\": [0, 0, %d], \"tip\": {\"type\": \"box\", \"size\": "
                         "[0.01, 2, 2]}, \"model\": \"hard\", \"stiffness\": {\"normal\": 20000, \"tangential\": "
                         "13300}, \"damping\": {\"normal\": 60, \"tangential\": 40}, \"friction\": %g, %s\"ramp\": "
                         "0.2}",
                         side ? ", " : "", side ? 0.02 : -0.02, side ? -1 : 1, friction, side ? press : "");
    snprintf(text + used, sizeof text - (size_t)used,
             "], \"schedule\": [%s], \"simulation\": {\"step\": %.17g, \"duration\": %.17g}}", schedule, step,
             duration);
    return scene_from_text(text);
}

static void assert_closes(const energy_ledger *l)
{
    assert_true(fabs(l->closure) <= fmax(1e-6 * l->work_size, 1e-9));
}

/* Sliding between pads: friction loses 2 mu N times the slip, the push works force times travel, and what moves has
 * m v^2 / 2; gravity and base acceleration work like the push. */
static void test_sliding(void **state)
{
    (void)state;
    static const struct {
        const char *schedule;
        scene_channel channel;
    } pushes[3] = {
        {"{\"time\": 0.5, \"force\": [0, 0, 0]}, {\"time\": 0.5, \"force\": [6, 0, 0]}", SCENE_FORCE},
        {"{\"time\": 0.5, \"gravity\": [0, 0, 0]}, {\"time\": 0.5, \"gravity\": [12, 0, 0]}", SCENE_GRAVITY},
        {"{\"time\": 0.5, \"base_acceleration\": [0, 0, 0]}, {\"time\": 0.5, \"base_acceleration\": [-12, 0, 0]}",
         SCENE_BASE_ACCELERATION},
    };
    for (int k = 0; k < 3; k++) {
        scene *s = between_pads("\"normal_force\": 5, ", 0.4, pushes[k].schedule, 1e-3, 1.1);
        world *w = world_of(s);
        world_run_until(w, 0.6); /* slides steadily */
        double x0 = dBodyGetPosition(w->object)[0];
        energy_ledger before = w->ledger;
        world_run_until(w, 1.1); /* 0.72 m on: still between the pads */
        const energy_ledger *l = &w->ledger;
        double travel = dBodyGetPosition(w->object)[0] - x0, speed = dBodyGetLinearVel(w->object)[0];
        double external = l->work_external - before.work_external, fell = before.gravity - l->gravity;
        assert_true(travel > 0.5 && dBodyGetPosition(w->object)[0] < 0.95);
        assert_close(l->friction - before.friction, 2 * 0.4 * 5 * travel, 1e-6 * 4 * travel);
        assert_close(pushes[k].channel == SCENE_GRAVITY ? fell : external, 6 * travel, 1e-9 * 6 * travel);
        assert_close(pushes[k].channel == SCENE_GRAVITY ? external : fell, 0, 1e-12);
        assert_close(l->kinetic, 0.5 * 0.5 * speed * speed, 1e-9);
        /* the sum rule of an implicit step: m a^2 h^2 / 2 in each */
        assert_close(l->integrator - before.integrator, 0.5 * 0.5 * 4 * 4 * 1e-3 / 2, 1e-6);
        assert_closes(l);
        world_free(w);
        scene_free(s);
    }
}

/* At rest under a slow push the contacts hold F^2 / (2 k) of it, sideways kt twice; closed along the normal as springs
 * in series. The drive has done what is stored, and half of the slow push's work force times travel is the spring's. */
static void test_springs(void **state)
{
    (void)state;
    scene *s = between_pads("\"closing\": 0.0005, ", 0.9,
                            "{\"time\": 0.5, \"force\": [0, 0, 0]}, {\"time\": 1.5, \"force\": [4, 0, 0]}", 1e-4, 2.5);
    world *w = world_of(s);
    world_run_until(w, 0.5);
    double stored = 0.5 * 10000 * 0.0005 * 0.0005; /* 2e4 and 2e4 N/m in series */
    assert_close(w->ledger.elastic, stored, 1e-6 * stored);
    /* the damper's and the step's parts go with the speed of closing: h k v/2 and c v, below a percent */
    assert_close(w->ledger.work_drives, stored + w->ledger.damping + w->ledger.integrator, 1e-9);
    assert_true(w->ledger.damping > 0 && w->ledger.damping < 0.05 * stored);
    world_run_until(w, 2.5);
    double sheared = 4.0 * 4.0 / (2 * 2 * 13300);
    assert_close(w->ledger.elastic - stored, sheared, 1e-5 * sheared);
    assert_close(w->ledger.work_external, sheared, 0.02 * sheared); /* a ramp of 1 s against vibrations of 3 ms */
    assert_close(w->ledger.friction, 0, 0);
    assert_close(w->ledger.kinetic, 0, 1e-15);
    assert_closes(&w->ledger);
    world_free(w);
    scene_free(s);
}

/* A slider pushes a box along against nothing but its own damper: at the speed force / damping its work is force times
 * travel, and the damper takes damping times speed^2. */
static void test_slider(void **state)
{
    (void)state;
    scene *s = scene_from_text(
        "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0], \"object\": {\"shape\": {\"type\": \"box\", \"size\": "
        "[0.04, 0.04, 0.04]}, \"mass\": 0.1}, \"fingers\": [{\"point\": [-0.02, 0, 0], \"normal\": [1, 0, 0], "
        "\"tip\": {\"type\": \"box\", \"size\": [0.01, 0.03, 0.03]}, \"model\": \"hard\", \"stiffness\": {\"normal\": "
        "20000}, \"damping\": {\"normal\": 20}, \"friction\": 0.5, \"drive\": {\"type\": \"slider\", \"mass\": 0.1, "
        "\"force\": 2, \"damping\": 10}}], \"simulation\": {\"duration\": 2}}");
    world *w = world_of(s);
    world_run_until(w, 1); /* 50 times the time constant of 20 ms */
    energy_ledger before = w->ledger;
    double x0 = dBodyGetPosition(w->fingers[0].body)[0];
    world_run_until(w, 2);
    double travel = dBodyGetPosition(w->fingers[0].body)[0] - x0, speed = dBodyGetLinearVel(w->fingers[0].body)[0];
    assert_close(speed, 2.0 / 10, 1e-9);
    assert_close(w->ledger.work_drives - before.work_drives, 2 * travel, 1e-9 * 2 * travel);
    assert_close(w->ledger.damping - before.damping, 10 * 0.2 * 0.2 * 1, 1e-8);
    assert_close(w->ledger.kinetic, 0.5 * 0.2 * speed * speed, 1e-9);
    assert_closes(&w->ledger);
    world_free(w);
    scene_free(s);
}

/* A ball without friction slips out from between two fingertips under force control. The one that it has left goes as
 * far as it may in a step, and the force that nothing bore there does no work. */
static void test_drive_at_limit(void **state)
{
    (void)state;
    scene *s = scene_from_text(
        "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"sphere\", \"radius\": 0.02}, \"mass\": "
        "0.5}, \"fingers\": [{\"point\": [-0.02, 0, 0], \"normal\": [1, 0, 0], \"tip\": {\"type\": \"sphere\", "
        "\"radius\": "
        "0.005}, \"model\": \"hard\", \"stiffness\": {\"normal\": 20000}, \"friction\": 0, \"normal_force\": 5}, "
        "{\"point\": [0.02, 0, 0], \"normal\": [-1, 0, 0], \"tip\": {\"type\": \"sphere\", \"radius\": 0.005}, "
        "\"model\": "
        "\"hard\", \"stiffness\": {\"normal\": 20000}, \"friction\": 0, \"normal_force\": 6}], \"simulation\": "
        "{\"duration\": 0.2}}");
    world *w = world_of(s);
    world_run_until(w, 0.2);
    assert_true(pinch_ode_statistics(w->plugin).drives_at_limit > 0);
    assert_true(w->ledger.work_size > 0.1);
    assert_closes(&w->ledger);
    world_free(w);
    scene_free(s);
}

/* Rails that turn leave errors of position in their sliders' joints, whose work is the time step's. */
static void test_turning_rails(void **state)
{
    (void)state;
    static const char text[] =
        "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0], \"object\": {\"shape\": {\"type\": \"box\", "
        "\"size\": [0.1, 0.1, 0.1]}, \"mass\": 0.3}, \"fingers\": ["
        "{\"name\": \"L\", \"point\": [-0.05, 0, 0], \"normal\": [1, 0, 0], %s}, "
        "{\"name\": \"R\", \"point\": [0.05, 0, 0], \"normal\": [-1, 0, 0], %s}], \"schedule\": [{\"time\": 0}, "
        "{\"time\": 0.4, \"hand\": {\"translation\": [0, 0, 0]}}, {\"time\": 0.9, \"hand\": {\"rotation\": "
        "[0, 1.5, 0]}}], \"simulation\": {\"step\": %g, \"duration\": 1}}";
    static const char tip[] = "\"model\": \"hard\", \"stiffness\": {\"normal\": 20000}, \"friction\": 0.6, "
                              "\"damping\": {\"normal\": 20, \"tangential\": 20}, \"drive\": {\"type\": "
                              "\"slider\", \"mass\": 0.1, \"force\": 10, \"damping\": 5}";
    static const double steps[] = {1e-3, 5e-3};
    for (int i = 0; i < 2; i++) {
        char whole[2000];
        (void)snprintf(whole, sizeof whole, text, tip, tip, steps[i]);
        scene *s = scene_from_text(whole);
        world *w = world_of(s);
        world_run_until(w, 1);
        assert_true(w->ledger.work_size > 1e-3);
        assert_true(fabs(w->ledger.closure) <= 1e-10 * w->ledger.work_size);
        world_free(w);
        scene_free(s);
    }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_sliding), cmocka_unit_test(test_springs),
                                       cmocka_unit_test(test_slider), cmocka_unit_test(test_turning_rails),
                                       cmocka_unit_test(test_drive_at_limit)};
    int failed = cmocka_run_group_tests_name("ledger", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
