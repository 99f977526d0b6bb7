/* A finger that is pressed by a known torque, and hands of chance on objects of chance. */
#include "support/cmocka_all.h"
#include "support/draw.h"
#include "support/program.h"
#include "support/scene_run.h"

#include "hands/hand.h"
#include "scenes/world/world_hand.h"
#include "statics/hand_statics.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A bar on one hinge presses a ball on its end against a fixed block, whose face stands across the bar's way: the block
 * is pushed with torque over lever arm, whatever the stiffness. `control` drives the hinge. */
static world *pressing(const char *control, scene **s)
{
    static const char hand_text[] =
        "<mujoco><compiler angle='radian'/><worldbody><body name='base'><geom type='sphere' size='0.005' mass='0.1'"
        " contype='0' conaffinity='0'/>"
        "<body name='bar'><joint name='hinge' axis='0 1 0' range='-1 1' damping='0.01' armature='1e-4'/>"
        "<geom name='ball' type='sphere' size='0.01' pos='0.08 0 0' mass='0.05'/></body></body></worldbody></mujoco>";
    char text[2048], *folder = program_make_folder();
    free(program_write_file(folder, "bar.xml", hand_text));
    snprintf(text, sizeof text,
             "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0],"
             " \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.1, 0.1, 0.02]}, \"mass\": 1,"
             "  \"position\": [0.08, 0, -0.0201]},"
             " \"environment\": [{\"name\": \"ground\", \"shape\": {\"type\": \"box\", \"size\": [1, 1, 0.1]},"
             "  \"position\": [0, 0, -0.08], \"stiffness\": {\"normal\": 1e6}, \"damping\": {\"normal\": 1000},"
             "  \"friction\": 0.5}],"
             " \"hand\": {\"file\": \"%s/bar.xml\", \"control\": {\"hinge\": %s},"
             "  \"contacts\": {\"*\": {\"model\": \"frictionless\", \"stiffness\": {\"normal\": 5000},"
             "   \"damping\": {\"normal\": 5}}}}}",
             folder, control);
    *s = scene_from_text(text);
    program_remove_folder(folder);
    return world_of(*s);
}

static void check_lever(const char *control, double torque)
{
    scene *s;
    world *w = pressing(control, &s);
    world_run_until(w, 3);
    const world_finger_state *f = NULL;
    for (int i = 0; i < w->finger_count; i++)
        if (w->fingers[i].state.points > 0) f = &w->fingers[i].state;
    assert_non_null(f);
    assert_close(w->hands[0].joints[0].torque, torque, 0);
    /* the hinge is at the origin, its axis along y: the moment of the finger's force about it balances the torque */
    double about = f->point[2] * f->force[0] - f->point[0] * f->force[2];
    assert_close(about, torque, 1e-9);
    pinch_ode_stats stats = pinch_ode_statistics(w->plugin);
    assert_int_equal(stats.unconverged_steps + stats.fallback_islands, 0);
    assert_true(fabs(w->ledger.closure) <= 1e-9 * w->ledger.work_size);
    world_free(w);
    scene_free(s);
}

static void test_torque_over_lever_arm(void **state)
{
    (void)state;
    check_lever("{\"type\": \"torque\", \"target\": 0.4}", 0.4);
    check_lever("{\"type\": \"torque\", \"target\": 3, \"max_force\": 0.25}", 0.25);
    check_lever("{\"type\": \"position\", \"kp\": 50, \"kd\": 0.5, \"target\": 0.9, \"max_force\": 0.3}", 0.3);
    check_lever("{\"type\": \"velocity\", \"kd\": 5, \"target\": 2, \"max_force\": 0.2}", 0.2);
}

/* A body on one joint without damping or friction follows its motor and touches nothing: what the motor has to push
 * with dies away until it is much less than what rounding leaves of m v / h. */
