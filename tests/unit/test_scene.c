/* Checks what the loader makes of a scene file: defaults, frames and tips; and the scene over time. */

#include "support/cmocka_all.h"
#include "support/program.h"

#include "common/vector.h"
#include "scenes/scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* `finger` and `rest` are JSON; %s in the template's order */
static scene *load(const char *object, const char *fingers, const char *rest)
{
    char text[8192];
    snprintf(text, sizeof text, "{\"format\": \"pinch-scene/1\", \"object\": %s, \"fingers\": [%s]%s}", object, fingers,
             rest);
    char *folder = program_make_folder();
    char *path = program_write_file(folder, "probe.json", text);
    scene *s;
    scene_error error;
    scene_status status = scene_load(path, &s, &error);
    if (status != SCENE_OK) print_error("%s\n", error.text);
    assert_int_equal(status, SCENE_OK);
    program_remove_folder(folder);
    free(path);
    return s;
}

#define CUBE    "{\"shape\": {\"type\": \"box\", \"size\": [2, 2, 2]}, \"mass\": 3}"
#define CONTACT "\"model\": \"hard\", \"stiffness\": {\"normal\": 300}, \"friction\": 0.5"
#define FINGER  "{\"point\": [-1, 0, 0], \"normal\": [1, 0, 0], " CONTACT "}"

static void assert_vector(const double *v, double x, double y, double z, double tolerance)
{
    assert_close(v[0], x, tolerance);
    assert_close(v[1], y, tolerance);
    assert_close(v[2], z, tolerance);
}

static void test_defaults(void **state)
{
    (void)state;
    scene *s = load(CUBE, FINGER, "");
    assert_string_equal(s->name, "probe");
    assert_string_equal(s->source, "");
    assert_int_equal(s->dimension, 3);
    assert_vector(s->gravity, 0, 0, -9.81, 0);
    assert_vector(s->objects[0].position, 0, 0, 0, 0);
    assert_true(s->objects[0].orientation[0] == 1.0);
    assert_close(s->objects[0].inertia[0], 2.0, 1e-14);
    const scene_finger *f = &s->fingers[0];
    assert_string_equal(f->name, "F1");
    assert_int_equal(f->tip.type, SCENE_SPHERE);
    assert_close(f->tip.u.sphere.radius, 0.1 * sqrt(3), 1e-15);
    assert_close(f->stiffness.tangential, 200, 1e-12);
    assert_true(f->damping.normal == 0.0 && f->damping.tangential == 0.0 && f->closing == 0.0 && f->ramp == 0.0);
    assert_true(isinf(f->max_force) && isinf(f->damage_max_force) && isinf(f->damage_max_slip));
    assert_true(f->friction.kinetic == 0.5);
    assert_int_equal(f->drive.type, SCENE_DRIVE_FIXED);
    assert_int_equal(s->entry_count, 1);
    assert_vector(s->schedule[0].channels[SCENE_GRAVITY].value, 0, 0, -9.81, 0);
    assert_true(s->step == 0.001 && s->duration == 2.0);
    assert_int_equal(s->solver.name, PINCH_SOLVER_NSNMGK);
    assert_int_equal(s->solver.formulation, SCENE_COULOMB);
    assert_true(s->solver.tolerance == 1e-10 && s->solver.max_iterations == 20000 && s->solver.pyramid_faces == 8);
    scene_free(s);
}

static void test_plane(void **state)
{
    (void)state;
    scene *s = load(CUBE,
                    "{\"point\": [1, 0.5, 0], \"normal\": [-1, 0, 0], \"tangent\": [0, 0, 0], \"model\": \"soft\", "
                    "\"stiffness\": {\"normal\": 300}, \"friction\": 0.5}",
                    ", \"dimension\": 2");
    assert_vector(s->gravity, 0, -9.81, 0, 0);
    assert_int_equal(s->fingers[0].model, SCENE_HARD);
    assert_vector(s->fingers[0].t1, 0, -1, 0, 0);
    assert_vector(s->fingers[0].t2, 0, 0, 1, 0);
    scene_free(s);
}

