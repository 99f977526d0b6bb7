/*
 * ODE's own colliders spoil the contacts of these scenes: round tips on round objects, flat tips on polyhedra, and
 * meshes.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/program.h"
#include "support/scene_run.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double CLOSING = 0.0005, STIFFNESS = 20000;

/* Two fingers close on the object along x, no gravity. */
static scene *pinched(const char *shape, const char *orientation, double reach, const char *tip, const char *more)
{
    char text[4096];
    int used = snprintf(text, sizeof text,
                        "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0], \"object\": {\"shape\": %s, \"mass\": "
                        "0.1, \"orientation\": %s}, \"fingers\": [",
                        shape, orientation);
    for (int side = 0; side < 2; side++)
        used += snprintf(text + used, sizeof text - (size_t)used,
                         "%s{\"point\": [%.17g, 0, 0], \"normal\": [%d, 0, 0], \"tip\": %s, \"model\": \"soft\", "
                         "\"stiffness\": {\"normal\": %g, \"torsional\": 0.5}, \"damping\": {\"normal\": 20, "
                         "\"tangential\": 20, \"torsional\": 0.01}, \"torsional_friction\": 0.003, "
                         "\"friction\": 0.8, \"closing\": %g, \"ramp\": 0.2}",
                         side ? ", " : "", side ? reach : -reach, side ? -1 : 1, tip, STIFFNESS, CLOSING);
    snprintf(text + used, sizeof text - (size_t)used, "]%s, \"simulation\": {\"step\": 0.001, \"duration\": 4}}", more);
    return scene_from_text(text);
}

static const char UPRIGHT[] = "[1, 0, 0, 0]";
static const char WEIGHT[] = ", \"schedule\": [{\"time\": 0.5, \"force\": [0, 0, 0]}, {\"time\": 1, \"force\": [0, "
                             "0.4, -0.9]}]";

/* Settles: forces balance, nothing moves; without a load every tip carries stiffness times closing. */
static void settles(const char *shape, const char *orientation, double reach, const char *tip)
{
    for (int loaded = 0; loaded < 2; loaded++) {
        scene *s = pinched(shape, orientation, reach, tip, loaded ? WEIGHT : "");
        world *w = world_of(s);
        world_run_until(w, 4);
        balance_at_rest left = world_balance(w);
        print_message("%.40s.. with %.40s..: %.1e N, %.1e N m left over, %.17g N\n", shape + 10, tip + 10, left.force,
                      left.moment, w->fingers[0].state.normal_force);
        assert_close(left.force, 0, 1e-9);
        assert_close(left.moment, 0, 1e-9);
        assert_close(dCalcVectorLength3(dBodyGetLinearVel(w->object)), 0, 1e-9);
        for (int i = 0; i < 2 && !loaded; i++)
            assert_close(w->fingers[i].state.normal_force, STIFFNESS * CLOSING, 1e-6);
        world_free(w);
        scene_free(s);
    }
}

static void test_round_tips_on_round_objects(void **state)
{
    (void)state;
    static const char object[] = "{\"type\": \"cylinder\", \"radius\": 0.015, \"length\": 0.08}";
    settles(object, UPRIGHT, 0.015, "{\"type\": \"capsule\", \"radius\": 0.008, \"length\": 0.03}");
    settles(object, UPRIGHT, 0.015, "{\"type\": \"cylinder\", \"radius\": 0.008, \"length\": 0.03}");
    settles(object, UPRIGHT, 0.015,
            "{\"type\": \"capsule\", \"radius\": 0.008, \"length\": 0.03, \"orientation\": [0.7071067811865476, "
            "0.7071067811865476, 0, 0]}");
    settles(object, UPRIGHT, 0.015,
            "{\"type\": \"cylinder\", \"radius\": 0.008, \"length\": 0.03, \"orientation\": [0.7071067811865476, "
            "0.7071067811865476, 0, 0]}");
    settles("{\"type\": \"ellipsoid\", \"radii\": [0.02, 0.025, 0.03]}", UPRIGHT, 0.02,
            "{\"type\": \"cylinder\", \"radius\": 0.008, \"length\": 0.03, \"rounding\": 0.002}");
}

