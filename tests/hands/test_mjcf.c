/* MJCF: default classes, frames, orientations, couplings, actuators, and what is refused with its line. */

#include "support/cmocka_all.h"

#include "hand_case.h"
#include "support/program.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

static const char whole[] =
    "<mujoco model=\"m\">\n"
    "<compiler angle=\"degree\" boundmass=\"0\"/>\n"
    "<option timestep=\"0.001\"/>\n"
    "<default>\n"
    "  <joint damping=\"1\" armature=\"0.5\"/><geom size=\"0.1 0.2 0.3\"/>\n"
    "  <general biastype=\"affine\" gainprm=\"3\" biasprm=\"0 -3 -1\"/>\n"
    "  <default class=\"a\"><joint damping=\"2\"/><geom type=\"box\" mass=\"1\"/>\n"
    "    <default class=\"b\"><joint range=\"-90 90\" axis=\"0 2 0\"/><geom size=\"0.5\"/><position "
    "kp=\"7\"/></default>\n"
    "  </default>\n"
    "</default>\n"
    "<worldbody><light/><geom type=\"plane\" size=\"1 1 1\"/>\n"
    "  <body name=\"palm\" childclass=\"a\"><geom name=\"g1\"/>\n"
    "    <frame pos=\"0 0 1\" euler=\"0 0 90\"><body name=\"one\" pos=\"1 0 0\" childclass=\"b\">\n"
    "      <joint name=\"j1\"/><joint name=\"j2\" class=\"a\" type=\"slide\" axis=\"1 0 0\" ref=\"0.5\"/>"
    "<geom name=\"g2\" contype=\"0\" conaffinity=\"0\"/>\n"
    "      <frame pos=\"0 0 0.25\"><joint name=\"j3\" pos=\"0 0 0.25\" ref=\"90\"/></frame>\n"
    "      <site name=\"s1\" pos=\"0 0 1\"/></body></frame>\n"
    "    <body name=\"two\" pos=\"0 2 0\"><joint name=\"j4\" limited=\"false\" range=\"0 1\" "
    "actuatorfrcrange=\"-2 3\" frictionloss=\"0.25\" stiffness=\"4\" springref=\"180\"/>\n"
    "      <inertial pos=\"0 0 1\" mass=\"2\" fullinertia=\"2 3 4 0.1 0.2 0.3\"/><geom class=\"b\" friction=\"0.9\"/>"
    "<body><geom type=\"sphere\" size=\"0.01\" mass=\"0.5\"/></body></body>\n"
    "  </body>\n"
    "</worldbody>\n"
    "<contact><exclude body1=\"one\" body2=\"world\"/></contact>\n"
    "<tendon><fixed name=\"t\"><joint joint=\"j1\" coef=\"2\"/><joint joint=\"j4\" coef=\"-1\"/></fixed></tendon>\n"
    "<equality><joint joint1=\"j3\" joint2=\"j2\" polycoef=\"0.5 2 0 0 0\"/>"
    "<connect body1=\"one\" body2=\"two\" anchor=\"0 0 0\"/><connect site1=\"s1\" site2=\"s1\" active=\"false\"/>"
    "</equality>\n"
    "<actuator><general joint=\"j1\"/><position name=\"p\" tendon=\"t\" class=\"b\" kv=\"4\" forcerange=\"-1 2\"/>"
    "<motor joint=\"j4\" gear=\"5\" ctrlrange=\"-1 1\"/><velocity joint=\"j2\" kv=\"6\"/>"
    "<position joint=\"j1\" kp=\"2\" dampratio=\"1\" inheritrange=\"0.5\"/></actuator>\n"
    "<sensor/><keyframe/>\n"
    "</mujoco>\n";

