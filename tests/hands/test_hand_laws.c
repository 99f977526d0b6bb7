/* Joints, drives and tendons of small hands of MJCF that touch nothing do what their laws say. */
#include "support/cmocka_all.h"
#include "support/program.h"
#include "support/scene_run.h"

#include "hands/hand.h"
#include "scenes/world/world_hand.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* A palm without weight, and the finger that `joint` moves: 0.05 kg and 1e-3 kg m^2 at `place`, in the frame of the
 * hand. `more` follows the bodies, `keys` the file of the hand in the scene, `step` is in seconds. */
static world *finger_of(const char *joint, const char *place, const char *more, const char *keys, double step,
                        scene **s)
{
    char text[2048], *folder = program_make_folder();
    snprintf(text, sizeof text,
             "<mujoco><compiler angle='radian'/><worldbody><body name='palm'>"
             "<inertial pos='0 0 0' mass='0.5' diaginertia='1e-3 1e-3 1e-3'/><body name='finger' pos='%s'>"
             "<inertial pos='0 0 0' mass='0.05' diaginertia='1e-3 1e-3 1e-3'/><joint name='joint' %s/></body></body>"
             "</worldbody>%s</mujoco>",
             place, joint, more);
    free(program_write_file(folder, "finger.xml", text));
    snprintf(text, sizeof text,
             "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0], \"object\": {\"shape\": {\"type\": \"sphere\","
             " \"radius\": 0.02}, \"mass\": 0.1, \"position\": [5, 5, 0]}, \"simulation\": {\"step\": %g},"
             " \"hand\": {\"file\": \"%s/finger.xml\"%s}}",
             step, folder, keys);
    *s = scene_from_text(text);
    program_remove_folder(folder);
    return world_of(*s);
}

static void end(world *w, scene *s)
{
    assert_true(fabs(w->ledger.closure) <= 1e-9 * w->ledger.work_size);
    world_free(w);
    scene_free(s);
}

/* A finger on a slide, with and without armature, is carried round by a palm that turns steadily: the joint rests, and
 * neither the armature nor what is said of its rate may know of the turning, whatever the time step and the axis. The
 * axis may point along the way, or outwards, where the drive has to hold the finger on its circle. */
static void test_a_slide_on_a_palm_that_turns(void **state)
{
    (void)state;
    static const double STEPS[] = {2e-3, 1e-3, 5e-4}, RATE = 1, ARM = 0.06;
    static const char *const axes[] = {"0 1 0", "0 0 1"};
    for (int k = 0; k < 12; k++) {
        bool outwards = k % 2;
        double h = STEPS[k / 4], torque = outwards ? -0.05 * RATE * RATE * ARM : 0;
        char joint[128];
        snprintf(joint, sizeof joint, "type='slide' axis='%s' armature='%g'", axes[outwards], k / 2 % 2 ? 0.1 : 0.0);
        scene *s;
        world *w = finger_of(joint, "0 0 0.06", "<actuator><position joint='joint' kp='1000' kv='20'/></actuator>",
                             ", \"control\": {\"joint\": {\"target\": 0}}, \"base\": {\"drive\": {\"type\": \"path\","
                             " \"points\": [{\"time\": 0}, {\"time\": 2, \"rotation\": [2, 0, 0]}]}}",
                             h, &s);
        world_run_until(w, 1);
        const world_joint *j = &w->hands[0].joints[0];
        assert_close(j->torque, torque, 2e-3 * h);
        assert_close(j->position, -torque / 1000, 2e-3 * h);
        assert_close(j->velocity, 0, 0.6 * RATE * RATE * ARM * h); /* a step goes along the chord of its circle */
        end(w, s);
    }
}

/* A joint's armature a resists changes of its own rate, and nothing else. Of a base that suddenly moves at the rate v
 * along the joint, a free finger of inertia m is left behind: m (v + q') + a q' = 0. */