/* A cylinder's flat end on polyhedra: it sinks in by the closing, no more. */
static void test_flat_tips_on_polyhedra(void **state)
{
    (void)state;
    static const char flat[] = "{\"type\": \"cylinder\", \"radius\": 0.006, \"length\": 0.02, \"orientation\": "
                               "[0.7071067811865476, 0, 0.7071067811865476, 0]}";
    settles("{\"type\": \"prism\", \"vertices\": [[-0.02, -0.02], [0.02, -0.02], [0.02, 0.02], [-0.02, 0.02]], "
            "\"height\": 0.05}",
            UPRIGHT, 0.02, flat);
    settles("{\"type\": \"convex\", \"vertices\": [[-0.02, -0.03, -0.03], [-0.02, 0.03, -0.03], [-0.02, 0.03, 0.03], "
            "[-0.02, -0.03, 0.03], [0.02, -0.03, -0.03], [0.02, 0.03, -0.03], [0.02, 0.03, 0.03], [0.02, -0.03, "
            "0.03]]}",
            UPRIGHT, 0.02, flat);
    settles("{\"type\": \"prism\", \"vertices\": [[-0.02, -0.02], [0.02, -0.02], [0.02, 0.02], [-0.02, 0.02]], "
            "\"height\": 0.05}",
            UPRIGHT, 0.02, "{\"type\": \"box\", \"size\": [0.01, 0.02, 0.02]}");
}

/* Shapes that only fingertip geometry has, as objects and as tips. */
static void test_tips_of_real_shape(void **state)
{
    (void)state;
    static const char box[] = "{\"type\": \"box\", \"size\": [0.04, 0.05, 0.06], \"rounding\": 0.008}";
    static const char drum[] = "{\"type\": \"cylinder\", \"radius\": 0.015, \"length\": 0.08, \"rounding\": 0.004}";
    static const char super[] =
        "{\"type\": \"superellipsoid\", \"radii\": [0.02, 0.025, 0.03], \"exponents\": [0.7, 0.8]}";
    /* its z axis along -x: one finger's tip is flat, the other's round */
    settles(box, UPRIGHT, 0.02,
            "{\"type\": \"flat_capsule\", \"radius\": 0.008, \"length\": 0.02, \"orientation\": "
            "[0.7071067811865476, 0, -0.7071067811865476, 0]}");
    settles(box, UPRIGHT, 0.02,
            "{\"type\": \"superellipsoid\", \"radii\": [0.006, 0.01, 0.01], \"exponents\": [0.6, 0.9]}");
    settles(drum, UPRIGHT, 0.015, "{\"type\": \"box\", \"size\": [0.01, 0.02, 0.02], \"rounding\": 0.003}");
    settles(super, UPRIGHT, 0.02, "{\"type\": \"ellipsoid\", \"radii\": [0.008, 0.01, 0.012]}");
    settles("{\"type\": \"flat_capsule\", \"radius\": 0.02, \"length\": 0.04}", UPRIGHT, 0.02,
            "{\"type\": \"cylinder\", \"radius\": 0.008, \"length\": 0.03, \"rounding\": 0.002}");
}

