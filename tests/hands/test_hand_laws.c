/* Joints, drives and tendons of small hands of MJCF that touch nothing do what their laws say. */
#define _POSIX_C_SOURCE 200809L
#include "support/cmocka_all.h"
#include "support/program.h"
#include "support/scene_run.h"

#include "hands/hand.h"
#include "scenes/world/world_hand.h"
#include "statics/hand_statics.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PRINTED = 8192 };

static void print_to(const scene *s, char *text)
{
    FILE *stream = fmemopen(text, PRINTED, "w");
    assert_non_null(stream);
    assert_int_equal(scene_print(s, stream), SCENE_OK);
    fclose(stream);
}

static void loads_as_printed(const scene *s)
{
    char text[PRINTED], second[PRINTED];
    print_to(s, text);
    scene *again = scene_from_text(text);
    print_to(again, second);
    assert_string_equal(text, second);
    scene_free(again);
}

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
    loads_as_printed(*s);
    program_remove_folder(folder);
    return world_of(*s);
}

static void end(world *w, scene *s)
{
    assert_true(fabs(w->ledger.closure) <= 1e-9 * w->ledger.work_size);
    world_free(w);
    scene_free(s);
}

static void must_not_be_called(void *context, const char *text)
{
    (void)context;
    fail_msg("not expressed: %s", text);
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
        {"actuatorfrcrange='-0.02 0.01'", "motor", 0.01},
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

#define POSITION(name, gains) "<position name='" name "' joint='joint' " gains "/>"
#define VELOCITY(name, gains) "<velocity name='" name "' joint='joint' " gains "/>"

/* What several actuators of one joint or tendon do adds up, whatever their order; a scene names each. `torque` is what
 * all of them do after two seconds, when the finger rests or goes at the speed of a drive. */
static void test_several_drives_of_a_joint(void **state)
{
    (void)state;
    static const struct {
        const char *drives, *control;
        double position, velocity, torque; /* position INFINITY: it moves on */
    } cases[] = {
        {POSITION("p", "kp='1'") VELOCITY("v", "kv='0.05'"), "\"p\": {\"target\": 0.5}", 0.5, 0, 0},
        {VELOCITY("v", "kv='0.05'") POSITION("p", "kp='1'"), "\"joint\": {\"target\": 0.5}", 0.5, 0, 0},
        {VELOCITY("v", "kv='0.05'") POSITION("p", "kp='1'"), "\"*\": {\"target\": 0.5}", 0.5, 0, 0},
        {VELOCITY("joint", "kv='0.05'") POSITION("p", "kp='1'"), "\"joint\": {\"target\": 0.5}", 0.5, 0, 0},
        {POSITION("p", "kp='1'") VELOCITY("v", "kv='0.1'"), "\"p\": {\"target\": 0.5}, \"v\": {\"target\": 2}", 0.7, 0,
         0},
        {"<motor name='m' joint='joint'/>" VELOCITY("v", "kv='0.05'"), "\"m\": {\"target\": 0.02}", INFINITY, 0.4, 0},
        {"<motor name='m' joint='joint' gear='2'/>" POSITION("p", "kp='1' kv='0.05'"),
         "\"p\": {\"target\": 0.5}, \"m\": {\"target\": 0.1}", 0.6, 0, 0},
        {POSITION("p", "kp='1' kv='0.05'") POSITION("q", "kp='3' kv='0.05'"),
         "\"p\": {\"target\": 0.5}, \"q\": {\"target\": 0.1}", 0.2, 0, 0},
        {POSITION("p", "kp='1' kv='0.05'") POSITION("q", "kp='30' kv='0.05' forcerange='-0.2 0.2'"),
         "\"p\": {\"target\": 0.5}, \"q\": {\"target\": 9}", 0.7, 0, 0},
        {POSITION("p", "kp='1'") "<general joint='joint' biastype='affine' biasprm='0 -1 -0.05' gainprm='1'/>",
         "\"p\": {\"target\": 0.5}", 0.25, 0, 0},
        {"<position name='p' tendon='tendon' kp='25' kv='1'/><motor name='m' tendon='tendon'/>" VELOCITY("v",
                                                                                                         "kv='0.1'"),
         "\"tendon\": {\"target\": 0.1}, \"m\": {\"target\": 1}", 0.7, 0, 0},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char more[640], keys[256];
        snprintf(
            more, sizeof more,
            "<tendon><fixed name='tendon'><joint joint='joint' coef='0.2'/></fixed></tendon><actuator>%s</actuator>",
            cases[k].drives);
        snprintf(keys, sizeof keys, ", \"control\": {%s}", cases[k].control);
        scene *s;
        world *w = finger_of("axis='0 1 0'", "0 0 0.1", more, keys, 1e-3, &s);
        world_run_until(w, 3);
        const world_joint *j = &w->hands[0].joints[0];
        if (isfinite(cases[k].position)) assert_close(j->position, cases[k].position, 1e-9);
        assert_close(j->velocity, cases[k].velocity, 1e-9);
        assert_close(j->torque, cases[k].torque, 1e-9);
        world_hand_not_expressed(w, must_not_be_called, NULL);
        end(w, s);
    }
}

/* On its way, a joint with a drive to a position and one that damps moves as with one that does both. In the statics
 * the damper does nothing; one that is told to move has no place to stand still. */
static void test_a_damper_beside_a_position(void **state)
{
    (void)state;
    static const char *const drives[] = {POSITION("p", "kp='1' kv='0.03'"),
                                         POSITION("p", "kp='1'") VELOCITY("v", "kv='0.03'")};
    double position[2], velocity[2], torque[2];
    for (int k = 0; k < 2; k++) {
        char more[256];
        snprintf(more, sizeof more, "<actuator>%s</actuator>", drives[k]);
        scene *s;
        world *w = finger_of("axis='0 1 0'", "0 0 0.1", more, ", \"control\": {\"p\": {\"target\": 0.5}}", 1e-3, &s);
        world_run_until(w, 0.05);
        position[k] = w->hands[0].joints[0].position;
        velocity[k] = w->hands[0].joints[0].velocity;
        torque[k] = w->hands[0].joints[0].torque;
        hand_statics x;
        assert_true(hand_statics_solve(s, 0.05, &x));
        assert_close(x.joints[0].position, 0.5, 1e-9);
        hand_statics_free(&x);
        end(w, s);
    }
    assert_close(position[1], position[0], 1e-12);
    assert_close(velocity[1], velocity[0], 1e-11);
    assert_close(torque[1], torque[0], 1e-11);
}

static void keep_text(void *context, const char *text)
{
    snprintf(context, 256, "%s", text);
}

static void add_text(void *context, const char *text)
{
    size_t length = strlen(context);
    snprintf((char *)context + length, 2048 - length, "%s\n", text);
}

/* What bounds all drives of a joint together bounds each of them; where that differs, it is said. */
static void test_a_bound_of_several_drives(void **state)
{
    (void)state;
    static const struct {
        const char *ranges[2];
        bool differs;
    } cases[] = {{{"", ""}, true}, {{"forcerange='-1 1'", "forcerange='-1 1'"}, false}};
    for (int k = 0; k < 2; k++) {
        char more[512], told[256] = "";
        snprintf(more, sizeof more,
                 "<actuator><motor name='m' joint='joint' %s/><motor name='n' joint='joint' %s/></actuator>",
                 cases[k].ranges[0], cases[k].ranges[1]);
        scene *s;
        world *w = finger_of("axis='0 1 0' actuatorfrcrange='-2 2'", "0 0 0.1", more,
                             ", \"control\": {\"m\": {\"target\": 0.5}, \"n\": {\"target\": 0.25}}", 1e-3, &s);
        world_run_until(w, 0.01);
        assert_close(w->hands[0].joints[0].torque, 0.75, 1e-12);
        world_hand_not_expressed(w, keep_text, told);
        assert_string_equal(
            told, cases[k].differs ? "joint: the bound of all its drives together (each has it for itself)" : "");
        end(w, s);
    }
}

#define GENERAL(keys) "<actuator><general name='drive' biastype='affine' " keys "/></actuator>"

/* Of an actuator that pulls to no place, the constant acts beside the target, and the speed term damps: from rest, the
 * steps of the joint go by I (v+ - v) = h (torque - damping v+). */
static void test_constants_and_damping_of_torques(void **state)
{
    (void)state;
    static const struct {
        const char *drive, *control;
        double torque, damping;
    } cases[] = {
        {GENERAL("joint='joint' biasprm='-0.3 0 0'"), "", -0.3, 0},
        {GENERAL("joint='joint' biasprm='-0.3 0 0'"), "\"joint\": {\"target\": 0.2}", -0.1, 0},
        {GENERAL("joint='joint' gainprm='0' biasprm='0.1 0 0'"), "", 0.1, 0},
        {GENERAL("joint='joint' biasprm='-0.3 0 0'"),
         "\"*\": {\"type\": \"velocity\", \"kd\": 1}, \"joint\": {\"type\": \"torque\"}", -0.3, 0},
        {GENERAL("joint='joint' gainprm='4' biasprm='-0.3 -4 0'"), "\"joint\": {\"type\": \"torque\", \"target\": 0.2}",
         0.2, 0},
        {GENERAL("joint='joint' biasprm='0 0 -0.1'"), "\"joint\": {\"target\": 0.2}", 0.2, 0.1},
        {GENERAL("joint='joint' gear='2' biasprm='-0.3 0 -0.01'"), "\"drive\": {\"target\": 0.2}", -0.4, 0.04},
        {GENERAL("joint='joint' gear='-2' biasprm='-0.3 0 -0.01'"), "", 0.6, 0.04},
        {GENERAL("tendon='tendon' biasprm='-0.3 0 0'"), "\"drive\": {\"target\": 0.2}", -0.02, 0},
        {GENERAL("tendon='tendon' biasprm='-0.3 0 -0.5'"), "\"tendon\": {\"target\": 0.2}", -0.02, 0.02},
        {GENERAL("joint='joint' biasprm='-0.3 0 -0.1'") "<actuator><motor name='m' joint='joint'/></actuator>",
         "\"m\": {\"target\": 0.2}", -0.1, 0.1},
        {"<actuator><motor name='m' joint='joint'/></actuator>", "\"m\": {\"target\": 0.2, \"kd\": 0.1}", 0.2, 0.1},
    };
    static const double INERTIA = 1e-3, STEP = 1e-3;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char more[512], keys[128];
        snprintf(more, sizeof more, "<tendon><fixed name='tendon'><joint joint='joint' coef='0.2'/></fixed></tendon>%s",
                 cases[k].drive);
        snprintf(keys, sizeof keys, ", \"control\": {%s}", cases[k].control);
        scene *s;
        world *w = finger_of("axis='0 1 0'", "0 0 0.1", more, keys, STEP, &s);
        world_run_until(w, 0.02);
        double v = 0, before = 0, d = cases[k].damping;
        for (int i = 0; i < w->steps; i++) {
            before = v;
            v = (INERTIA * v + STEP * cases[k].torque) / (INERTIA + STEP * d);
        }
        const world_joint *j = &w->hands[0].joints[0];
        assert_close(j->velocity, v, 1e-9);
        assert_close(j->torque, INERTIA * (v - before) / STEP, 1e-9);
        world_hand_not_expressed(w, must_not_be_called, NULL);
        end(w, s);
    }
}