static void test_motors_whose_force_dies_away(void **state)
{
    (void)state;
    static const struct {
        const char *joint, *control;
        double end; /* m, rad or, where it is INFINITY, not known */
    } cases[] = {
        {"slide", "{\"type\": \"position\", \"kp\": 2000, \"kd\": 20, \"target\": [[0, 0], [1, 0.1]]}", 0.1},
        {"slide", "{\"type\": \"velocity\", \"kd\": 1000, \"target\": 0.1}", INFINITY},
        {"slide", "{\"type\": \"velocity\", \"kd\": 100, \"target\": 0.1}", INFINITY},
        {"slide",
         "{\"type\": \"position\", \"kp\": 1e6, \"kd\": 100, \"target\": [[0, 0], [1, 0.1]], \"max_force\": 3}", 0.1},
        {"hinge", "{\"type\": \"position\", \"kp\": 2, \"kd\": 0.02, \"target\": [[0, 0], [1, 0.1]]}", 0.1},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char text[2048], *folder = program_make_folder();
        snprintf(text, sizeof text,
                 "<mujoco><compiler angle='radian'/><worldbody><body name='base'><geom type='sphere' size='0.005'"
                 " mass='1'/><body name='finger'><joint name='joint' type='%s' axis='1 0 0' range='-1 1'/>"
                 "<geom type='box' size='0.005 0.015 0.015' mass='0.1'/></body></body></worldbody></mujoco>",
                 cases[k].joint);
        free(program_write_file(folder, "hand.xml", text));
        snprintf(text, sizeof text,
                 "{\"format\": \"pinch-scene/1\","
                 " \"object\": {\"shape\": {\"type\": \"sphere\", \"radius\": 0.02}, \"mass\": 0.1,"
                 "  \"position\": [0, 1, 0.5]},"
                 " \"hand\": {\"file\": \"%s/hand.xml\", \"base\": {\"position\": [0, 0, 0.5]},"
                 "  \"control\": {\"joint\": %s}}}",
                 folder, cases[k].control);
        scene *s = scene_from_text(text);
        program_remove_folder(folder);
        world *w = world_of(s);
        world_run_until(w, 1.5);
        pinch_ode_stats stats = pinch_ode_statistics(w->plugin);
        assert_int_equal(stats.unconverged_steps + stats.fallback_islands, 0);
        assert_true(fabs(w->ledger.closure) <= 1e-9 * w->ledger.work_size);
        if (isfinite(cases[k].end)) assert_close(w->hands[0].joints[0].position, cases[k].end, 1e-9);
        world_free(w);
        scene_free(s);
    }
}

/* Two bars on hinges without damping, friction or armature swing and touch nothing: their motor's and their weight's
 * work is all in their motion. */
static void test_energy_of_a_finger_that_touches_nothing(void **state)
{
    (void)state;
    static const char hand_text[] =
        "<mujoco><compiler angle='radian'/><worldbody><body name='base'><geom type='sphere' size='0.005' mass='0.1'/>"
        "<body name='bar'><joint name='first' axis='0 1 0' range='-1 1'/>"
        "<geom type='capsule' size='0.01' fromto='0 0 0 0.06 0 0' mass='0.05'/>"
        "<body name='end' pos='0.08 0 0'><joint name='second' axis='0 1 0' range='-1 1'/>"
        "<geom type='capsule' size='0.01' fromto='0.02 0 0 0.06 0 0' "
        "mass='0.03'/></body></body></body></worldbody></mujoco>";
    char text[1024], *folder = program_make_folder();
    free(program_write_file(folder, "bars.xml", hand_text));
    snprintf(text, sizeof text,
             "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"sphere\", \"radius\": 0.01},"
             " \"mass\": 0.1, \"position\": [0, 1, 0]},"
             " \"hand\": {\"file\": \"%s/bars.xml\", \"control\": {\"first\": {\"type\": \"position\", \"kp\": 3,"
             "  \"kd\": 0.02, \"max_force\": 0.3, \"target\": [[0, 0], [0.2, 0.6], [0.5, -0.4]]},"
             "  \"second\": {\"type\": \"velocity\", \"kd\": 0.05, \"target\": 2, \"max_force\": 0.1}}}}",
             folder);
    scene *s = scene_from_text(text);
    program_remove_folder(folder);
    world *w = world_of(s);
    world_run_until(w, 0.8);
    assert_true(w->ledger.work_size > 0.05);
    assert_true(fabs(w->ledger.closure) <= 1e-9 * w->ledger.work_size);
    assert_true(pinch_ode_statistics(w->plugin).joints_solved > 0);
    world_free(w);
    scene_free(s);
}

/* A bar of 50 g whose weight is taken off by a part, with a ball of 30 g fixed to its end, on a position drive. All is
 * accelerated upwards. */
