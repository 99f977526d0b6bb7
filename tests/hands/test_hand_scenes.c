/*
 * Every shipped scene with a hand holds its object to the end, every step of it is solved and verified, and nothing is
 * left to ODE. At rest motors give what their law says, ties and loops hold, and nothing creeps.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"
#include "support/draw.h"
#include "support/platform.h"
#include "support/program.h"
#include "support/scene_run.h"

#include "hands/hand.h"
#include "scenes/world/world_hand.h"

#include <glob.h>
#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static int wrong;
static const char *asked_for = ""; /* scenes with this in their names */

static void refuse(const char *name, const char *what, double value)
{
    print_error("%s: %s %g\n", name, what, value);
    wrong++;
}

/* What holds at rest, joint by joint: kp (target - q) to 1e-10, a motor at its bound to the bit, ties to 1e-12. */
static void check_joints(const char *name, const world *w)
{
    for (int k = 0; k < w->hand_count; k++) {
        const world_hand *h = &w->hands[k];
        for (int i = 0; i < h->joint_count; i++) {
            const world_joint *j = &h->joints[i];
            const scene_control *c = j->control;
            if (c->type != SCENE_POSITION_CONTROL) continue;
            double asked = c->kp * (j->target - j->position);
            if (fabs(asked) > c->max_force) {
                if (fabs(j->own_torque) != c->max_force || !j->saturated) refuse(name, "a bound missed", j->own_torque);
            } else if (!(fabs(j->own_torque - asked) <= 1e-10)) {
                refuse(name, "a motor is off by", j->own_torque - asked);
            }
        }
        for (int i = 0; i < h->tie_count; i++) {
            const world_tie *t = &h->ties[i];
            double x = -t->law.target - t->offset;
            for (int j = 0; j < t->terms; j++) x += t->factor[j] * h->joints[t->joint[j]].position;
            if (t->tendon < 0 && !(fabs(x) <= 1e-12)) refuse(name, "a tie is off by", x);
            if (!t->control || t->control->type != SCENE_POSITION_CONTROL) continue;
            double asked = -t->law.kp * x, most = t->control->max_force;
            if (fabs(asked) > most ? fabs(t->force) != most : !(fabs(t->force - asked) <= 1e-10))
                refuse(name, "a tendon is off by", t->force - asked);
        }
        if (!(world_loop_gap(h) <= 1e-10)) refuse(name, "a loop is open by", world_loop_gap(h));
    }
}

/* After the scene the hand stands still: what is held must not move any more. */
static void check_rest(const char *name, world *w, bool full)
{
    double x[3], moved[3], seconds = full ? 60 : 0.5;
    /* a wrist with damping 0.5 N m s/rad loses a digit in a third of a second, a finger that slips on the turned sphere
     * one in 1.1 s */
    world_run_until(w, w->time + (full ? 12 : 1));
    memcpy(x, dBodyGetPosition(w->object), sizeof x);
    world_run_until(w, w->time + seconds);
    for (int i = 0; i < 3; i++) moved[i] = dBodyGetPosition(w->object)[i] - x[i];
    double creep = sqrt(moved[0] * moved[0] + moved[1] * moved[1] + moved[2] * moved[2]) / seconds;
    if (!(creep <= 1e-12)) refuse(name, "creep in m/s", creep);
    check_joints(name, w);
}

static void compare_bits(const char *name, const world *w, const json_t *hashes)
{
    char hash[17];
    if (!hashes) return;
    snprintf(hash, sizeof hash, "%016" PRIx64, world_hash(w));
    const char *golden = json_string_value(json_object_get(hashes, name));
    if (golden && strcmp(golden, hash) == 0) return;
    print_error("%s ends in %s, not in %s as it did\n", name, hash, golden ? golden : "(none)");
    wrong++;
}

/* The whole of all scenes takes minutes. The quick tests run one scene of a kind to its end, and of others the start.
 */
static bool runs_whole(const char *name)
{
    static const char *const some[] = {"three-finger-lift.json", "robotiq-like-peg.json",
                                       "parallel-gripper-hand-over.json"};
    for (size_t i = 0; i < sizeof some / sizeof *some; i++)
        if (strcmp(some[i], name) == 0) return true;
    return draw_full() || *asked_for;
}

static void check_scene(const char *path, const json_t *hashes)
{
    const char *name = file_name(path);
    bool whole = runs_whole(name);
    scene *s;
    scene_error error;
    simulation_result r;
    if (scene_load(path, &s, &error) != SCENE_OK) fail_msg("%s", error.text);
    world *w = world_of(s);
    simulation *run = simulation_start(w);
    for (long k = 0; k < (whole ? simulation_steps(run) : 40); k++) assert_int_equal(simulation_step(run), WORLD_OK);
    simulation_finish(run, &r);
    if (whole && strcmp(simulation_outcome(&r), "held") != 0) refuse(name, "not held; events", r.event_count);
    if (!(fabs(w->ledger.closure) <= 1e-8 * w->ledger.work_size)) refuse(name, "energy closes to", w->ledger.closure);
    if (whole) compare_bits(name, w, hashes);
    if (whole) check_rest(name, w, draw_full());
    pinch_ode_stats stats = pinch_ode_statistics(w->plugin);
    if (stats.unconverged_steps) refuse(name, "unconverged steps", (double)stats.unconverged_steps);
    if (stats.fallback_islands + stats.contacts_left_unsolved + stats.joints_left)
        refuse(name, "left to ODE", (double)stats.fallback_islands);
    simulation_free(&r);
    world_free(w);
    scene_free(s);
}

static void test_every_scene(void **state)
{
    (void)state;
    enum { LEAST = 38 };
    glob_t found;
    char hash[17];
    json_error_t error;
    json_t *golden =
        json_load_file(PINCH_SOURCE_DIR "/assets/reference/hands/hashes.json", JSON_REJECT_DUPLICATES, &error);
    assert_non_null(golden);
    snprintf(hash, sizeof hash, "%016" PRIx64, platform_fingerprint());
    bool comparable = strcmp(json_string_value(json_object_get(golden, "versions")), platform_versions()) == 0 &&
                      strcmp(json_string_value(json_object_get(golden, "fingerprint")), hash) == 0;
    assert_int_equal(glob(PINCH_SOURCE_DIR "/assets/scenes/hands/*.json", 0, NULL, &found), 0);
    assert_true(found.gl_pathc >= LEAST);
    for (size_t i = 0; i < found.gl_pathc; i++)
        if (strstr(file_name(found.gl_pathv[i]), asked_for))
            check_scene(found.gl_pathv[i], comparable ? json_object_get(golden, "scenes") : NULL);
    globfree(&found);
    json_decref(golden);
    assert_int_equal(wrong, 0);
}

/* The argument is a part of the names of scenes: these alone are run, to their end. */
int main(int argc, char **argv)
{
    if (argc > 1) asked_for = argv[1];
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_scene),
    };
    int failed = cmocka_run_group_tests_name("scenes with hands", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