/* Where an actuator pulls to a place, its constant moves that place: control moves it too, within its range, but not
 * where the gain is 0. A drive by torque rests where the joint's spring bears it, its constant included. */
static void test_where_constants_of_actuators_lead(void **state)
{
    (void)state;
    static const struct {
        const char *drive, *control;
        double position;
    } cases[] = {
        {GENERAL("joint='joint' gainprm='0' biasprm='0.2 -4 -0.1'"), "", 0.2 / 5},
        {GENERAL("joint='joint' gainprm='0' biasprm='0.2 -4 -0.1'"), "\"joint\": {\"target\": 3}", 0.2 / 5},
        {GENERAL("joint='joint' gainprm='0' biasprm='0.2 -1 -0.1' gear='2'"), "", 0.4 / 5},
        {GENERAL("joint='joint' gainprm='6' biasprm='-0.3 -4 -0.1' ctrlrange='-0.1 0.1'"), "\"joint\": {\"target\": 9}",
         (0.6 - 0.3) / 5},
        {GENERAL("joint='joint' gainprm='4' biasprm='-0.3 -4 0.7'"), "\"joint\": {\"target\": 0.5}", 2.0 / 5},
        {GENERAL("joint='joint' biasprm='-0.3 0 -0.1'"), "", -0.3},
        {GENERAL("joint='joint' biasprm='-0.3 0 -0.1'"), "\"joint\": {\"target\": 0.2}", -0.1},
        {GENERAL("tendon='tendon' biasprm='-0.3 0 -2.5'"), "\"tendon\": {\"target\": 0.2}", -0.02},
        {GENERAL("tendon='tendon' gainprm='0' biasprm='0.3 -100 -2.5'"), "", 0.06 / 5},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char more[512], keys[128];
        snprintf(more, sizeof more, "<tendon><fixed name='tendon'><joint joint='joint' coef='0.2'/></fixed></tendon>%s",
                 cases[k].drive);
        snprintf(keys, sizeof keys, ", \"control\": {%s}", cases[k].control);
        scene *s;
        world *w = finger_of("axis='0 1 0' stiffness='1'", "0 0 0.1", more, keys, 1e-3, &s);
        world_run_until(w, 4);
        assert_close(w->hands[0].joints[0].position, cases[k].position, 1e-9);
        hand_statics x;
        assert_true(hand_statics_solve(s, 0.05, &x));
        assert_close(x.joints[0].position, cases[k].position, 1e-9);
        hand_statics_free(&x);
        end(w, s);
    }
}

