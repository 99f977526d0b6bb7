/* URDF: what every element means, and what is refused with its line. */

#include "support/cmocka_all.h"

#include "hand_case.h"
#include "support/program.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define MASS(m)                                                                                                        \
    "<inertial><mass value=\"" m "\"/><inertia ixx=\"1e-4\" ixy=\"0\" ixz=\"0\" iyy=\"1e-4\" iyz=\"0\" "               \
    "izz=\"1e-4\"/></inertial>"
#define ENDS(a, b) "<parent link=\"" a "\"/><child link=\"" b "\"/>"

static const char whole[] =
    "<robot name=\"r\">\n"
    "<link name=\"tip\">" MASS(
        "0.1") "<collision><geometry><sphere radius=\"0.01\"/></geometry></collision></link>\n"
               "<link name=\"base\"/>\n"
               "<link name=\"a\"><inertial><origin xyz=\"0 0 0.1\" rpy=\"0 0 1.5707963267948966\"/><mass "
               "value=\"0.5\"/>"
               "<inertia ixx=\"1e-3\" ixy=\"0\" ixz=\"0\" iyy=\"2e-3\" iyz=\"0\" izz=\"2.5e-3\"/></inertial>\n"
               "<collision name=\"c\"><origin xyz=\"0 1 0\"/><geometry><box size=\"0.2 0.4 "
               "0.6\"/></geometry></collision>\n"
               "<visual><geometry><cylinder radius=\"0.1\" length=\"0.4\"/></geometry>"
               "<material name=\"red\"/></visual><sensor/></link>\n"
               "<link name=\"b\">" MASS("0.2") "</link><link name=\"c\">" MASS(
                   "0.3") "</link>\n"
                          "<joint name=\"j1\" type=\"revolute\">" ENDS(
                              "base",
                              "a") "<origin xyz=\"1 2 3\" rpy=\"0.1 0.2 0.3\"/>"
                                   "<axis xyz=\"0 3 4\"/><limit lower=\"-1\" upper=\"2\" effort=\"5\" velocity=\"6\"/>"
                                   "<dynamics damping=\"0.7\" friction=\"0.8\"/></joint>\n"
                                   "<joint name=\"j2\" type=\"continuous\">" ENDS(
                                       "a",
                                       "b") "<limit effort=\"0\" velocity=\"0\"/></joint>\n"
                                            "<joint name=\"j3\" type=\"prismatic\">" ENDS(
                                                "a",
                                                "c") "<axis xyz=\"0 0 -1\"/><limit effort=\"9\" velocity=\"1\"/>"
                                                     "<mimic joint=\"j1\" multiplier=\"-2\" offset=\"0.25\"/></joint>\n"
                                                     "<joint name=\"f\" type=\"fixed\">" ENDS(
                                                         "b", "tip") "<origin xyz=\"0 0 0.5\"/></joint>\n"
                                                                     "<material name=\"red\"><color rgba=\"1 0 0 "
                                                                     "0.5\"/></material><gazebo/></robot>\n";