static world *relieved_bar(double part, double gear, const char *control, scene **s)
{
    char text[1536], *folder = program_make_folder();
    snprintf(
        text, sizeof text,
        "<mujoco><compiler angle='radian'/><worldbody><body name='base'><geom type='sphere' size='0.005' mass='0.1'/>"
        "<body name='bar' gravcomp='%g'><joint name='hinge' axis='0 -1 0'/>"
        "<geom type='capsule' size='0.01' fromto='0 0 0 0.1 0 0' mass='0.05'/>"
        "<body name='ball' pos='0.12 0 0'><geom type='sphere' size='0.01' mass='0.03'/></body></body></body>"
        "</worldbody><actuator><position name='drive' joint='hinge' kp='2' kv='0.02' gear='%g' ctrlrange='-0.3 0.6'/>"
        "</actuator></mujoco>",
        part, gear);
    free(program_write_file(folder, "bar.xml", text));
    snprintf(text, sizeof text,
             "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"sphere\", \"radius\": 0.01},"
             " \"mass\": 0.1, \"position\": [0, 1, 0]}, \"hand\": {\"file\": \"%s/bar.xml\", \"joints\":"
             " {\"hinge\": -0.4}, \"control\": {%s}}, \"environment\": [{\"name\": \"table\", \"shape\":"
             " {\"type\": \"box\", \"size\": [0.5, 0.5, 0.2]}, \"position\": [0, 1, -0.11], \"stiffness\":"
             " {\"normal\": 1e5}, \"damping\": {\"normal\": 50}, \"friction\": 0.5}], \"schedule\": [{\"time\": 0,"
             " \"base_acceleration\": [0, 0, 3]}]}",
             folder, control);
    *s = scene_from_text(text);
    program_remove_folder(folder);
    world *w = world_of(*s);
    world_run_until(w, 3);
    assert_true(fabs(w->ledger.closure) <= 1e-8 * w->ledger.work_size);
    return w;
}

/* gravcomp takes its part of a link's weight off, in a run and at its end; what is fixed to the link keeps its own. */
static void test_weight_that_is_taken_off(void **state)
{
    (void)state;
    static const double PARTS[] = {0, 0.5, 1, 1.7};
    for (int k = 0; k < 4; k++) {
        scene *s;
        world *w = relieved_bar(PARTS[k], 2, "\"drive\": {\"target\": 0.2}", &s);
        const world_joint *j = &w->hands[0].joints[0];
        double load = 12.81 * (0.05 * 0.05 + 0.03 * 0.12) - 9.81 * PARTS[k] * 0.05 * 0.05;
        double weight = cos(j->position) * load;
        assert_close(j->velocity, 0, 1e-9);
        assert_close(j->torque, weight, 1e-9);
        assert_close(j->position, 0.2 - weight / (2 * 2 * 2), 1e-9);
        hand_statics x;
        assert_true(hand_statics_solve(s, 3, &x));
        assert_int_equal(x.joint_count, 1);
        assert_close(x.joints[0].torque, weight, 1e-9);
        assert_close(x.joints[0].weight_torque, -weight, 1e-9);
        hand_statics_free(&x);
        world_free(w);
        scene_free(s);
    }
}

/* Targets are held within the range of control of the file, as gear and gain turn it into positions; where a scene says
 * none, the joint stays where it starts. */
static void test_targets_beyond_the_range_of_control(void **state)
{
    (void)state;
    static const struct {
        const char *control;
        double position, kp, gear;
    } cases[] = {
        {"\"drive\": {\"target\": 1}", 0.3, 8, 2},
        {"\"drive\": {\"target\": -1}", -0.15, 8, 2},
        {"\"drive\": {\"target\": [[0, 0], [1, 0.25], [2, 2]]}", 0.3, 8, 2},
        {"\"drive\": {\"kd\": 0.1}", -0.4, 8, 2},
        {"\"drive\": {\"target\": 0.7, \"kp\": 4, \"kd\": 0.1}", 0.7, 4, 0}, /* no control moves it */
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        scene *s;
        world *w = relieved_bar(1, cases[k].gear, cases[k].control, &s);
        const world_joint *j = &w->hands[0].joints[0];
        double weight = cos(j->position) * (12.81 * (0.05 * 0.05 + 0.03 * 0.12) - 9.81 * 0.05 * 0.05);
        assert_close(j->position, cases[k].position - weight / cases[k].kp, 1e-9);
        world_free(w);
        scene_free(s);
    }
}

/* Dry friction takes its torque times the way, also from a joint that is flung, at 80 rad/s in steps of 1 ms, whose
 * other rows take back errors of position. */