#define DRIVE(keys) "<actuator><" keys " name='drive'/></actuator>"

/* The range of control holds what a scene asks of a motor, and a range of forces bounds what any drive exerts, on the
 * side that it is asked for: with a constant torque the finger goes at torque * t / I. */
static void test_ranges_that_are_not_the_same_both_ways(void **state)
{
    (void)state;
    static const struct {
        const char *drive;
        double target, torque;
    } cases[] = {
        {DRIVE("motor joint='joint' ctrlrange='0 1'"), -0.5, 0},
        {DRIVE("motor joint='joint' ctrlrange='0 1'"), 5, 1},
        {DRIVE("motor joint='joint' ctrlrange='0.1 1'"), 0, 0.1},
        {DRIVE("motor joint='joint' gear='-3' ctrlrange='0 1'"), 2, 0},
        {DRIVE("motor joint='joint' gear='-3' ctrlrange='0 1'"), -2, -2},
        {DRIVE("motor joint='joint' gear='2' ctrlrange='-1 1'"), -9, -2},
        {DRIVE("motor tendon='tendon' ctrlrange='0 5'"), -2, 0},
        {DRIVE("motor tendon='tendon' ctrlrange='0 5'"), 2, 0.4},
        {DRIVE("general joint='joint' gainprm='0'"), 2, 0},
        {DRIVE("motor joint='joint' forcerange='-0.2 1'"), -0.5, -0.2},
        {DRIVE("motor joint='joint' forcerange='-0.2 1'"), 0.5, 0.5},
        {DRIVE("motor joint='joint' gear='-2' forcerange='-0.2 1'"), 0.9, 0.4},
        {DRIVE("motor joint='joint' forcerange='0.3 0.4'"), -1, 0.3},
        {DRIVE("position joint='joint' kp='5' kv='0.01' forcerange='-0.2 1'"), -9, -0.2},
        {DRIVE("position joint='joint' kp='5' kv='0.01' forcerange='-0.2 1'"), 9, 1},
        {DRIVE("position tendon='tendon' kp='5' forcerange='5 6'"), 9, 0.8}, /* the tendon lets it have 4 N alone */
        {DRIVE("position tendon='tendon' kp='5' forcerange='-1 0.2'"), 9, 0.04},
        {DRIVE("velocity joint='joint' kv='5' forcerange='-0.2 1'"), -99, -0.2},
        {DRIVE("velocity tendon='tendon' kv='5' forcerange='-0.2 1'"), -99, -0.04},
        {DRIVE("general joint='joint' biastype='affine' biasprm='0 0 -0.001' forcerange='-0.2 1'"), -0.5, -0.2},
        {DRIVE("general joint='joint' biastype='affine' biasprm='-1 0 -0.001' forcerange='-1 0.2'"), 9, 0.2},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char more[384], keys[128];
        snprintf(more, sizeof more,
                 "<tendon><fixed name='tendon' actuatorfrcrange='-10 4'><joint joint='joint' "
                 "coef='0.2'/></fixed></tendon>%s",
                 cases[k].drive);
        snprintf(keys, sizeof keys, ", \"control\": {\"drive\": {\"target\": %g}}", cases[k].target);
        scene *s;
        world *w = finger_of("axis='0 1 0'", "0 0 0.1", more, keys, 1e-3, &s);
        world_run_until(w, 0.01);
        assert_close(w->hands[0].joints[0].torque, cases[k].torque, 1e-12);
        assert_close(w->hands[0].joints[0].velocity, cases[k].torque / 1e-3 * 0.01, 1e-9);
        if (strstr(cases[k].drive, "forcerange"))
            assert_int_equal(w->hands[0].joints[0].saturated, cases[k].torque != cases[k].target);
        world_hand_not_expressed(w, must_not_be_called, NULL);
        end(w, s);
    }
}

