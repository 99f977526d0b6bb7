/* Random grasps by the shipped hands: whatever the object and however it lies in the hand, every step is solved. */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/scene_run.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

static void put(json_t *object, const char *key, json_t *value)
{
    assert_int_equal(json_object_set_new(object, key, value), 0);
}

static json_t *draw_shape(pinch_random *random)
{
    double a[3];
    for (int i = 0; i < 3; i++) a[i] = draw_uniform(random, 0.02, 0.055);
    switch (draw_index(random, 4)) {
    case 0:
        return json_pack("{s:s, s:[f,f,f]}", "type", "box", "size", a[0], a[1], a[2]);
    case 1:
        return json_pack("{s:s, s:f}", "type", "sphere", "radius", a[0] / 2);
    case 2:
        return json_pack("{s:s, s:f, s:f}", "type", "cylinder", "radius", a[0] / 2, "length", a[1]);
    default:
        return json_pack("{s:s, s:f, s:f}", "type", "capsule", "radius", a[0] / 2.5, "length", a[1] / 2);
    }
}

/* The hand closes as in its scene with a cube, on another object; weight sets in, and the hand is shaken. */
static void draw_grasp(pinch_random *random, const char *hand, json_t *document)
{
    json_t *object = json_object_get(document, "object"), *position = json_object_get(object, "position"), *contact;
    json_t *of = json_object_get(document, "hand");
    const char *key, *file = strrchr(json_string_value(json_object_get(of, "file")), '/') + 1;
    double q[4], length = 0, weight = draw_uniform(random, 0.25, 0.35), by[3];
    put(of, "file", json_sprintf("%s/assets/hands/%s", PINCH_SOURCE_DIR, file));
    for (int i = 0; i < 4; i++) {
        q[i] = draw_uniform(random, -1, 1);
        length += q[i] * q[i];
    }
    for (int i = 0; i < 4; i++) q[i] /= sqrt(length);
    for (size_t i = 0; i < 3; i++) {
        double x = json_number_value(json_array_get(position, i));
        assert_int_equal(json_array_set_new(position, i, json_real(x + draw_uniform(random, -0.006, 0.006))), 0);
        by[i] = draw_uniform(random, 0, 0.01);
    }
    put(object, "shape", draw_shape(random));
    put(object, "mass", json_real(draw_log_uniform(random, 0.02, 0.3)));
    put(object, "orientation", json_pack("[f,f,f,f]", q[0], q[1], q[2], q[3]));
    json_object_foreach(json_object_get(of, "contacts"), key, contact)
        put(contact, "friction", json_real(draw_uniform(random, 0.2, 1.2)));
    put(document, "name", json_string(hand));
    put(document, "simulation", json_pack("{s:f}", "duration", 0.6));
    put(document, "schedule",
        json_pack("[{s:f, s:[i,i,i]}, {s:f, s:[i,i,i]}, {s:f, s:[i,i,f], s:{s:{s:[f,f,f], s:f, s:f}}}]", "time", 0.0,
                  "gravity", 0, 0, 0, "time", weight, "gravity", 0, 0, 0, "time", weight + 0.1, "gravity", 0, 0, -9.81,
                  "hand", "translation", "amplitude", by[0], by[1], by[2], "frequency", draw_uniform(random, 1, 5),
                  "fade", 0.1));
}

static void test_every_step_of_random_grasps(void **state)
{
    (void)state;
    static const char *const hands[] = {"three-finger", "allegro-like", "parallel-gripper", "robotiq-like",
                                        "shadow-like"};
    enum { HANDS = sizeof hands / sizeof *hands };
    long unsolved = 0, left = 0, touching = 0;
    for (int k = 0; k < HANDS * draw_count(1000); k++) {
        char path[512];
        json_error_t error;
        pinch_random random;
        simulation_result r;
        pinch_random_seed(&random, 7000 + (uint64_t)k);
        snprintf(path, sizeof path, "%s/assets/scenes/hands/%s-precision-cube.json", PINCH_SOURCE_DIR,
                 hands[k % HANDS]);
        json_t *document = json_load_file(path, 0, &error);
        assert_non_null(document);
        draw_grasp(&random, hands[k % HANDS], document);
        char *text = json_dumps(document, JSON_REAL_PRECISION(17));
        scene *s = scene_from_text(text);
        world *w = world_of(s);
        simulation *run = simulation_start(w);
        for (long i = 0; i < simulation_steps(run); i++) assert_int_equal(simulation_step(run), WORLD_OK);
        simulation_finish(run, &r);
        pinch_ode_stats stats = pinch_ode_statistics(w->plugin);
        unsolved += stats.unconverged_steps + stats.too_soft_islands;
        left += stats.fallback_islands + stats.contacts_left_unsolved + stats.joints_left;
        touching += w->contact_count > 0;
        if (stats.unconverged_steps) print_error("%s, draw %d\n", hands[k % HANDS], k);
        simulation_free(&r);
        world_free(w);
        scene_free(s);
        free(text);
        json_decref(document);
    }
    print_message("%ld grasps touch at the end\n", touching);
    assert_int_equal(unsolved, 0);
    assert_int_equal(left, 0);
    assert_true(touching > draw_count(1000));
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_step_of_random_grasps),
    };
    int failed = cmocka_run_group_tests_name("random grasps by hands", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
