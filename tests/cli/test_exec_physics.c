/*
 * Checks what ODE programs that know nothing of Pinch gain by it: rest, energy, friction and forces. It also checks how
 * much of that is Pinch's own work. Every program runs as it is, and under plain ODE where the two are compared.
 */

#define _XOPEN_SOURCE 700 /* M_PI */

#include "support/cmocka_all.h"

#include "support/command.h"
#include "support/draw.h"
#include "support/sanitized.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_WORDS = 16 };

/* Words separated by single blanks, the first a program's name. */
static exec_run run_words(bool under_pinch, const char *text)
{
    static char buffer[512];
    char *words[MOST_WORDS + 1] = {NULL};
    int count = 0;
    snprintf(buffer, sizeof buffer, "%s", text);
    for (char *word = strtok(buffer, " "); word && count < MOST_WORDS; word = strtok(NULL, " ")) words[count++] = word;
    words[0] = exec_program(words[0]);
    exec_run r = exec_program_run(under_pinch ? (char *[]){NULL} : NULL, words);
    if (r.result.status != 0 || !r.line) print_error("%s: %d\n%s\n", text, r.result.status, r.result.err);
    assert_int_equal(r.result.status, 0);
    assert_non_null(r.line);
    return r;
}

static double number_of(bool under_pinch, const char *text, const char *key)
{
    exec_run r = run_words(under_pinch, text);
    double value = exec_number(r.line, key);
    exec_run_free(&r);
    return value;
}

/* 99.9 % of the contacts are Pinch's, 99.9 % of the steps converge at once: of 5,000, in whose beginning, where things
 * still fall into place, a shorter run has all of the hard ones. */
static void expect_own_work(const exec_run *r, const char *text)
{
    double solved = exec_number(r->stats, "contacts_solved"), left = exec_number(r->stats, "contacts_left");
    double steps = exec_number(r->stats, "steps"), unconverged = exec_number(r->stats, "unconverged_steps");
    double most = 0.001 * fmax(steps, 5000);
    if (!(solved >= 0.999 * (solved + left)) || unconverged > most)
        print_error("%s: solved %g, left %g, unconverged %g of %g\n", text, solved, left, unconverged, steps);
    assert_true(solved > 0 && solved >= 0.999 * (solved + left));
    assert_true(unconverged <= most);
}

/* smallest extent of the bodies of a program, m */
typedef struct program_case {
    const char *text;
    double size;
} program_case;

/* the hundred-second versions with PINCH_TEST_FULL */
static const char *steps(void)
{
    return draw_full() ? "5000" : "1500";
}

/* What rests under ODE rests under Pinch, and no deeper than ODE's plus what the floors cost. */
static void what_rests_under_ode_rests(void **state)
{
    (void)state;
    static const program_case cases[] = {
        {"stack --stepper quick", 0.5}, {"wall --stepper quick", 0.2},     {"chain --stepper quick", 0.06},
        {"car --stepper quick", 0.4},   {"gripper --stepper quick", 0.02}, {"ragdoll --stepper quick", 0.08},
        {"heavy --stepper world", 0.5}, {"spheres --stepper quick", 0.16}, {"boxes --stepper quick", 0.15},
    };
    int wrong = 0;
    int piles = draw_full() ? 0 : 2; /* take their time */
    for (size_t i = 0; i < sizeof cases / sizeof *cases - (size_t)piles; i++) {
        char text[256];
        snprintf(text, sizeof text, "%s --steps %s", cases[i].text, steps());
        exec_run plain = run_words(false, text), pinch = run_words(true, text);
        expect_own_work(&pinch, text);
        double floor_depth = exec_number(pinch.stats, "floor_depth_max");
        double speed = exec_number(plain.line, "speed_last"), speed_pinch = exec_number(pinch.line, "speed_last");
        double depth = exec_number(plain.line, "depth_last"), depth_pinch = exec_number(pinch.line, "depth_last");
        print_message("%-32s speed %.1e, Pinch %.1e; depth %.3e, Pinch %.3e, floor %.1e, level %g\n", text, speed,
                      speed_pinch, depth, depth_pinch, floor_depth, exec_number(pinch.stats, "rung_max"));
        bool rests = speed_pinch < 1e-3 && depth_pinch <= 1.01 * depth + 1e-6 + floor_depth &&
                     floor_depth <= 1e-3 * cases[i].size;
        if (speed < 1e-3 && !rests) {
            print_error("%s: rests under ODE, not so under Pinch\n", text);
            wrong++;
        }
        exec_run_free(&plain);
        exec_run_free(&pinch);
    }
    assert_int_equal(wrong, 0);
}

