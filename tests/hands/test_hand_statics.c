/*
 * The statics of hands: a finger that a known torque presses, motors and joints in series with a fingertip, and scenes
 * at rest, of which the statics and the run have to agree, since they share no solver.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"
#include "support/command.h"
#include "support/draw.h"
#include "support/scene_run.h"
#include "support/schema.h"

#include "scenes/world/world_hand.h"
#include "statics/hand_statics.h"

#include <glob.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A bar on a hinge presses a ball at its end, 0.08 m from the hinge, down onto a block that stands on the ground.
 * Without friction and without weight the ball's force is upright, so that its lever arm is 0.08 cos q. */
static const double BAR = 0.08, TIP_STIFFNESS = 5000;

static char *pressing_text(const char *folder, const char *control)
{
    char *text = malloc(2048);
    assert_non_null(text);
    snprintf(text, 2048,
             "{\"format\": \"pinch-scene/1\", \"name\": \"press\", \"gravity\": [0, 0, 0],"
             " \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.1, 0.1, 0.02]}, \"mass\": 1,"
             "  \"position\": [0.08, 0, -0.0201]},"
             " \"environment\": [{\"name\": \"ground\", \"shape\": {\"type\": \"box\", \"size\": [1, 1, 0.1]},"
             "  \"position\": [0, 0, -0.08], \"stiffness\": {\"normal\": 1e6}, \"damping\": {\"normal\": 1000},"
             "  \"friction\": 0.5}],"
             " \"hand\": {\"file\": \"%s/bar.xml\", \"control\": {\"hinge\": %s},"
             "  \"contacts\": {\"*\": {\"model\": \"frictionless\", \"stiffness\": {\"normal\": %g},"
             "   \"damping\": {\"normal\": 5}}}}}",
             folder, control, TIP_STIFFNESS);
    return text;
}

static scene *pressing(const char *control)
{
    static const char hand_text[] =
        "<mujoco><compiler angle='radian'/><worldbody><body name='base'><geom type='sphere' size='0.005' mass='0.1'"
        " contype='0' conaffinity='0'/>"
        "<body name='bar'><joint name='hinge' axis='0 1 0' range='-1 1' damping='0.01' armature='1e-4'/>"
        "<geom name='ball' type='sphere' size='0.01' pos='0.08 0 0' mass='0.05'/></body></body></worldbody></mujoco>";
    char *folder = program_make_folder(), *text = pressing_text(folder, control);
    free(program_write_file(folder, "bar.xml", hand_text));
    scene *s = scene_from_text(text);
    program_remove_folder(folder);
    free(text);
    return s;
}

/* The object is pushed with torque over lever arm, at rest as well as from where the bar is still on its way. */
static void check_lever(const char *control, double torque, double time)
{
    scene *s = pressing(control);
    hand_statics x;
    assert_true(hand_statics_solve(s, time, &x));
    assert_int_equal(x.status, HAND_STATICS_SOLVED);
    assert_int_equal(x.joint_count, 1);
    assert_int_equal(x.finger_count, 1);
    const hand_static_joint *j = &x.joints[0];
    assert_close(j->torque, torque, 0);
    assert_close(j->contact_torque, -torque, 1e-9);
    if (time >= 1) { /* at rest */
        assert_close(x.fingers[0].normal_force * BAR * cos(j->position), torque, 1e-9);
        assert_close(x.fingers[0].force[2], -x.fingers[0].normal_force, 1e-9);
    }
    hand_statics_free(&x);
    scene_free(s);
}

static void test_torque_over_lever_arm(void **state)
{
    (void)state;
    check_lever("{\"type\": \"torque\", \"target\": 0.4}", 0.4, 3);
    check_lever("{\"type\": \"torque\", \"target\": 3, \"max_force\": 0.25}", 0.25, 3);
    check_lever("{\"type\": \"position\", \"kp\": 50, \"kd\": 0.5, \"target\": 0.9, \"max_force\": 0.3}", 0.3, 3);
    check_lever("{\"type\": \"torque\", \"target\": 0.4}", 0.4, 0.05);
}

/* The compliance of the joint, over the lever arm squared, adds to that of the fingertip and of the ground: from a
 * state in motion the statics say where the bar will come to rest, as far as displacements are small. */
static void test_compliances_in_series(void **state)
{
    (void)state;
    double kp = 20, target = 0.05;
    scene *s =
        pressing("{\"type\": \"position\", \"kp\": 20, \"kd\": 0.2, \"target\": [[0, 0], [0.5, 0], [0.501, 0.05]]}");
    hand_statics early, late;
    assert_true(hand_statics_solve(s, 0.503, &early));
    assert_true(hand_statics_solve(s, 3, &late));
    assert_int_equal(early.status, HAND_STATICS_SOLVED);
    assert_int_equal(late.status, HAND_STATICS_SOLVED);
    const hand_static_joint *j = &late.joints[0];
    assert_close(j->torque, kp * (target - j->position), 1e-12);
    assert_close(late.fingers[0].normal_force * BAR * cos(j->position), j->torque, 1e-9);
    /* on the ground the block's face is where the ball touches it at q = 0; sin q / q - 1 is below 1e-4 */
    double series = 1 / TIP_STIFFNESS + BAR * BAR / kp + 1e-6, force = BAR * target / series;
    assert_close(late.fingers[0].normal_force, force, 1e-3 * force);
    assert_close(early.fingers[0].normal_force, late.fingers[0].normal_force, 1e-3 * late.fingers[0].normal_force);
    hand_statics_free(&early);
    hand_statics_free(&late);
    scene_free(s);
}

