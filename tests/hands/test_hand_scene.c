/* Hands in scene files: which rule wins, what is the default, where joints start, and what is refused. */
#include "support/cmocka_all.h"

#include "hands/hand.h"
#include "scenes/scene.h"
#include "support/program.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ASSET_HANDS PINCH_SOURCE_DIR "/assets/hands/"

/* Loads a scene with an object and a hand whose keys are `keys` (with a comma in front); NULL where it is refused. */
static scene *load(const char *file, const char *keys, scene_error *error)
{
    char text[4096];
    scene *s = NULL;
    snprintf(text, sizeof text,
             "{\"format\": \"pinch-scene/1\",\n"
             " \"object\": {\"shape\": {\"type\": \"sphere\", \"radius\": 0.02}, \"mass\": 0.1},\n"
             " \"hand\": {\"file\": \"%s%s\"%s}}\n",
             ASSET_HANDS, file, keys);
    char *folder = program_make_folder(), *path = program_write_file(folder, "scene.json", text);
    scene_status status = scene_load(path, &s, error);
    program_remove_folder(folder);
    free(path);
    assert_true((status == SCENE_OK) == (s != NULL));
    return s;
}

static scene *load_good(const char *file, const char *keys)
{
    scene_error error;
    scene *s = load(file, keys, &error);
    if (!s) fail_msg("%s", error.text);
    return s;
}

static const scene_control *control_of(const scene *s, const char *name)
{
    for (size_t i = 0; i < s->hands[0].control_count; i++)
        if (strcmp(s->hands[0].controls[i].name, name) == 0) return &s->hands[0].controls[i];
    fail_msg("no control of %s", name);
    return NULL;
}

static const scene_finger *link_of(const scene *s, const char *name)
{
    for (size_t i = 0; i < s->hands[0].link_count; i++)
        if (strcmp(s->hands[0].links[i].name, name) == 0) return &s->hands[0].links[i];
    fail_msg("no link %s", name);
    return NULL;
}

static void test_the_most_specific_rule_wins(void **state)
{
    (void)state;
    scene *s = load_good("three-finger.urdf",
                         ", \"control\": {\"f1_mcp\": {\"target\": [[0, 0.2], [0.5, 0.9]]},"
                         "  \"*\": {\"type\": \"position\", \"kp\": 2, \"kd\": 0.05},"
                         "  \"f1_*\": {\"kp\": 3, \"max_force\": 0.5}, \"f?_mcp\": {\"kp\": 4},"
                         "  \"f3_pip\": {\"type\": \"torque\", \"target\": 0.4}},"
                         " \"contacts\": {\"*\": {\"friction\": 0.7}, \"f*_tip\": {\"model\": \"soft\","
                         "  \"stiffness\": {\"normal\": 4000, \"torsional\": 0.2}, \"torsional_friction\": 0.003}}");
    const scene_control *c = control_of(s, "f1_mcp"); /* "f?_mcp" has more plain characters than "f1_*" */
    assert_int_equal(c->type, SCENE_POSITION_CONTROL);
    assert_true(c->kp == 4 && c->kd == 0.05 && c->max_force == 0.5 && c->target_count == 2);
    assert_true(fabs(scene_target_at(c, 0.25) - 0.55) < 1e-15);
    assert_true(scene_target_at(c, -1) == 0.2 && scene_target_at(c, 9) == 0.9);
    c = control_of(s, "f2_pip");
    assert_true(c->kp == 2 && c->max_force == 1 && c->target_count == 1); /* the file's effort */
    c = control_of(s, "f3_pip");                                          /* another type: begins anew */
    assert_int_equal(c->type, SCENE_TORQUE_CONTROL);
    assert_true(c->kp == 0 && c->kd == 0 && c->target[0].value == 0.4);
    assert_true(link_of(s, "f2_tip")->model == SCENE_SOFT && link_of(s, "f2_tip")->friction.static_ == 0.7);
    assert_true(link_of(s, "palm")->model == SCENE_HARD && link_of(s, "palm")->stiffness.normal == 1e5);
    scene_free(s);
}

static void test_the_file_says_what_is_driven(void **state)
{
    (void)state;
    scene *s = load_good("shadow-like.xml", ", \"control\": {\"*\": {\"kd\": 0.1}, \"A_FFJ0\": {\"target\": 1}}");
    const scene_control *c = control_of(s, "FFJ0"); /* a tendon, by the name of its actuator */
    assert_true(c->tendon >= 0 && c->type == SCENE_POSITION_CONTROL && c->kp == 1 && c->kd == 0.1);
    assert_true(c->max_force == 1 && c->target[0].value == 1);
    assert_int_equal(control_of(s, "FFJ2")->type, SCENE_UNDRIVEN);
    scene_free(s);
    s = load_good("parallel-gripper.urdf", ", \"control\": {\"*\": {\"type\": \"velocity\", \"kd\": 9}}");
    assert_int_equal(control_of(s, "left_finger_slide")->type, SCENE_VELOCITY_CONTROL);
    assert_int_equal(control_of(s, "right_finger_slide")->type, SCENE_UNDRIVEN); /* it follows the other one */
    scene_free(s);
}