static void a_stack_stands_still(void **state)
{
    (void)state;
    exec_run r = run_words(true, draw_full() ? "stack --steps 7000" : "stack --steps 2000");
    print_message("stack: %.2e J, drift %.2e m\n", exec_number(r.line, "kinetic"), exec_number(r.line, "drift"));
    assert_true(exec_number(r.line, "kinetic") <= 1e-12);
    assert_true(exec_number(r.line, "drift") <= 1e-9);
    exec_run_free(&r);
    r = run_words(true, "heavy --stepper quick");
    assert_true(exec_number(r.line, "top") > 0.745);
    assert_true(exec_number(r.line, "speed_last") < 1e-3);
    exec_run_free(&r);
}

/* Within a step a body that is much heavier than the one below can move as little as one that is jammed. It must not be
 * taken for that, and sink through a floor of compliance. (Quickstep lets both of these fall through.) */
static void the_heaviest_do_not_sink(void **state)
{
    (void)state;
    static const char *const texts[] = {"heavy --mass 100000 --h 0.005", "heavy --mass 1000000 --h 0.005",
                                        "heavy --mass 1000000 --h 0.01 --stepper world"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        double top = number_of(true, texts[i], "top");
        if (!(top > 0.735)) print_error("%s: %g m\n", texts[i], top);
        assert_true(top > 0.735 && top <= 0.75);
    }
}

/* A heap that needs softer contacts for good keeps them, and lies still. Heaps were pressed in and thrown up again and
 * again for as long as they were stepped, while stiffer contacts were tried every few steps. In one of ten heaps a box
 * slides, tips or swings on two points for longer than this, whatever the solver: of six, five have to lie still, and
 * of three with sanitizers two. */
static void heaps_come_to_rest(void **state)
{
    (void)state;
    int at_rest = 0, heaps = 0;
    for (int count = 45; count <= 95; count += SANITIZED ? 20 : 10) {
        char words[64];
        snprintf(words, sizeof words, "boxes --count %d --steps 1500 --stepper quick", count);
        exec_run r = run_words(true, words);
        expect_own_work(&r, "boxes");
        at_rest += exec_number(r.line, "speed_last") < 1e-6 && exec_number(r.line, "kinetic") == 0;
        heaps++;
        exec_run_free(&r);
    }
    assert_true(at_rest >= heaps - 1);
}