static void classes_and_frames(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    hand *h = hand_from_text(folder, "h.xml", whole);
    assert_true(h->is_mjcf);
    assert_int_equal(h->link_count, 4);
    assert_int_equal(h->body_count, 3);
    assert_string_equal(h->links[3].name, "body_3");
    const hand_joint *j = h->joints;
    assert_int_equal(h->joint_count, 4);
    assert_true(j[0].damping == 2 && j[0].armature == 0.5 && j[0].axis[1] == 1);
    assert_close(j[0].upper, PI / 2, 1e-15);
    assert_true(j[1].type == HAND_SLIDER && j[1].reference == 0.5 && !j[1].limited && j[1].axis[0] == 1);
    assert_numbers(j[2].anchor, (double[]){0, 0, 0.5}, 3, 1e-15);
    assert_close(j[2].reference, PI / 2, 1e-15);
    assert_true(!j[3].limited && j[3].least_effort == -2 && j[3].effort == 3 && j[3].friction == 0.25);
    assert_true(j[3].stiffness == 4 && fabs(j[3].spring_reference - PI) < 1e-15);
    /* a class with one number in size replaces only the first */
    const hand_geom *g = h->geoms;
    assert_int_equal(h->geom_count, 4);
    assert_numbers(g[0].size, (double[]){0.1, 0.2, 0.3}, 3, 0);
    assert_numbers(g[1].size, (double[]){0.5, 0.2, 0.3}, 3, 0);
    assert_true(g[0].collides && !g[1].collides);
    assert_true(g[2].friction[0] == 0.9 && g[2].friction[1] == 0.005 && g[0].friction[0] == -1);
    /* masses: from geoms, and from <inertial>, to which the geom adds nothing */
    assert_true(h->links[0].mass.mass == 1 && h->links[1].mass.mass == 1 && h->links[2].mass.mass == 2);
    assert_numbers(h->links[2].mass.inertia, (double[]){2, 0.1, 0.2, 0.1, 3, 0.3, 0.2, 0.3, 4}, 9, 1e-15);
    assert_close(h->bodies[2].mass.mass, 2.5, 1e-15);
    assert_close(h->links[1].mass.inertia[0], (0.2 * 0.2 + 0.3 * 0.3) / 3, 1e-15);

    hand_pose poses[4];
    double q[4] = {0, 0.5, PI / 2, 0};
    hand_kinematics(h, q, poses);
    assert_numbers(poses[1].position, (double[]){0, 1, 1}, 3, 1e-15);
    assert_orientation(poses[1].orientation, (double[]){sqrt(0.5), 0, 0, sqrt(0.5)}, 1e-15);
    /* j3 turns by 90 degrees about the y of the link, at half a metre above it: with the frame's turn, towards -y */
    q[2] = PI;
    hand_kinematics(h, q, poses);
    assert_numbers(poses[1].position, (double[]){0, 0.5, 1.5}, 3, 1e-15);
    hand_free(h);
    program_remove_folder(folder);
}

static void couplings_and_drives(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    hand *h = hand_from_text(folder, "h.xml", whole);
    assert_int_equal(h->coupling_count, 1);
    assert_int_equal(h->couplings[0].joint, 2);
    assert_int_equal(h->couplings[0].of, 1);
    /* j3 - 90 deg = 0.5 + 2 (j2 - 0.5) */
    assert_close(h->couplings[0].offset, PI / 2 + 0.5 - 1, 1e-15);
    assert_true(h->couplings[0].multiplier == 2);
    assert_int_equal(h->loop_count, 1);
    /* the origin of "one", seen from "two" */
    assert_numbers(h->loops[0].anchor[1], (double[]){0, -1, 1}, 3, 1e-15);
    assert_int_equal(h->exclude_count, 1);
    assert_int_equal(h->excludes[0].link[1], -1);
    assert_int_equal(h->tendon_count, 1);
    assert_true(h->tendons[0].count == 2 && h->tendons[0].coefficients[1] == -1);
    assert_close(h->tendons[0].rest[0], -PI, 1e-15);

    const hand_drive *d = h->drives;
    assert_int_equal(h->drive_count, 5);
    assert_true(d[0].type == HAND_POSITION && d[0].kp == 3 && d[0].kd == 1 && isinf(d[0].most_force));
    assert_true(d[1].type == HAND_POSITION && d[1].tendon == 0 && d[1].joint == -1 && d[1].kp == 7 && d[1].kd == 4);
    assert_true(d[1].least_force == -1 && d[1].most_force == 2 && isinf(d[1].most_control));
    assert_true(d[2].type == HAND_MOTOR && d[2].gain == 1 && d[2].gear == 5 && d[2].most_control == 1);
    assert_true(d[2].bias[1] == 0);
    assert_true(d[3].type == HAND_VELOCITY && d[3].kd == 6 && d[3].kp == 0);
    assert_true(d[4].kp == 2 && d[4].damping_ratio == 1 && d[4].kd == 0);
    assert_close(d[4].most_control, PI / 4, 1e-15);
    assert_int_equal(h->unmodelled_count, 0);
    assert_int_equal(h->ignored_count, 6); /* option, light, plane, inactive equality, sensor, keyframe */
    hand_free(h);
    program_remove_folder(folder);
}

