/*
 * Runs every program of tests/programs under `pinch exec` with both of ODE's steps. Each must go on as it should, and
 * its statistics must add up. With PINCH_TEST_FULL the runs are long.
 */

#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/command.h"
#include "support/draw.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char *const programs[] = {"stack",   "wall",     "spheres", "boxes",    "chain",    "car",
                                 "gripper", "ragdoll",  "heavy",   "slope",    "sleep",    "bounce",
                                 "slip",    "conveyor", "limit",   "infinite", "feedback", "bridge"};
enum { PROGRAMS = sizeof programs / sizeof *programs };
static char *const steppers[] = {"quick", "world"};

/* worldstep's cost grows with the cube of what touches: piles are quickstep's */
static bool is_pile(const char *program)
{
    return strcmp(program, "spheres") == 0 || strcmp(program, "boxes") == 0 || strcmp(program, "wall") == 0;
}

static char *steps_of(const char *program)
{
    return draw_full() ? "5000" : is_pile(program) ? "60" : "800";
}

static void expect_sums(const json_t *s, long steps)
{
    assert_int_equal(exec_number(s, "steps"), steps);
    assert_int_equal(exec_number(s, "worlds"), 1);
    assert_int_equal(exec_number(s, "steps_refused"), 0);
    long left = (long)exec_number(s, "contacts_left");
    assert_int_equal(left, exec_number(s, "contacts_left_by_scope") + exec_number(s, "contacts_left_unsupported") +
                               exec_number(s, "contacts_left_unsolved") + exec_number(s, "contacts_left_refused") +
                               exec_number(s, "contacts_left_unrecorded"));
    long offered = (long)exec_number(s, "contacts_offered"), solved = (long)exec_number(s, "contacts_solved");
    long others = (long)(exec_number(s, "contacts_malformed") + exec_number(s, "contacts_asleep"));
    assert_true(offered > 0);
    /* a point may stay on for a step in which the collider did not return it, and merge with another */
    assert_true(solved + left + others > 0);
    assert_true(left - (long)exec_number(s, "contacts_left_unsolved") + others <= offered);
    assert_true(exec_number(s, "unconverged_steps") <= (double)steps);
    assert_true(exec_number(s, "islands_fallback") <= exec_number(s, "islands") + exec_number(s, "islands_fallback"));
    assert_true(exec_number(s, "iterations_mean") <= exec_number(s, "iterations_max"));
    assert_true(exec_number(s, "time_pinch_s") > 0 && exec_number(s, "time_ode_s") > 0);
    assert_true(exec_number(s, "depth_max") >= 0 && exec_number(s, "floor_depth_max") >= 0);
}

static void all_go_on(void **state)
{
    (void)state;
    for (int i = 0; i < PROGRAMS; i++)
        for (int k = 0; k < (is_pile(programs[i]) ? 1 : 2); k++) {
            char *steps = steps_of(programs[i]);
            exec_run r = exec_program_run((char *[]){NULL}, (char *[]){exec_program(programs[i]), "--steps", steps,
                                                                       "--stepper", steppers[k], NULL});
            if (r.result.status != 0) print_error("%s %s: %s\n", programs[i], steppers[k], r.result.err);
            assert_int_equal(r.result.status, 0);
            assert_non_null(r.line);
            assert_true(json_is_true(json_object_get(r.line, "finite")));
            assert_int_equal(exec_number(r.line, "steps"), atol(steps));
            expect_sums(r.stats, atol(steps));
            exec_run_free(&r);
        }
}

/* With nothing in scope a program is ODE's alone, to the bit: no random number of its is drawn, no order changed. */
static void outside_of_the_scope_to_the_bit(void **state)
{
    (void)state;
    for (int i = 0; i < PROGRAMS; i++)
        for (int k = 0; k < (is_pile(programs[i]) ? 1 : 2); k++) {
            char *command[] = {exec_program(programs[i]),
                               "--steps",
                               is_pile(programs[i]) ? "60" : "800",
                               "--stepper",
                               steppers[k],
                               NULL};
            exec_run plain = exec_program_run(NULL, command);
            exec_run under = exec_program_run((char *[]){"--only", "material", NULL}, command);
            if (strcmp(plain.result.out, under.result.out) != 0) print_error("%s %s\n", programs[i], steppers[k]);
            assert_string_equal(plain.result.out, under.result.out);
            assert_int_equal(plain.result.status, under.result.status);
            const json_t *s = under.stats;
            assert_int_equal(exec_number(s, "contacts_solved"), 0);
            assert_int_equal(exec_number(s, "contacts_offered"), 0);
            assert_true(exec_number(s, "contacts_left_by_scope") > 0);
            assert_int_equal(exec_number(s, "contacts_left"), exec_number(s, "contacts_left_by_scope"));
            exec_run_free(&plain);
            exec_run_free(&under);
        }
}