static void test_joints_follow_and_loops_close(void **state)
{
    (void)state;
    scene *s = load_good("parallel-gripper.urdf", ", \"joints\": {\"left_finger_slide\": 0.03}");
    assert_true(s->hands[0].start[1] == 0.03);
    scene_free(s);
    s = load_good("robotiq-like.xml", ", \"joints\": {\"left_driver_joint\": 0.3}");
    const hand *model = s->hands[0].model; /* all cranks of the parallelograms turn alike */
    for (size_t i = 0; i < model->joint_count; i++) assert_true(fabs(s->hands[0].start[i] - 0.3) < 1e-10);
    scene_free(s);
}

static void test_what_is_refused(void **state)
{
    (void)state;
    static const struct {
        const char *file, *keys, *says;
    } cases[] = {
        {"nothing.urdf", "", ":3: hand.file: expected a hand that can be read"},
        {"three-finger.urdf", ", \"colour\": 1", "hand.colour: expected a known key"},
        {"three-finger.urdf", ", \"joints\": {\"f9_mcp\": 0}", "hand.joints.f9_mcp: expected the name of a joint, or"},
        {"three-finger.urdf", ", \"joints\": {\"f1_pip\": 2.5}",
         "expected a position of f1_pip from 0 to 1.9, got 2.5"},
        {"three-finger.urdf", ", \"control\": {\"f9\": {\"kp\": 1}}",
         "the name of a joint, tendon or actuator, or a glob that matches one; there are f1_"},
        {"shadow-like.xml", ", \"control\": {\"A_FFJ9\": {\"kp\": 1}}", "; there are WRJ2 (A_WRJ2), WRJ1 (A_WRJ1), "},
        {"shadow-like.xml", ", \"control\": {\"A_FFJ9\": {\"kp\": 1}}", ", FFJ2, FFJ1, MFJ4 (A_MFJ4), "},
        {"shadow-like.xml", ", \"control\": {\"A_FFJ9\": {\"kp\": 1}}", ", FFJ0 (A_FFJ0), "},
        {"three-finger.urdf", ", \"control\": {\"*\": {\"type\": \"position\"}}",
         "hand.control.*.kp: expected a number"},
        {"three-finger.urdf", ", \"control\": {\"*\": {\"type\": \"position\", \"kp\": 1e300}}",
         "hand.control.*.kp: expected a number from 0 to 1e+15"},
        {"three-finger.urdf", ", \"control\": {\"*\": {\"type\": \"velocity\", \"kd\": 1e300}}",
         "hand.control.*.kd: expected a number from 0 to 1e+15"},
        {"three-finger.urdf", ", \"control\": {\"*\": {\"type\": \"torque\", \"max_force\": 1e300}}",
         "hand.control.*.max_force: expected a number from 1e-12 to 1e+12"},
        {"three-finger.urdf", ", \"control\": {\"*\": {\"kp\": 1}}", "hand.control.*.type: expected position, torque"},
        {"three-finger.urdf", ", \"control\": {\"f1_*\": {\"type\": \"torque\", \"target\": [[1, 0], [0, 1]]}}",
         "hand.control.f1_*.target[1][0]: expected a time"},
        {"three-finger.urdf", ", \"contacts\": {\"tip*\": {}}", "hand.contacts.tip*: expected the name of a link"},
        {"three-finger.urdf", ", \"contacts\": {\"*\": {\"model\": \"soft\"}}", "torsional: expected a number > 0"},
        {"three-finger.urdf", ", \"base\": {\"drive\": {\"type\": \"slider\", \"mass\": 1}}", "drive fixed or path"},
        {"parallel-gripper.urdf", ", \"joints\": {\"*\": 0.01, \"right_finger_slide\": 0.02}", "at 0.01"},
        {"robotiq-like.xml", ", \"joints\": {\"left_driver_joint\": 0.3, \"left_link_joint\": 0.1}", "loops"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        scene_error error;
        scene *s = load(cases[i].file, cases[i].keys, &error);
        if (s || !strstr(error.text, cases[i].says))
            fail_msg("expected \"%s\", got \"%s\"", cases[i].says, s ? "a scene" : error.text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_most_specific_rule_wins),
        cmocka_unit_test(test_the_file_says_what_is_driven),
        cmocka_unit_test(test_joints_follow_and_loops_close),
        cmocka_unit_test(test_what_is_refused),
    };
    return cmocka_run_group_tests_name("hands in scene files", tests, NULL, NULL);
}