static void every_element(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    hand *h = hand_from_text(folder, "h.urdf", whole);
    assert_false(h->is_mjcf);
    assert_int_equal(h->link_count, 5);
    assert_int_equal(h->body_count, 4);
    assert_int_equal(h->joint_count, 3);
    const hand_link *a = &h->links[hand_find_link(h, "a")], *tip = &h->links[hand_find_link(h, "tip")];
    assert_string_equal(h->links[0].name, "base");
    assert_string_equal(h->bodies[0].name, "base");
    /* turned by a quarter about z: x and y of the inertia change places */
    assert_numbers(a->mass.inertia, (double[]){2e-3, 0, 0, 0, 1e-3, 0, 0, 0, 2.5e-3}, 9, 1e-18);
    assert_numbers(a->mass.centre, (double[]){0, 0, 0.1}, 3, 0);
    assert_int_equal(tip->body, h->links[hand_find_link(h, "b")].body);
    const hand_body *b = &h->bodies[tip->body];
    assert_close(b->mass.mass, 0.3, 1e-15);
    assert_close(b->mass.centre[2], 0.1 * 0.5 / 0.3, 1e-15);
    /* Steiner: two masses at the ends of a rod of half a metre */
    assert_close(b->mass.inertia[0], 2e-4 + 0.1 * 0.2 / 0.3 * 0.25, 1e-15);
    assert_close(b->mass.inertia[8], 2e-4, 1e-18);

    const hand_joint *j1 = &h->joints[hand_find_joint(h, "j1")], *j2 = &h->joints[hand_find_joint(h, "j2")];
    const hand_joint *j3 = &h->joints[hand_find_joint(h, "j3")];
    assert_numbers(j1->axis, (double[]){0, 0.6, 0.8}, 3, 1e-16);
    assert_true(j1->limited && j1->lower == -1 && j1->upper == 2 && j1->effort == 5 && j1->least_effort == -5);
    assert_true(j1->velocity == 6 && j1->damping == 0.7 && j1->friction == 0.8);
    assert_true(!j2->limited && isinf(j2->effort) && isinf(j2->velocity) && j2->axis[0] == 1);
    assert_true(j3->type == HAND_SLIDER && j3->limited && j3->lower == 0 && j3->upper == 0);
    assert_int_equal(h->coupling_count, 1);
    assert_true(h->couplings[0].multiplier == -2 && h->couplings[0].offset == 0.25);
    assert_string_equal(h->joints[h->couplings[0].of].name, "j1");

    assert_int_equal(h->geom_count, 3);
    assert_true(h->geoms[0].type == HAND_BOX && h->geoms[0].size[2] == 0.3 && h->geoms[0].pose.position[1] == 1);
    assert_true(h->geoms[1].type == HAND_CYLINDER && !h->geoms[1].collides && h->geoms[1].colour[3] == 0.5);
    assert_true(h->geoms[2].pose.position[2] == 0.5); /* in the frame of the body */
    int last = -1, tips = 0;
    for (size_t k = 0; k < h->body_count; k++) {
        if (hand_tip_of(h, k) < 0) continue;
        last = hand_tip_of(h, k);
        tips++;
    }
    assert_int_equal(tips, 1);
    assert_string_equal(h->links[last].name, "tip");
    assert_int_equal(h->ignored_count, 2);
    assert_int_equal(h->unmodelled_count, 0);
    assert_close(hand_total_mass(h), 1.1, 1e-15);
    hand_free(h);
    program_remove_folder(folder);
}

/* R = Rz(yaw) Ry(pitch) Rx(roll), written out. */
static void roll_pitch_yaw(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    hand *h = hand_from_text(folder, "h.urdf", whole);
    double r = 0.1, p = 0.2, y = 0.3, q[3] = {0, 0, 0}, matrix[9];
    double expected[9] = {cos(y) * cos(p),
                          cos(y) * sin(p) * sin(r) - sin(y) * cos(r),
                          cos(y) * sin(p) * cos(r) + sin(y) * sin(r),
                          sin(y) * cos(p),
                          sin(y) * sin(p) * sin(r) + cos(y) * cos(r),
                          sin(y) * sin(p) * cos(r) - cos(y) * sin(r),
                          -sin(p),
                          cos(p) * sin(r),
                          cos(p) * cos(r)};
    hand_pose poses[5];
    hand_kinematics(h, q, poses);
    const hand_pose *a = &poses[hand_find_link(h, "a")];
    pose_matrix(a->orientation, matrix);
    assert_numbers(matrix, expected, 9, 1e-15);
    assert_numbers(a->position, (double[]){1, 2, 3}, 3, 0);
    hand_free(h);
    program_remove_folder(folder);
}