/* ODE's own threads inside of a step are ODE's matter. */
static void worlds_with_threads(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        exec_run r = exec_program_run((char *[]){NULL}, (char *[]){exec_program("ragdoll"), "--steps", "400",
                                                                   "--stepper", steppers[k], "--threads", "3", NULL});
        assert_int_equal(r.result.status, 0);
        assert_true(json_is_true(json_object_get(r.line, "finite")));
        expect_sums(r.stats, 400);
        exec_run_free(&r);
    }
}

/* Same input, same bits. */
static void twice_the_same(void **state)
{
    (void)state;
    char *command[] = {exec_program("ragdoll"), "--steps", "400", NULL};
    exec_run first = exec_program_run((char *[]){NULL}, command), second = exec_program_run((char *[]){NULL}, command);
    assert_string_equal(first.result.out, second.result.out);
    assert_int_equal(exec_number(first.stats, "contacts_solved"), exec_number(second.stats, "contacts_solved"));
    exec_run_free(&first);
    exec_run_free(&second);
}

static char python[] = "/usr/bin/python3";

/* Returns the seconds of the processor that the first step of a chain on the ground takes. */
static double seconds_of_chain(char *links)
{
    exec_run r = exec_program_run((char *[]){NULL}, (char *[]){exec_program("chain"), "--links", links, "--height",
                                                               "0.0295", "--steps", "1", "--time", "1", NULL});
    assert_int_equal(r.result.status, 0);
    assert_true(exec_number(r.stats, "contacts_solved") >= 2 * atoi(links));
    assert_int_equal(exec_number(r.stats, "joints_solved"), atoi(links));
    double seconds = exec_number(r.line, "step_time");
    exec_run_free(&r);
    return seconds;
}

/* Four times the links take about four times as long; sixteen would be in proportion to their square. */
static void long_chains_in_linear_time(void **state)
{
    (void)state;
    double shorter = seconds_of_chain("500"), longer = seconds_of_chain("2000");
    if (longer > 10 * shorter) print_error("500 links: %g s, 2000 links: %g s\n", shorter, longer);
    assert_true(longer <= 10 * shorter);
}

static void a_python_program(void **state)
{
    (void)state;
    char script[1024];
    snprintf(script, sizeof script, "%s/tests/programs/pile.py", PINCH_SOURCE_DIR);
    if (system("/usr/bin/python3 -c 'import ode' 2>/dev/null") != 0) {
        print_message("skipped: %s has no module ode (package python3-pyode)\n", python);
        skip();
    }
    for (int k = 0; k < 2; k++) {
        exec_run r = exec_program_run((char *[]){NULL}, (char *[]){python, script, "600", steppers[k], NULL});
        if (r.result.status != 0) print_error("%s\n", r.result.err);
        assert_int_equal(r.result.status, 0);
        assert_true(json_is_true(json_object_get(r.line, "finite")));
        assert_int_equal(exec_number(r.stats, "steps"), 600);
        assert_true(exec_number(r.stats, "contacts_offered") > 5000);
        /* the four boxes stand on each other, and the sphere beside them */
        const json_t *heights = json_object_get(r.line, "heights");
        static const double expected[] = {0.2, 0.6, 1.0, 1.4, 0.2};
        for (size_t i = 0; i < 5; i++) assert_close(json_number_value(json_array_get(heights, i)), expected[i], 5e-3);
        exec_run_free(&r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_go_on),           cmocka_unit_test(outside_of_the_scope_to_the_bit),
        cmocka_unit_test(worlds_with_threads), cmocka_unit_test(twice_the_same),
        cmocka_unit_test(a_python_program),    cmocka_unit_test(long_chains_in_linear_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