static void test_frames(void **state)
{
    (void)state;
    /* least aligned axis, ties x, y, z; a tangent made perpendicular; a half turn about z for -x */
    scene *s = load(CUBE,
                    FINGER ", {\"point\": [1, 0, 0], \"normal\": [-7, 0, 0], \"tangent\": [3, 0, 2], " CONTACT "}, "
                           "{\"point\": [0, 0, 1], \"normal\": [0, -1, -1], \"tip\": {\"type\": \"box\", "
                           "\"size\": [0.2, 1, 1]}, " CONTACT "}",
                    "");
    assert_vector(s->fingers[0].t1, 0, 1, 0, 0);
    assert_vector(s->fingers[0].t2, 0, 0, 1, 0);
    assert_vector(s->fingers[1].normal, -1, 0, 0, 0);
    assert_vector(s->fingers[1].t1, 0, 0, 1, 1e-15);
    const double *q = s->fingers[1].tip_orientation;
    assert_true(q[0] == 0.0 && q[1] == 0.0 && q[2] == 0.0 && q[3] == 1.0);
    assert_vector(s->fingers[2].t1, 1, 0, 0, 1e-15);
    double x[3];
    scene_rotate(s->fingers[2].tip_orientation, (double[3]){1, 0, 0}, x);
    assert_vector(x, 0, -sqrt(0.5), -sqrt(0.5), 1e-15);
    assert_vector(s->fingers[2].tip_position, 0, 0.1 * sqrt(0.5), 1 + 0.1 * sqrt(0.5), 1e-15);
    scene_free(s);
}

/* normals close to -x: the tip's x axis must still be the normal, to rounding */
static void test_tip_axis_near_minus_x(void **state)
{
    (void)state;
    for (double small = 1e-3; small > 1e-13; small *= 0.1) {
        char finger[512];
        snprintf(finger, sizeof finger, "{\"point\": [1, 0, 0], \"normal\": [-1, %.3g, %.3g], " CONTACT "}", small,
                 -2 * small);
        scene *s = load(CUBE, finger, "");
        const scene_finger *f = &s->fingers[0];
        double x[3];
        scene_rotate(f->tip_orientation, (double[3]){1, 0, 0}, x);
        assert_vector(x, f->normal[0], f->normal[1], f->normal[2], 1e-12);
        scene_free(s);
    }
}

static void test_tip_positions(void **state)
{
    (void)state;
    /* a box tip lying on its long side; one standing on an edge; a capsule */
    scene *s = load(CUBE,
                    "{\"point\": [-1, 0, 0], \"normal\": [1, 0, 0], \"tip\": {\"type\": \"box\", \"size\": "
                    "[0.2, 0.6, 0.4], \"orientation\": [1, 0, 0, 1]}, " CONTACT "}, "
                    "{\"point\": [1, 0, 0], \"normal\": [-1, 0, 0], \"tip\": {\"type\": \"box\", \"size\": "
                    "[0.2, 0.2, 0.4], \"orientation\": [0.9238795325112867, 0, 0, 0.3826834323650898]}, " CONTACT "}, "
                    "{\"point\": [0, 1, 0], \"normal\": [0, -1, 0], \"tip\": {\"type\": \"capsule\", \"radius\": 0.1, "
                    "\"length\": 0.5}, " CONTACT "}",
                    "");
    assert_vector(s->fingers[0].tip_position, -1.3, 0, 0, 1e-15);
    assert_vector(s->fingers[1].tip_position, 1 + 0.1 * sqrt(2), 0, 0, 1e-9);
    assert_vector(s->fingers[2].tip_position, 0, 1.1, 0, 1e-15);
    scene_free(s);
}