/* Nothing drives a pile or a wall: what it has it got at the start. */
static void energy_does_not_grow(void **state)
{
    (void)state;
    static const char *const friction[] = {"0.5", "10", "-1"}; /* -1: infinite */
    static const char *const texts[] = {"wall --steps 600", "boxes --steps 400 --count 20",
                                        "spheres --steps 400 --count 50", "stack --steps 600"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        for (size_t k = 0; k < (SANITIZED ? 1 : sizeof friction / sizeof *friction); k++) {
            char text[256];
            snprintf(text, sizeof text, "%s --mu %s", texts[i], friction[k]);
            exec_run r = run_words(true, text);
            double start = exec_number(r.line, "energy_start"), most = exec_number(r.line, "energy_max");
            if (most > start * (1 + 1e-6)) print_error("%s: %.9g J became %.9g J\n", text, start, most);
            assert_true(most <= start * (1 + 1e-6));
            exec_run_free(&r);
        }
}

static void a_slope_holds_to_the_friction_angle(void **state)
{
    (void)state;
    static const char *const directions[] = {"0", "37", "90", "200"};
    double limit = atan(0.5) * 180 / M_PI;
    for (size_t i = 0; i < 4; i++) {
        char text[256];
        snprintf(text, sizeof text, "slope --direction %s --angle %.9f --steps 3000", directions[i], limit - 0.01);
        double speed = number_of(true, text, "speed_last");
        if (!(speed < 1e-9)) print_error("%s: %g m/s\n", text, speed);
        assert_true(speed < 1e-9);
        snprintf(text, sizeof text, "slope --direction %s --angle %.9f --steps 1400", directions[i], limit + 0.01);
        double slid = number_of(true, text, "slid");
        if (!(slid > 1e-3)) print_error("%s: %g m\n", text, slid);
        assert_true(slid > 1e-3);
        double angle = (limit + 5) * M_PI / 180;
        snprintf(text, sizeof text, "slope --direction %s --angle %.9f --steps 1400", directions[i], limit + 5);
        double expected = 9.81 * (sin(angle) - 0.5 * cos(angle));
        assert_close(number_of(true, text, "acceleration"), expected, 1e-3 * expected);
    }
}

static void feedback_sums_to_the_weight(void **state)
{
    (void)state;
    static const char *const texts[] = {"feedback --stepper quick", "feedback --stepper world"};
    for (int i = 0; i < 2; i++) {
        exec_run r = run_words(true, texts[i]);
        assert_close(exec_number(r.line, "z"), exec_number(r.line, "weight"), 1e-9);
        assert_close(exec_number(r.line, "x"), 0, 1e-9);
        assert_close(exec_number(r.line, "y"), 0, 1e-9);
        expect_own_work(&r, texts[i]);
        exec_run_free(&r);
    }
}

/* Each surface mode does what it does in ODE: closed forms where there is one. */
static void surface_modes_keep_their_meaning(void **state)
{
    (void)state;
    assert_close(number_of(true, "conveyor --speed 0.5", "velocity"),
                 number_of(false, "conveyor --speed 0.5 --stepper world", "velocity"), 1e-6);
    /* a push over four contacts: each slips at slip1 times its share */
    assert_close(number_of(true, "slip --push 2", "velocity"),
                 number_of(false, "slip --push 2 --stepper world", "velocity"), 1e-4);
    /* four contacts with mu 0.5 N each resist 2 N */
    assert_true(fabs(number_of(true, "limit --push 1.99", "velocity")) < 1e-6);
    assert_true(number_of(true, "limit --push 2.01", "velocity") > 1e-2);
    assert_true(fabs(number_of(true, "infinite", "moved")) < 2e-3);
    assert_true(fabs(number_of(true, "infinite --approx 1", "moved")) < 2e-3);
    assert_close(number_of(true, "bounce", "rebound_6"), 0.36, 0.01);
    assert_close(number_of(true, "bounce", "rebound_9"), 0.81, 0.01);
    /* with an elastic ball, rounding of the step's start at the ground is all that counts */
    assert_close(number_of(true, "bounce", "rebound_10"), 1, 0.01);
    assert_close(number_of(true, "bounce", "last_10"), 1, 0.05);
}

/* What moves gives bodies all that it does work for: belts uphill, fingers that rise, and jaws that open again. */
static void what_moves_does_its_work(void **state)
{
    (void)state;
    static const char *const belts[] = {"conveyor --slope 10", "conveyor --slope 20",
                                        "conveyor --slope 20 --h 0.001 --steps 2000"};
    for (size_t i = 0; i < sizeof belts / sizeof *belts; i++) {
        char text[96];
        snprintf(text, sizeof text, "%s --mu 0.8", belts[i]);
        assert_close(number_of(true, text, "velocity"), 0.5, 1e-6);
    }
    static const char *const fingers[] = {"lifted", "lifted --speed 0.2", "lifted --h 0.002", "lifted --h 0.001"};
    for (size_t i = 0; i < sizeof fingers / sizeof *fingers; i++)
        assert_true(fabs(number_of(true, fingers[i], "behind")) < 1e-3);
    /* the grip of these is all overlap, and lasts as they stop, or nearly do */
    static const char *const speeds[] = {"0.03", "0.06", "0.1", "0.13", "0.19", "0.3"};
    for (size_t i = 0; i < sizeof speeds / sizeof *speeds; i++) {
        char text[96];
        snprintf(text, sizeof text, "lifted --hard 1 --until 200 --h 0.02 --speed %s", speeds[i]);
        assert_true(fabs(number_of(true, text, "behind")) < 1e-5);
    }
    assert_true(fabs(number_of(true, "lifted --hard 1 --until 200 --h 0.02 --speed 0.1 --after 0.001", "behind")) <
                1e-5);
    static const char *const vices[] = {"vice", "vice --stepper world", "vice --h 0.001 --steps 5000"};
    for (size_t i = 0; i < sizeof vices / sizeof *vices; i++)
        assert_true(fabs(number_of(true, vices[i], "error")) < 1e-4);
}

/* Bodies that begin in each other come apart within a second or so, whatever lies on them, and nothing is thrown. */
static void what_is_sunk_comes_out(void **state)
{
    (void)state;
    static const struct {
        const char *words;
        double at_most; /* s */
    } cases[] = {{"sunk --depth 0.05", 0.25},
                 {"sunk --depth 0.05 --stepper world", 0.25},
                 {"sunk --depth 0.01", 0.25},
                 {"sunk --depth 0.05 --h 0.01", 0.5},
                 {"sunk --depth 0.05 --h 0.001 --steps 3000", 0.1},
                 {"sunk --depth 0.02 --h 0.0002 --steps 5000", 0.1},
                 {"sunk --depth 0.05 --hinged 1", 0.25},
                 {"sunk --depth 0.02 --hinged 1", 0.25},
                 {"sunk --depth 0.05 --boxes 6", 1.2},
                 {"sunk --depth 0.02 --between 0.02 --boxes 6", 1},
                 {"sunk --depth 0.01 --between 0.01 --boxes 12", 1.5}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        exec_run r = run_words(true, cases[i].words);
        double out = exec_number(r.line, "out_after");
        if (!(out > 0 && out <= cases[i].at_most)) fail_msg("%s: out after %g s", cases[i].words, out);
        /* they get what they need to be where they belong, and next to nothing of what ODE throws them with */
        double end = exec_number(r.line, "energy_end");
        double thrown = number_of(false, cases[i].words, "energy_max") - end;
        assert_true(end > exec_number(r.line, "energy_start"));
        assert_true(exec_number(r.line, "energy_max") - end <= 0.02 * thrown);
        exec_run_free(&r);
    }
}

/* However short the step, what comes out of an overlap does not hop: it is no faster than takes it out. */
static void what_is_sunk_does_not_hop(void **state)
{
    (void)state;
    static const char *const steps[] = {"--h 0.002 --steps 1000", "--h 0.001 --steps 1500", "--h 0.0002 --steps 5000"};
    static const double depths[] = {0.002, 0.01, 0.05};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            char words[80];
            (void)snprintf(words, sizeof words, "sunk --depth %g %s", depths[k], steps[i]);
            exec_run r = run_words(true, words);
            /* or a fiftieth of its size in 25 ms */
            assert_true(exec_number(r.line, "speed_max") <= fmax(sqrt(2 * 9.81 * depths[k]), 0.28));
            assert_true(exec_number(r.line, "depth_last") < 1e-6);
            exec_run_free(&r);
        }
}

