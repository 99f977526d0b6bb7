/*
 * Objects and tips of many shapes make random grasps, which are closed first and then loaded. In a grasp that holds,
 * the forces at rest balance, nothing creeps, and every step was solved.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/scene_run.h"
#include "support/text.h"

#include <stdio.h>
#include <string.h>

typedef enum object_kind { CUBE = 0, BALL, ROD, PRISM, OBJECTS } object_kind;
typedef enum grip_kind { TWO_PADS = 0, TWO_SOFT, THREE, TWO_PAIRS, GRIPS } grip_kind;

typedef struct plan {
    pinch_random random;
    object_kind object;
    grip_kind grip;
    double size; /* half width of the object, m */
    double mass, mu, load;
    int sides; /* of a prism */
    char name[64];
} plan;

static void describe_object(plan *p, text *t)
{
    add(t, "\"object\": {\"mass\": %.17g, \"shape\": ", p->mass);
    switch (p->object) {
    case CUBE:
        add(t, "{\"type\": \"box\", \"size\": [%.17g, %.17g, %.17g]}", 2 * p->size, 2 * p->size,
            2 * p->size * draw_uniform(&p->random, 0.6, 1.5));
        break;
    case BALL:
        add(t, "{\"type\": \"sphere\", \"radius\": %.17g}", p->size);
        break;
    case ROD:
        add(t, "{\"type\": \"capsule\", \"radius\": %.17g, \"length\": %.17g}", p->size,
            p->size * draw_uniform(&p->random, 2, 5));
        break;
    default: /* a regular polygon with a face towards -x */
        add(t, "{\"type\": \"prism\", \"height\": %.17g, \"vertices\": [", p->size * draw_uniform(&p->random, 1.5, 3));
        for (int k = 0; k < p->sides; k++) {
            double pi = 3.141592653589793, angle = pi + (2 * k - 1) * pi / p->sides, r = p->size / cos(pi / p->sides);
            add(t, "%s[%.17g, %.17g]", k ? ", " : "", r * cos(angle), r * sin(angle));
        }
        add(t, "]}");
    }
    add(t, "},\n");
}

typedef enum drive_kind { CLOSING = 0, NORMAL_FORCE, SLIDER, STILL } drive_kind;

/* A finger at the angle about z (a face's middle, or the round side), `up` above the middle. */
static void describe_finger(plan *p, text *t, double angle, double up, drive_kind drive, bool first)
{
    double n[2] = {-cos(angle), -sin(angle)}, kn = draw_log_uniform(&p->random, 5e3, 5e4);
    bool pad = p->grip == TWO_PADS || draw_chance(&p->random, 0.3);
    bool soft = p->grip == TWO_SOFT || draw_chance(&p->random, 0.3);
    if (p->grip == TWO_PADS && p->object == BALL) soft = true;
    add(t, "%s  {\"point\": [%.17g, %.17g, %.17g], \"normal\": [%.17g, %.17g, 0], ", first ? "" : ",\n",
        -p->size * n[0], -p->size * n[1], up, n[0], n[1]);
    if (pad && p->object != PRISM)
        add(t, "\"tip\": {\"type\": \"box\", \"size\": [0.01, %.17g, %.17g]}, ", p->size, p->size);
    else if (p->object != PRISM && draw_chance(&p->random, 0.3))
        add(t, "\"tip\": {\"type\": \"capsule\", \"radius\": %.17g, \"length\": %.17g}, ", 0.3 * p->size,
            0.8 * p->size);
    else
        add(t, "\"tip\": {\"type\": \"sphere\", \"radius\": %.17g}, ", p->size * draw_uniform(&p->random, 0.2, 0.6));
    add(t, "\"model\": \"%s\", \"friction\": %.17g, \"stiffness\": {\"normal\": %.17g, \"tangential\": %.17g",
        soft ? "soft" : "hard", p->mu, kn, kn * draw_uniform(&p->random, 0.4, 1));
    if (soft) add(t, ", \"torsional\": %.17g", kn * 1e-4);
    /* near critical for the object on a few such springs, so that it comes to rest in time */
    double c = sqrt(kn * p->mass);
    add(t, "}, \"damping\": {\"normal\": %.17g, \"tangential\": %.17g", c, c);
    if (soft) add(t, ", \"torsional\": %.17g", c * 1e-4);
    add(t, "}, ");
    if (soft) add(t, "\"torsional_friction\": %.17g, ", 0.3 * p->size);
    if (drive == CLOSING) add(t, "\"closing\": %.17g, ", p->load / kn);
    if (drive == NORMAL_FORCE) add(t, "\"normal_force\": %.17g, ", p->load);
    if (drive == SLIDER)
        add(t, "\"drive\": {\"type\": \"slider\", \"mass\": %.17g, \"force\": %.17g, \"damping\": %.17g}, ",
            p->mass * draw_uniform(&p->random, 0.3, 2), p->load, 2 * c);
    add(t, "\"ramp\": 0.3}");
}

/* One side of each opposing pair stands still or closes, so that the pair has a place; any kind may push from the
 * other. */
static void describe_pair(plan *p, text *t, double angle, double up, bool first)
{
    drive_kind drive = (drive_kind)draw_index(&p->random, 3);
    describe_finger(p, t, angle, up, drive, first);
    describe_finger(p, t, angle + 3.141592653589793, up, drive == CLOSING ? CLOSING : STILL, false);
}