/* ODE's own solvers have the damping of a drive by torque as a joint's damper, without a bound. What they lack is said.
 */
static void test_drives_by_torque_and_bounds_under_ode(void **state)
{
    (void)state;
    static const struct {
        const char *drive, *told; /* NULL: moves as under Pinch */
    } cases[] = {
        {GENERAL("joint='joint' biasprm='-0.3 0 -0.1'"), NULL},
        {GENERAL("joint='joint' biasprm='-0.3 0 -0.1' forcerange='-1 1'"),
         "joint: a drive by torque, whose bound does not count its damping"},
        {GENERAL("tendon='tendon' biasprm='-0.3 0 -0.1'"), "tendon: damping of a drive by torque"},
        {DRIVE("position joint='joint' kp='1' forcerange='-0.2 1'"),
         "joint: a bound that is not the same both ways (its larger side)"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char more[384], told[2048] = "";
        snprintf(more, sizeof more, "<tendon><fixed name='tendon'><joint joint='joint' coef='0.2'/></fixed></tendon>%s",
                 cases[k].drive);
        scene *s;
        world *w = finger_of("axis='0 1 0'", "0 0 0.1", more, "", 1e-3, &s), *by_ode;
        world_settings settings = world_default_settings(s);
        char error[256];
        settings.contact_solver = WORLD_WORLDSTEP;
        assert_int_equal(world_create(s, &settings, &by_ode, error), WORLD_OK);
        world_run_until(w, 0.02);
        world_run_until(by_ode, 0.02);
        world_hand_not_expressed(by_ode, add_text, told);
        if (cases[k].told) {
            assert_non_null(strstr(told, cases[k].told));
        } else {
            assert_null(strstr(told, "joint: "));
            assert_close(by_ode->hands[0].joints[0].velocity, w->hands[0].joints[0].velocity, 1e-6);
            assert_close(by_ode->hands[0].joints[0].torque, w->hands[0].joints[0].torque, 1e-6);
        }
        world_free(by_ode);
        end(w, s);
    }
}

/* Within such a range a servo moves the joint as one without a bound does, also on a palm that turns; at either end of
 * it, a spring bears it in the statics as in the run. */
static void test_servos_within_such_a_range(void **state)
{
    (void)state;
    static const char *const ranges[] = {"", "forcerange='-0.2 1'"};
    double position[2], torque[2];
    for (int k = 0; k < 2; k++) {
        char more[256];
        snprintf(more, sizeof more, "<actuator><position joint='joint' kp='1' kv='0.03' %s/></actuator>", ranges[k]);
        scene *s;
        world *w = finger_of("axis='0 1 0'", "0 0 0.1", more,
                             ", \"control\": {\"joint\": {\"target\": 0.2}}, \"base\": {\"drive\": {\"type\": \"path\","
                             " \"points\": [{\"time\": 0}, {\"time\": 1, \"rotation\": [0, 0.3, 0]}]}}",
                             1e-3, &s);
        world_run_until(w, 0.05);
        position[k] = w->hands[0].joints[0].position;
        torque[k] = w->hands[0].joints[0].torque;
        end(w, s);
    }
    assert_close(position[1], position[0], 1e-12);
    assert_close(torque[1], torque[0], 1e-11);
    for (int k = 0; k < 4; k++) {
        char more[384], keys[128];
        bool tendon = k > 1;
        double target = k % 2 ? 9 : -9, force = k % 2 ? 1 : -0.2;
        snprintf(more, sizeof more,
                 "<tendon><fixed name='tendon'><joint joint='joint' coef='0.2'/></fixed></tendon><actuator>"
                 "<position name='drive' %s kp='5' forcerange='-0.2 1'/></actuator>",
                 tendon ? "tendon='tendon'" : "joint='joint'");
        snprintf(keys, sizeof keys, ", \"control\": {\"drive\": {\"target\": %g}}", target);
        scene *s;
        world *w = finger_of("axis='0 1 0' stiffness='1' damping='0.05'", "0 0 0.1", more, keys, 1e-3, &s);
        world_run_until(w, 3);
        assert_close(w->hands[0].joints[0].position, (tendon ? 0.2 : 1) * force, 1e-9);
        hand_statics x;
        assert_true(hand_statics_solve(s, 0.05, &x));
        assert_close(x.joints[0].position, (tendon ? 0.2 : 1) * force, 1e-9);
        hand_statics_free(&x);
        end(w, s);
    }
}

/* Terms that no drive here has are said to be missing. */
static void test_terms_that_drive_motion_on(void **state)
{
    (void)state;
    static const struct {
        const char *drive, *told;
    } cases[] = {
        {GENERAL("joint='joint' biasprm='0 2 0'"),
         "hand: length term of an actuator that pushes away from a place of the file"},
        {GENERAL("joint='joint' biasprm='0 0 0.1'"),
         "hand: speed term of an actuator that drives motion on of the file"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char told[256] = "";
        scene *s;
        world *w = finger_of("axis='0 1 0'", "0 0 0.1", cases[k].drive, "", 1e-3, &s);
        world_hand_not_expressed(w, keep_text, told);
        assert_string_equal(told, cases[k].told);
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
        cmocka_unit_test(test_several_drives_of_a_joint),
        cmocka_unit_test(test_a_damper_beside_a_position),
        cmocka_unit_test(test_a_bound_of_several_drives),
        cmocka_unit_test(test_constants_and_damping_of_torques),
        cmocka_unit_test(test_where_constants_of_actuators_lead),
        cmocka_unit_test(test_terms_that_drive_motion_on),
        cmocka_unit_test(test_ranges_that_are_not_the_same_both_ways),
        cmocka_unit_test(test_servos_within_such_a_range),
        cmocka_unit_test(test_drives_by_torque_and_bounds_under_ode),
    };
    int failed = cmocka_run_group_tests_name("laws of joints, drives and tendons", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