static void test_turned_object(void **state)
{
    (void)state;
    /* capsule along y: the surface is where the turned shape has it */
    scene *s = load("{\"shape\": {\"type\": \"capsule\", \"radius\": 1, \"length\": 4}, \"mass\": 1, \"position\": "
                    "[5, 0, 0], \"orientation\": [1, -1, 0, 0]}",
                    "{\"point\": [4, 1.5, 0], \"normal\": [1, 0, 0], " CONTACT "}, "
                    "{\"point\": [5, -3, 0], \"normal\": [0, 1, 0], " CONTACT "}",
                    "");
    assert_int_equal(s->finger_count, 2);
    scene_free(s);
}

static void test_control(void **state)
{
    (void)state;
    scene *s = load(CUBE,
                    "{\"point\": [-1, 0, 0], \"normal\": [1, 0, 0], \"normal_force\": 7, " CONTACT "}, "
                    "{\"point\": [1, 0, 0], \"normal\": [-1, 0, 0], \"drive\": {\"type\": \"slider\", \"mass\": 0.1, "
                    "\"force\": 12}, " CONTACT "}, "
                    "{\"point\": [0, 1, 0], \"normal\": [0, -1, 0], \"closing\": -0.1, " CONTACT "}",
                    "");
    double force;
    assert_true(scene_finger_force(&s->fingers[0], &force) && force == 7.0);
    assert_true(scene_finger_force(&s->fingers[1], &force) && force == 12.0);
    assert_false(s->fingers[1].drive.u.slider.gravity);
    assert_true(!scene_finger_force(&s->fingers[2], &force) && force == 0.0);
    scene_free(s);
}

static void test_ramp(void **state)
{
    (void)state;
    assert_true(scene_ramp(-1, 2) == 0.0 && scene_ramp(0, 2) == 0.0 && scene_ramp(2, 2) == 1.0);
    assert_true(scene_ramp(9, 2) == 1.0 && scene_ramp(0, 0) == 1.0 && scene_ramp(-1e-9, 0) == 0.0);
    assert_close(scene_ramp(1, 2), 0.5, 1e-16);
    assert_close(scene_ramp(0.5, 2), 0.15625, 1e-16);
}

static void assert_load(const scene *s, double t, scene_channel channel, double x, double y, double z)
{
    scene_loads loads;
    scene_schedule_at(s, t, &loads);
    assert_vector(loads.v[channel], x, y, z, 1e-12);
}

static void test_schedule_linear(void **state)
{
    (void)state;
    scene *s = load(CUBE, FINGER,
                    ", \"gravity\": [0, 0, -5], \"schedule\": [{\"time\": 1, \"force\": [2, 0, 0]}, "
                    "{\"time\": 2, \"torque\": [0, 0, 4]}, {\"time\": 3, \"force\": [4, 0, 0]}, "
                    "{\"time\": 3, \"force\": [0, 8, 0]}, {\"time\": 4, \"gravity\": [0, 0, 0]}]");
    scene_loads first;
    scene_first_loads(s, &first);
    assert_vector(first.v[SCENE_FORCE], 2, 0, 0, 0);
    assert_load(s, 0, SCENE_FORCE, 2, 0, 0);   /* held before the first */
    assert_load(s, 1.5, SCENE_FORCE, 2, 0, 0); /* left out: keeps */
    assert_load(s, 1.5, SCENE_TORQUE, 0, 0, 2);
    assert_load(s, 2.5, SCENE_FORCE, 3, 0, 0);
    assert_load(s, 3, SCENE_FORCE, 0, 8, 0); /* equal times jump */
    assert_load(s, 3.5, SCENE_FORCE, 0, 8, 0);
    assert_load(s, 3.5, SCENE_GRAVITY, 0, 0, -2.5);
    assert_load(s, 99, SCENE_GRAVITY, 0, 0, 0);
    assert_load(s, 99, SCENE_TORQUE, 0, 0, 4);
    scene_free(s);
}