/* What is moved by its pose alone takes along what is in its way, with the overlap that ODE's push-out leaves at its
 * speed, speed h/erp, of which a step's way is the box's own. */
static void nothing_goes_through_what_it_shoves(void **state)
{
    (void)state;
    static const struct {
        const char *words;
        double speed, h;
    } cases[] = {{"shoved", 0.2, 0.005},
                 {"shoved --stepper world", 0.2, 0.005},
                 {"shoved --lift 1", 0.2, 0.005},
                 {"shoved --kinematic 1", 0.2, 0.005},
                 {"shoved --kinematic 2", 0.2, 0.005},
                 {"shoved --dynamic 1000", 0.2, 0.005},
                 {"shoved --dynamic 1000 --speed 1", 1, 0.005},
                 {"shoved --dynamic 1000 --lift 1", 0.2, 0.005},
                 {"shoved --plane 1", 0.2, 0.005},
                 {"shoved --speed 0.02", 0.02, 0.005},
                 {"shoved --speed 1", 1, 0.005},
                 {"shoved --speed 0.5 --h 0.001 --steps 1000", 0.5, 0.001},
                 {"shoved --speed 0.05 --h 0.02 --steps 100", 0.05, 0.02}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        exec_run r = run_words(true, cases[i].words);
        double overlap = cases[i].speed * cases[i].h / 0.2, ahead = cases[i].speed * cases[i].h - overlap;
        assert_close(exec_number(r.line, "ahead"), ahead, 1e-5 + 0.002 * overlap); /* friction presses them together */
        assert_close(exec_number(r.line, "speed"), cases[i].speed, 5e-4 * cases[i].speed);
        assert_close(exec_number(r.stats, "depth_max"), overlap, 0.02 * overlap);
        exec_run_free(&r);
    }
    /* what floats along is pressed by next to nothing, of which rounding of its momentum is much, and answers are
     * found, if not where all forces are 1e-11 N */
    static const char *const floating[] = {"shoved --weightless 1 --speed 0.3 --h 0.002 --steps 500",
                                           "shoved --weightless 1 --speed 0.05 --h 0.001 --steps 800"};
    for (int i = 0; i < 2; i++) {
        exec_run r = run_words(true, floating[i]);
        assert_true(exec_number(r.line, "ahead") > -0.004 && exec_number(r.stats, "unconverged_steps") <= 2);
        exec_run_free(&r);
    }
    /* a pose may be set less often than the world is stepped */
    assert_close(number_of(true, "shoved --every 2", "ahead"), -0.005, 1e-4);
    assert_true(number_of(true, "shoved --every 10 --h 0.001 --steps 1000", "ahead") > -0.004);
    /* what is set once into a body is no motion that takes it along */
    assert_true(number_of(true, "shoved --jump 0.05", "speed_max") < 0.2);
    assert_true(number_of(true, "shoved --jump 0.05 --h 0.001 --steps 1000", "speed_max") < 0.7);
}

