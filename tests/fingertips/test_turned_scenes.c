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

/* Writes a scene that is turned. In its text @x y z@ is a vector, ~w x y z~ an orientation, and ' stands for ". */
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
            *to++ = (char)(*text == '\'' ? '"' : *text);
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
    "{'format': 'pinch-scene/1', 'gravity': [0, 0, 0], 'object': {'shape': {'type': 'box', 'size': [0.1, 0.1, 0.1]}, "
    "'mass': 1e9, 'position': @0 0 0@, 'orientation': ~1 0 0 0~}, 'fingers': [{'name': 'pad', 'point': @-0.05 0 0@, "
    "'normal': @1 0 0@, 'tangent': @0 1 0@, %s, 'tip': {'type': 'box', 'size': [0.01, 0.02, 0.02], 'orientation': "
    "~%.17g 0 %.17g 0~}, 'closing': 0.0005, 'drive': {'type': 'path', 'points': [{'time': 0.02}, {'time': 0.04, "
    "'translation': @0 0.0001 0.00005@}, {'time': 0.4, 'translation': @0 0.0001 0.00005@, 'rotation': @0 0.1 0@}]}}]}";

static void tilting_pads_keep_their_force(void **state)
{
    (void)state;
    static char text[TEXT];
    static const char slides[] = "'model': 'frictionless', 'stiffness': {'normal': 10000}, 'damping': {'normal': 0}";
    static const char sticks[] = "'model': 'hard', 'stiffness': {'normal': 10000, 'tangential': 8000}, 'damping': "
                                 "{'normal': 5, 'tangential': 5}, 'friction': 1";
    snprintf(text, sizeof text, TILTING, slides, 1.0, 0.0);
    expect_the_same("slides", text, 300, 40, 1e-9);
    /* of faces that lie on each other, rounding decides whose points count, and friction acts there: this one is
     * tilted from the start */
    snprintf(text, sizeof text, TILTING, sticks, cos(0.001), sin(0.001));
    expect_the_same("sticks", text, 300, 40, 1e-9);
}

/* Grasps of which a tip begins slantwise: how large a geom is does not depend on that, and so which points of a contact
 * are one and the same. */
static const char BOX[] =
    "{'format': 'pinch-scene/1', 'gravity': @1.51817703 3.7479767 -1.02880434@, 'object': {'shape': {'type': "
    "'box', 'size': [0.0551876139, 0.0648932584, 0.101372364]}, 'mass': 0.0966229463, 'position': @-0.0665970445 "
    "-0.00227699124 -0.0752101573@, 'orientation': ~0.597627572 -0.534452154 -0.0805704073 0.592208232~}, "
    "'fingers': [{'name': 'n1', 'point': @-0.0539785071 0.0230036843 -0.0510933702@, 'normal': @-0.62171788 "
    "-0.27269939 -0.734235603@, 'tangent': @-0.528707116 0.0825777 0.417015707@, 'model': 'frictionless', "
    "'stiffness': {'normal': 12118.0731, 'tangential': 8272.69419}, 'damping': {'normal': 17.1090906, "
    "'tangential': 17.1090906}, 'closing': 0.00581105827, 'ramp': 0.1, 'tip': {'type': 'box', 'size': "
    "[0.0169482451, 0.0220327186, 0.0152534206], 'orientation': ~0.270250794 0.340742671 0.278912037 "
    "-0.856193328~}}, {'name': 'n2', 'point': @-0.103417472 0.0167657682 -0.095295848@, 'normal': @0.62171788 "
    "0.27269939 0.734235603@, 'tangent': @-0.539632701 0.828441456 0.14924885@, 'model': 'frictionless', "
    "'stiffness': {'normal': 2134019.74, 'tangential': 1001601.37}, 'damping': {'normal': 635.722219, "
    "'tangential': 635.722219}, 'friction': 1.65629984, 'normal_force': 51.5541449, 'ramp': 0.2}]}";
