/*
 * The statics of the exact cone against slow motion in ODE: boxes held by round tips, closed first, then loaded. The
 * statics are about the undeformed pose; what is left of the difference comes from the displacements, F/kn over the
 * object's size L, and goes with them.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/scene_run.h"

#include "grasp.h"

#include <stdio.h>
#include <string.h>

typedef struct text {
    char bytes[16384];
    size_t used;
} text;

static void add(text *t, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void add(text *t, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    int n = vsnprintf(t->bytes + t->used, sizeof t->bytes - t->used, format, arguments);
    va_end(arguments);
    assert_true(n > 0 && t->used + (size_t)n < sizeof t->bytes);
    t->used += (size_t)n;
}

static const double SIZE = 0.05, LOAD = 5; /* m; N: what closing builds up */

/* One tip on each of 3 to 6 spots of the box's faces, the first two against each other. */
static void describe_fingers(pinch_random *random, text *t, double kn, double mass, double ramp)
{
    int count = 3 + draw_index(random, 4);
    for (int i = 0; i < count; i++) {
        int axis = i < 2 ? 0 : draw_index(random, 3), sign = i == 0                     ? 1
                                                             : i == 1                   ? -1
                                                             : draw_chance(random, 0.5) ? 1
                                                                                        : -1;
        double point[3], normal[3] = {0, 0, 0};
        for (int j = 0; j < 3; j++) point[j] = draw_uniform(random, -0.35, 0.35) * SIZE;
        if (i < 2) point[1] *= 0.3, point[2] *= 0.3;
        point[axis] = -0.5 * sign * SIZE;
        normal[axis] = sign;
        double k = kn, kt = k * draw_uniform(random, 0.5, 1);
        bool soft = draw_chance(random, 0.3);
        double closing = i < 2 ? 2 * LOAD / k : LOAD * draw_uniform(random, 0, 1) / k;
        add(t,
            "%s{\"point\": [%.17g, %.17g, %.17g], \"normal\": [%g, %g, %g], \"tip\": {\"type\": \"sphere\", "
            "\"radius\": %.17g}, \"model\": \"%s\", \"stiffness\": {\"normal\": %.17g, \"tangential\": %.17g",
            i ? ", " : "", point[0], point[1], point[2], normal[0], normal[1], normal[2],
            draw_uniform(random, 0.005, 0.02), soft ? "soft" : "hard", k, kt);
        if (soft) add(t, ", \"torsional\": %.17g", k * 1e-4);
        double c = 0.3 * sqrt(1e4 * mass); /* its lag on a slow load goes with 1/kn, too */
        add(t, "}, \"damping\": {\"normal\": %.17g, \"tangential\": %.17g", c, c);
        if (soft) add(t, ", \"torsional\": %.17g", c * 1e-4);
        add(t, "}, \"friction\": %.17g, ", draw_uniform(random, 0.2, 0.8));
        if (soft) add(t, "\"torsional_friction\": %.17g, ", draw_uniform(random, 0.001, 0.006));
        add(t, "\"closing\": %.17g, \"ramp\": %.17g}", closing, ramp);
    }
}

/*
 * The same draws for every kn: only stiffness, and closing with it, scale. The motion is `slow` times slower than a
 * ramp of a second; its slip is wrong by the part of the ramp that a step takes, which must stay below 1/kn.
 */
static scene *make_scene(uint64_t seed, double kn, double slow)
{
    static text t;
    pinch_random random;
    t.used = 0;
    pinch_random_seed(&random, seed);
    double wrench[6], mass = 0.2;
    add(&t,
        "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0], \"object\": {\"shape\": {\"type\": \"box\", "
        "\"size\": [%g, %g, %g]}, \"mass\": %g}, \"fingers\": [",
        SIZE, SIZE, SIZE, mass);
    describe_fingers(&random, &t, kn, mass, slow);
    double scale = draw_uniform(&random, 0.2, 1.2) * LOAD;
    draw_direction(&random, wrench);
    draw_direction(&random, wrench + 3);
    for (int i = 0; i < 3; i++) {
        wrench[i] *= scale;
        wrench[3 + i] *= scale * 0.2 * SIZE;
    }
    add(&t,
        "], \"schedule\": [{\"time\": %.17g, \"force\": [0, 0, 0], \"torque\": [0, 0, 0]}, {\"time\": %.17g, "
        "\"force\": [%.17g, %.17g, %.17g], \"torque\": [%.17g, %.17g, %.17g]}], \"simulation\": {\"duration\": "
        "%.17g}}",
        1.2 * slow, 3 * slow, wrench[0], wrench[1], wrench[2], wrench[3], wrench[4], wrench[5], 3 * slow + 1.5);
    return scene_from_text(t.bytes);
}

typedef struct comparison {
    bool held, slipping;
    double difference, unit; /* largest difference of a finger's force, N; F, N */
    double moved;            /* m: how far the object moves, turns counted at its radius */
} comparison;

enum { MAX_FINGERS = 8 };