/* Flat pads on a superellipsoid's nearly flat poles: under a load off the middle it stays where it is. */
static void test_pads_on_flat_spots(void **state)
{
    (void)state;
    static const char pad[] = "{\"type\": \"box\", \"size\": [0.01, 0.02, 0.02]}";
    static const char rounded[] = "{\"type\": \"box\", \"size\": [0.01, 0.02, 0.02], \"rounding\": 0.003}";
    static const char flat[] = "{\"type\": \"flat_capsule\", \"radius\": 0.008, \"length\": 0.02, \"orientation\": "
                               "[0.7071067811865476, 0, -0.7071067811865476, 0]}";
    static const char bulky[] =
        "{\"type\": \"superellipsoid\", \"radii\": [0.02, 0.025, 0.03], \"exponents\": [0.5, 0.5]}";
    static const char plump[] =
        "{\"type\": \"superellipsoid\", \"radii\": [0.02, 0.025, 0.03], \"exponents\": [0.7, 0.8]}";
    static const char y[] = "[0.7071067811865476, 0, 0, 0.7071067811865476]"; /* the pole along x */
    static const char z[] = "[0.7071067811865476, 0, 0.7071067811865476, 0]";
    const struct {
        const char *shape, *orientation, *tip;
        double reach;
    } cases[] = {
        {bulky, y, pad, 0.025}, {bulky, z, rounded, 0.03}, {bulky, UPRIGHT, flat, 0.02}, {plump, z, pad, 0.03}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        settles(cases[k].shape, cases[k].orientation, cases[k].reach, cases[k].tip);
        scene *s = pinched(cases[k].shape, cases[k].orientation, cases[k].reach, cases[k].tip, WEIGHT);
        world *w = world_of(s);
        dVector3 start;
        world_run_until(w, 4);
        memcpy(start, dBodyGetPosition(w->object), sizeof start);
        world_run_until(w, 6);
        for (int i = 0; i < 3; i++) assert_close(dBodyGetPosition(w->object)[i], start[i], 2e-12);
        world_free(w);
        scene_free(s);
    }
}

/* Hertz' law between an ellipsoid's pole (radii a; b, c across) and a ball: at rest, F = 4/3 E* sqrt(R) delta^(3/2)
 * with 1/R^2 the product of the relative curvatures. */
static void test_hertz(void **state)
{
    (void)state;
    static const double a = 0.008, b = 0.01, c = 0.012, ball = 0.02, modulus = 2e5, depth = 0.0004;
    char text[2048];
    int used = snprintf(text, sizeof text,
                        "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0], \"object\": {\"shape\": {\"type\": "
                        "\"sphere\", \"radius\": %g}, \"mass\": 0.1}, \"fingers\": [",
                        ball);
    for (int side = 0; side < 2; side++)
        used += snprintf(text + used, sizeof text - (size_t)used,
                         "%s{\"point\": [%g, 0, 0], \"normal\": [%d, 0, 0], \"tip\": {\"type\": \"ellipsoid\", "
                         "\"radii\": [%g, %g, %g]}, \"model\": \"hard\", \"stiffness\": {\"normal\": 1000, \"hertz\": "
                         "%g}, \"damping\": {\"normal\": 5, \"tangential\": 5}, \"friction\": 0.5, \"closing\": %g, "
                         "\"ramp\": 0.2}",
                         side ? ", " : "", side ? ball : -ball, side ? -1 : 1, a, b, c, modulus, depth);
    snprintf(text + used, sizeof text - (size_t)used, "]}");
    scene *s = scene_from_text(text);
    world *w = world_of(s);
    world_run_until(w, 2);
    double R = 1 / sqrt((a / (b * b) + 1 / ball) * (a / (c * c) + 1 / ball));
    for (int i = 0; i < 2; i++)
        assert_close(w->fingers[i].state.normal_force, 4.0 / 3 * modulus * sqrt(R) * pow(depth, 1.5), 1e-9);
    world_free(w);
    scene_free(s);
}

/* A cube of two halves: mass properties of the whole, and a pad across the seam feels one body. */
static const char halves[] =
    "o low\nv -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n"
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
    "o high\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
    "f 8 7 6 5\nf -4 -3 -2 -1\nf 5 6 10 9\nf 6 7 11 10\nf 7 8 12 11\nf 8 5 9 12\n";

