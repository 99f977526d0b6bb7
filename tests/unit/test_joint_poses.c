/* The plugin keeps the state of joints that ODE does not show, for one joint and its bodies, until it is told anew. */
#include "support/cmocka_all.h"

#include "joints/hinge_reference.h"
#include "joints/joint_pose.h"

#include <string.h>

static dJointID make_hinge2(dWorldID world, dBodyID a, dBodyID b, double angle)
{
    const dVector3 axis1 = {0, 0, 1}, axis2 = {sin(angle), 0, cos(angle)};
    dJointID joint = dJointCreateHinge2(world, NULL);
    dJointAttach(joint, a, b);
    dJointSetHinge2Axes(joint, axis1, axis2);
    return joint;
}

static void test_a_hinge2_keeps_its_angle(void **state)
{
    (void)state;
    dWorldID world = dWorldCreate();
    dBodyID a = dBodyCreate(world), b = dBodyCreate(world);
    dQuaternion turn;
    pinch_joint_pose pose;
    dQFromAxisAndAngle(turn, 1, 2, 3, 0.7);
    dBodySetQuaternion(b, turn);
    dJointID joint = make_hinge2(world, a, b, 1.1);
    assert_true(pinch_joint_pose_now(joint, &pose));
    assert_close(pose.cosine, cos(1.1), 1e-15);
    assert_close(pose.sine, sin(1.1), 1e-15);
    dQFromAxisAndAngle(turn, 0, 1, 0, 0.2); /* towards each other, where it is noted now */
    dBodySetQuaternion(a, turn);
    assert_true(pinch_joint_pose_now(joint, &pose));
    assert_close(pose.cosine, cos(0.9), 1e-15);
    dJointAttach(joint, NULL, NULL);
    assert_false(pinch_joint_pose_now(joint, &pose));
    dWorldDestroy(world);
}

static void test_it_is_of_one_joint(void **state)
{
    (void)state;
    dWorldID world = dWorldCreate();
    dBodyID a = dBodyCreate(world), b = dBodyCreate(world);
    const dBodyID bodies[2] = {a, b}, swapped[2] = {b, a};
    dJointID joint = make_hinge2(world, a, b, 1.1), other = make_hinge2(world, a, b, 1.2);
    pinch_joint_poses poses;
    pinch_joint_pose pose;
    int hint = 0;
    memset(&poses, 0, sizeof poses);
    assert_null(pinch_joint_pose_of(&poses, joint, bodies, &hint));
    assert_true(pinch_joint_pose_now(joint, &pose));
    pinch_joint_pose_keep(&poses, &pose);
    const pinch_joint_pose *kept = pinch_joint_pose_of(&poses, joint, bodies, &hint);
    assert_non_null(kept);
    assert_true(kept->cosine == pose.cosine && kept->sine == pose.sine);
    assert_null(pinch_joint_pose_of(&poses, other, bodies, &hint));
    assert_null(pinch_joint_pose_of(&poses, joint, swapped, &hint));
    pose.type = dJointTypeFixed; /* one that was there before */
    pinch_joint_pose_keep(&poses, &pose);
    assert_int_equal(poses.count, 1);
    assert_null(pinch_joint_pose_of(&poses, joint, bodies, &hint));
    pinch_joint_poses_free(&poses);
    dWorldDestroy(world);
}

/* A ball shows all it has, and a slider needs a body. */
static void test_others_have_none(void **state)
{
    (void)state;
    dWorldID world = dWorldCreate();
    dBodyID a = dBodyCreate(world), b = dBodyCreate(world);
    dJointID ball = dJointCreateBall(world, NULL), slider = dJointCreateSlider(world, NULL);
    pinch_joint_pose pose;
    dJointAttach(ball, a, b);
    assert_false(pinch_joint_pose_now(ball, &pose));
    assert_false(pinch_joint_pose_now(slider, &pose));
    dJointAttach(slider, NULL, b);
    assert_true(pinch_joint_pose_now(slider, &pose));
    assert_true(pose.body[0] == b && !pose.body[1] && pose.sine == 0);
    dWorldDestroy(world);
}

/* Anchors and axes are often set in different poses. Each is kept as it was. */
static void test_parts_are_kept_by_themselves(void **state)
{
    (void)state;
    dWorldID world = dWorldCreate();
    dBodyID a = dBodyCreate(world), b = dBodyCreate(world);
    const dBodyID bodies[2] = {a, b};
    dJointID joint = dJointCreatePR(world, NULL);
    pinch_joint_poses poses;
    pinch_joint_pose pose;
    dQuaternion turn;
    int hint = 0;
    memset(&poses, 0, sizeof poses);
    dJointAttach(joint, a, b);
    dJointSetPRAnchor(joint, 0, 0, 1);
    assert_true(pinch_joint_pose_now(joint, &pose));
    pose.known = PINCH_KNOWS_OFFSET;
    pinch_joint_pose_keep(&poses, &pose);
    dBodySetPosition(a, 0, 0, -3); /* the anchor in a stays */
    dQFromAxisAndAngle(turn, 1, 0, 0, 0.5);
    dBodySetQuaternion(b, turn);
    dJointSetPRAxis2(joint, 1, 0, 0);
    assert_true(pinch_joint_pose_now(joint, &pose));
    pose.known = PINCH_KNOWS_TURN;
    pinch_joint_pose_keep(&poses, &pose);
    const pinch_joint_pose *kept = pinch_joint_pose_of(&poses, joint, bodies, &hint);
    assert_non_null(kept);
    assert_int_equal(kept->known, PINCH_KNOWS_TURN | PINCH_KNOWS_OFFSET);
    assert_close(kept->offset[2], 1, 1e-15);
    assert_close(kept->turn[1], sin(0.25), 1e-15);
    pinch_joint_pose_forget(&poses, joint, PINCH_KNOWS_TURN);
    assert_int_equal(kept->known, PINCH_KNOWS_OFFSET);
    pinch_joint_poses_free(&poses);
    dWorldDestroy(world);
}