static scene *make_grasp(uint64_t seed, char name[64])
{
    static const char *const objects[OBJECTS] = {"box", "sphere", "capsule", "prism"};
    static const char *const grips[GRIPS] = {"two pads", "two soft tips", "three fingers", "two pairs"};
    static text t;
    plan p = {.sides = 4};
    t.used = 0;
    pinch_random_seed(&p.random, seed);
    p.object = (object_kind)draw_index(&p.random, OBJECTS);
    p.grip = (grip_kind)draw_index(&p.random, GRIPS);
    if (p.grip == TWO_PADS && p.object == PRISM) p.grip = TWO_SOFT;
    if (p.grip == THREE && p.object == CUBE) p.object = PRISM;
    if (p.grip == THREE) p.sides = draw_chance(&p.random, 0.5) ? 3 : 6;
    p.size = draw_log_uniform(&p.random, 0.008, 0.05);
    p.mass = draw_log_uniform(&p.random, 0.02, 0.5);
    p.mu = draw_uniform(&p.random, 0.3, 1);
    int fingers = p.grip == THREE ? 3 : p.grip == TWO_PAIRS ? 4 : 2;
    /* each finger can carry its part of the weight 3 to 8 times: the stiffer ones take more than their part, and a
     * third finger gets less than its own force where friction helps the two against it */
    p.load = p.mass * 9.81 / (p.mu * fingers) * draw_uniform(&p.random, 3, 8);
    snprintf(name, 64, "%s, %s", objects[p.object], grips[p.grip]);

    add(&t, "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0],\n");
    describe_object(&p, &t);
    add(&t, "\"fingers\": [\n");
    double up = draw_uniform(&p.random, -0.2, 0.2) * p.size, pi = 3.141592653589793;
    if (p.object == BALL) up = 0;
    if (p.grip == THREE) {
        /* Three forces at 120 degrees balance. Two that push against a third are half carried by each other's friction
         * and leave the third less than its part of the weight; a sphere, which cannot do without it, rolls out. */
        drive_kind drive = draw_chance(&p.random, 0.5) || p.object == BALL ? CLOSING : SLIDER;
        for (int k = 0; k < 3; k++)
            describe_finger(&p, &t, pi + 2 * pi * k / 3, up, drive == SLIDER && k == 0 ? STILL : drive, k == 0);
    } else {
        describe_pair(&p, &t, pi, up, true);
        if (p.grip == TWO_PAIRS) describe_pair(&p, &t, pi / 2, up, false);
    }
    add(&t, "],\n\"schedule\": [{\"time\": 0, \"gravity\": [0, 0, 0]}, {\"time\": 0.6, \"gravity\": [0, 0, 0]}, "
            "{\"time\": 1, \"gravity\": [0, 0, -9.81]}],\n\"simulation\": {\"duration\": 10}}\n");
    return scene_from_text(t.bytes);
}

/* found by the full count, and kept: a capsule that runs out over its pads, at the edge of what counts as flat */
static const int hard_seeds[] = {433};
enum { HARD_SEEDS = sizeof hard_seeds / sizeof hard_seeds[0] };

/* Unconverged steps are reported but allowed where the second try finds the answer; a fallback is no answer. */
static void test_held_grasps_come_to_rest(void **state)
{
    (void)state;
    int wrong = 0, retried = 0, dropped = 0, count = draw_count(3000);
    for (int k = 1 - HARD_SEEDS; k <= count; k++) {
        int seed = k > 0 ? k : hard_seeds[-k];
        char name[64];
        scene *s = make_grasp((uint64_t)seed, name);
        world *w = world_of(s);
        simulation *run = simulation_start(w);
        simulation_result r;
        assert_non_null(run);
        while (w->steps < simulation_steps(run)) assert_int_equal(simulation_step(run), WORLD_OK);
        simulation_finish(run, &r);
        balance_at_rest left = world_balance(w);
        pinch_ode_stats stats = pinch_ode_statistics(w->plugin);
        int fell = 0;
        for (int e = 0; e < r.event_count; e++) fell += r.events[e].type == EVENT_DROPPED;
        const char *fault = stats.fallback_islands > 0       ? "a step was left to ODE"
                            : fell                           ? "dropped"
                            : !(left.force <= 1e-9)          ? "forces do not balance"
                            : !(left.moment <= 1e-9)         ? "moments do not balance"
                            : !(left.cone <= 1e-9)           ? "outside the cone"
                            : !(r.motion.creep <= 1e-12)     ? "creeps"
                            : !(r.speed_max <= 1e-10)        ? "moves"
                            : !(stats.residual_max <= 1e-10) ? "residual"
                                                             : NULL;
        retried += stats.unconverged_steps > 0;
        dropped += fell;
        if (fault) {
            wrong++;
            print_error("seed %d (%s): %s; %g N, %g N m, creep %g m/s, fastest %g m/s, %ld unconverged steps, %ld "
                        "fallbacks, residual %g\n",
                        seed, name, fault, left.force, left.moment, r.motion.creep, r.speed_max,
                        stats.unconverged_steps, stats.fallback_islands, stats.residual_max);
        }
        simulation_free(&r);
        world_free(w);
        scene_free(s);
    }
    print_message("%d grasps, %d with a step that needed a second try\n", count, retried);
    assert_int_equal(wrong, 0);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_held_grasps_come_to_rest)};
    int failed = cmocka_run_group_tests_name("random grasps", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