static const char mesh_scene[] =
    "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0], \"object\": {\"shape\": {\"type\": \"mesh\", \"file\": "
    "\"halves.obj\"}, \"mass\": 1000}, \"fingers\": [{\"point\": [-1, 0, 0], \"normal\": [1, 0, 0], \"tip\": %s, "
    "\"model\": \"hard\", \"stiffness\": {\"normal\": 1e5}, \"damping\": {\"normal\": 3e4, \"tangential\": 3e4}, "
    "\"friction\": 0.5, \"closing\": 0.01, \"ramp\": 0.5}, {\"point\": [1, 0, 0], \"normal\": [-1, 0, 0], \"tip\": %s, "
    "\"model\": \"hard\", \"stiffness\": {\"normal\": 1e5}, \"damping\": {\"normal\": 3e4, \"tangential\": 3e4}, "
    "\"friction\": 0.5, \"closing\": 0.01, \"ramp\": 0.5}]}";

static void test_mesh_in_pieces(void **state)
{
    (void)state;
    static const char *const tips[] = {"{\"type\": \"box\", \"size\": [0.2, 0.6, 0.5]}",
                                       "{\"type\": \"sphere\", \"radius\": 0.3}"};
    char *folder = program_make_folder(), *mesh = program_write_file(folder, "halves.obj", halves);
    for (int t = 0; t < 2; t++) {
        char text[2048];
        scene *s;
        scene_error error;
        snprintf(text, sizeof text, mesh_scene, tips[t], tips[t]);
        char *path = program_write_file(folder, "halves.json", text);
        if (scene_load(path, &s, &error) != SCENE_OK) fail_msg("%s", error.text);
        assert_close(s->objects[0].shape.volume, 8, 1e-12);
        for (int i = 0; i < 9; i++) assert_close(s->objects[0].shape.unit_inertia[i], i % 4 ? 0 : 2.0 / 3, 1e-12);
        world *w = world_of(s);
        world_run_until(w, 2);
        for (int i = 0; i < 2; i++) assert_close(w->fingers[i].state.normal_force, 1000, 1e-6);
        assert_close(w->depth_max, 0.01, 1e-6);
        world_free(w);
        scene_free(s);
        free(path);
    }
    free(mesh);
    program_remove_folder(folder);
}

/* What a mesh file may have wrong: one line that says so. */
static void test_bad_meshes(void **state)
{
    (void)state;
    static const struct {
        const char *text, *says;
    } bad[] = {
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4"},
        {"v 0 0 x\n", "line 1"},
        {"v 0 0 nan\n", "line 1"},
        {"v 0 0 0\nv 1 0 0\nf 1 2\n", "line 3"},
        {"v 0 0 0\nf 0 1 1\n", "line 2"},
        {"v 0 0 0\nf -9223372036854775808 1 1\n", "line 2"},
        {"# nothing\n", "triangles"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "flat"},
        {"solid s\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\nendsolid\n",
         "line 7"},
        {"solid s\nwhat\n", "line 2"},
        /* a tetrahedron without a side */
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n", "convex"},
        /* twice the same */
        {"o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\no b\nf 1 3 2\nf 1 2 4\nf 1 4 "
         "3\nf "
         "2 3 4\n",
         "overlap"},
    };
    char *folder = program_make_folder(), text[2048];
    snprintf(text, sizeof text, mesh_scene, "{\"type\": \"sphere\", \"radius\": 1}",
             "{\"type\": \"sphere\", \"radius\": 1}");
    char *path = program_write_file(folder, "halves.json", text);
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        scene *s;
        scene_error error;
        char *mesh = program_write_file(folder, "halves.obj", bad[k].text);
        assert_int_equal(scene_load(path, &s, &error), SCENE_BAD_INPUT);
        if (!strstr(error.text, bad[k].says) || !strstr(error.text, "object.shape.file") || strchr(error.text, '\n'))
            fail_msg("%s: no \"%s\"", error.text, bad[k].says);
        free(mesh);
    }
    free(path);
    program_remove_folder(folder);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_tips_on_round_objects),
        cmocka_unit_test(test_flat_tips_on_polyhedra),
        cmocka_unit_test(test_tips_of_real_shape),
        cmocka_unit_test(test_pads_on_flat_spots),
        cmocka_unit_test(test_hertz),
        cmocka_unit_test(test_mesh_in_pieces),
        cmocka_unit_test(test_bad_meshes),
    };
    int failed = cmocka_run_group_tests_name("tip scenes", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