static void test_dry_friction_of_a_flung_finger(void **state)
{
    (void)state;
    static const double FRICTION = 0.001;
    static const char hand_text[] =
        "<mujoco><compiler angle='radian'/><worldbody><body name='base'><geom type='sphere' size='0.005' mass='0.1'/>"
        "<body name='bar'><joint name='hinge' axis='0 1 0' range='-2 2' frictionloss='0.001'/>"
        "<geom type='capsule' size='0.008' fromto='0 0 0 0 0 -0.06' mass='0.05'/></body></body></worldbody></mujoco>";
    char text[1024], *folder = program_make_folder();
    free(program_write_file(folder, "bar.xml", hand_text));
    snprintf(text, sizeof text,
             "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"sphere\", \"radius\": 0.01},"
             " \"mass\": 0.1, \"position\": [0, 1, 0]}, \"hand\": {\"file\": \"%s/bar.xml\", \"control\": {\"hinge\":"
             " {\"type\": \"torque\", \"target\": 0.8}}}}",
             folder);
    scene *s = scene_from_text(text);
    program_remove_folder(folder);
    world *w = world_of(s);
    double way = 0, at = w->hands[0].joints[0].position;
    for (int step = 1; step <= 40 && !w->hands[0].joints[0].at_limit; step++) {
        assert_close(w->ledger.friction, FRICTION * way, 0.02 * FRICTION * way + 1e-12);
        world_run_until(w, 1e-3 * step);
        way += fabs(w->hands[0].joints[0].position - at);
        at = w->hands[0].joints[0].position;
    }
    assert_true(way > 1.5);
    assert_true(fabs(w->ledger.closure) <= 1e-9 * w->ledger.work_size);
    world_free(w);
    scene_free(s);
}

/* ---- Random grasps. ---- */

static const struct hand_kind {
    const char *file, *base;
    double centre[3], spread, reach; /* of the object's place; how far joints are closed */
    const char *joints;              /* a start that leaves room */
} kinds[] = {
    {"three-finger.urdf", "palm", {0, 0, 0.11}, 0.01, 0.6, "\"f*_mcp\": -0.3, \"f*_pip\": 0.5"},
    {"allegro-like.urdf", "palm", {0.08, 0.01, 0.02}, 0.01, 0.6, "\"*_mcp\": 0.5, \"*_pip\": 0.6, \"thumb_rot\": 1.2"},
    {"parallel-gripper.urdf", "hand", {0, 0, 0.12}, 0.004, -0.02, "\"left_finger_slide\": 0.038"},
    {"robotiq-like.xml", "base", {0, 0, 0.145}, 0.004, 0.6, "\"*_driver_joint\": 0.05"},
    {"shadow-like.xml", "palm", {0.005, -0.05, 0.13}, 0.01, 0.7, "\"?FJ3\": 0.5, \"?FJ2\": 0.4, \"THJ4\": 1"},
};

static void draw_object(pinch_random *random, char *text, size_t size)
{
    double r = draw_uniform(random, 0.015, 0.028), q[9];
    draw_frame(random, q);
    const char *shape =
        (const char *[]){"{\"type\": \"sphere\", \"radius\": %g}", "{\"type\": \"box\", \"size\": [%g, %g, %g]}",
                         "{\"type\": \"cylinder\", \"radius\": %g, \"length\": %g}",
                         "{\"type\": \"capsule\", \"radius\": %g, \"length\": %g}"}[draw_index(random, 4)];
    double a = strstr(shape, "box") ? 2 * r : r, b = draw_uniform(random, 0.03, 0.06);
    snprintf(text, size, shape, a, b, draw_uniform(random, 0.03, 0.06)); /* further values are left out */
}

/* What became of the grasps of a hand. An answer that fails its verification counts as unconverged. */
static struct hand_tally {
    int grasps, touching;              /* touching: with a contact when it ended */
    long steps, contacts, unconverged; /* contacts are summed over steps */
    long islands_left, joints_left, too_soft;
} tallies[5];

static void add_to_tally(struct hand_tally *t, const pinch_ode_stats *stats, bool touching)
{
    t->grasps++;
    t->touching += touching;
    t->steps += stats->steps;
    t->contacts += stats->contacts_solved;
    t->unconverged += stats->unconverged_steps;
    t->islands_left += stats->fallback_islands;
    t->joints_left += stats->joints_left;
    t->too_soft += stats->too_soft_islands;
}

static bool touches(const world *w)
{
    const pinch_ode_contact *list;
    int count;
    assert_int_equal(pinch_ode_contacts(w->plugin, &list, &count), PINCH_OK);
    return count > 0;
}

/* Closes a hand within 0.3 s; weight comes while it closes, or objects would have fallen out by then. Returns whether
 * all steps were solved and verified. */