static const char CAPSULE[] =
    "{'format': 'pinch-scene/1', 'gravity': @0 0 -1.44121883@, 'object': {'shape': {'type': 'capsule', 'radius': "
    "0.0300259185, 'length': 0.0582769758}, 'mass': 0.654989617, 'position': @0 0 0@, 'orientation': ~1 0 0 0~}, "
    "'fingers': [{'name': 'n2', 'point': @-0.0263831322 0.0135008675 0.0339563869@, 'normal': @0.87867887 "
    "-0.449640585 -0.160458053@, 'tangent': @0.0410819483 0.319008438 -0.668967987@, 'model': 'frictionless', "
    "'stiffness': {'normal': 77048.1916, 'tangential': 81097.7485}, 'damping': {'normal': 112.322933, "
    "'tangential': 112.322933}, 'friction': 1.78491394, 'closing': 0.00633285818, 'ramp': 0.1, 'tip': {'type': "
    "'cylinder', 'radius': 0.0100268692, 'length': 0.0100268692, 'rounding': 0.00200537384, 'orientation': "
    "~0.857332305 0.452018532 -0.0349607406 -0.243799736~}}, {'name': 'n3', 'point': @0.0295934553 "
    "-0.00507766154 -0.0269682299@, 'normal': @-0.985597298 0.169109333 0@, 'tangent': @-0.0415118502 "
    "-0.241937961 0.684581336@, 'model': 'soft', 'stiffness': {'normal': 690733.19, 'tangential': 720684.92, "
    "'torsional': 77.4201887}, 'damping': {'normal': 336.312008, 'tangential': 336.312008, 'torsional': "
    "0.00446471453}, 'friction': 1.07943969, 'torsional_friction': 0.000806165936, 'normal_force': 401.1703, "
    "'ramp': 0.1, 'tip': {'type': 'convex', 'vertices': [[-0.00596688409, -0.00716026091, -0.00477350727], "
    "[-0.00596688409, -0.00716026091, 0.00477350727], [-0.00596688409, 0.00716026091, -0.00477350727], "
    "[-0.00596688409, 0.00716026091, 0.00477350727], [0.00596688409, -0.00716026091, -0.00477350727], "
    "[0.00596688409, -0.00716026091, 0.00477350727], [0.00596688409, 0.00716026091, -0.00477350727], "
    "[0.00596688409, 0.00716026091, 0.00477350727]], 'orientation': ~0.0848607749 0 0 0.996392819~}}]}";
static const char FLAT_CAPSULE[] =
    "{'format': 'pinch-scene/1', 'gravity': @1.87477043 -0.180164745 0.00611726546@, 'object': {'shape': "
    "{'type': 'flat_capsule', 'radius': 0.0249566935, 'length': 0.059101367}, 'mass': 0.00143137667, 'position': "
    "@0 0 0@, 'orientation': ~-0.0115645075 -0.574403913 -0.466182794 -0.672755535~}, 'fingers': [{'name': 'n1', "
    "'point': @0.0364509141 0.00236184678 0.00860762234@, 'normal': @-0.801053915 0.422073553 -0.424460294@, "
    "'tangent': @-0.576301566 -0.556945257 0.533799664@, 'model': 'soft', 'stiffness': {'normal': 308.243875, "
    "'tangential': 160.152091, 'torsional': 0.00157980389}, 'damping': {'normal': 0.332119366, 'tangential': "
    "0.332119366, 'torsional': 2.36669213e-07}, 'friction': 0.606743397, 'torsional_friction': 0.00111635401, "
    "'closing': 0.00438213591, 'ramp': 0.1}, {'name': 'n3', 'point': @-0.00358307732 0.0271187865 "
    "0.00695709843@, 'normal': @0.557571239 -0.762276373 -0.328708143@, 'tangent': @0.394859144 0.174266285 "
    "0.26565521@, 'model': 'soft', 'stiffness': {'normal': 444.850584, 'tangential': 513.919248, 'torsional': "
    "0.0153947221}, 'damping': {'normal': 0.39898269, 'tangential': 0.39898269, 'torsional': 0}, 'friction': "
    "1.25581998, 'torsional_friction': 0.000272451739, 'closing': 0.00239525293, 'ramp': 0.1, 'tip': {'type': "
    "'box', 'size': [0.00419525794, 0.00545383533, 0.00377573215], 'orientation': ~0.868200153 0.15815851 "
    "0.105821141 -0.458275317~}}], 'simulation': {'step': 0.0005}}";

static void turned_grasps_have_turned_forces(void **state)
{
    (void)state;
    expect_the_same("box", BOX, 96, 10, 1e-9);
    expect_the_same("capsule", CAPSULE, 94, 10, 1e-9);
    expect_the_same("flat capsule", FLAT_CAPSULE, 188, 10, 1e-9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tilting_pads_keep_their_force),
        cmocka_unit_test(turned_grasps_have_turned_forces),
    };
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
