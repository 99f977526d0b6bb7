/*
 * The force of a pad is continuous as it tilts, while its corners lift and come down again, from four points of contact
 * to two or one and back: four times as slow, it changes a fourth as much from step to step. A jump would not.
 */
#include "support/cmocka_all.h"

#include "support/scene_run.h"

#include <stdio.h>

enum { TEXT = 4096 };

/* A pad on a cube, which hardly moves, tilts to either side about an axis in the plane of its face. */
static const char PAD[] =
    "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0], \"object\": {\"shape\": {\"type\": \"box\", \"size\": "
    "[0.1, "
    "0.1, 0.1]}, \"mass\": 1e9}, \"fingers\": [{\"name\": \"pad\", \"point\": [-0.05, 0, 0], \"normal\": [1, 0, 0], "
    "%s, "
    "\"tip\": {\"type\": \"box\", \"size\": [0.01, 0.02, 0.02]}, \"closing\": 0.0005, \"drive\": {\"type\": \"path\", "
    "\"points\": [{\"time\": 0.1}, {\"time\": 0.2, \"translation\": [0, %g, %g]}, {\"time\": %g, \"translation\": [0, "
    "%g, %g], \"rotation\": [0, %g, %g]}, {\"time\": %g, \"translation\": [0, %g, %g], \"rotation\": [0, 0, 0]}, "
    "{\"time\": %g, \"translation\": [0, %g, %g], \"rotation\": [0, %g, %g]}, {\"time\": %g, \"translation\": [0, %g, "
    "%g], \"rotation\": [0, 0, 0]}]}}]}";
static const char SLIDES[] = "\"model\": \"frictionless\", \"stiffness\": {\"normal\": 10000}, \"damping\": "
                             "{\"normal\": 0}";
static const char STICKS[] = "\"model\": \"hard\", \"stiffness\": {\"normal\": 10000, \"tangential\": 8000}, "
                             "\"damping\": {\"normal\": 0, \"tangential\": 0}, \"friction\": 1";
static const double START = 0.25, TILT = 0.2;

/* The largest change of force (N) and moment (N m) from step to step, and the force in the end. */
typedef struct changes {
    double force, moment, end, most;
} changes;

static changes tilt(const char *law, double shift, const double axis[2], double each)
{
    char text[TEXT];
    double y = shift, z = 0.5 * shift, a = TILT * axis[0], b = TILT * axis[1];
    snprintf(text, sizeof text, PAD, law, y, z, START + each, y, z, a, b, START + 2 * each, y, z, START + 3 * each, y,
             z, -a, -b, START + 4 * each, y, z);
    scene *s = scene_from_text(text);
    world *w = world_of(s);
    changes c = {0, 0, 0, 0};
    world_run_until(w, START);
    world_finger_state before = w->fingers[0].state;
    while (w->time < START + 4 * each) {
        assert_int_equal(world_advance(w), WORLD_OK);
        const world_finger_state *now = &w->fingers[0].state;
        for (int i = 0; i < 3; i++) {
            c.force = fmax(c.force, fabs(now->force[i] - before.force[i]));
            c.moment = fmax(c.moment, fabs(now->moment[i] - before.moment[i]));
        }
        c.most = fmax(c.most, now->normal_force);
        before = *now;
    }
    c.end = before.normal_force;
    world_free(w);
    scene_free(s);
    return c;
}

static void forces_have_no_jumps(void **state)
{
    (void)state;
    static const double axes[][2] = {{1, 0}, {1, 0.001}, {0.9284766908852594, 0.3713906763541037}, {0.7071, 0.7071}};
    for (size_t k = 0; k < 2 * sizeof axes / sizeof axes[0]; k++) {
        const char *law = k % 2 ? STICKS : SLIDES;
        double shift = k % 2 ? 1e-4 : 0;
        changes fast = tilt(law, shift, axes[k / 2], 0.5), slow = tilt(law, shift, axes[k / 2], 2);
        if (!(slow.force <= 0.3 * fast.force) || !(slow.moment <= 0.3 * fast.moment))
            print_error("axis %zu, %s: %g N and %g N m a step, four times as slow %g N and %g N m\n", k / 2,
                        k % 2 ? "sticks" : "slides", fast.force, fast.moment, slow.force, slow.moment);
        assert_true(slow.force <= 0.3 * fast.force);
        assert_true(slow.moment <= 0.3 * fast.moment);
        assert_true(fast.most > 10);     /* it is pressed on by its edge alone, or its corner */
        assert_close(fast.end, 5, 0.01); /* stiffness times closing, as in the beginning; the cube has moved a little */
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forces_have_no_jumps),
    };
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
