/*
 * Every shipped scene must be solved and verified in every step and end as assets/reference/fields.json says. Those
 * that hold an object must end at rest.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/program.h"
#include "support/scene_run.h"

#include <jansson.h>
#include <stdio.h>
#include <string.h>

/* scenes that end at rest in the fingers: the forces balance there */
static const char *const at_rest[] = {
    "pinched-capsule.json", "pinched-capsule-60n.json", "example-1.json", "example-1b.json", "example-2.json",
    "example-3.json",       "example-4.json",           "egg.json",       "mug.json",        "screwdriver.json",
};
enum { AT_REST = sizeof at_rest / sizeof at_rest[0] };

static bool rests(const char *name)
{
    for (int i = 0; i < AT_REST; i++)
        if (strcmp(at_rest[i], name) == 0) return true;
    return false;
}

static void compare(const char *name, const char *what, const double *got, const json_t *golden, int *wrong)
{
    for (size_t i = 0; i < json_array_size(golden); i++) {
        double wanted = json_number_value(json_array_get(golden, i));
        if (fabs(got[i] - wanted) <= 1e-9) continue; /* m, 1, N: the project's bound across machines */
        (*wrong)++;
        print_error("%s: %s[%zu] is %.17g, golden %.17g\n", name, what, i, got[i], wanted);
    }
}

/* Pose of the object and forces of the fingers at the end; tests/reference/write_golden.c makes the file. */
static void compare_golden(const world *w, const char *name, const json_t *golden, int *wrong)
{
    const json_t *fields = json_object_get(json_object_get(golden, "scenes"), name);
    if (!fields) {
        (*wrong)++;
        print_error("%s: no golden fields\n", name);
        return;
    }
    compare(name, "position", dBodyGetPosition(w->object), json_object_get(fields, "position"), wrong);
    compare(name, "orientation", dBodyGetQuaternion(w->object), json_object_get(fields, "orientation"), wrong);
    const json_t *forces = json_object_get(fields, "forces");
    assert_int_equal(json_array_size(forces), w->finger_count);
    for (int i = 0; i < w->finger_count; i++)
        compare(name, w->fingers[i].finger->name, w->fingers[i].state.force, json_array_get(forces, (size_t)i), wrong);
}

static void test_every_scene(void **state)
{
    (void)state;
    int wrong = 0;
    json_error_t error;
    json_t *golden = json_load_file(PINCH_SOURCE_DIR "/assets/reference/fields.json", 0, &error);
    assert_non_null(golden);
    for (const char *const *path = shipped_scenes(); *path; path++) {
        const char *name = file_name(*path);
        scene *s = scene_shipped(name);
        world *w = world_of(s);
        world_run_until(w, s->duration);
        pinch_ode_stats stats = pinch_ode_statistics(w->plugin);
        if (stats.unconverged_steps || !(stats.residual_max <= 1e-10)) {
            wrong++;
            print_error("%s: %ld unconverged steps, residual %g\n", name, stats.unconverged_steps, stats.residual_max);
        }
        if (rests(name)) {
            balance_at_rest left = world_balance(w);
            double speed = dCalcVectorLength3(dBodyGetLinearVel(w->object)),
                   spin = dCalcVectorLength3(dBodyGetAngularVel(w->object));
            if (!(left.force <= 1e-9) || !(left.moment <= 1e-9) || !(left.cone <= 1e-9) || !(speed <= 1e-9) ||
                !(spin <= 1e-9)) {
                wrong++;
                print_error("%s: forces off by %g N, moments by %g N m, cone by %g N; %g m/s, %g rad/s\n", name,
                            left.force, left.moment, left.cone, speed, spin);
            }
        }
        compare_golden(w, name, golden, &wrong);
        world_free(w);
        scene_free(s);
    }
    json_decref(golden);
    assert_int_equal(wrong, 0);
}

/* The prism's leg fingers slip along the hypotenuse's direction: 4 sqrt 2 N and sqrt 2 N, to 1e-3. */
static void test_example_2_forces(void **state)
{
    (void)state;
    scene *s = scene_shipped("example-2.json");
    world *w = world_of(s);
    world_run_until(w, s->duration);
    assert_close(w->fingers[0].state.normal_force, 10, 1e-9);
    for (int i = 1; i < 3; i++) {
        const world_finger_state *f = &w->fingers[i].state;
        assert_close(f->normal_force, 4 * sqrt(2), 1e-3);
        assert_close(dCalcVectorLength3(f->tangential_force), sqrt(2), 1e-3);
    }
    world_free(w);
    scene_free(s);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_scene),
        cmocka_unit_test(test_example_2_forces),
    };
    int failed = cmocka_run_group_tests_name("shipped scenes", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