/* SDF has -1 where there is no bound, and files that were made of it have it still. */
static void minus_one_is_no_bound(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    hand *h = hand_from_text(folder, "h.urdf",
                             "<robot name=\"r\"><link name=\"a\"/><link name=\"b\">" MASS(
                                 "1") "</link>"
                                      "<joint name=\"j\" type=\"continuous\">" ENDS(
                                          "a", "b") "<limit effort=\"-1\" velocity=\"-1.0\"/></joint></robot>");
    assert_true(isinf(h->joints[0].effort) && isinf(h->joints[0].velocity) && h->joints[0].effort > 0);
    assert_int_equal(h->ignored_count, 2);
    hand_free(h);
    program_remove_folder(folder);
}

static void couplings_are_followed(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    hand *h = hand_from_text(folder, "h.urdf", whole);
    double q[3] = {0};
    bool given[3] = {false};
    int j1 = hand_find_joint(h, "j1"), j3 = hand_find_joint(h, "j3");
    q[j1] = 0.5;
    hand_follow_couplings(h, given, q);
    assert_close(q[j3], 0.25 - 1, 1e-15);
    given[j3] = true;
    q[j3] = 7;
    hand_follow_couplings(h, given, q);
    assert_true(q[j3] == 7);
    hand_free(h);
    program_remove_folder(folder);
}

#define ROBOT(text) "<robot name=\"r\">\n" text "\n</robot>"
#define TWO(joint)  ROBOT("<link name=\"a\"/>\n<link name=\"b\">" MASS("1") "</link>\n" joint)
#define LIMIT       "<limit lower=\"0\" upper=\"1\" effort=\"1\" velocity=\"1\"/>"