static void test_armature_when_the_palm_starts(void **state)
{
    (void)state;
    static const struct {
        const char *joint, *motion;
        double rate, inertia;
    } cases[] = {
        {"type='slide' axis='0 1 0' armature='0.1'", "\"translation\": [0, 0.2, 0]", 0.2, 0.05},
        {"axis='0 1 0' armature='0.002'", "\"rotation\": [0, 0.2, 0]", 0.2, 1e-3},
    };
    for (int k = 0; k < 4; k++) {
        double start = k / 2 ? 0.1 : 0, armature = k % 2 ? 0.002 : 0.1;
        char keys[256];
        snprintf(keys, sizeof keys,
                 ", \"base\": {\"drive\": {\"type\": \"path\", \"points\": [{\"time\": %g}, {\"time\": %g, %s}]}}",
                 start, start + 1, cases[k % 2].motion);
        scene *s;
        world *w = finger_of(cases[k % 2].joint, "0 0 0", "", keys, 1e-3, &s);
        world_run_until(w, 0.4);
        double m = cases[k % 2].inertia;
        assert_close(w->hands[0].joints[0].velocity, -m / (m + armature) * cases[k % 2].rate, 1e-9);
        end(w, s);
    }
}

/* A tendon's spring rests at its springlength, of either sign, or where its joints' springs rest; between two numbers
 * it rests anywhere. */
static void test_lengths_at_which_tendons_rest(void **state)
{
    (void)state;
    static const struct {
        const char *rest;
        double length;
    } cases[] = {
        {"", 0.003},
        {"springlength='-1'", 0.003},
        {"springlength='-1 -1'", 0.003},
        {"springlength='-0.004'", -0.004},
        {"springlength='0.002'", 0.002},
        {"springlength='0'", 0},
        {"springlength='-0.005 -0.002'", -0.002},
        {"springlength='-1 -0.006'", -0.006},
        {"springlength='-1 1'", 0.001}, /* where it starts */
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char more[256];
        snprintf(more, sizeof more,
                 "<tendon><fixed stiffness='1000' %s><joint joint='joint' coef='0.01'/></fixed></tendon>",
                 cases[k].rest);
        scene *s;
        world *w = finger_of("axis='0 1 0' damping='0.02' springref='0.3'", "0 0 0.1", more,
                             ", \"joints\": {\"joint\": 0.1}", 1e-3, &s);
        world_run_until(w, 4);
        assert_close(w->hands[0].joints[0].position, cases[k].length / 0.01, 1e-9);
        end(w, s);
    }
}

/* What a tendon's actuatorfrcrange lets its drive do: a torque or a position far off move the finger by it. */
static void test_bounds_of_the_forces_of_tendons(void **state)
{
    (void)state;
    static const struct {
        const char *bound, *drive;
        double force;
    } cases[] = {
        {"", "motor", 0.4},
        {"actuatorfrcrange='-0.01 0.01'", "motor", 0.01},
        {"actuatorfrcrange='-0.01 0.01'", "position kp='1000'", 0.01},
        {"actuatorfrcrange='-0.02 0.01'", "motor", 0.02}, /* the larger side */
        {"actuatorfrcrange='-0.01 0.01' actuatorfrclimited='false'", "motor", 0.4},
        {"actuatorfrcrange='-0.01 0.01'", "motor forcerange='-0.005 0.005'", 0.005},
        {"actuatorfrcrange='-0.01 0.01'", "motor forcerange='-0.05 0.05'", 0.01},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char more[384];
        snprintf(more, sizeof more,
                 "<tendon><fixed name='tendon' %s><joint joint='joint' coef='0.1'/></fixed></tendon>"
                 "<actuator><%s name='drive' tendon='tendon'/></actuator>",
                 cases[k].bound, cases[k].drive);
        scene *s;
        world *w =
            finger_of("axis='0 1 0'", "0 0 0.1", more, ", \"control\": {\"drive\": {\"target\": 0.4}}", 1e-3, &s);
        world_run_until(w, 0.1);
        assert_close(w->hands[0].joints[0].torque, 0.1 * cases[k].force, 1e-12);
        assert_close(w->hands[0].joints[0].velocity, 0.1 * cases[k].force / 1e-3 * 0.1, 1e-9);
        end(w, s);
    }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_slide_on_a_palm_that_turns),
        cmocka_unit_test(test_armature_when_the_palm_starts),
        cmocka_unit_test(test_lengths_at_which_tendons_rest),
        cmocka_unit_test(test_bounds_of_the_forces_of_tendons),
    };
    int failed = cmocka_run_group_tests_name("laws of joints, drives and tendons", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