static bool random_grasp(pinch_random *random, int number)
{
    const struct hand_kind *k = &kinds[number % 5];
    char shape[256], text[2048];
    double down[3], mu = draw_uniform(random, 0.3, 1.2), close = k->reach * draw_uniform(random, 0.4, 1.3);
    draw_object(random, shape, sizeof shape);
    draw_direction(random, down);
    bool soft = draw_chance(random, 0.5), own = strstr(k->file, ".xml") != NULL, grip = strstr(k->file, "parallel");
    double x[3];
    for (int i = 0; i < 3; i++) x[i] = k->centre[i] + draw_uniform(random, -k->spread, k->spread);
    char gains[128] = "";
    if (!own) snprintf(gains, sizeof gains, "\"kp\": %g, \"kd\": %g,", grip ? 3000.0 : 3.0, grip ? 60.0 : 0.06);
    double start = grip ? 0.038 : 0, damping = draw_uniform(random, 0, 20);
    double stiffness = draw_log_uniform(random, 2000, 50000);
    bool touches_itself = draw_chance(random, 0.3);
    double mass = draw_log_uniform(random, 0.02, 0.3);
    snprintf(text, sizeof text,
             "{\"format\": \"pinch-scene/1\", \"schedule\": [{\"time\": 0, \"gravity\": [0, 0, 0]},"
             "  {\"time\": 0.25, \"gravity\": [0, 0, 0]}, {\"time\": 0.35, \"gravity\": [%g, %g, %g]}],"
             " \"object\": {\"shape\": %s, \"mass\": %g, \"position\": [%g, %g, %g]},"
             " \"hand\": {\"file\": \"" PINCH_SOURCE_DIR "/assets/hands/%s\", \"joints\": {%s}, \"self_collision\": %s,"
             "  \"control\": {\"*\": {\"type\": \"position\", %s \"target\": [[0, %g], [0.3, %g]]}},"
             "  \"contacts\": {\"*\": {\"model\": \"%s\", \"friction\": %g, \"torsional_friction\": 0.002,"
             "   \"stiffness\": {\"normal\": %g, \"torsional\": 0.2}, \"damping\": {\"normal\": %g}}}}}",
             9.81 * down[0], 9.81 * down[1], 9.81 * down[2], shape, mass, x[0], x[1], x[2], k->file, k->joints,
             touches_itself ? "true" : "false", gains, start, start + close, soft ? "soft" : "hard", mu, stiffness,
             damping);
    scene *s = scene_from_text(text);
    world *w = world_of(s);
    world_run_until(w, draw_full() ? 0.6 : 0.35);
    pinch_ode_stats stats = pinch_ode_statistics(w->plugin);
    bool fine = !stats.unconverged_steps && !stats.fallback_islands && !stats.joints_left && !stats.too_soft_islands;
    add_to_tally(&tallies[number % 5], &stats, touches(w));
    if (!fine)
        print_error("grasp %d (%s): %ld of %ld steps unconverged, %ld islands and %ld joints left to ODE: %s\n", number,
                    k->file, stats.unconverged_steps, stats.steps, stats.fallback_islands, stats.joints_left, text);
    world_free(w);
    scene_free(s);
    return fine;
}

static int first_grasp, grasp_count;

static void test_random_grasps(void **state)
{
    (void)state;
    int failed = 0;
    for (int number = first_grasp; number < first_grasp + grasp_count; number++) {
        pinch_random random;
        pinch_random_seed(&random, (uint64_t)number + 1);
        failed += !random_grasp(&random, number);
    }
    for (int i = 0; i < 5; i++) {
        const struct hand_tally *t = &tallies[i];
        print_message(
            "%s: %d grasps (%d touch at the end), %ld steps, %ld contacts; %ld steps unconverged, %ld islands "
            "and %ld joints left to ODE, %ld islands too soft\n",
            kinds[i].file, t->grasps, t->touching, t->steps, t->contacts, t->unconverged, t->islands_left,
            t->joints_left, t->too_soft);
    }
    assert_int_equal(failed, 0);
}

/* The arguments are the first random grasp and how many follow; grasp k has hand k modulo 5. */
int main(int argc, char **argv)
{
    enum { GRASPS = 5000 }; /* a thousand with each hand */
    first_grasp = argc > 1 ? atoi(argv[1]) : 0;
    grasp_count = argc > 2 ? atoi(argv[2]) : draw_full() ? GRASPS : 10;
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_torque_over_lever_arm),
        cmocka_unit_test(test_motors_whose_force_dies_away),
        cmocka_unit_test(test_energy_of_a_finger_that_touches_nothing),
        cmocka_unit_test(test_weight_that_is_taken_off),
        cmocka_unit_test(test_targets_beyond_the_range_of_control),
        cmocka_unit_test(test_dry_friction_of_a_flung_finger),
        cmocka_unit_test(test_random_grasps),
    };
    int failed = cmocka_run_group_tests_name("hands that press and grasp", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