/* The statics under `factor` times the wrench; into c: F and how far the object moves. */
static bool solve(const scene *s, double factor, pinch_finger_result *results, comparison *c)
{
    pinch_finger fingers[MAX_FINGERS];
    pinch_grasp grasp;
    pinch_statics *statics;
    pinch_statics_result r;
    scene_static_grasp(s, fingers, &grasp);
    const scene_entry *last = &s->schedule[s->entry_count - 1];
    for (int i = 0; i < 3; i++) {
        grasp.wrench[i] = factor * last->channels[SCENE_FORCE].value[i];
        grasp.wrench[3 + i] = factor * last->channels[SCENE_TORQUE].value[i];
    }
    pinch_statics_settings settings = pinch_default_statics_settings();
    settings.path_tolerance = 1e-7; /* well below the 4e-5 that the stiffest fingers leave */
    assert_int_equal(pinch_statics_create(MAX_FINGERS, 0, &statics), PINCH_OK);
    assert_int_equal(pinch_statics_solve(statics, &grasp, &settings, results, &r), PINCH_OK);
    pinch_statics_destroy(statics);
    c->unit = r.verification.force_scale;
    c->moved = 0;
    for (int i = 0; i < 3; i++) c->moved = hypot(c->moved, hypot(r.translation[i], grasp.radius * r.rotation[i]));
    return r.solve.status == PINCH_SOLVE_CONVERGED;
}

static comparison compare(uint64_t seed, double kn, double slow)
{
    comparison c = {.held = false};
    pinch_finger_result expected[MAX_FINGERS];
    scene *s = make_scene(seed, kn, slow);
    /* held with a tenth to spare: at the limit itself any disturbance grows */
    if (solve(s, 1.1, expected, &c) && solve(s, 1, expected, &c)) {
        world *w = world_of(s);
        world_run_until(w, s->duration);
        c.held = true;
        for (int i = 0; i < w->finger_count; i++) {
            c.slipping = c.slipping || expected[i].state == PINCH_CONTACT_SLIP;
            double d = 0;
            for (int j = 0; j < 3; j++) d = hypot(d, w->fingers[i].state.force[j] - expected[i].force[j]);
            c.difference = fmax(c.difference, d);
        }
        world_destroy(w);
    }
    scene_free(s);
    return c;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void test_statics_are_the_limit_of_stiff_fingers(void **state)
{
    (void)state;
    enum { DECADES = 4, MOST = 500 };
    static const double SLOW[DECADES] = {1, 2, 4, 16};
    static double ratio[DECADES][MOST];
    int count = draw_count(MOST), held = 0, slipping = 0, wrong = 0, unexplained = 0;
    for (uint64_t seed = 1; held < count && seed < 100000; seed++) {
        comparison c[DECADES];
        c[0] = compare(seed, 1e4, SLOW[0]);
        if (!c[0].held) continue;
        slipping += c[0].slipping;
        bool off = false, far_off = false;
        for (int k = 0; k < DECADES; k++) {
            double kn = 1e4 * pow(10, k);
            if (k) c[k] = compare(seed, kn, SLOW[k]);
            double share = c[k].difference / c[k].unit, bound = 2 * c[k].unit / (kn * SIZE);
            ratio[k][held] = share;
            if (c[k].held && share <= bound) continue;
            off = true;
            far_off = far_off || !c[k].held || share > 5 * c[k].moved / SIZE;
            print_message(
                "seed %d, kn %g: %.3g of the force scale %.3g N apart, bound %.3g, moved %.3g of its size%s\n",
                (int)seed, kn, share, c[k].unit, bound, c[k].moved / SIZE, c[k].slipping ? ", slipping" : "");
        }
        wrong += off;
        unexplained += far_off;
        held++;
    }
    print_message(
        "%d grasps, %d of them slipping, %d out of bounds, %d of them by more than the object's motion explains; "
        "forces apart over F, median and largest:\n",
        held, slipping, wrong, unexplained);
    for (int k = 0; k < DECADES; k++) {
        qsort(ratio[k], (size_t)held, sizeof ratio[k][0], ascending);
        print_message("  kn %.0e N/m: %.3g %.3g\n", 1e4 * pow(10, k), ratio[k][held / 2], ratio[k][held - 1]);
    }
    /* 2 F/(kn L) for each. What is left beyond that is of two kinds. Near its limit a slipping grasp gives more than
     * F/kn and answers to a change of its geometry with more than its like: the difference still falls tenfold a
     * decade, WRONG_SHARE. And where the object has no equilibrium for a while, or is free to turn
     * when it is closed, its mass decides where it comes to rest. */
    assert_true(wrong <= 1 + held / 25);
    assert_true(unexplained <= held / 50);
    /* tenfold a decade in the median; between 5 and 20 for the few that a quick run draws */
    for (int k = 1; k < DECADES; k++) {
        double fall = ratio[k - 1][held / 2] / ratio[k][held / 2];
        assert_true(fall > 5 && fall < 20);
    }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_statics_are_the_limit_of_stiff_fingers)};
    int failed = cmocka_run_group_tests_name("statics as a limit", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