#define BODY(text) "<mujoco>\n<worldbody><body name=\"a\">\n" text "\n</body></worldbody></mujoco>"
#define TWO(text)                                                                                                      \
    "<mujoco>\n<worldbody><body name=\"a\"><body name=\"b\"><joint name=\"j\"/><geom size=\"1\"/></body></body>"       \
    "</worldbody>\n" text "\n</mujoco>"

/* Every way to say the same orientation. */
static void orientations(void **state)
{
    (void)state;
    static const char *const turns[] = {
        "quat=\"2 0 0 2\"",  "axisangle=\"0 0 3 90\"", "euler=\"0 0 90\"", "xyaxes=\"0 1 0 -3 1 0\"",
        "quat=\"1 0 0 0\" ", "zaxis=\"1 0 0\"",        "zaxis=\"0 0 -2\"",
    };
    double q = sqrt(0.5);
    double expected[][4] = {{q, 0, 0, q}, {q, 0, 0, q}, {q, 0, 0, q}, {q, 0, 0, q},
                            {1, 0, 0, 0}, {q, 0, q, 0}, {0, 1, 0, 0}};
    char *folder = program_make_folder();
    for (size_t i = 0; i < sizeof turns / sizeof turns[0]; i++) {
        char text[512];
        snprintf(text, sizeof text, BODY("<geom %s size=\"1\"/>"), turns[i]);
        hand *h = hand_from_text(folder, "h.xml", text);
        assert_orientation(h->geoms[0].pose.orientation, expected[i], 1e-15);
        hand_free(h);
    }
    program_remove_folder(folder);
}

/* Lower case turns with the body, upper case about fixed axes. */
static void euler_sequences(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    double q[2][4];
    static const char *const texts[] = {
        "<mujoco><compiler angle=\"radian\" eulerseq=\"xyz\"/><worldbody><body euler=\"0.3 -0.7 1.1\"/></worldbody>"
        "</mujoco>",
        "<mujoco><compiler angle=\"radian\" eulerseq=\"ZYX\"/><worldbody><body euler=\"1.1 -0.7 0.3\"/></worldbody>"
        "</mujoco>"};
    for (int i = 0; i < 2; i++) {
        hand *h = hand_from_text(folder, "h.xml", texts[i]);
        memcpy(q[i], h->links[0].pose.orientation, sizeof q[i]);
        hand_free(h);
    }
    assert_orientation(q[0], q[1], 1e-15);
    /* Rx Ry Rz takes z to Rx Ry z */
    double z[3] = {0, 0, 1}, to[3];
    scene_rotate(q[0], z, to);
    assert_numbers(to, (double[]){sin(-0.7), -sin(0.3) * cos(-0.7), cos(0.3) * cos(-0.7)}, 3, 1e-15);
    program_remove_folder(folder);
}

static void includes(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    free(program_write_file(folder, "parts.xml",
                            "<x><body name=\"inner\"><geom size=\"1\"/></body><include file=\"more.xml\"/></x>"));
    free(program_write_file(folder, "more.xml", "<x>\n<body name=\"last\">\n<geom size=\"bad\"/></body></x>"));
    char *path =
        program_write_file(folder, "h.xml", "<mujoco><worldbody><include file=\"parts.xml\"/></worldbody></mujoco>");
    hand *h;
    hand_error error;
    /* the error is in the file in which it stands */
    assert_int_equal(hand_load(path, NULL, 0, &h, &error), HAND_BAD_INPUT);
    assert_non_null(strstr(error.text, "more.xml:3: <geom"));
    free(program_write_file(folder, "more.xml", "<x><body name=\"last\"/></x>"));
    assert_int_equal(hand_load(path, NULL, 0, &h, &error), HAND_OK);
    assert_int_equal(h->link_count, 2);
    hand_free(h);
    free(program_write_file(folder, "more.xml", "<x><include file=\"parts.xml\"/></x>"));
    assert_int_equal(hand_load(path, NULL, 0, &h, &error), HAND_BAD_INPUT);
    assert_non_null(strstr(error.text, "not included twice"));
    free(path);
    program_remove_folder(folder);
}

