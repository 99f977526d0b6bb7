/* Runs the real `pinch bench` and checks its documents, and what in them does not depend on the machine's speed. */
#include "support/cmocka_all.h"

#include "support/command.h"
#include "support/sanitized.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static json_t *rows_of(const program_result *r, json_t **document)
{
    *document = json_loads(r->out, 0, NULL);
    assert_non_null(*document);
    assert_string_equal(json_string_value(json_object_get(*document, "command")), "bench");
    json_t *rows = json_object_get(*document, "rows");
    assert_true(json_is_array(rows));
    return rows;
}

static double number(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    if (!json_is_number(value)) print_error("%s is no number\n", key);
    assert_true(json_is_number(value));
    return json_number_value(value);
}

/* What every row must show: verified answers, forces on the law, nothing allocated, nobody left out. */
static void check_row(const json_t *row, double residual_N)
{
    const json_t *pinch = json_object_get(row, "pinch"), *quickstep = json_object_get(row, "quickstep");
    assert_true(number(row, "contacts") > 0);
    assert_true(number(row, "rounds") >= 7);
    assert_true(number(row, "ratio_quickstep") > 0);
    assert_true(number(row, "residual_max") <= 1e-10);
    assert_true(number(row, "unsolved_steps") == 0);
    assert_true(number(pinch, "step_us") > 0 && number(quickstep, "step_us") > 0);
    assert_true(number(pinch, "residual_N") <= residual_N);
    assert_true(number(pinch, "allocations_per_step") == 0);
    assert_true(number(row, "memory_per_contact_bytes") > 100);
}

static void grasps_are_solved_without_allocating(void **state)
{
    (void)state;
    char *const names[] = {"step", "hands", "carried", "slip", "cold"};
    const int rows_expected[] = {4, 2, 2, 2, 2}; /* up to size 10 */
    for (int k = 0; k < 5; k++) {
        program_result r = PINCH(NULL, "bench", names[k], "--max-size", "10", "--budget", "0.05", "--json");
        assert_int_equal(r.status, 0);
        assert_string_equal(r.err, "");
        json_t *document, *rows = rows_of(&r, &document), *row;
        size_t i;
        assert_int_equal(json_array_size(rows), rows_expected[k]);
        json_array_foreach(rows, i, row) check_row(row, 1e-9);
        json_decref(document);
        program_free(&r);
    }
}

/* Hands of 16 and 24 joints, at rest and shaken, one each: solved, without allocating, and at rest not even solved. */
static void robot_hands_are_solved_without_allocating(void **state)
{
    (void)state;
    if (SANITIZED)
        skip(); /* until they rest takes half a minute; the scenes with hands run under the sanitizers in tests/hands */
    program_result r = PINCH(NULL, "bench", "robots", "--max-size", "1", "--budget", "0.02", "--json");
    assert_int_equal(r.status, 0);
    json_t *document, *rows = rows_of(&r, &document), *row;
    size_t i;
    assert_int_equal(json_array_size(rows), 4);
    json_array_foreach(rows, i, row)
    {
        bool rests = strstr(json_string_value(json_object_get(row, "case")), "at rest") != NULL;
        assert_true(json_is_true(json_object_get(row, "held")));
        assert_true(number(row, "contacts") >= 3);
        assert_true(number(row, "ratio_quickstep") > 0);
        assert_true(number(row, "unsolved_steps") == 0 && number(row, "left_to_ode") == 0);
        assert_true(number(row, "allocations_per_step") == 0);
        assert_true(rests ? number(row, "iterations") == 0 : number(row, "iterations") > 0);
    }
    json_decref(document);
    program_free(&r);
}

static void a_pile_at_rest_is_solved(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "bench", "pile", "--max-size", "60", "--budget", "0.2", "--json");
    assert_int_equal(r.status, 0);
    json_t *document, *rows = rows_of(&r, &document), *row;
    size_t i;
    assert_int_equal(json_array_size(rows), 3);
    json_array_foreach(rows, i, row)
    {
        assert_true(number(row, "residual_max") <= 1e-10);
        const json_t *pinch = json_object_get(row, "pinch");
        assert_true(number(pinch, "kinetic_energy_J") < 10); /* of 60 bodies of 1 to 10 kg */
        if (strcmp(json_string_value(json_object_get(row, "series")), "wall") != 0) continue;
        assert_true(json_is_true(json_object_get(pinch, "stands")));
        assert_true(number(pinch, "moved_m") < 1e-3);
        assert_true(number(pinch, "kinetic_energy_J") < 1e-18);
        assert_true(number(pinch, "iterations") < 1); /* most steps find that nothing has changed */
    }
    json_decref(document);
    program_free(&r);
}

