/*
 * Every shipped scene runs with its own step and with the step halved three times. The final poses must converge. The
 * energy ledger must close, its losses must never go backwards, and what the step loses must vanish in the limit.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/program.h"
#include "support/sanitized.h"
#include "support/scene_run.h"

#include <string.h>

enum { MAX_SCENES = 64, HALVINGS = 4 };
/* Longer scenes are halved three times in full runs only, else once: they agree to 1e-9 m from the start, and so do
 * their first two runs. */
static const double QUICK_DURATION = 5; /* s */

typedef struct outcome {
    double position[3], orientation[4], radius;
    energy_ledger ledger;
    double back; /* J, most that a loss ever went back by in a step, over the work so far */
} outcome;

static double went_back(double now, double before, double size)
{
    return size > 0 ? fmax(0, before - now) / size : 0;
}

static void assert_closes(const char *name, const energy_ledger *l)
{
    if (fabs(l->closure) <= fmax(1e-6 * l->work_size, 1e-9)) return;
    fail_msg("%s: the ledger is off by %g J of %g J of work", name, l->closure, l->work_size);
}

static outcome run(const char *name, double step)
{
    outcome o = {.back = 0};
    scene *s = scene_shipped(name);
    s->step = step;
    world *w = world_of(s);
    long steps = lround(s->duration / step);
    while (w->steps < steps) {
        energy_ledger before = w->ledger;
        assert_int_equal(world_advance(w), WORLD_OK);
        o.back = fmax(o.back, went_back(w->ledger.friction, before.friction, w->ledger.work_size));
        o.back = fmax(o.back, went_back(w->ledger.damping, before.damping, w->ledger.work_size));
        assert_closes(name, &w->ledger);
    }
    memcpy(o.position, dBodyGetPosition(w->object), sizeof o.position);
    memcpy(o.orientation, dBodyGetQuaternion(w->object), sizeof o.orientation);
    o.ledger = w->ledger;
    o.radius = s->objects[0].shape.bounding_radius;
    world_free(w);
    scene_free(s);
    return o;
}

/* m: the way of the centre, and of the farthest point by the turn */
static double apart(const outcome *a, const outcome *b)
{
    dQuaternion turn;
    dQMultiply1(turn, a->orientation, b->orientation);
    double angle = 2 * sqrt(turn[1] * turn[1] + turn[2] * turn[2] + turn[3] * turn[3]), way = 0;
    for (int i = 0; i < 3; i++) way = hypot(way, a->position[i] - b->position[i]);
    return way + angle * a->radius;
}

/*
 * Final poses that differ by more than 1e-9 m come closer by 2 a halving, at first order; 1.9 because the terms of
 * higher order are a few percent at 1 ms. The others agree to the 1e-9 m.
 */
static void check_poses(const char *name, const outcome *o, int runs, int *wrong)
{
    if (runs < HALVINGS) {
        double first = apart(&o[0], &o[1]);
        print_message("%-24s %10.3g  %s\n", name, first, first <= 1e-9 ? "the same" : "DIFFERS");
        *wrong += !(first <= 1e-9);
        return;
    }
    double d[HALVINGS - 1];
    for (int k = 0; k < HALVINGS - 1; k++) d[k] = apart(&o[k], &o[k + 1]);
    bool same = d[0] <= 1e-9 && d[1] <= 1e-9 && d[2] <= 1e-9, converges = d[0] >= 1.9 * d[1] && d[1] >= 1.9 * d[2];
    print_message("%-24s %10.3g %10.3g %10.3g  %s", name, d[0], d[1], d[2],
                  same        ? "the same"
                  : converges ? "converges"
                              : "DOES NOT CONVERGE");
    if (!same) print_message(" %.2f %.2f", d[0] / d[1], d[1] / d[2]);
    print_message("\n");
    *wrong += !same && !converges;
}

/*
 * The step's part vanishes at first order, too, once the step resolves the contacts' own vibrations (sqrt(k/m) h well
 * below 1): it never grows, and where it shrinks by 1.9 once it goes on doing so. 1e-9 J is the ledger's own bound.
 */
static void check_ledger(const char *name, const outcome *o, int runs, int *wrong)
{
    bool good = true;
    for (int k = 0; k < runs; k++) {
        const energy_ledger *l = &o[k].ledger;
        good = good && l->friction >= 0 && l->damping >= 0 && o[k].back <= 1e-12;
    }
    print_message("%-24s %10.3g", name, o[0].ledger.integrator);
    double ratio = 0;
    for (int k = 1; k < runs; k++) {
        double now = fabs(o[k - 1].ledger.integrator), next = fabs(o[k].ledger.integrator), before = ratio;
        ratio = now / next;
        print_message(" %10.3g (%.2f)", next, ratio);
        if (now <= 1e-9) continue;
        good = good && ratio >= 1.4 && (before < 1.9 || ratio >= 1.9) && (k < HALVINGS - 1 || ratio >= 1.6);
    }
    print_message("  closes to %.1g of %.3g J%s\n", o[0].ledger.closure, o[0].ledger.work_size, good ? "" : "  WRONG");
    *wrong += !good;
}

static void test_halved_steps(void **state)
{
    (void)state;
    static outcome o[MAX_SCENES][HALVINGS];
    const char *const *paths = shipped_scenes();
    int wrong = 0, count = 0, runs[MAX_SCENES];
    print_message("final poses, m apart: 1 to 1/2, 1/2 to 1/4, 1/4 to 1/8 of the scene's step\n");
    for (int i = 0; paths[i]; i++, count++) {
        assert_true(i < MAX_SCENES);
        runs[i] = 0;
        if (SANITIZED && i % 4) continue;
        const char *name = file_name(paths[i]);
        scene *s = scene_shipped(name);
        double step = s->step;
        runs[i] = draw_full() || s->duration <= QUICK_DURATION ? HALVINGS : 2;
        scene_free(s);
        for (int k = 0; k < runs[i]; k++) o[i][k] = run(name, ldexp(step, -k));
        check_poses(name, o[i], runs[i], &wrong);
    }
    print_message("energy lost to the step, J: the scene's step, 1/2, 1/4, 1/8 (ratios)\n");
    for (int i = 0; i < count; i++)
        if (runs[i] > 0) check_ledger(file_name(paths[i]), o[i], runs[i], &wrong);
    assert_int_equal(wrong, 0);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_halved_steps)};
    int failed = cmocka_run_group_tests_name("steps and energy", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
