/* The shipped hands, and the real `pinch hand`. */

#include "support/cmocka_all.h"

#include "hand_case.h"
#include "support/command.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define HAND(name) PINCH_SOURCE_DIR "/assets/hands/" name

static const struct {
    const char *file;
    size_t links, bodies, joints, drives, couplings, tendons, loops, tips;
    double mass;
} shipped[] = {
    {HAND("three-finger.urdf"), 13, 10, 9, 0, 0, 0, 0, 3, 0.709},
    {HAND("allegro-like.urdf"), 21, 17, 16, 0, 0, 0, 0, 4, 0.9545},
    {HAND("parallel-gripper.urdf"), 5, 3, 2, 0, 1, 0, 0, 2, 0.73},
    {HAND("robotiq-like.xml"), 11, 7, 6, 1, 1, 1, 2, 4, 0.958},
    {HAND("shadow-like.xml"), 25, 25, 24, 20, 0, 4, 0, 5, 3.794},
};
enum { SHIPPED = sizeof shipped / sizeof shipped[0] };

static hand *load(const char *file)
{
    hand *h;
    hand_error error;
    if (hand_load(file, NULL, 0, &h, &error) != HAND_OK) fail_msg("%s", error.text);
    return h;
}

static void shipped_hands_are_whole(void **state)
{
    (void)state;
    for (int i = 0; i < SHIPPED; i++) {
        hand *h = load(shipped[i].file);
        int tips = 0;
        for (size_t b = 0; b < h->body_count; b++) tips += hand_tip_of(h, b) >= 0;
        assert_int_equal(h->link_count, shipped[i].links);
        assert_int_equal(h->body_count, shipped[i].bodies);
        assert_int_equal(h->joint_count, shipped[i].joints);
        assert_int_equal(h->drive_count, shipped[i].drives);
        assert_int_equal(h->coupling_count, shipped[i].couplings);
        assert_int_equal(h->tendon_count, shipped[i].tendons);
        assert_int_equal(h->loop_count, shipped[i].loops);
        assert_int_equal(tips, shipped[i].tips);
        assert_close(hand_total_mass(h), shipped[i].mass, 1e-12);
        assert_int_equal(h->ignored_count, 0);
        assert_int_equal(h->unmodelled_count, 0);
        for (size_t k = 0; k < h->joint_count; k++) assert_true(h->joints[k].limited);
        for (size_t k = 0; k < h->geom_count; k++) assert_true(h->geoms[k].type != HAND_MESH);
        hand_free(h);
    }
}

static const hand_pose *pose_of(const hand *h, const hand_pose *poses, const char *link)
{
    int index = hand_find_link(h, link);
    assert_true(index >= 0);
    return &poses[index];
}

/* The published lengths: a finger that is bent at one joint. */
static void fingers_have_their_lengths(void **state)
{
    (void)state;
    hand *h = load(HAND("allegro-like.urdf"));
    hand_pose poses[64];
    double q[64] = {0};
    q[hand_find_joint(h, "middle_pip")] = 1.5;
    hand_kinematics(h, q, poses);
    double z = 0.0007 + 0.0164 + 0.054, out = 0.0384 + 0.0267;
    assert_numbers(pose_of(h, poses, "middle_tip")->position, (double[]){out * sin(1.5), 0, z + out * cos(1.5)}, 3,
                   1e-15);
    hand_free(h);

    h = load(HAND("shadow-like.xml"));
    memset(q, 0, sizeof q);
    q[hand_find_joint(h, "MFJ3")] = 1.5;
    hand_kinematics(h, q, poses);
    assert_numbers(pose_of(h, poses, "middle_tip")->position,
                   (double[]){0.011, -0.07 * sin(1.5), 0.034 + 0.099 + 0.07 * cos(1.5)}, 3, 1e-15);
    hand_free(h);
}

/* With the cranks parallel the loops of the linkage gripper are closed at every angle, and its pads close 85 mm. */
static void the_linkage_closes(void **state)
{
    (void)state;
    hand *h = load(HAND("robotiq-like.xml"));
    hand_pose poses[64];
    double gap[2];
    for (int step = 0; step <= 8; step++) {
        double q[8];
        for (size_t k = 0; k < h->joint_count; k++) q[k] = 0.1 * step;
        hand_kinematics(h, q, poses);
        for (size_t k = 0; k < h->loop_count; k++) {
            double ends[2][3];
            for (int i = 0; i < 2; i++) pose_point(&poses[h->loops[k].link[i]], h->loops[k].anchor[i], ends[i]);
            assert_numbers(ends[0], ends[1], 3, 1e-11);
        }
        const hand_pose *right = pose_of(h, poses, "right_pad"), *left = pose_of(h, poses, "left_pad");
        gap[step == 8] = right->position[0] - left->position[0] - 2 * 0.004;
        assert_orientation(right->orientation, (double[]){1, 0, 0, 0}, 1e-12);
    }
    assert_close(gap[1], 0, 1e-10);
    hand_kinematics(h, (double[8]){0}, poses);
    gap[0] = pose_of(h, poses, "right_pad")->position[0] - pose_of(h, poses, "left_pad")->position[0] - 0.008;
    assert_close(gap[0], 0.085, 1e-10);
    hand_free(h);
}