/* They stand where they were built: the first solve, from no forces, has to succeed. */
static void pyramids_stand(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "bench", "pyramid", "--max-size", "55", "--budget", "0.1", "--json");
    assert_int_equal(r.status, 0);
    json_t *document, *rows = rows_of(&r, &document), *row;
    size_t i;
    assert_int_equal(json_array_size(rows), 2);
    json_array_foreach(rows, i, row)
    {
        const json_t *pinch = json_object_get(row, "pinch");
        assert_true(number(row, "residual_max") <= 1e-10);
        assert_true(json_is_true(json_object_get(pinch, "stands")));
        assert_true(number(pinch, "moved_m") < 1e-2);
    }
    json_decref(document);
    program_free(&r);
}

/* Pinch has the exact answer. A point is called below Pinch's just where its own numbers say so, and quickstep's law is
 * kept the better, the more iterations it makes. */
static void points_of_accuracy_and_time_are_judged(void **state)
{
    (void)state;
    program_result r =
        PINCH(NULL, "bench", "pareto", "--min-size", "2", "--max-size", "2", "--budget", "0.02", "--json");
    assert_int_equal(r.status, 0);
    json_t *document, *rows = rows_of(&r, &document);
    assert_int_equal(json_array_size(rows), 1);
    const json_t *row = json_array_get(rows, 0), *settings = json_object_get(row, "settings");
    double largest = number(row, "largest_force_N");
    assert_true(largest > 1 && json_array_size(settings) == 9);
    const json_t *ours = json_array_get(settings, 0);
    assert_true(number(ours, "law_error_N") <= 1e-9 && number(ours, "exact_error_N") <= 1e-9);
    for (size_t k = 0; k < 9; k++) {
        const json_t *point = json_array_get(settings, k), *below = json_object_get(point, "below_pinch");
        assert_true(number(point, "contact_us") > 0 && number(point, "contact_us") < number(point, "whole_us"));
        size_t expected = 0;
        for (int e = 0; e < 2; e++) {
            const char *key = e ? "exact_error_N" : "law_error_N";
            bool accurate = number(point, key) <= fmax(number(ours, key), 1e-9 * largest);
            expected += accurate && number(point, "ratio_contact") < 1;
            expected += accurate && number(point, "ratio_whole") < 1;
        }
        assert_int_equal(json_array_size(below), expected);
    }
    double few = number(json_array_get(settings, 2), "law_error_N");
    assert_true(few > 1e-6 && number(json_array_get(settings, 5), "law_error_N") < 1e-3 * few);
    assert_true(number(json_array_get(settings, 1), "exact_error_N") > 1e-3); /* the elasticity of fingertips */
    json_decref(document);
    program_free(&r);
}

/* Piles have no exact answer, so that nothing is judged by it. */
static void piles_are_judged_by_the_law(void **state)
{
    (void)state;
    program_result r =
        PINCH(NULL, "bench", "pareto", "--min-size", "20", "--max-size", "20", "--budget", "0.02", "--json");
    assert_int_equal(r.status, 0);
    json_t *document, *rows = rows_of(&r, &document);
    assert_int_equal(json_array_size(rows), 1);
    const json_t *settings = json_object_get(json_array_get(rows, 0), "settings");
    const json_t *ours = json_array_get(settings, 0);
    assert_int_equal(json_array_size(settings), 9);
    for (size_t k = 0; k < 9; k++) {
        const json_t *point = json_array_get(settings, k), *below = json_object_get(point, "below_pinch");
        bool accurate = number(point, "law_error_N") <= number(ours, "law_error_N");
        assert_true(number(point, "contact_us") > 0 && json_is_null(json_object_get(point, "exact_error_N")));
        assert_int_equal(json_array_size(below),
                         accurate * ((number(point, "ratio_contact") < 1) + (number(point, "ratio_whole") < 1)));
    }
    assert_true(number(json_array_get(settings, 3), "law_error_N") > 10 * number(ours, "law_error_N"));
    json_decref(document);
    program_free(&r);
}

