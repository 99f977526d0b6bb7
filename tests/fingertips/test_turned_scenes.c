/*
 * A scene that is turned as a whole does what it did, turned. Rounding alone may tell the two apart: which way things
 * lie in the world is no part of what they are.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/scene_run.h"

#include <stdio.h>
#include <string.h>

enum { TEXT = 8192, MOST_STEPS = 1000, MOST_FINGERS = 3 };

/* The forces of all fingers after each step, as they are in the scene before it is turned. */
typedef struct forces {
    int steps, fingers;
    double force[MOST_STEPS][MOST_FINGERS][3];
} forces;

static void write_vector(const dReal *R, const double *v, char **to)
{
    double turned[3];
    for (int i = 0; i < 3; i++) turned[i] = R[4 * i] * v[0] + R[4 * i + 1] * v[1] + R[4 * i + 2] * v[2];
    *to += sprintf(*to, "[%.17g, %.17g, %.17g]", turned[0], turned[1], turned[2]);
}

static void write_orientation(const double *turn, const double *q, char **to)
{
    dQuaternion turned;
    dQMultiply0(turned, turn, q);
    *to += sprintf(*to, "[%.17g, %.17g, %.17g, %.17g]", turned[0], turned[1], turned[2], turned[3]);
}

/* Writes a scene that is turned. In its text @x y z@ is a vector, and ~w x y z~ an orientation. */
static void turned_text(const char *text, const double *turn, char *to)
{
    dMatrix3 R;
    double x[4];
    int used;
    dQtoR(turn, R);
    for (; *text; text++) {
        if (*text == '@') {
            assert_int_equal(sscanf(text, "@%lf %lf %lf@%n", &x[0], &x[1], &x[2], &used), 3);
            write_vector(R, x, &to);
        } else if (*text == '~') {
            assert_int_equal(sscanf(text, "~%lf %lf %lf %lf~%n", &x[0], &x[1], &x[2], &x[3], &used), 4);
            write_orientation(turn, x, &to);
        } else {
            *to++ = *text;
            continue;
        }
        text += used - 1;
    }
    *to = '\0';
}

static void run_turned(const char *text, const double *turn, int steps, forces *f)
{
    static char turned[2 * TEXT];
    dMatrix3 R;
    dQtoR(turn, R);
    turned_text(text, turn, turned);
    scene *s = scene_from_text(turned);
    world *w = world_of(s);
    f->steps = steps;
    f->fingers = w->finger_count;
    for (int step = 0; step < steps; step++) {
        assert_int_equal(world_advance(w), WORLD_OK);
        for (int i = 0; i < f->fingers; i++) {
            const double *force = w->fingers[i].state.force;
            for (int k = 0; k < 3; k++)
                f->force[step][i][k] = R[k] * force[0] + R[4 + k] * force[1] + R[8 + k] * force[2];
        }
    }
    world_free(w);
    scene_free(s);
}

/* Runs the scene as it is and turned so many times, and compares the forces of every step, to a part of the largest. */
static void expect_the_same(const char *name, const char *text, int steps, int turns, double part)
{
    static forces straight, turned;
    pinch_random random;
    double largest = 0;
    pinch_random_seed(&random, 41);
    run_turned(text, (const double[]){1, 0, 0, 0}, steps, &straight);
    for (int step = 0; step < steps; step++)
        for (int i = 0; i < straight.fingers; i++)
            for (int k = 0; k < 3; k++) largest = fmax(largest, fabs(straight.force[step][i][k]));
    assert_true(largest > 0);
    for (int n = 0; n < turns; n++) {
        dQuaternion turn;
        for (int i = 0; i < 4; i++) turn[i] = draw_uniform(&random, -1, 1);
        dNormalize4(turn);
        run_turned(text, turn, steps, &turned);
        for (int step = 0; step < steps; step++)
            for (int i = 0; i < straight.fingers; i++)
                for (int k = 0; k < 3; k++) {
                    double is = turned.force[step][i][k], was = straight.force[step][i][k];
                    if (fabs(is - was) > part * largest)
                        print_error("%s, turn %d, step %d, finger %d: %.12g N, not %.12g\n", name, n, step, i, is, was);
                    assert_true(fabs(is - was) <= part * largest);
                }
    }
}

/* A pad that is pressed onto a cube tilts about one of its edges, which is parallel to one of the cube's. */
static const char TILTING[] =
    "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0], \"object\": {\"shape\": {\"type\": \"box\", \"size\": "
    "[0.1, 0.1, 0.1]}, \"mass\": 1e9, \"position\": @0 0 0@, \"orientation\": ~1 0 0 0~}, \"fingers\": [{\"name\": "
    "\"pad\", \"point\": @-0.05 0 0@, \"normal\": @1 0 0@, \"tangent\": @0 1 0@, %s, \"tip\": {\"type\": \"box\", "
    "\"size\": [0.01, 0.02, 0.02], \"orientation\": ~%.17g 0 %.17g 0~}, \"closing\": 0.0005, \"drive\": {\"type\": "
    "\"path\", \"points\": [{\"time\": 0.02}, {\"time\": 0.04, \"translation\": @0 0.0001 0.00005@}, {\"time\": 0.4, "
    "\"translation\": @0 0.0001 0.00005@, \"rotation\": @0 0.1 0@}]}}]}";

static void tilting_pads_keep_their_force(void **state)
{
    (void)state;
    static char text[TEXT];
    static const char slides[] = "\"model\": \"frictionless\", \"stiffness\": {\"normal\": 10000}, \"damping\": "
                                 "{\"normal\": 0}";
    static const char sticks[] = "\"model\": \"hard\", \"stiffness\": {\"normal\": 10000, \"tangential\": 8000}, "
                                 "\"damping\": {\"normal\": 5, \"tangential\": 5}, \"friction\": 1";
    snprintf(text, sizeof text, TILTING, slides, 1.0, 0.0);
    expect_the_same("slides", text, 300, 40, 1e-9);
    /* of faces that lie on each other, rounding decides whose points count, and friction acts there: this one is
     * tilted from the start */
    snprintf(text, sizeof text, TILTING, sticks, cos(0.001), sin(0.001));
    expect_the_same("sticks", text, 300, 40, 1e-9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tilting_pads_keep_their_force),
    };
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
