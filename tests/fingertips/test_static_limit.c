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
static void describe_fingers(pinch_random *random, text *t, double kn, double mass)
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
        add(t, "\"closing\": %.17g, \"ramp\": 1}", closing);
    }
}

/* The same draws for every kn: only stiffness, and closing with it, scale. */
static scene *make_scene(uint64_t seed, double kn)
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
    describe_fingers(&random, &t, kn, mass);
    double scale = draw_uniform(&random, 0.2, 1.2) * LOAD;
    draw_direction(&random, wrench);
    draw_direction(&random, wrench + 3);
    for (int i = 0; i < 3; i++) {
        wrench[i] *= scale;
        wrench[3 + i] *= scale * 0.2 * SIZE;
    }
    add(&t,
        "], \"schedule\": [{\"time\": 1.2, \"force\": [0, 0, 0], \"torque\": [0, 0, 0]}, {\"time\": 3, \"force\": "
        "[%.17g, %.17g, %.17g], \"torque\": [%.17g, %.17g, %.17g]}], \"simulation\": {\"duration\": 4.5}}",
        wrench[0], wrench[1], wrench[2], wrench[3], wrench[4], wrench[5]);
    return scene_from_text(t.bytes);
}

typedef struct comparison {
    bool held, slipping;
    double difference, unit; /* largest difference of a finger's force, N; F, N */
} comparison;

enum { MAX_FINGERS = 8 };

/* The statics under `factor` times the wrench. */
static bool solve(const scene *s, double factor, pinch_finger_result *results, double *unit)
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
    *unit = r.verification.force_scale;
    return r.solve.status == PINCH_SOLVE_CONVERGED;
}

static comparison compare(uint64_t seed, double kn)
{
    comparison c = {.held = false};
    pinch_finger_result expected[MAX_FINGERS];
    scene *s = make_scene(seed, kn);
    /* held with a tenth to spare: at the limit itself any disturbance grows */
    if (solve(s, 1.1, expected, &c.unit) && solve(s, 1, expected, &c.unit)) {
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
    enum { DECADES = 4, MOST = 1000 };
    static double ratio[DECADES][MOST];
    int count = draw_count(1000), held = 0, slipping = 0, wrong = 0;
    assert_true(count <= MOST);
    for (uint64_t seed = 1; held < count && seed < 100000; seed++) {
        comparison c[DECADES];
        c[0] = compare(seed, 1e4);
        if (!c[0].held) continue;
        slipping += c[0].slipping;
        bool off = false;
        for (int k = 0; k < DECADES; k++) {
            double kn = 1e4 * pow(10, k);
            if (k) c[k] = compare(seed, kn);
            double share = c[k].difference / c[k].unit, bound = 2 * c[k].unit / (kn * SIZE);
            ratio[k][held] = share;
            if (c[k].held && share <= bound) continue;
            off = true;
            print_message("seed %d, kn %g: %.3g of the force scale %.3g N apart, bound %.3g%s\n", (int)seed, kn, share,
                          c[k].unit, bound, c[k].slipping ? ", slipping" : "");
        }
        wrong += off;
        held++;
    }
    print_message("%d grasps, %d of them slipping, %d out of bounds; forces apart over F, median and largest:\n", held,
                  slipping, wrong);
    for (int k = 0; k < DECADES; k++) {
        qsort(ratio[k], (size_t)held, sizeof ratio[k][0], ascending);
        print_message("  kn %.0e N/m: %.3g %.3g\n", 1e4 * pow(10, k), ratio[k][held / 2], ratio[k][held - 1]);
    }
    /* 2 F/(kn L) for each. Grasps that slip on the way may have several equilibria, and inertia, however small, may
     * pick another one than the quasi-static path does: test_static_dynamic finds 6 of 96 so with no geometry in
     * between, here 46 of the first 670 are. They are listed, and may be no more than a tenth. */
    assert_true(10 * wrong <= held);
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