/* Bodies of several geoms that begin in each other come apart, though friction has no limit. */
static void nothing_stays_in_the_other(void **state)
{
    (void)state;
    static const struct {
        int kind, seed;
    } cases[] = {{0, 1}, {0, 4}, {0, 5}, {0, 6}, {0, 14}, {1, 2}, {1, 4}, {1, 14}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char words[80];
        (void)snprintf(words, sizeof words, "merged --kind %d --seed %d", cases[i].kind, cases[i].seed);
        exec_run r = run_words(true, words);
        assert_true(exec_number(r.line, "depth_max") > 0.1);
        assert_true(exec_number(r.line, "depth_last") < 0.005);
        exec_run_free(&r);
    }
}

/* A plate that moves whatever it meets presses bodies against a wall, and they have no way out but at many times its
 * speed, if any. They are not shot out; the plate goes into them. A lever gets what the plate gives it. */
static void nothing_is_shot_out_of_a_press(void **state)
{
    (void)state;
    static const double SPEED = 0.5; /* the plate's */
    static const char *const rows[] = {"--objects 2 --height 0.4 --h 0.001",
                                       "--objects 3 --height 0.6 --h 0.001",
                                       "--objects 4 --height 0.6 --squeeze 0.01",
                                       "--objects 4 --height 0.8 --h 0.001",
                                       "--objects 5 --height 0.8",
                                       "--objects 3 --height 0.6 --h 0.005 --spheres 1",
                                       "--objects 4 --height 0.6 --spheres 1",
                                       "--objects 4 --height 0.6 --h 0.005 --spheres 1"};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        char words[80];
        (void)snprintf(words, sizeof words, "pressed %s", rows[i]);
        assert_true(number_of(true, words, "speed_max") < 10 * SPEED);
    }
    static const double ratios[] = {1, 4, 15, 40};
    for (size_t i = 0; i < sizeof ratios / sizeof *ratios; i++) {
        char words[80];
        (void)snprintf(words, sizeof words, "pressed --lever %g", ratios[i]);
        double speed = SPEED / 0.8 * ratios[i]; /* the plate's edge is at 0.8 of the short arm */
        assert_close(number_of(true, words, "end_speed"), speed, 0.01 * speed);
    }
    /* the plate is held back to what a gear gives, and not stopped */
    double geared = number_of(true, "pressed --lever 150", "end_speed");
    assert_true(geared > 50 * SPEED && geared < SPEED / 0.8 * 150);
}