/* All numbers of threads give the same bits, and the gains are against one thread. */
static void threads_are_compared_with_one(void **state)
{
    (void)state;
    program_result r =
        PINCH(NULL, "bench", "threads", "--max-size", "100", "--threads", "3", "--budget", "0.02", "--json");
    assert_int_equal(r.status, 0);
    json_t *document, *rows = rows_of(&r, &document), *row;
    size_t i;
    assert_int_equal(json_array_size(rows), 3);
    json_array_foreach(rows, i, row)
    {
        const json_t *quartiles = json_object_get(row, "whole_gain_quartiles");
        double low = json_number_value(json_array_get(quartiles, 0)), gain = number(row, "whole_gain"),
               high = json_number_value(json_array_get(quartiles, 1));
        assert_true(number(row, "threads") == (double)i + 1);
        assert_true(number(row, "contacts") == 500);
        assert_true(json_is_true(json_object_get(row, "same_bits")));
        assert_true(number(row, "contact_us") > 0 && number(row, "whole_us") > 0);
        assert_true(low > 0 && low <= gain && gain <= high);
        if (i == 0) assert_true(gain == 1 && number(row, "contact_gain") == 1);
    }
    json_decref(document);
    program_free(&r);
}

static void sizes_out_of_range_are_refused(void **state)
{
    (void)state;
    char *const wrong[][2] = {{"--max-size", "0"}, {"--threads", "65"}, {"--threads", "none"}, {"--budget", "0"}};
    for (int k = 0; k < 4; k++) {
        program_result r = PINCH(NULL, "bench", "step", wrong[k][0], wrong[k][1]);
        assert_int_equal(r.status, 2);
        assert_string_equal(r.out, "");
        assert_non_null(strstr(r.err, wrong[k][0]));
        program_free(&r);
    }
    static const struct {
        char *name, *least, *expected;
    } none[] = {{"hands", "11", "of hands, which are 1, 10, 100, 1000, 10000\n"},
                {"pareto", "50", "of pareto, which are 1, "},
                {"robots", "5", "of robots, which are 1, 4, 16\n"},
                {"threads", "5", "of threads, which are 100, 200, 210, 600, 820, 1000, 2000\n"}};
    for (int k = 0; k < 4; k++) {
        program_result r = PINCH(NULL, "bench", none[k].name, "--min-size", none[k].least, "--max-size", none[k].least);
        assert_int_equal(r.status, 2);
        assert_string_equal(r.out, "");
        assert_non_null(strstr(r.err, none[k].expected));
        program_free(&r);
    }
}

static void options_without_a_meaning_are_refused(void **state)
{
    (void)state;
    char *const wrong[][3] = {
        {"step", "--faithful", NULL},     {"collide", "--faithful", NULL}, {"collide", "--threads", "2"},
        {"collide", "--plot", "nowhere"}, {"paper", "--threads", "2"},     {"paper", "--max-size", "10"},
        {"pile", "--faithful", NULL},     {"pareto", "--threads", "2"},    {"threads", "--plot", "nowhere"}};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        char expected[80];
        program_result r = PINCH(NULL, "bench", wrong[k][0], wrong[k][1], wrong[k][2]);
        assert_int_equal(r.status, 2);
        assert_string_equal(r.out, "");
        snprintf(expected, sizeof expected, "pinch bench: %s means nothing for %s; it takes --seed", wrong[k][1],
                 wrong[k][0]);
        assert_true(strncmp(r.err, expected, strlen(expected)) == 0);
        assert_true(strchr(r.err, '\n') == r.err + strlen(r.err) - 1);
        program_free(&r);
    }
}

/* The numbers under `key` of the objects `part` (of the rows themselves for NULL) in the output of a benchmark. */
enum { MOST_ROWS = 256 };
static int numbers_of(const char *const *arguments, const char *part, const char *key, double values[MOST_ROWS])
{
    program_result r = command_run(NULL, arguments);
    assert_int_equal(r.status, 0);
    json_t *document, *rows = rows_of(&r, &document), *row;
    size_t i, count = json_array_size(rows);
    assert_true(count > 0 && count <= MOST_ROWS);
    json_array_foreach(rows, i, row) values[i] = number(part ? json_object_get(row, part) : row, key);
    json_decref(document);
    program_free(&r);
    return (int)count;
}

/* The seed is all that is random: the same one, the default among them, gives the same numbers; another one others. */
static void check_seed(const char *const *arguments, const char *part, const char *key)
{
    const char *const seeds[] = {NULL, "1", "4294967298"}; /* 2^32 + 2: what ODE's 32 bits cut off counts, too */
    double values[3][MOST_ROWS];
    int count[3];
    for (int k = 0; k < 3; k++) {
        const char *all[12] = {NULL};
        int n = 0;
        for (; arguments[n]; n++) all[n] = arguments[n];
        if (seeds[k]) all[n] = "--seed", all[n + 1] = seeds[k];
        count[k] = numbers_of(all, part, key, values[k]);
    }
    assert_true(count[0] == count[1] && count[0] == count[2]);
    assert_memory_equal(values[0], values[1], (size_t)count[0] * sizeof(double));
    assert_memory_not_equal(values[0], values[2], (size_t)count[0] * sizeof(double));
}

