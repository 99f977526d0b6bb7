/* Contacts as programs make them that do not leave them to dCollide: without geoms, and hundreds of one pair; and those
 * of shapes that they change. */
#include "support/cmocka_all.h"

#include "support/command.h"

static exec_run run(char **words)
{
    char *program = words[0];
    words[0] = exec_program(program);
    exec_run r = exec_program_run((char *[]){NULL}, words);
    words[0] = program;
    assert_int_equal(r.result.status, 0);
    assert_non_null(r.line);
    return r;
}

/* Whatever is in the place of the geoms, the contacts are solved, and everything rests where it was put. */
static void contacts_without_geoms_are_solved(void **state)
{
    (void)state;
    static char *const names[] = {"0", "1", "2", "3"}, *const steppers[] = {"world", "quick"};
    for (int i = 0; i < 8; i++) {
        exec_run r = run((char *[]){"geomless", "--names", names[i / 2], "--stepper", steppers[i % 2], NULL});
        double drift = exec_number(r.line, "drift"), top = exec_number(r.line, "top");
        if (drift > 1e-7) print_error("names %s, %s: drift %g m\n", names[i / 2], steppers[i % 2], drift);
        assert_true(drift <= 1e-7); /* in 5 s; under quickstep 1e-3 m */
        assert_close(top, 1.75, 1e-4);
        assert_int_equal(exec_number(r.stats, "contacts_malformed"), 0);
        assert_int_equal(exec_number(r.stats, "contacts_left"), 0);
        assert_true(exec_number(r.stats, "contacts_solved") > 0);
        exec_run_free(&r);
    }
}

/*
 * 324 contacts of one pair carry as they do in ODE: no tilt, and as springs (erp d/h = cfm r each) the depth
 * m g h cfm/(324 erp). The box stands 1e-4 m deep at first, of which the floor of a stiff contact's compliance may
 * leave 1e-6 m.
 */
static void hundreds_of_contacts_carry_a_box(void **state)
{
    (void)state;
    static char *const steppers[] = {"world", "quick"}, *const soft[] = {"0", "1e-3"};
    const double depth[] = {0, 9.81 * 0.005 * 1e-3 / (324 * 0.2)}, near[] = {1e-6, 1e-10};
    for (int i = 0; i < 4; i++) {
        exec_run r = run((char *[]){"tessellated", "--soft", soft[i / 2], "--stepper", steppers[i % 2], NULL});
        assert_true(exec_number(r.line, "tilt") < 1e-9);
        assert_true(exec_number(r.line, "drift") < 1e-9);
        assert_true(exec_number(r.line, "speed_last") < 1e-9);
        assert_close(exec_number(r.line, "height"), 0.5 - depth[i / 2], near[i / 2]);
        exec_run_free(&r);
    }
}

/* Each of 324 contacts resists with at most 0.01 N. What is left of a push of 3.34 N moves 1 kg by 5 m in 10 s. */
static void hundreds_of_limits_add_up(void **state)
{
    (void)state;
    exec_run r = run((char *[]){"tessellated", "--limit", "0.01", "--push", "3.23", NULL});
    assert_true(exec_number(r.line, "drift") < 1e-5);
    exec_run_free(&r);
    r = run((char *[]){"tessellated", "--limit", "0.01", "--push", "3.34", NULL});
    assert_close(exec_number(r.line, "drift"), 5, 0.05);
    exec_run_free(&r);
}

/* Pads tilt about edges that are parallel to the cubes' below them, 10,000 steps of pads in all. ODE's collider loses
 * some of them. */
static void tilting_pads_are_not_lost(void **state)
{
    (void)state;
    exec_run r = run((char *[]){"tilted", NULL});
    assert_int_equal(exec_number(r.line, "lost"), 0);
    assert_int_equal(exec_number(r.line, "single"), 0);
    exec_run_free(&r);
}

/* ODE's spaces meet a mesh with other data while the ball on it, whose motion would have them look at it, rests. */
static void meshes_may_change_below_what_rests(void **state)
{
    (void)state;
    static char *const kinds[] = {"0", "1", "2", "3"}, *const carriers[] = {"0", "1"};
    for (int i = 0; i < 8; i++) {
        exec_run r = run((char *[]){"remeshed", "--kind", kinds[i / 2], "--carrier", carriers[i % 2], NULL});
        assert_close(exec_number(r.line, "lifted"), 0.1, 1e-5);
        assert_close(exec_number(r.line, "landed"), 0.1, 1e-5);
        exec_run_free(&r);
    }
}

/* ODE's space does not look behind a geom that is added to it until the geom moves, which one at rest does not. */
static void geoms_may_change_spaces_at_rest(void **state)
{
    (void)state;
    static char *const numbers[] = {"0", "1", "2", "3", "4"};
    for (int i = 0; i < 20; i++) {
        exec_run r = run((char *[]){"respaced", "--kind", numbers[i / 5], "--what", numbers[i % 5], NULL});
        assert_close(exec_number(r.line, "rests"), 0.3, 1e-5);
        assert_close(exec_number(r.line, "landed"), 0.1, 1e-5);
        exec_run_free(&r);
    }
}

/* A collider that has room for fewer contacts than there are leaves out whole corners of a mesh in some steps. These
 * are still there, and keep their springs, though it puts contacts on the mesh and not between the surfaces. */
static void corners_without_room_keep_their_springs(void **state)
{
    (void)state;
    static char *const cases[][2] = {{"200", "0.3"}, {"200", "0.6"}, {"260", "0.6"}, {"320", "0"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        exec_run r =
            run((char *[]){"meshed", "--stepper", "world", "--stiffness", cases[i][0], "--tilt", cases[i][1], NULL});
        assert_true(fabs(exec_number(r.line, "sinks")) < 1e-9);
        exec_run_free(&r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tilting_pads_are_not_lost),         cmocka_unit_test(corners_without_room_keep_their_springs),
        cmocka_unit_test(contacts_without_geoms_are_solved), cmocka_unit_test(hundreds_of_contacts_carry_a_box),
        cmocka_unit_test(hundreds_of_limits_add_up),         cmocka_unit_test(meshes_may_change_below_what_rests),
        cmocka_unit_test(geoms_may_change_spaces_at_rest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