/* Notes `things` of a joint's pose. */
static void note(pinch_joint_poses *poses, dJointID joint, unsigned things)
{
    pinch_joint_pose pose;
    assert_true(pinch_joint_pose_now(joint, &pose));
    pose.known &= things;
    assert_true(pinch_joint_pose_keep(poses, &pose));
}

static unsigned known(const pinch_joint_poses *poses, dJointID joint)
{
    dBodyID bodies[2];
    int hint = 0;
    assert_true(pinch_joint_bodies(joint, bodies));
    const pinch_joint_pose *pose = pinch_joint_pose_of(poses, joint, bodies, &hint);
    return pose ? pose->known : 0;
}

/* What was noted with a body goes when that is forgotten. What is noted after it, with another one at its address,
 * stays: here that is the same one. */
static void test_a_body_is_forgotten(void **state)
{
    enum { BODIES = 6, BOTH = PINCH_KNOWS_TURN | PINCH_KNOWS_OFFSET };
    (void)state;
    dWorldID world = dWorldCreate();
    dBodyID bodies[BODIES];
    dJointID joints[BODIES]; /* between two bodies that follow each other */
    pinch_joint_poses poses;
    memset(&poses, 0, sizeof poses);
    for (int i = 0; i < BODIES; i++) bodies[i] = dBodyCreate(world);
    pinch_joint_poses_forget_body(&poses, bodies[0]); /* nothing is noted yet */
    for (int i = 0; i < BODIES; i++) {
        joints[i] = dJointCreateSlider(world, NULL);
        dJointAttach(joints[i], bodies[i], bodies[(i + 1) % BODIES]);
        note(&poses, joints[i], BOTH);
    }
    for (int round = 0; round < 3; round++) {
        pinch_joint_poses_forget_body(&poses, bodies[1]);
        note(&poses, joints[1], BOTH); /* with the next one */
        pinch_joint_poses_forget_body(&poses, bodies[4]);
        note(&poses, joints[3], PINCH_KNOWS_TURN); /* its offset is the other's */
        pinch_joint_poses_drop_forgotten(&poses);
        const unsigned wanted[BODIES] = {0, BOTH, BOTH, PINCH_KNOWS_TURN, 0, BOTH};
        for (int i = 0; i < BODIES; i++) assert_int_equal(known(&poses, joints[i]), wanted[i]);
        for (int i = 0; i < BODIES; i++) note(&poses, joints[i], BOTH);
    }
    for (int i = 0; i < 10 * BODIES; i++) pinch_joint_poses_forget_body(&poses, bodies[2]); /* nobody reads */
    assert_true(poses.forgotten_count <= BODIES);
    pinch_joint_poses_drop_forgotten(&poses);
    for (int i = 0; i < BODIES; i++) assert_int_equal(known(&poses, joints[i]), i == 1 || i == 2 ? 0 : BOTH);
    pinch_joint_poses_free(&poses);
    dWorldDestroy(world);
}

/* The same for what was found out of hinges. */
static void test_hinges_of_bodies_are_forgotten(void **state)
{
    enum { BODIES = 4 };
    (void)state;
    dWorldID world = dWorldCreate();
    dBodyID bodies[BODIES];
    int references[BODIES];
    pinch_hinge_references kept;
    pinch_key_map gone;
    double axis[3];
    memset(&kept, 0, sizeof kept);
    memset(&gone, 0, sizeof gone);
    for (int i = 0; i < BODIES; i++) bodies[i] = dBodyCreate(world);
    for (int i = 0; i < BODIES; i++) {
        dJointID joint = dJointCreateHinge(world, NULL);
        dJointAttach(joint, bodies[i], bodies[(i + 1) % BODIES]);
        assert_true(pinch_add_hinge_reference(&kept, joint, bodies[i], 1, &references[i]));
        assert_non_null(pinch_hinge_reference_axis(&kept, references[i], bodies[i], 1, axis));
    }
    pinch_hinge_references_forget_bodies(&kept, &gone);
    for (int i = 0; i < BODIES; i++) assert_true(kept.items[references[i]].reliable);
    assert_true(pinch_key_map_add(&gone, (uintptr_t)bodies[1], 1));
    pinch_hinge_references_forget_bodies(&kept, &gone);
    for (int i = 0; i < BODIES; i++) assert_true(kept.items[references[i]].reliable == (i > 1));
    pinch_key_map_free(&gone);
    pinch_item_index_free(&kept.index);
    free(kept.items);
    dWorldDestroy(world);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_hinge2_keeps_its_angle), cmocka_unit_test(test_it_is_of_one_joint),
        cmocka_unit_test(test_others_have_none),         cmocka_unit_test(test_parts_are_kept_by_themselves),
        cmocka_unit_test(test_a_body_is_forgotten),      cmocka_unit_test(test_hinges_of_bodies_are_forgotten),
    };
    int failed = cmocka_run_group_tests_name("what joints keep", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