/* The order of quickstep's rows; with next to no budget the number of rounds is fixed. */
static void a_seed_orders_the_rows_of_quickstep(void **state)
{
    (void)state;
    check_seed((const char *const[]){"bench", "step", "--max-size", "2", "--budget", "1e-9", "--json", NULL},
               "quickstep", "residual_N");
}

static void a_seed_draws_the_poses_of_collide(void **state)
{
    (void)state;
    check_seed((const char *const[]){"bench", "collide", "--budget", "1e-9", "--json", NULL}, NULL, "contacts_mean");
}

/* The paper's two methods and nothing else, and NSNGRK's rows by the seed. */
static void the_paper_alone(void **state)
{
    (void)state;
    program_result r =
        PINCH(NULL, "bench", "paper", "--faithful", "--faces", "4", "--json", SANITIZED ? "--budget" : NULL, "0.01");
    assert_int_equal(r.status, 0);
    json_t *document, *rows = rows_of(&r, &document), *row;
    enum { PAPER_ROWS = 5 };
    double default_seed[MOST_ROWS], other_seed[MOST_ROWS];
    size_t i;
    assert_int_equal(json_array_size(rows), PAPER_ROWS);
    json_array_foreach(rows, i, row)
    {
        const char *const methods[] = {"nsngrk", "nsnmgk"};
        for (int k = 0; k < 2; k++) {
            const json_t *m = json_object_get(row, methods[k]);
            assert_string_equal(json_string_value(json_object_get(m, "status")), "converged");
            assert_true(number(m, "residual") <= 1e-4 && number(m, "iterations") > 1);
            const json_t *time = json_object_get(m, "time_quartiles_s");
            assert_true(number(time, "low") > 0 && number(time, "low") <= number(m, "time_s"));
            assert_true(number(m, "time_s") <= number(time, "high"));
        }
        /* the speed-up is a median of ratios, and about the ratio of the work */
        const json_t *quartiles = json_object_get(row, "speedup_quartiles"), *work = json_object_get(row, "operations");
        assert_true(number(quartiles, "low") <= number(row, "speedup"));
        assert_true(number(quartiles, "high") >= number(row, "speedup"));
        assert_true(number(row, "rounds") >= (SANITIZED ? 1 : 5));
        /* operations of an iteration times iterations */
        assert_close(number(row, "row_operation_ratio"),
                     number(row, "iteration_ratio") * number(work, "nsngrk") / number(work, "nsnmgk"), 1e-12);
        assert_close(number(work, "nsngrk"), number(row, "unknowns") + 1, 1e-9);
        assert_close(number(work, "nsnmgk"),
                     number(row, "unknowns") + 2 * number(work, "projections_of_an_iteration") - 1, 1e-9);
        const json_t *faces = json_object_get(row, "faces");
        assert_true(i < 2 ? json_is_null(faces) : json_integer_value(faces) == 4); /* 1 and 1b are without friction */
        default_seed[i] = number(json_object_get(row, "nsngrk"), "iterations");
        assert_close(number(row, "speedup"), number(row, "iteration_ratio"), 0.4 * number(row, "iteration_ratio"));
        assert_null(json_object_get(row, "default"));
        assert_null(json_object_get(row, "lemke"));
    }
    json_decref(document);
    program_free(&r);
    numbers_of((const char *const[]){"bench", "paper", "--faithful", "--faces", "4", "--seed", "1000", "--budget",
                                     "0.01", "--json", NULL},
               "nsngrk", "iterations", other_seed);
    for (i = 0; i < PAPER_ROWS; i++)
        assert_true(fabs(other_seed[i] - default_seed[i]) < 0.1 * default_seed[i]); /* means of 50 */
    assert_memory_not_equal(default_seed, other_seed, sizeof(double) * PAPER_ROWS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grasps_are_solved_without_allocating),
        cmocka_unit_test(robot_hands_are_solved_without_allocating),
        cmocka_unit_test(a_pile_at_rest_is_solved),
        cmocka_unit_test(pyramids_stand),
        cmocka_unit_test(points_of_accuracy_and_time_are_judged),
        cmocka_unit_test(piles_are_judged_by_the_law),
        cmocka_unit_test(threads_are_compared_with_one),
        cmocka_unit_test(sizes_out_of_range_are_refused),
        cmocka_unit_test(options_without_a_meaning_are_refused),
        cmocka_unit_test(a_seed_orders_the_rows_of_quickstep),
        cmocka_unit_test(a_seed_draws_the_poses_of_collide),
        cmocka_unit_test(the_paper_alone),
    };
    return cmocka_run_group_tests_name("pinch bench", tests, NULL, NULL);
}