static double number_at(const json_t *list, size_t index)
{
    return json_number_value(json_array_get(list, index));
}

static void the_document_is_the_hand(void **state)
{
    (void)state;
    for (int i = 0; i < SHIPPED; i++) {
        program_result r = PINCH(NULL, "hand", shipped[i].file, "--json");
        json_t *d = cli_document(&r);
        hand *h = load(shipped[i].file);
        hand_pose poses[64];
        double q[64] = {0};
        hand_kinematics(h, q, poses);
        assert_int_equal(r.status, 0);
        assert_string_equal(json_string_value(cli_at(d, "command")), "hand");
        assert_int_equal(json_array_size(cli_at(d, "links")), h->link_count);
        assert_int_equal(json_array_size(cli_at(d, "bodies")), h->body_count);
        assert_int_equal(json_array_size(cli_at(d, "tips")), shipped[i].tips);
        assert_true(json_number_value(cli_at(d, "total_mass")) == hand_total_mass(h));
        const json_t *joints = cli_at(d, "joints"), *placed = cli_at(d, "kinematics.links");
        for (size_t k = 0; k < h->joint_count; k++) {
            const json_t *limits = cli_at(json_array_get(joints, k), "limits");
            assert_true(number_at(limits, 0) == h->joints[k].lower && number_at(limits, 1) == h->joints[k].upper);
        }
        for (size_t k = 0; k < h->link_count; k++)
            for (size_t c = 0; c < 3; c++)
                assert_true(number_at(cli_at(json_array_get(placed, k), "position"), c) == poses[k].position[c]);
        hand_free(h);
        json_decref(d);
        program_free(&r);
    }
}

static void positions_are_taken(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "hand", HAND("parallel-gripper.urdf"), "--json", "--at", "left_finger_slide=0.03");
    json_t *d = cli_document(&r);
    /* the right finger mimics the left one */
    assert_close(json_number_value(cli_at(d, "kinematics.joints.right_finger_slide")), 0.03, 0);
    json_decref(d);
    program_free(&r);
    r = PINCH(NULL, "hand", HAND("parallel-gripper.urdf"), "--at", "left_finger_slide=0.03,right_finger_slide=0.03");
    assert_int_equal(r.status, 0);
    assert_non_null(strstr(r.out, "left_finger "));
    assert_non_null(strstr(r.out, "0.030000000"));
    assert_non_null(strstr(r.out, "coupling: right_finger_slide"));
    assert_non_null(strstr(r.out, "tips: left_pad, right_pad"));
    program_free(&r);
}

/* What --at draws a scene must be able to begin with. */
static void positions_are_checked(void **state)
{
    (void)state;
    static const char *const at[][2] = {
        {"left_finger_slide=9", "--at: expected a position of left_finger_slide from 0 to 0.04, got 9"},
        {"left_finger_slide=-1e-6", "--at: expected a position of left_finger_slide from"},
        {"left_finger_slide=0.01,right_finger_slide=0.02",
         "--at: expected right_finger_slide at 0.01, where left_finger_slide takes it, got 0.02"},
        {"right_finger_slide=0.02", "--at: expected right_finger_slide at 0, where left_finger_slide takes it"}};
    for (size_t i = 0; i < sizeof at / sizeof *at; i++)
        cli_refused(PINCH(NULL, "hand", HAND("parallel-gripper.urdf"), "--at", at[i][0]), 2, at[i][1]);
    /* a follower leaves its limits before the one that it follows does */
    char *folder = program_make_folder();
    free(program_write_file(
        folder, "h.urdf",
        "<robot name='h'><link name='a'/><link name='b'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' "
        "ixy='0' ixz='0' iyz='0'/></inertial></link><link name='c'><inertial><mass value='1'/><inertia ixx='1' iyy='1' "
        "izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link><joint name='j' type='revolute'><parent link='a'/><child "
        "link='b'/><axis xyz='0 0 1'/><limit lower='0' upper='2' effort='1' velocity='1'/></joint><joint name='k' "
        "type='revolute'><parent link='a'/><child link='c'/><axis xyz='0 0 1'/><limit lower='0' upper='2' effort='1' "
        "velocity='1'/><mimic joint='j' multiplier='2'/></joint></robot>"));
    cli_refused(PINCH(folder, "hand", "h.urdf", "--at", "j=1.5"), 2,
                "--at: expected a position of k from 0 to 2, got 3");
    cli_refused(PINCH(folder, "hand", "h.urdf", "--at", "j=1.5", "--gltf", "h.glb"), 2,
                "--at: expected a position of k");
    program_result r = PINCH(folder, "hand", "h.urdf", "--at", "k=1,j=0.5", "--gltf", "h.glb");
    assert_int_equal(r.status, 0);
    program_free(&r);
    program_remove_folder(folder);
}