static void test_schedule_signals(void **state)
{
    (void)state;
    scene *s =
        load(CUBE, FINGER,
             ", \"schedule\": [{\"time\": 0, \"force\": [0, 0, 2], \"gravity\": [0, 0, -10]}, "
             "{\"time\": 1, \"gravity\": {\"turn\": [0, 0, -10], \"axis\": [0, 3, 0], \"frequency\": 0.25}, "
             "\"force\": {\"amplitude\": [8, 0, 0], \"frequency\": 1, \"phase\": 1.5707963267948966, \"fade\": 2}}, "
             "{\"time\": 2, \"torque\": [1, 0, 0]}, "
             "{\"time\": 4, \"gravity\": [0, 0, -10], \"force\": [1, 0, 0]}]");
    assert_load(s, 0.5, SCENE_GRAVITY, 0, 0, -10);
    assert_load(s, 0.5, SCENE_FORCE, 0, 0, 1); /* to the sine's start: faded in from zero */
    assert_load(s, 2, SCENE_GRAVITY, -10, 0, 0);
    assert_load(s, 3, SCENE_GRAVITY, 0, 0, 10); /* goes on through an entry that leaves it out */
    assert_load(s, 2, SCENE_FORCE, 4, 0, 0);
    assert_load(s, 3.5, SCENE_FORCE, -8, 0, 0);
    assert_load(s, 3.75, SCENE_GRAVITY, -10 * sin(0.6875 * 2 * SCENE_PI), 0, -10 * cos(0.6875 * 2 * SCENE_PI));
    assert_load(s, 4, SCENE_GRAVITY, 0, 0, -10);
    assert_load(s, 4, SCENE_FORCE, 1, 0, 0);
    scene_free(s);
}

static void test_base_pose(void **state)
{
    (void)state;
    scene *s =
        load(CUBE,
             "{\"point\": [-1, 0, 0], \"normal\": [1, 0, 0], \"tip\": {\"type\": \"sphere\", \"radius\": 0.5}, "
             "\"closing\": 0.25, \"ramp\": 1, \"drive\": {\"type\": \"path\", \"points\": [{\"time\": 1}, "
             "{\"time\": 3, \"translation\": [0, 2, 0], \"rotation\": [0, 0, 3.141592653589793]}]}, " CONTACT "}",
             ", \"schedule\": [{\"time\": 3}, {\"time\": 4, \"hand\": {\"translation\": [0, 0, 1], \"rotation\": "
             "[0, 0, 1.5707963267948966]}}]");
    double p[3], q[4], x[3];
    const scene_finger *f = &s->fingers[0];
    scene_base_pose(s, f, 0, p, q);
    assert_vector(p, -1.5, 0, 0, 1e-15);
    scene_base_pose(s, f, 0.5, p, q);
    assert_vector(p, -1.375, 0, 0, 1e-15);
    scene_base_pose(s, f, 2, p, q);
    assert_vector(p, -1.25, 1, 0, 1e-15);
    scene_rotate(q, (double[3]){1, 0, 0}, x);
    assert_vector(x, 0, 1, 0, 1e-15);
    scene_base_pose(s, f, 4, p, q); /* the hand: a quarter turn about the origin, then up */
    assert_vector(p, -2, -1.25, 1, 1e-15);
    scene_rotate(q, (double[3]){1, 0, 0}, x);
    assert_vector(x, 0, -1, 0, 1e-15);
    scene_free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_defaults),        cmocka_unit_test(test_plane),
        cmocka_unit_test(test_frames),          cmocka_unit_test(test_tip_axis_near_minus_x),
        cmocka_unit_test(test_tip_positions),   cmocka_unit_test(test_turned_object),
        cmocka_unit_test(test_control),         cmocka_unit_test(test_ramp),
        cmocka_unit_test(test_schedule_linear), cmocka_unit_test(test_schedule_signals),
        cmocka_unit_test(test_base_pose),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