static void test_what_is_not_meant(void **state)
{
    (void)state;
    scene *s = pressing("{\"type\": \"velocity\", \"kd\": 5, \"target\": 2, \"max_force\": 0.2}");
    hand_statics x;
    assert_true(hand_statics_solve(s, 0.1, &x));
    assert_int_equal(x.status, HAND_STATICS_UNSUPPORTED);
    assert_non_null(strstr(x.why, "hinge"));
    hand_statics_free(&x);
    scene_free(s);
}

/* ---- Scenes at rest. ---- */

static double largest(double a, const double *b, const double *c)
{
    for (int i = 0; i < 3; i++) a = fmax(a, fabs(b[i] - c[i]));
    return a;
}

/* Forces of the links and torques of the joints by the statics and by the run. Both are a rest in the same pose. */
static void compare_with_run(const char *path)
{
    scene *s;
    scene_error error;
    hand_statics x;
    if (scene_load(path, &s, &error) != SCENE_OK) fail_msg("%s", error.text);
    double time = s->duration + (draw_full() ? 20 : 3), off = 0, turned = 0; /* some come to rest slowly */
    assert_true(hand_statics_solve(s, time, &x));
    if (x.status != HAND_STATICS_SOLVED) fail_msg("%s: status %d %s", path, (int)x.status, x.why);
    world *w = world_of(s);
    world_run_until(w, time);
    for (int k = 0; k < x.finger_count; k++)
        for (int i = 0; i < w->finger_count; i++)
            if (strcmp(w->fingers[i].finger->name, x.fingers[k].name) == 0 && w->object_count == 1)
                off = largest(off, x.fingers[k].force, w->fingers[i].state.force);
    for (int h = 0, k = 0; h < w->hand_count; h++)
        for (int i = 0; i < w->hands[h].joint_count; i++, k++) {
            const world_joint *j = &w->hands[h].joints[i];
            turned = fmax(turned, fmax(fabs(j->torque - x.joints[k].torque), fabs(j->position - x.joints[k].position)));
            if (j->saturated != x.joints[k].saturated) fail_msg("%s: %s saturated?", path, j->of->name);
            double sum = x.joints[k].torque + x.joints[k].contact_torque + x.joints[k].weight_torque +
                         x.joints[k].passive_torque;
            assert_close(sum, 0, 1e-12);
        }
    if (!(off <= 1e-8 && turned <= 1e-9)) fail_msg("%s: forces differ by %g N, joints by %g", path, off, turned);
    hand_statics_free(&x);
    world_free(w);
    scene_free(s);
}

static void test_scenes_at_rest(void **state)
{
    (void)state;
    static const char *const some[] = {"three-finger-power-cylinder.json", "parallel-gripper-precision-cube.json",
                                       "robotiq-like-power-cylinder.json"};
    char path[512];
    if (draw_full()) {
        glob_t found;
        assert_int_equal(glob(PINCH_SOURCE_DIR "/assets/scenes/hands/*.json", 0, NULL, &found), 0);
        for (size_t i = 0; i < found.gl_pathc; i++) compare_with_run(found.gl_pathv[i]);
        globfree(&found);
        return;
    }
    for (size_t i = 0; i < sizeof some / sizeof *some; i++) {
        snprintf(path, sizeof path, "%s/assets/scenes/hands/%s", PINCH_SOURCE_DIR, some[i]);
        compare_with_run(path);
    }
}

/* ---- The command. ---- */

static void test_the_command(void **state)
{
    (void)state;
    const char *file = PINCH_SOURCE_DIR "/assets/scenes/hands/three-finger-precision-cube.json";
    json_error_t error;
    json_t *schema = json_load_file(PINCH_SOURCE_DIR "/assets/schema/pinch-solve-1.json", 0, &error);
    assert_non_null(schema);
    program_result r = PINCH(NULL, "solve", file, "--time", "1", "--json");
    assert_int_equal(r.status, 0);
    json_t *d = cli_document(&r);
    assert_int_equal(schema_faults(schema, d), 0);
    assert_int_equal(json_array_size(json_object_get(d, "joints")), 9);
    assert_true(json_is_null(json_object_get(d, "grasp")));
    assert_int_equal(json_array_size(json_object_get(d, "not_expressed")), 0);
    assert_true(json_is_array(json_object_get(d, "not_expressed")));
    json_decref(d);
    json_decref(schema);
    program_free(&r);
    r = PINCH(NULL, "solve", file, "--time", "1");
    assert_int_equal(r.status, 0);
    assert_non_null(strstr(r.out, "of contacts"));
    program_free(&r);
    cli_refused(PINCH(NULL, "solve", file), 2, "expected --at-end or --time");
    cli_refused(PINCH(NULL, "solve", file, "--at-end", "--directions"), 2, "--directions");
    cli_refused(PINCH(NULL, "solve", file, "--at-end", "--no-newton"), 2, "--no-newton");
    cli_refused(PINCH(NULL, "solve", file, "--at-end", "--formulation", "lcp"), 2, "coulomb");
}