static void wrong_calls_are_refused(void **state)
{
    (void)state;
    cli_refused(PINCH(NULL, "hand"), 2, "");
    cli_refused(PINCH(NULL, "hand", "none.urdf"), 2, "none.urdf: expected a readable file");
    cli_refused(PINCH(NULL, "hand", SCENE("example-1.json")), 2, "example-1.json:1: expected an XML document");
    cli_refused(PINCH(NULL, "hand", PINCH_SOURCE_DIR), 2, "expected a readable file");
    cli_refused(PINCH(NULL, "hand", "/dev/zero"), 2, "/dev/zero");
    cli_refused(PINCH(NULL, "hand", HAND("shadow-like.xml"), "--at", "WRJ1"), 2, "expected JOINT=POSITION");
    cli_refused(PINCH(NULL, "hand", HAND("shadow-like.xml"), "--at", "X=1"), 2, "not \"X\"; there are WRJ2 WRJ1");
    cli_refused(PINCH(NULL, "hand", HAND("shadow-like.xml"), "--at", "WRJ1=1x"), 2, "expected a position");
    cli_refused(PINCH(NULL, "hand", HAND("shadow-like.xml"), "--at", "WRJ1=0,WRJ1=0.1"), 2,
                "--at: expected each joint once, got WRJ1 twice");
    cli_refused(PINCH(NULL, "hand", HAND("shadow-like.xml"), "--package", "a"), 2, "expected NAME=DIRECTORY");
    char *folder = program_make_folder();
    free(program_write_file(folder, "h.urdf", "<robot>\n<link name=\"a\"/>\n<link name=\"b\"/>\n</robot>"));
    cli_refused(PINCH(folder, "hand", "h.urdf"), 2, "h.urdf:3: <link name=\"b\">: expected one link");
    program_remove_folder(folder);
}

static void write_bytes(const char *folder, const char *name, const char *bytes, size_t size)
{
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *stream = fopen(path, "wb");
    assert_non_null(stream);
    assert_int_equal(fwrite(bytes, 1, size, stream), size);
    assert_int_equal(fclose(stream), 0);
}

/* A zero byte does not end the document in silence. Text of two bytes a character has zero bytes of its own. */
static void zero_bytes(void **state)
{
    (void)state;
    static const char behind[] = "<robot name=\"r\"><link name=\"a\"/></robot>\0<junk>";
    static const char within[] = "<robot name=\"r\"><link name=\"a\"/>\0<link name=\"b\"/></robot>";
    static const char included[] = "<mujoco><include file=\"behind.xml\"/></mujoco>";
    char *folder = program_make_folder(), wide[2 * sizeof behind];
    size_t text = strlen(behind);
    write_bytes(folder, "behind.xml", behind, sizeof behind - 1);
    write_bytes(folder, "within.xml", within, sizeof within - 1);
    write_bytes(folder, "included.xml", included, sizeof included - 1);
    cli_refused(PINCH(folder, "hand", "behind.xml"), 2, "behind.xml: expected an XML document without a zero byte");
    cli_refused(PINCH(folder, "hand", "within.xml"), 2, "within.xml: expected an XML document without a zero byte");
    cli_refused(PINCH(folder, "hand", "included.xml"), 2, "behind.xml without a zero byte");
    memcpy(wide, "\xff\xfe", 2);
    for (size_t i = 0; i < text; i++) memcpy(wide + 2 + 2 * i, (const char[]){behind[i], 0}, 2);
    write_bytes(folder, "wide.xml", wide, 2 + 2 * text);
    program_result r = PINCH(folder, "hand", "wide.xml");
    assert_int_equal(r.status, 0);
    assert_non_null(strstr(r.out, "\"r\": 1 links"));
    program_free(&r);
    program_remove_folder(folder);
}

/* The table of drives has the constant of an actuator beside its gains. */
static void constants_of_actuators_are_shown(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    free(program_write_file(
        folder, "h.xml",
        "<mujoco><worldbody><body name='a'><geom size='1'/><body name='b'><joint name='j'/><geom size='1'/></body>"
        "</body></worldbody><actuator><general name='g' joint='j' gainprm='2' biastype='affine' biasprm='-0.375 -3 0'/>"
        "</actuator></mujoco>"));
    program_result r = PINCH(folder, "hand", "h.xml");
    assert_int_equal(r.status, 0);
    const char *head = strstr(r.out, "constant"), *row = strstr(r.out, "-0.375");
    assert_true(head && row && row > head);
    program_free(&r);
    program_remove_folder(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shipped_hands_are_whole),
        cmocka_unit_test(fingers_have_their_lengths),
        cmocka_unit_test(the_linkage_closes),
        cmocka_unit_test(the_document_is_the_hand),
        cmocka_unit_test(zero_bytes),
        cmocka_unit_test(positions_are_taken),
        cmocka_unit_test(positions_are_checked),
        cmocka_unit_test(constants_of_actuators_are_shown),
        cmocka_unit_test(wrong_calls_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