static const hand_fault faults[] = {
    {"", NULL, "expected an XML document"},
    {"<robot>\n<link name=\"a\">\n</robot>", NULL, "expected an XML document"},
    {"<!DOCTYPE robot [<!ENTITY a \"b\">]><robot/>", NULL, "document type"},
    {"<sdf/>", "<sdf", "expected a root element <robot> (URDF) or <mujoco> (MJCF)"},
    {"<robot/>", "<robot", "expected a link without a joint above it"},
    {ROBOT("<link/>"), "<link/>", "expected an attribute name"},
    {ROBOT("<link name=\"a\"/>\n<link name=\"a\" />"), "<link name=\"a\" />", "expected a name of its own"},
    {ROBOT("<link name=\"a\"/>\n<link name=\"b\"/>"), "<link name=\"b\"/>", "expected one link without a joint above"},
    {TWO("<joint name=\"j\" type=\"revolute\">" ENDS("a", "b") "</joint>"), "<joint", "expected <limit>"},
    {TWO("<joint name=\"j\" type=\"continuous\">" ENDS("a", "b") "\n<origin xzy=\"0 0 1\"/></joint>"), "<origin",
     "unknown attribute xzy; there are xyz rpy"},
    {TWO("<joint name=\"j\" type=\"continuous\">" ENDS("a", "b") "\n<origin xyz=\"0 0 1\" ryp=\"0 0 1\"/></joint>"),
     "<origin", "unknown attribute ryp; there are xyz rpy"},
    {TWO("<joint name=\"j\" type=\"continuous\">" ENDS("a", "b") "\n<limit lowr=\"-1\"/></joint>"), "<limit",
     "unknown attribute lowr; there are lower upper effort velocity"},
    {TWO("<joint name=\"j\" type=\"continuous\">" ENDS("a", "b") "\n<dynamics dampin=\"1\"/></joint>"), "<dynamics",
     "unknown attribute dampin; there are damping friction"},
    {TWO("<joint name=\"j\" type=\"continuous\">" ENDS("a", "b") "\n<mimic joint=\"j\" multipler=\"2\"/></joint>"),
     "<mimic", "unknown attribute multipler; there are joint multiplier offset"},
    {TWO("<joint name=\"j\" type=\"continuous\">" ENDS(
         "a", "b") "\n<axis xyz=\"0 0 1\"/><mimic joint=\"j\" ofset=\"2\"/></joint>"),
     "<axis", "unknown attribute ofset; there are joint multiplier offset"},
    {TWO("<joint name=\"j\" type=\"revolute\">" ENDS("a", "b") "\n<limit lower=\"2\" upper=\"1\"/></joint>"), "<limit",
     "expected lower <= upper, not 2 and 1"},
    {TWO("<joint name=\"j\" type=\"revolute\">" ENDS("a", "b") "\n<limit upper=\"1\" effort=\"-3\"/></joint>"),
     "<limit", "expected effort >= 0, not -3"},
    {TWO("<joint name=\"j\" type=\"continuous\">" ENDS("a", "b") "\n<limit velocity=\"-0.5\"/></joint>"), "<limit",
     "expected velocity >= 0, not -0.5"},
    {TWO("<joint name=\"j\" type=\"revolute\">" ENDS("a", "b") "\n<axis xyz=\"0 0 0\"/>" LIMIT "</joint>"), "<axis",
     "expected an axis with a direction"},
    {TWO("<joint name=\"j\" type=\"revolute\">" ENDS("a", "b") "\n<axis xyz=\"0 0\"/>" LIMIT "</joint>"), "<axis",
     "expected 3 numbers in xyz, not \"0 0\""},
    {TWO("<joint name=\"j\" type=\"revolute\">" ENDS("a", "b") "\n<axis xyz=\"0 nan 1\"/>" LIMIT "</joint>"), "<axis",
     "expected 3 numbers"},
    {TWO("<joint name=\"j\" type=\"floating\">" ENDS("a", "b") "</joint>"), "<joint",
     "expected the type revolute, continuous, prismatic or fixed, not \"floating\""},
    {TWO("<joint name=\"j\" type=\"fixed\">\n<parent link=\"a\"/>\n<child link=\"x\"/></joint>"), "<child",
     "expected the name of a link in link, not \"x\""},
    {TWO("<joint name=\"j\" type=\"fixed\"><parent link=\"a\"/></joint>"), "<joint", "expected <child> in it"},
    {TWO("<joint name=\"j\" type=\"fixed\">" ENDS("a", "b") "</joint>\n<joint name=\"k\" type=\"fixed\">" ENDS(
         "a", "b") "</joint>"),
     "<joint name=\"k\"", "expected one joint above link \"b\", but line 4 has another"},
    {ROBOT("<link name=\"r\"/>\n<link name=\"a\"/>\n<link name=\"b\"/><joint name=\"j\" type=\"fixed\">" ENDS(
         "a", "b") "</joint><joint name=\"k\" type=\"fixed\">" ENDS("b", "a") "</joint>"),
     "<link name=\"a\"/>", "it hangs in a circle"},
    {ROBOT("<link name=\"a\"/>\n<link name=\"b\"/>\n<joint name=\"j\" type=\"revolute\">" ENDS("a", "b") LIMIT
           "</joint>"),
     "<link name=\"b\"/>", "expected a mass"},
    {ROBOT("<link name=\"a\">\n<inertial><mass value=\"-1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" "
           "iyz=\"0\" izz=\"1\"/></inertial></link>"),
     "<inertial", "expected a mass that is not negative"},
    {ROBOT("<link name=\"a\">\n<inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" "
           "iyz=\"0\" izz=\"4\"/></inertial></link>"),
     "<inertial", "expected an inertia that a body can have"},
    {ROBOT("<link name=\"a\">\n<inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"2\" ixz=\"0\" iyy=\"1\" "
           "iyz=\"0\" izz=\"1\"/></inertial></link>"),
     "<inertial", "expected an inertia that a body can have"},
    {ROBOT("<link name=\"a\">\n<inertial><mass value=\"1\"/></inertial></link>"), "<inertial",
     "expected <mass> and <inertia>"},
    {ROBOT("<link name=\"a\">\n<collision><geometry>\n<sphere radius=\"0\"/></geometry></collision></link>"), "<sphere",
     "expected a positive radius"},
    {ROBOT("<link name=\"a\">\n<collision><geometry>\n<cone/></geometry></collision></link>"), "<cone",
     "expected <box>"},
    {ROBOT("<link name=\"a\">\n<collision/></link>"), "<collision", "expected <geometry>"},
    {TWO("<joint name=\"j\" type=\"continuous\">" ENDS("a", "b") "\n<mimic joint=\"j\"/></joint>"), "<mimic",
     "joint \"j\" would follow itself"},
    {TWO("<joint name=\"j\" type=\"continuous\">" ENDS("a", "b") "\n<mimic joint=\"x\"/></joint>"), "<mimic",
     "expected the name of a joint in joint, not \"x\""},
};