/* A joint that two couplings name follows one of them, and the other one is turned round: all conditions hold. */
static void couplings_form_trees(void **state)
{
    (void)state;
    static const char joint[] = "<body><joint name=\"%c\"/><geom size=\"1\"/></body>";
    char *folder = program_make_folder(), text[2048] = "<mujoco><worldbody>";
    for (char name = 'a'; name <= 'f'; name++) snprintf(text + strlen(text), sizeof text - strlen(text), joint, name);
    strcat(text,
           "</worldbody><equality><joint joint1=\"a\" joint2=\"b\" polycoef=\"1 2 0 0 0\"/>"
           "<joint joint1=\"a\" joint2=\"c\" polycoef=\"0 0.5 0 0 0\"/>"
           "<joint joint1=\"d\" joint2=\"e\" polycoef=\"0 -1 0 0 0\"/>"
           "<joint joint1=\"d\" joint2=\"b\" polycoef=\"3 4 0 0 0\"/>"
           "<joint joint1=\"f\" polycoef=\"0.25 0 0 0 0\"/><joint joint1=\"f\" joint2=\"e\"/></equality></mujoco>");
    hand *h = hand_from_text(folder, "h.xml", text);
    double q[6] = {0};
    bool given[6] = {false};
    assert_int_equal(h->coupling_count, 6);
    for (int i = 0; i < 6; i++) assert_true(h->joints[i].coupling >= 0); /* f is held, and all hang on it */
    hand_follow_couplings(h, given, q);
    assert_close(q[5], 0.25, 1e-15);
    assert_close(q[4], q[5], 1e-15);
    assert_close(q[3], -q[4], 1e-15);
    assert_close(q[3], 3 + 4 * q[1], 1e-15);
    assert_close(q[0], 1 + 2 * q[1], 1e-15);
    assert_close(q[0], 0.5 * q[2], 1e-15);
    hand_free(h);
    program_remove_folder(folder);
}

/* What changes the physics and can be left out is listed; PID plugins become position drives. */
static void unmodelled_parts(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    hand *h = hand_from_text(
        folder, "h.xml",
        TWO("<extension><plugin plugin=\"mujoco.pid\"><instance name=\"i\"><config key=\"kp\" value=\"3\"/>"
            "<config key=\"ki\" value=\"2\"/><config key=\"kd\" value=\"0.5\"/></instance></plugin></extension>"
            "<tendon><spatial name=\"s\"/></tendon><actuator><position tendon=\"s\"/>"
            "<plugin plugin=\"mujoco.pid\" instance=\"i\" joint=\"j\" forcerange=\"-1 1\"/></actuator>"));
    assert_int_equal(h->unmodelled_count, 3);
    assert_int_equal(h->drive_count, 1);
    assert_true(h->drives[0].type == HAND_POSITION && h->drives[0].kp == 3 && h->drives[0].kd == 0.5);
    assert_true(h->drives[0].most_force == 1);
    hand_free(h);
    program_remove_folder(folder);
}

/* Pairs of geoms and welds to what a program moves are listed; the hand is what it is without them. */
static void pairs_and_mocap_bodies(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    hand *h =
        hand_from_text(folder, "h.xml",
                       "<mujoco><worldbody><body name=\"handle\" mocap=\"true\"/><body name=\"a\">"
                       "<geom name=\"g\" size=\"1\"/><body name=\"b\"><joint/><geom name=\"f\" size=\"1\"/></body>"
                       "</body></worldbody><contact><pair geom1=\"g\" geom2=\"f\" condim=\"1\"/>"
                       "<exclude body1=\"a\" body2=\"b\"/><pair geom1=\"f\" geom2=\"g\"/></contact><equality>"
                       "<weld body1=\"handle\" body2=\"a\"/><weld body1=\"b\" body2=\"handle\"/></equality></mujoco>");
    assert_int_equal(h->unmodelled_count, 2);
    assert_string_equal(h->unmodelled[0].what, "contact of a pair of geoms");
    assert_string_equal(h->unmodelled[1].what, "weld to a mocap body");
    assert_true(h->unmodelled[0].count == 2 && h->unmodelled[1].count == 2);
    assert_int_equal(h->ignored_count, 1);
    assert_int_equal(h->exclude_count, 1);
    assert_int_equal(h->loop_count, 0);
    assert_int_equal(h->body_count, 2);
    hand_free(h);
    program_remove_folder(folder);
}

