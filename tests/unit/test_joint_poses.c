/* The plugin keeps the state of joints that ODE does not show, for one joint and its bodies, until it is told anew. */
#include "support/cmocka_all.h"

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

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_hinge2_keeps_its_angle),
        cmocka_unit_test(test_it_is_of_one_joint),
        cmocka_unit_test(test_others_have_none),
        cmocka_unit_test(test_parts_are_kept_by_themselves),
    };
    int failed = cmocka_run_group_tests_name("what joints keep", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