/* The scene of a gripper far below a ball, under this gravity. */
static char *write_far_ball(const char *folder, double gravity)
{
    char text[1024];
    snprintf(text, sizeof text,
             "{\"format\": \"pinch-scene/1\", \"objects\": [{\"name\": \"ball\", \"shape\": {\"type\": \"sphere\", "
             "\"radius\": 0.02}, \"mass\": 0.1, \"position\": [0, 0, 0.5]}], \"hand\": {\"file\": \"" PINCH_SOURCE_DIR
             "/assets/hands/parallel-gripper.urdf\", \"control\": {\"left_finger_slide\": {\"type\": \"position\", "
             "\"kp\": 1000, \"kd\": 10}}}, \"gravity\": [0, 0, %g], \"simulation\": {\"duration\": 0.1}}",
             gravity);
    return program_write_file(folder, "far.json", text);
}

/* What nothing touches cannot be held, and no search is needed to tell; without a load it stays where it is. */
static void test_nothing_touched(void **state)
{
    (void)state;
    char *folder = program_make_folder(), *file = write_far_ball(folder, -9.81);
    json_t *schema = json_load_file(PINCH_SOURCE_DIR "/assets/schema/pinch-solve-1.json", 0, NULL);
    program_result r = PINCH(NULL, "solve", file, "--at-end", "--json");
    assert_int_equal(r.status, 1);
    json_t *d = cli_document(&r);
    assert_int_equal(schema_faults(schema, d), 0);
    assert_string_equal(json_string_value(json_object_get(d, "status")), "infeasible");
    assert_close(json_number_value(json_object_get(d, "residual")), 0.981, 1e-12);
    assert_true(json_is_false(cli_at(d, "verification.passed")));
    json_decref(d);
    json_decref(schema);
    program_free(&r);
    r = PINCH(NULL, "solve", file, "--at-end");
    assert_int_equal(r.status, 1);
    assert_string_equal(r.out, "far: infeasible at 0.1 s: nothing touches ball, which has a load\n");
    program_free(&r);
    free(file);
    file = write_far_ball(folder, 0);
    r = PINCH(NULL, "solve", file, "--at-end");
    assert_int_equal(r.status, 0);
    program_free(&r);
    free(file);
    program_remove_folder(folder);
}

/* Two links hang from hinges without drives beside an object on a table, from where nothing brings them back but their
 * weight. Off the vertical by a little, the answer is the vertical, but for the cube of that. */
static void test_links_that_hang(void **state)
{
    (void)state;
    static const char hand_text[] =
        "<mujoco><compiler angle='radian'/><worldbody><body name='base'><geom type='sphere' size='0.005'/>"
        "<body name='upper'><joint name='shoulder' axis='0 1 0' damping='0.2'/>"
        "<geom type='box' size='.01 .01 .1' pos='0 0 -.1' mass='.2'/>"
        "<body name='lower' pos='0 0 -.2'><joint name='elbow' axis='0 1 0' damping='0.2'/>"
        "<geom type='box' size='.01 .01 .05' pos='0 0 -.05' mass='.1'/></body></body></body></worldbody></mujoco>";
    static const char scene_text[] =
        "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.05, 0.05, 0.05]},"
        " \"mass\": 0.1, \"position\": [0, 2, 0.02499]}, \"environment\": [{\"name\": \"table\", \"shape\": {\"type\":"
        " \"box\", \"size\": [0.2, 0.2, 0.1]}, \"position\": [0, 2, -0.05], \"stiffness\": {\"normal\": 1e5},"
        " \"friction\": 0.5}], \"hand\": {\"file\": \"%s/links.xml\","
        " \"joints\": {\"shoulder\": %g, \"elbow\": %g}}}";
    const double off = 1e-3;
    char text[1024], *folder = program_make_folder();
    free(program_write_file(folder, "links.xml", hand_text));
    snprintf(text, sizeof text, scene_text, folder, off, -2 * off);
    scene *s = scene_from_text(text);
    hand_statics x;
    assert_true(hand_statics_solve(s, 0, &x));
    assert_int_equal(x.status, HAND_STATICS_SOLVED);
    for (int i = 0; i < 2; i++) assert_true(fabs(x.joints[i].weight_torque) < 0.3 * 9.81 * 0.2 * 10 * off * off * off);
    hand_statics_free(&x);
    scene_free(s);
    program_remove_folder(folder);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_torque_over_lever_arm), cmocka_unit_test(test_compliances_in_series),
        cmocka_unit_test(test_what_is_not_meant),     cmocka_unit_test(test_scenes_at_rest),
        cmocka_unit_test(test_the_command),           cmocka_unit_test(test_nothing_touched),
        cmocka_unit_test(test_links_that_hang),
    };
    int failed = cmocka_run_group_tests_name("hands that stand still", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