/* Each replica is further by the offset, as the one before sees it, and the angles add up: places and turns are those
 * of MuJoCo 3.3. */
static void replicas(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double position[3], orientation[4];
    } bodies[] = {{"b_0", {1.18508, 2.03264, 2.9316}, {0.95155, 0.2393, 0.18931, 0.03813}},
                  {"b_1", {2.04827, 2.7274, 2.78369}, {0.73856, 0.48899, 0.44857, 0.11915}},
                  {"b_2", {2.64145, 3.61145, 2.62448}, {0.50265, 0.51338, 0.6954, 0.01396}}};
    char *folder = program_make_folder();
    hand *h = hand_from_text(
        folder, "h.xml",
        "<mujoco><compiler eulerseq=\"zyx\"/><worldbody><body name=\"a\" pos=\"1 2 3\" euler=\"10 20 30\">"
        "<geom size=\".1\"/><replicate count=\"3\" offset=\"1 0.5 0\" euler=\"20 30 40\" sep=\"_\">"
        "<body name=\"b\" pos=\".2 0 0\"><joint name=\"k\"/><geom "
        "size=\".1\"/></body></replicate></body></worldbody></mujoco>");
    hand_pose poses[4];
    double q[3] = {0};
    assert_int_equal(h->link_count, 4);
    hand_kinematics(h, q, poses);
    for (int i = 0; i < 3; i++) {
        const hand_pose *p = &poses[hand_find_link(h, bodies[i].name)];
        assert_numbers(p->position, bodies[i].position, 3, 1e-5);
        assert_orientation(p->orientation, bodies[i].orientation, 1e-5);
    }
    hand_free(h);
    program_remove_folder(folder);
}

/* The innermost suffix comes first, and has as many digits as the count. What refers to replicas is replicated, too. */
static void names_of_replicas(void **state)
{
    (void)state;
    char *folder = program_make_folder(), name[16];
    hand *h = hand_from_text(
        folder, "h.xml",
        "<mujoco><worldbody><body name=\"palm\"><geom size=\"1\"/><body name=\"c\"><joint name=\"k\"/><geom "
        "size=\"1\"/>"
        "</body><replicate count=\"2\"><replicate count=\"10\" sep=\"-\"><body name=\"b\"><joint name=\"j\"/>"
        "<geom size=\"1\"/></body></replicate></replicate></body></worldbody>"
        "<contact><exclude body1=\"palm\" body2=\"b\"/><exclude body1=\"palm\" body2=\"c\"/></contact>"
        "<tendon><fixed name=\"t\"><joint joint=\"j\" coef=\"2\"/><joint joint=\"k\" coef=\"3\"/></fixed></tendon>"
        "<equality><joint joint1=\"j\" joint2=\"k\"/></equality>"
        "<actuator><motor name=\"m\" tendon=\"t\"/><motor name=\"n\" joint=\"k\"/><motor joint=\"j-031\"/></actuator>"
        "</mujoco>");
    assert_int_equal(h->link_count, 22);
    assert_int_equal(h->joint_count, 21);
    assert_int_equal(h->exclude_count, 21);
    assert_int_equal(h->tendon_count, 20);
    assert_int_equal(h->coupling_count, 20);
    assert_int_equal(h->drive_count, 22);
    for (int i = 0; i < 20; i++) {
        snprintf(name, sizeof name, "j-%02d%d", i % 10, i / 10);
        int joint = hand_find_joint(h, name);
        assert_true(joint >= 0);
        int tendon = h->drives[i].tendon;
        bool found = false;
        for (int k = 0; k < 20; k++) found = found || h->tendons[k].joints[0] == joint;
        assert_true(found && tendon >= 0);
        assert_string_equal(h->tendons[tendon].name + 1, h->drives[i].name + 1);
        assert_string_equal(h->joints[h->tendons[tendon].joints[0]].name + 1, h->drives[i].name + 1);
        assert_string_equal(h->joints[h->tendons[tendon].joints[1]].name, "k");
        assert_string_equal(h->joints[h->couplings[i].of].name, "k");
    }
    assert_string_equal(h->drives[20].name, "n");
    assert_string_equal(h->joints[h->drives[21].joint].name, "j-031");
    hand_free(h);
    program_remove_folder(folder);
}

