/*
 * Programs that throw things into each other, beside plain ODE: a heap that starts in itself is given up as soon as its
 * budget is used up and is not blown apart harder, and what is shot into the ground comes out as soon.
 */
#include "support/cmocka_all.h"

#include "support/command.h"
#include "support/draw.h"
#include "support/sanitized.h"

#include <stdio.h>
#include <string.h>

/* Of a solve that its budget ends, and the sweeps that take its place. */
enum { MOST_ITERATIONS = 60 };

typedef struct pair {
    exec_run plain, under;
} pair;

static pair run_both(char *const *command)
{
    pair r = {exec_program_run(NULL, command), exec_program_run((char *[]){NULL}, command)};
    assert_int_equal(r.plain.result.status, 0);
    assert_int_equal(r.under.result.status, 0);
    assert_non_null(r.plain.line);
    assert_non_null(r.under.line);
    return r;
}

static void free_both(pair *r)
{
    exec_run_free(&r->plain);
    exec_run_free(&r->under);
}

/* Asserts that Pinch's number is at most `most`. */
static void at_most(const pair *r, const char *key, double most)
{
    double value = exec_number(r->under.line, key);
    if (!(value <= most)) print_error("%s: %g, at most %g\n", key, value, most);
    assert_true(value <= most);
}

static void dense_start(void **state)
{
    (void)state;
    static char *const bodies[] = {"1000", "300", "10000"}, *const steps[] = {"1", "60", "1"};
    for (int i = 0; i < (draw_full() ? 3 : 2); i++) {
        char *command[] = {exec_program("dense"), "--bodies", bodies[i], "--steps", steps[i],
                           "--stepper",           "quick",    NULL};
        pair r = run_both(command);
        /* without a budget a solve would go on for hundreds of iterations, through one floor after the other */
        assert_true(exec_number(r.under.stats, "iterations_max") <= MOST_ITERATIONS);
        assert_true(exec_number(r.under.stats, "islands_swept") > 0);
        if (!SANITIZED) at_most(&r, "memory_mb", 3 * exec_number(r.plain.line, "memory_mb"));
        at_most(&r, "energy_max", 1.01 * exec_number(r.plain.line, "energy_max"));
        at_most(&r, "energy_end", 1.01 * exec_number(r.plain.line, "energy_end"));
        free_both(&r);
    }
}

/* After a step that took too long Pinch sweeps the heap, tries again after more and more steps, and solves what has
 * come apart. Nothing is left to ODE, and what sweeps do counts as not converged. */
static void heaps_come_apart(void **state)
{
    (void)state;
    char *command[] = {exec_program("dense"), "--bodies", "1000", "--steps", "60", "--stepper", "quick", NULL};
    exec_run r = exec_program_run((char *[]){NULL}, command);
    double swept = exec_number(r.stats, "islands_swept"), unconverged = exec_number(r.stats, "unconverged_steps");
    assert_true(swept > 40 && unconverged >= swept - 5 && unconverged <= 60);
    assert_true(exec_number(r.stats, "contacts_left") == 0 && exec_number(r.stats, "backoffs") == 0);
    assert_true(exec_number(r.stats, "contacts_solved") > 100000);
    assert_true(exec_number(r.line, "energy_max") <= 1.01 * exec_number(r.line, "energy_start"));
    assert_null(strstr(r.result.err, " left to ODE for a while"));
    exec_run_free(&r);
}

static void shots(void **state)
{
    (void)state;
    static char *const sizes[] = {"0.05", "0.01", "0.002"}, *const lengths[] = {"0.001", "0.005", "0.01"};
    static char *const steps[] = {"1000", "300", "200"}, *const steppers[] = {"quick", "world"};
    static char *const boxes[] = {"0", "1", "0"}, *const angles[] = {"0", "0", "60"};
    for (int k = 0; k < 3 * 3 * 3 * 2; k++) {
        int h = k / 3 % 3, kind = k / 9 % 3;
        char *command[] = {
            exec_program("shot"), "--size",  sizes[k % 3], "--h",       lengths[h],       "--steps", steps[h], "--box",
            boxes[kind],          "--angle", angles[kind], "--stepper", steppers[k / 27], NULL};
        pair r = run_both(command);
        /* the compliance of a contact makes the last part of the way a step longer */
        at_most(&r, "steps_inside", 1 + exec_number(r.plain.line, "steps_inside"));
        at_most(&r, "speed_out", 1.001 * exec_number(r.plain.line, "speed_out") + 1e-6);
        at_most(&r, "energy_max", exec_number(r.under.line, "energy_start"));
        at_most(&r, "energy_end", 1.01 * exec_number(r.plain.line, "energy_end"));
        free_both(&r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(dense_start),
        cmocka_unit_test(heaps_come_apart),
        cmocka_unit_test(shots),
    };
    return cmocka_run_group_tests_name("impacts", tests, NULL, NULL);
}