/* Errors of position are taken back against gravity: of loops whose stops are moved, and of a chain that was torn. */
static void what_is_torn_comes_back(void **state)
{
    (void)state;
    assert_true(fabs(number_of(true, "platform", "below")) < 0.01);
    assert_true(fabs(number_of(true, "platform --stepper world", "below")) < 0.01);
    assert_true(fabs(number_of(true, "platform --height 0.2", "below")) < 0.01);
    exec_run r = run_words(true, "wreck");
    assert_true(exec_number(r.line, "gaps_max") > 1 &&
                exec_number(r.line, "gaps") < 0.7 * exec_number(r.line, "gaps_max"));
    assert_true(exec_number(r.line, "energy_max") <= exec_number(r.line, "energy_start"));
    double gap = exec_number(r.line, "gap_max"), told = exec_number(r.stats, "joint_error_max");
    assert_true(told <= gap * (1 + 1e-9) && told >= gap / sqrt(3)); /* the statistics have the errors of single rows */
    exec_run_free(&r);
}

/* A joint's own compliance is that of a dashpot, also where the body beside it is light. */
static void compliance_beside_a_light_body(void **state)
{
    (void)state;
    double angle = number_of(false, "dashpot --steps 100 --stepper world", "angle");
    assert_true(angle > 0.1 && angle < 1.5);
    assert_close(number_of(true, "dashpot --steps 100", "angle"), angle, 1e-4);
    assert_close(number_of(true, "dashpot --steps 100 --stepper world", "angle"), angle, 1e-4);
}

static void machines_work(void **state)
{
    (void)state;
    exec_run r = run_words(true, "gripper");
    assert_true(exec_number(r.line, "held") > 0.34); /* lifted by 0.3 m */
    exec_run_free(&r);
    double plain = number_of(false, "car --stepper world", "distance");
    r = run_words(true, "car");
    assert_close(exec_number(r.line, "distance"), plain, 0.05 * plain);
    assert_true(exec_number(r.stats, "joints_solved") > 0); /* its hinge-2 joints, too */
    assert_int_equal(exec_number(r.stats, "joints_left"), 0);
    assert_true(exec_number(r.stats, "joint_error_max") < 1e-3 && exec_number(r.stats, "joint_error_max") > 0);
    assert_true(exec_number(r.stats, "joint_error_angle_max") < 1e-2);
    exec_run_free(&r);
    r = run_words(true, "sleep");
    assert_int_equal(exec_number(r.line, "asleep"), 6);
    assert_int_equal(exec_number(r.line, "woken"), 1);
    exec_run_free(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_rests_under_ode_rests),
        cmocka_unit_test(a_stack_stands_still),
        cmocka_unit_test(the_heaviest_do_not_sink),
        cmocka_unit_test(heaps_come_to_rest),
        cmocka_unit_test(energy_does_not_grow),
        cmocka_unit_test(a_slope_holds_to_the_friction_angle),
        cmocka_unit_test(feedback_sums_to_the_weight),
        cmocka_unit_test(surface_modes_keep_their_meaning),
        cmocka_unit_test(what_moves_does_its_work),
        cmocka_unit_test(what_is_sunk_comes_out),
        cmocka_unit_test(what_is_sunk_does_not_hop),
        cmocka_unit_test(nothing_goes_through_what_it_shoves),
        cmocka_unit_test(nothing_stays_in_the_other),
        cmocka_unit_test(nothing_is_shot_out_of_a_press),
        cmocka_unit_test(what_is_torn_comes_back),
        cmocka_unit_test(compliance_beside_a_light_body),
        cmocka_unit_test(machines_work),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