/* A contact without friction, or with more than sliding friction, is what a scene says of its links. */
static void contact_dimensions(void **state)
{
    (void)state;
    static const char *const values[] = {"1", "3", "4"};
    for (int k = 0; k < 3; k++) {
        char text[256], *folder = program_make_folder();
        snprintf(text, sizeof text,
                 "<mujoco><default><geom condim=\"%s\"/></default><worldbody><body name=\"a\"><geom size=\"1\"/>"
                 "<geom size=\"1\" contype=\"0\" conaffinity=\"0\"/></body></worldbody></mujoco>",
                 values[k]);
        hand *h = hand_from_text(folder, "h.xml", text);
        assert_int_equal(h->unmodelled_count, k != 1);
        if (k != 1) assert_string_equal(h->unmodelled[0].what, "condim of a geom");
        hand_free(h);
        program_remove_folder(folder);
    }
    static const hand_fault faults[] = {
        {"<mujoco>\n<worldbody><body><geom size=\"1\" condim=\"2\"/></body></worldbody></mujoco>", "condim",
         "expected 1, 3, 4 or 6 in condim"},
        {"<mujoco>\n<worldbody><body gravcomp=\"-1\"><geom size=\"1\"/></body></worldbody></mujoco>", "gravcomp",
         "expected a gravcomp that is not negative"},
    };
    hand_faults_are_named("h.xml", faults, 2);
}

/* A scene of a collection: what only floats beside the hand is left out and listed; empty numbers are not given. */
static void things_beside_the_hand(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    hand *h = hand_from_text(folder, "h.xml",
                             "<mujoco><default><default class=\"loose\"><joint type=\"free\"/></default></default>"
                             "<worldbody><body name=\"a\"><freejoint/><geom size=\"1\" mass=\"1\"/>"
                             "<body name=\"b\"><joint name=\"j\" range=\"\"/>"
                             "<geom size=\"1\" mass=\"2\" rgba=\"\" pos=\" \"/></body></body>"
                             "<body name=\"cube\"><freejoint/><geom size=\"1\" mass=\"4\"/></body>"
                             "<body name=\"ball\"><joint type=\"free\"/><geom size=\"1\"/></body>"
                             "<body name=\"cup\"><joint class=\"loose\"/><geom size=\"1\"/></body>"
                             "<body name=\"lid\" childclass=\"loose\"><joint/><geom size=\"1\"/></body>"
                             "</worldbody></mujoco>");
    assert_int_equal(h->body_count, 2);
    assert_int_equal(h->joint_count, 1);
    assert_false(h->joints[0].limited);
    assert_true(hand_total_mass(h) == 3);
    assert_int_equal(h->ignored_count, 2);
    assert_string_equal(h->ignored[0].what, "freejoint");
    assert_string_equal(h->ignored[1].what, "floating body beside the hand");
    assert_int_equal(h->ignored[1].count, 4);
    hand_free(h);
    program_remove_folder(folder);
}

/* Without `limited`, a range of two zeros is none. One the wrong way around is none either, and that is said. */
static void ranges_that_limit_nothing(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    hand *h =
        hand_from_text(folder, "h.xml",
                       "<mujoco><worldbody><body><joint name=\"a\" range=\"0 0\"/><joint name=\"b\" range=\"9 -9\"/>"
                       "<geom size=\"1\"/></body></worldbody></mujoco>");
    assert_int_equal(h->joint_count, 2);
    assert_false(h->joints[0].limited || h->joints[1].limited);
    assert_int_equal(h->ignored_count, 1);
    assert_string_equal(h->ignored[0].what, "range with the larger number first");
    assert_int_equal(h->ignored[0].count, 1);
    hand_free(h);
    program_remove_folder(folder);
}