static void faults_have_lines(void **state)
{
    (void)state;
    hand_faults_are_named("h.urdf", faults, sizeof faults / sizeof faults[0]);
}

static const char cube[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n"
                           "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

/* package://NAME/: given, a directory of that name above, and one beside the way up. */
static void packages(void **state)
{
    (void)state;
    char *folder = program_make_folder(), inner[512], path[640];
    static const char *const places[] = {"meshes/cube.obj", "package://pack/meshes/cube.obj",
                                         "package://other/cube.obj"};
    snprintf(inner, sizeof inner, "%s/pack", folder);
    assert_int_equal(mkdir(inner, 0700), 0);
    snprintf(path, sizeof path, "%s/meshes", inner);
    assert_int_equal(mkdir(path, 0700), 0);
    char *mesh = program_write_file(path, "cube.obj", cube);
    hand_package package = {"other", path};
    for (int i = 0; i < 3; i++) {
        char text[512];
        hand *h;
        hand_error error;
        snprintf(text, sizeof text,
                 "<robot name=\"r\"><link name=\"a\"><collision><geometry><mesh filename=\"%s\" scale=\"2 2 0.5\"/>"
                 "</geometry></collision></link></robot>",
                 places[i]);
        char *file = program_write_file(inner, "h.urdf", text);
        if (hand_load(file, &package, 1, &h, &error) != HAND_OK) fail_msg("%s", error.text);
        assert_int_equal(h->meshes[h->geoms[0].mesh].hull.vertex_count, 8);
        double volume, centre[3], second[9];
        mesh_hull_moments(&h->meshes[0].hull, &volume, centre, second);
        assert_close(volume, 2, 1e-14);
        hand_free(h);
        assert_int_equal(remove(file), 0);
        free(file);
    }
    assert_int_equal(remove(mesh), 0);
    free(mesh);
    assert_int_equal(remove(path), 0);
    assert_int_equal(remove(inner), 0);
    program_remove_folder(folder);
}

/* Of what stands twice in an element the first counts, and that is listed. */
static void repeated_elements(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    hand *h = hand_from_text(folder, "h.urdf",
                             "<robot><link name=\"a\"/><link name=\"b\"><inertial><mass value=\"1\"/><inertia ixx=\"1\""
                             " ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial><inertial/></link>"
                             "<joint name=\"j\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/>"
                             "<origin xyz=\"1 2 3\"/><origin xyz=\"4 5 6\"/></joint></robot>");
    assert_int_equal(h->ignored_count, 2);
    assert_string_equal(h->ignored[0].what, "second inertial");
    assert_string_equal(h->ignored[1].what, "second origin");
    assert_close(h->links[1].pose.position[0], 1, 0);
    assert_close(h->links[1].mass.mass, 1, 0);
    hand_free(h);
    program_remove_folder(folder);
}

/* What stands twice in a mass or in a shape is listed, and so is what else is in them; the first counts. */
static void repeated_parts(void **state)
{
    (void)state;
    static const struct {
        const char *inertial, *collision, *what[2];
    } cases[] = {
        {"", "<geometry><box size=\"2 2 2\"/></geometry>", {NULL, NULL}},
        {"<mass value=\"5\"/>", "<geometry><box size=\"2 2 2\"/></geometry>", {"second mass", NULL}},
        {"<origin/><origin xyz=\"1 0 0\"/>",
         "<geometry><box size=\"2 2 2\"/></geometry><geometry><sphere radius=\"9\"/></geometry>",
         {"second origin", "second geometry"}},
        {"<inertia/>",
         "<geometry><box size=\"2 2 2\"/><sphere radius=\"9\"/></geometry>",
         {"second inertia", "sphere after the shape of a <geometry>"}},
        {"<density/>",
         "<origin/><geometry><box size=\"2 2 2\"/></geometry><origin xyz=\"1 0 0\"/>",
         {"density", "second origin"}},
        {"", "<geometry><box size=\"2 2 2\"/></geometry><max_contacts/>", {"max_contacts", NULL}},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char text[1024], *folder = program_make_folder();
        snprintf(text, sizeof text,
                 "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" "
                 "ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/>%s</inertial><collision>%s</collision></link></robot>",
                 cases[k].inertial, cases[k].collision);
        hand *h = hand_from_text(folder, "h.urdf", text);
        size_t count = cases[k].what[1] ? 2 : cases[k].what[0] ? 1 : 0;
        assert_int_equal(h->ignored_count, count);
        for (size_t i = 0; i < count; i++) assert_string_equal(h->ignored[i].what, cases[k].what[i]);
        assert_close(h->links[0].mass.mass, 1, 0);
        assert_close(h->links[0].mass.centre[0], 0, 0);
        assert_int_equal(h->geom_count, 1);
        assert_int_equal(h->geoms[0].type, HAND_BOX);
        assert_close(h->geoms[0].pose.position[0], 0, 0);
        hand_free(h);
        program_remove_folder(folder);
    }
}

/* What URDF does not have is listed where it changes nothing, or is known not to be modelled. */
static void unknown_attributes(void **state)
{
    (void)state;
    static const char text[] =
        "<robot name=\"r\" xmlns:x=\"x\" version=\"1.0\"><link name=\"a\"/><link name=\"b\" type=\"t\" x:y=\"1\">" MASS(
            "1") "<collision name=\"c\" group=\"g\"><geometry><sphere radius=\"1\" "
                 "length=\"2\"/></geometry></collision>"
                 "<visual><origin ryp=\"1 1 1\"/><geometry><sphere radius=\"1\"/></geometry></visual></link>"
                 "<joint name=\"j\" type=\"continuous\" dont_collapse=\"true\">" ENDS(
                     "a", "b") "<limit effort=\"1\" velocity=\"1\" acceleration=\"3\" jerk=\"0\"/>"
                               "<dynamics damping=\"1\" spring_stiffness=\"2\" spring_reference=\"1\"/>"
                               "<safety_controller soft_lower_limit=\"-1\"/></joint>"
                               "<link name=\"c\"/><joint name=\"f\" type=\"fixed\">" ENDS(
                                   "b", "c") "<limit lowr=\"1\"/></joint></robot>";
    static const char *const ignored[] = {
        "attribute type of <link>",           "attribute group of <collision>",
        "attribute length of <sphere>",       "attribute ryp of <origin>",
        "attribute dont_collapse of <joint>", "attribute spring_reference of <dynamics>",
        "attribute lowr of <limit>",          "safety_controller"};
    static const char *const unmodelled[] = {"attribute acceleration of <limit>",
                                             "attribute spring_stiffness of <dynamics>"};
    char *folder = program_make_folder();
    hand *h = hand_from_text(folder, "h.urdf", text);
    assert_int_equal(h->ignored_count, 8);
    for (size_t i = 0; i < 8; i++) assert_string_equal(h->ignored[i].what, ignored[i]);
    assert_int_equal(h->unmodelled_count, 2);
    for (size_t i = 0; i < 2; i++) assert_string_equal(h->unmodelled[i].what, unmodelled[i]);
    hand_free(h);
    program_remove_folder(folder);
}

/* A mesh of a picture may be missing; one that touches is said to be missing; a broken one is refused. */
static void missing_and_broken_meshes(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    hand *h = hand_from_text(folder, "h.urdf",
                             "<robot><link name=\"a\"><visual><geometry><mesh filename=\"no.stl\"/></geometry></visual>"
                             "<collision><geometry><mesh filename=\"no.stl\"/></geometry></collision>"
                             "<collision><geometry><mesh filename=\"package://nowhere/a.stl\"/></geometry></collision>"
                             "</link></robot>");
    assert_int_equal(h->ignored_count, 1);
    assert_int_equal(h->unmodelled_count, 2);
    assert_string_equal(h->unmodelled[0].what, "contact with the mesh no.stl, which is not there");
    assert_string_equal(h->unmodelled[1].what, "contact with the mesh package://nowhere/a.stl, which is not there");
    for (size_t i = 0; i < h->geom_count; i++) assert_false(h->geoms[i].collides); /* a world is made without it */
    hand_free(h);
    free(program_write_file(folder, "bad.stl", "solid\nfacet\nvertex 1 2\n"));
    free(program_write_file(folder, "bad.ply", "ply\nformat ascii 1.0\nelement vertex 9999999\n"));
    free(program_write_file(folder, "bad.dae", "<COLLADA><library_geometries>"));
    free(program_write_file(folder, "bad.glb", "glTF\2\0\0\0"));
    free(program_write_file(folder, "flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
    static const char *const files[] = {"bad.stl", "bad.ply", "bad.dae", "bad.glb", "flat.obj"};
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        char text[256];
        hand_error error;
        snprintf(text, sizeof text,
                 "<robot><link name=\"a\"><collision><geometry><mesh filename=\"%s\"/></geometry></collision></link>"
                 "</robot>",
                 files[i]);
        char *file = program_write_file(folder, "h.urdf", text);
        assert_int_equal(hand_load(file, NULL, 0, &h, &error), HAND_BAD_INPUT);
        assert_non_null(strstr(error.text, files[i]));
        assert_null(strchr(error.text, '\n'));
        free(file);
    }
    program_remove_folder(folder);
}

/* White space before the declaration and version 0.0 are taken, and lines keep their numbers. */
static void declarations(void **state)
{
    (void)state;
    static const char *const heads[] = {"<?xml version=\"0.0\" ?>\n\n\n", "\n \t\r\n<?xml version=\"1.0\"?>\n",
                                        "\n\n<?xml version = '0.0'?>\n", "\n\n\n",
                                        "\n\n<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?><!--\xe9-->\n"};
    char *folder = program_make_folder();
    for (size_t i = 0; i < sizeof heads / sizeof *heads; i++) {
        char text[256];
        snprintf(text, sizeof text, "%s<robot name=\"r\"><link name=\"a\"/></robot>", heads[i]);
        hand *h = hand_from_text(folder, "h.urdf", text);
        assert_int_equal(h->links[0].line, 4);
        hand_free(h);
    }
    static const hand_fault refused[] = {
        {"<?xml version=\"2.0\"?><robot/>", NULL, "expected an XML document: Unsupported version"},
        {"<!-- first -->\n<?xml version=\"1.0\"?><robot/>", NULL, "expected an XML document"},
        {"\n<?xml version=\"0.0\"", NULL, "expected an XML document"},
        {"\n<?xml", NULL, "expected an XML document"},
    };
    hand_faults_are_named("h.urdf", refused, sizeof refused / sizeof *refused);
    program_remove_folder(folder);
}

/* What is wrong in a picture is listed, and the picture left out: nothing of the physics changes. */
static void pictures_do_not_matter(void **state)
{
    (void)state;
    static const struct {
        const char *picture, *what;
        size_t geoms;
    } cases[] = {
        {"<geometry><mesh filename=\"package://nope/a.stl\"/></geometry>",
         "meshes of pictures in the package nope, which is not there", 1},
        {"<geometry><mesh filename=\"no/a.stl\"/></geometry>", "mesh of a picture, which is not there", 1},
        {"<geometry><box size=\"0 0 0\"/></geometry>", "picture that is left out: expected positive lengths in size",
         0},
        {"<geometry><cone/></geometry>",
         "picture that is left out: expected <box>, <sphere>, <cylinder>, <capsule> or <mesh>", 0},
        {"", "picture that is left out: expected <geometry> with a shape in it", 0},
        {"<origin rpy=\"0 0\"/><geometry><sphere radius=\"1\"/></geometry>",
         "picture that is left out: expected 3 numbers in rpy, not \"0 0\"", 0},
        {"<geometry><sphere radius=\"1\"/></geometry><material><color rgba=\"red\"/></material>",
         "picture that is left out: expected 4 numbers in rgba, not \"red\"", 0},
    };
    char *folder = program_make_folder();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[512];
        snprintf(text, sizeof text,
                 "<robot><link name=\"a\"><visual>%s</visual><collision><geometry><sphere radius=\"2\"/></geometry>"
                 "</collision></link></robot>",
                 cases[i].picture);
        hand *h = hand_from_text(folder, "h.urdf", text);
        assert_int_equal(h->geom_count, cases[i].geoms + 1);
        assert_true(h->geoms[cases[i].geoms].collides && h->geoms[cases[i].geoms].size[0] == 2);
        assert_int_equal(h->ignored_count, 1);
        assert_string_equal(h->ignored[0].what, cases[i].what);
        assert_int_equal(h->unmodelled_count, 0);
        hand_free(h);
    }
    program_remove_folder(folder);
}

/* The same cube from four formats. */
static void other_formats(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    free(program_write_file(folder, "c.obj", cube));
    free(program_write_file(folder, "c.ply",
                            "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
                            "property float z\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n"
                            "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n"
                            "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n"));
    free(program_write_file(
        folder, "c.dae",
        "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">"
        "<asset><unit meter=\"0.5\"/><up_axis>Z_UP</up_axis></asset><library_geometries><geometry id=\"g\"><mesh>"
        "<source id=\"p\"><float_array id=\"pa\" count=\"12\">0 0 0 1 0 0 0 1 0 0 0 1</float_array><technique_common>"
        "<accessor source=\"#pa\" count=\"4\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" "
        "type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor></technique_common></source><vertices id=\"v\">"
        "<input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles count=\"4\"><input semantic=\"VERTEX\" "
        "source=\"#v\" offset=\"0\"/><p>0 2 1 0 1 3 1 2 3 2 0 3</p></triangles></mesh></geometry></library_geometries>"
        "<library_visual_scenes><visual_scene id=\"s\"><node><translate>0 0 2</translate><instance_geometry "
        "url=\"#g\"/></node></visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene>"
        "</COLLADA>"));
    hand *h = hand_from_text(folder, "h.urdf",
                             "<robot><link name=\"a\"><collision><geometry><mesh filename=\"c.obj\"/></geometry>"
                             "</collision><collision><geometry><mesh filename=\"c.ply\"/></geometry></collision>"
                             "<collision><geometry><mesh filename=\"c.dae\"/></geometry></collision></link></robot>");
    double volume, centre[3], second[9];
    for (int i = 0; i < 2; i++) {
        mesh_hull_moments(&h->meshes[i].hull, &volume, centre, second);
        assert_close(volume, 1, 1e-14);
        assert_numbers(centre, (double[]){0.5, 0.5, 0.5}, 3, 1e-14);
    }
    /* half a metre to the unit, z up as it is written, and the node's translation */
    mesh_hull_moments(&h->meshes[2].hull, &volume, centre, second);
    assert_close(volume, 0.125 / 6, 1e-8);
    assert_numbers(centre, (double[]){0.125, 0.125, 1.125}, 3, 1e-7);
    hand_free(h);
    program_remove_folder(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_element),
        cmocka_unit_test(roll_pitch_yaw),
        cmocka_unit_test(minus_one_is_no_bound),
        cmocka_unit_test(couplings_are_followed),
        cmocka_unit_test(faults_have_lines),
        cmocka_unit_test(packages),
        cmocka_unit_test(missing_and_broken_meshes),
        cmocka_unit_test(pictures_do_not_matter),
        cmocka_unit_test(declarations),
        cmocka_unit_test(repeated_elements),
        cmocka_unit_test(repeated_parts),
        cmocka_unit_test(unknown_attributes),
        cmocka_unit_test(other_formats),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