#define FLOATING "<body><freejoint/><geom size=\"1\"/><body><joint/><geom size=\"1\"/></body></body>"

static const hand_fault faults[] = {
    {"<mujoco><worldbody>\n<body><freejoint/></body><body><freejoint/></body></worldbody></mujoco>", "<body",
     "expected a free joint only in the one outermost body"},
    {"<mujoco><worldbody>\n" FLOATING FLOATING "</worldbody></mujoco>", "<body",
     "expected a free joint only in the one outermost body"},
    {BODY("<joint range=\"\" limited=\"true\"/><geom size=\"1\"/>"), "<joint", "expected a range"},
    {"<mujoco/>", NULL, "expected at least one link or body"},
    {"<mujoco>\n<deformable/></mujoco>", "<deformable", "not supported"},
    {"<mujoco>\n<wordbody/></mujoco>", "<wordbody", "not supported; there are"},
    {"<mujoco>\n<compiler angel=\"radian\"/></mujoco>", "<compiler", "unknown attribute angel"},
    {"<mujoco>\n<compiler angle=\"grad\"/></mujoco>", "<compiler", "expected one of radian degree in angle, not"},
    {"<mujoco>\n<compiler coordinate=\"global\"/></mujoco>", "<compiler", "global coordinates"},
    {"<mujoco>\n<compiler eulerseq=\"xyw\"/></mujoco>", "<compiler", "letters"},
    {"<mujoco>\n<include file=\"none.xml\"/></mujoco>", "<include", "expected a readable file"},
    {"<mujoco><default>\n<default class=\"a\"/><default class=\"a\" /></default></mujoco>", "<default class",
     "no other class"},
    {BODY("<geom class=\"x\"/>"), "<geom", "expected the name of a default class, not \"x\""},
    {BODY("<geom/>"), "<geom", "expected 1 positive number in size"},
    {BODY("<geom type=\"box\" size=\"1 1\"/>"), "<geom", "expected 3 positive numbers in size"},
    {BODY("<geom size=\"1 2 3 4\"/>"), "<geom", "expected 1 to 3 numbers in size"},
    {BODY("<geom size=\"1\" mas=\"1\"/>"), "<geom", "unknown attribute mas"},
    {BODY("<geom type=\"hfield\"/>"), "<geom", "hfield is not supported"},
    {BODY("<geom type=\"mesh\" mesh=\"m\"/>"), "<geom", "expected the name of a mesh in mesh, not \"m\""},
    {BODY("<geom type=\"sphere\" size=\"1\" fromto=\"0 0 0 0 0 1\"/>"), "<geom", "expected no fromto"},
    {BODY("<geom type=\"capsule\" size=\"1\" fromto=\"0 0 1 0 0 1\"/>"), "<geom", "two different points"},
    {BODY("<geom type=\"capsule\" size=\"1\" pos=\"1 0 0\" fromto=\"0 0 1 0 0 2\"/>"), "<geom", "either pos or fromto"},
    {BODY("<geom size=\"1\" quat=\"1 0 0 0\" euler=\"0 0 0\"/>"), "<geom", "expected one of quat"},
    {BODY("<geom size=\"1\" quat=\"0 0 0 0\"/>"), "<geom", "quaternion that is not 0"},
    {BODY("<geom size=\"1\" zaxis=\"0 0 0\"/>"), "<geom", "axes with a direction in zaxis"},
    {BODY("<geom size=\"1\" mass=\"-1\"/>"), "<geom", "a mass that is not negative"},
    {BODY("<joint type=\"ball\"/>"), "<joint", "the type ball is not supported"},
    {BODY("<joint axis=\"0 0 0\"/><geom size=\"1\"/>"), "<joint", "axis with a direction"},
    {BODY("<joint limited=\"true\"/>"), "<joint", "expected a range"},
    {BODY("<joint damping=\"1 2\"/>"), "<joint", "damping with more than one number"},
    {BODY("<joint/>"), "<body", "expected a mass"},
    {BODY("<flexcomp/>"), "<flexcomp", "not supported in a body"},
    {BODY("<composite/>"), "<composite", "not supported in a body"},
    {BODY("<inertial mass=\"1\" pos=\"0 0 0\" diaginertia=\"1 1 3\"/>"), "<inertial", "that a body can have"},
    {BODY("<inertial mass=\"1\" diaginertia=\"1 1 1\"/>"), "<inertial", "expected an attribute pos"},
    {BODY("<body name=\"a\" />"), "<body name=\"a\" />", "expected a name of its own"},
    {"<mujoco><worldbody>\n<joint/></worldbody></mujoco>", "<joint", "the world does not move"},
    {TWO("<contact><pear/></contact>"), "<contact", "not supported in <contact>; there are <exclude> and <pair>"},
    {"<mujoco>\n<body name=\"a\"/></mujoco>", "<body", "expected it in a <worldbody>"},
    {BODY("<replicate/>"), "<replicate", "expected an attribute count"},
    {BODY("<replicate count=\"0\"/>"), "<replicate", "expected a whole count from 1 to 100000, not 0"},
    {BODY("<replicate count=\"1.5\"/>"), "<replicate", "expected a whole count"},
    {BODY("<replicate count=\"2\" offset=\"1 0\"/>"), "<replicate", "expected 3 numbers in offset"},
    {BODY("<replicate count=\"2\" pos=\"1 0 0\"/>"), "<replicate", "unknown attribute pos"},
    {BODY("<replicate count=\"400\"><replicate count=\"300\"><geom size=\"1\"/></replicate></replicate>"), "<replicate",
     "expected replicates of at most 100000 elements"},
    {BODY("<replicate count=\"2\"><geom size=\"bad\"/></replicate>"), "<replicate", "expected 1 to 3 numbers in size"},
    {TWO("<contact><exclude body1=\"a\" body2=\"c\"/></contact>"), "<contact", "name of a body in body2, not \"c\""},
    {TWO("<equality><weld body1=\"a\"/></equality>"), "<equality", "not supported in <equality> but to a mocap body"},
    {TWO("<equality><joint joint1=\"j\" joint2=\"j\"/></equality>"), "<equality", "would follow itself"},
    {TWO("<equality><joint joint1=\"j\" polycoef=\"0 1 2 0 0\"/></equality>"), "<equality", "degree above one"},
    {TWO("<equality><joint joint1=\"j\"/><joint joint1=\"j\"/></equality>"), "<equality",
     "leave joint \"j\" one position"},
    {TWO("<tendon><fixed/></tendon>"), "<tendon", "at least one <joint>"},
    {TWO("<tendon><fixed springlength=\"-2 -3\"><joint joint=\"j\" coef=\"1\"/></fixed></tendon>"), "<tendon",
     "not larger"},
    {TWO("<actuator><muscle joint=\"j\"/></actuator>"), "<actuator", "not supported in <actuator>"},
    {TWO("<actuator><motor joint=\"x\"/></actuator>"), "<actuator", "name of a joint in joint, not \"x\""},
    {TWO("<actuator><motor/></actuator>"), "<actuator", "a joint or a tendon"},
    {TWO("<actuator><general joint=\"j\" gaintype=\"affine\"/></actuator>"), "<actuator", "gaintype fixed"},
    {TWO("<actuator><general joint=\"j\" dyntype=\"filter\"/></actuator>"), "<actuator", "no dynamics"},
    {TWO("<actuator><position joint=\"j\" kv=\"1\" dampratio=\"1\"/></actuator>"), "<actuator", "either kv or"},
};

static void faults_have_lines(void **state)
{
    (void)state;
    hand_faults_are_named("h.xml", faults, sizeof faults / sizeof faults[0]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(classes_and_frames),
        cmocka_unit_test(couplings_and_drives),
        cmocka_unit_test(orientations),
        cmocka_unit_test(euler_sequences),
        cmocka_unit_test(includes),
        cmocka_unit_test(unmodelled_parts),
        cmocka_unit_test(pairs_and_mocap_bodies),
        cmocka_unit_test(replicas),
        cmocka_unit_test(names_of_replicas),
        cmocka_unit_test(contact_dimensions),
        cmocka_unit_test(ranges_that_limit_nothing),
        cmocka_unit_test(things_beside_the_hand),
        cmocka_unit_test(couplings_form_trees),
        cmocka_unit_test(faults_have_lines),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
