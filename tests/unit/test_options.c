/* Tests the options of the command line without a command behind them. */

#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "cli/command.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

static const option_id all_options[] = {
    OPTION_SOLVER,    OPTION_FORMULATION,
    OPTION_TOLERANCE, OPTION_MAX_ITERATIONS,
    OPTION_FACES,     OPTION_SEED,
    OPTION_DURATION,  OPTION_STEP,
    OPTION_JSON,      OPTION_CSV,
    OPTION_QUIET,     OPTION_CONTACT_SOLVER,
    OPTION_NO_NEWTON, OPTION_ONLY,
    OPTION_KT_RATIO,  OPTION_CONFIG,
    OPTION_STATS,     OPTION_QUICKSTEP_ITERATIONS,
    OPTION_CONTACTS,  OPTION_COUNT,
};
static const command probe = {
    .name = "probe", .arguments = "SCENE", .min_arguments = 1, .max_arguments = 2, .options = all_options};
static const command launcher = {.name = "launcher",
                                 .arguments = "PROGRAM",
                                 .max_arguments = INT_MAX,
                                 .takes_program = true,
                                 .options = all_options};

/* text: words separated by single spaces; '_' stands for an empty word. *o points into `words`. */
static options_outcome parse(const command *c, const char *text, char words[256], options *o)
{
    static char *argv[32];
    int argc = 0;
    snprintf(words, 256, "%s", text);
    for (char *word = strtok(words, " "); word; word = strtok(NULL, " "))
        argv[argc++] = strcmp(word, "_") == 0 ? word + 1 : word;
    return options_parse(c, argc, argv, o);
}

static void test_values(void **state)
{
    (void)state;
    char words[256];
    options o;
    assert_int_equal(parse(&probe,
                           "a.json --solver lemke --formulation=lcp --tolerance 1e-12 --max-iterations=7 --faces 5 "
                           "--seed 18446744073709551615 --duration 0 --step .5 --json --csv t.csv b.json "
                           "--contact-solver worldstep",
                           words, &o),
                     OPTIONS_RUN);
    assert_int_equal(o.solver, PINCH_SOLVER_LEMKE);
    assert_int_equal(o.formulation, SCENE_LCP);
    assert_true(o.tolerance == 1e-12 && o.duration == 0.0 && o.step == 0.5);
    assert_int_equal(o.max_iterations, 7);
    assert_int_equal(o.faces, 5);
    assert_true(o.seed == UINT64_MAX);
    assert_int_equal(o.contact_solver, WORLD_WORLDSTEP);
    assert_true(o.json && !o.quiet && !o.given[OPTION_QUIET] && o.given[OPTION_DURATION]);
    assert_string_equal(o.csv, "t.csv");
    assert_int_equal(o.argument_count, 2);
    assert_string_equal(o.arguments[0], "a.json");
    assert_string_equal(o.arguments[1], "b.json");
}

static void test_defaults(void **state)
{
    (void)state;
    char words[256];
    options o;
    assert_int_equal(parse(&probe, "--json -- --odd-name.json", words, &o), OPTIONS_RUN);
    assert_string_equal(o.arguments[0], "--odd-name.json");
    assert_true(o.seed == 1);
    for (int i = 0; i < OPTION_COUNT; i++) assert_int_equal(o.given[i], i == OPTION_JSON);
}

static void test_program_keeps_its_options(void **state)
{
    (void)state;
    char words[256];
    options o;
    assert_int_equal(parse(&launcher, "--quiet -- prog --json --help", words, &o), OPTIONS_RUN);
    assert_int_equal(o.argument_count, 3);
    assert_false(o.json);
    assert_int_equal(parse(&launcher, "--quiet prog --json --nonsense", words, &o), OPTIONS_RUN);
    assert_int_equal(o.argument_count, 3);
}

static void test_exec_options(void **state)
{
    (void)state;
    char words[256];
    options o;
    assert_int_equal(parse(&launcher, "--only soft --kt-ratio=10 --stats - --config c.json prog --only x", words, &o),
                     OPTIONS_RUN);
    assert_int_equal(o.only, PINCH_ODE_SOFT_CONTACTS);
    assert_true(o.kt_ratio == 10);
    assert_string_equal(o.stats, "-");
    assert_string_equal(o.config, "c.json");
    assert_int_equal(o.argument_count, 3);
}

/* keys of a configuration are the options' names, with '_' for '-' */
static void test_keys(void **state)
{
    (void)state;
    assert_int_equal(options_find(&probe, "kt_ratio"), OPTION_KT_RATIO);
    assert_int_equal(options_find(&probe, "max_iterations"), OPTION_MAX_ITERATIONS);
    assert_int_equal(options_find(&probe, "kt-ratio"), OPTION_COUNT);
    assert_int_equal(options_find(&probe, "kt_rati"), OPTION_COUNT);
    assert_int_equal(options_find(&probe, "kt_ratio_"), OPTION_COUNT);
    assert_int_equal(options_find(&probe, ""), OPTION_COUNT);
    assert_true(options_is_number(OPTION_KT_RATIO) && options_is_number(OPTION_MAX_ITERATIONS));
    assert_false(options_is_number(OPTION_ONLY) || options_is_number(OPTION_STATS));
    options o = {.command = &launcher};
    char expected[160];
    assert_true(options_store(&o, OPTION_KT_RATIO, "0.5", expected, sizeof expected));
    assert_false(options_store(&o, OPTION_KT_RATIO, "11", expected, sizeof expected));
    assert_string_equal(expected, "a number > 0 and <= 10");
}

static void test_wrong(void **state)
{
    (void)state;
    static const char *const lines[] = {
        "",
        "a b c",
        "a --solver",
        "a --solver dantzig",
        "a --formulation cone",
        "a --tolerance 0",
        "a --tolerance nan",
        "a --tolerance inf",
        "a --tolerance 1e-9x",
        "a --tolerance 1e999",
        "a --tolerance _",
        "a --tolerance 0x1",
        "a --step -1",
        "a --duration -0.1",
        "a --faces 2",
        "a --faces 5000",
        "a --faces 8.5",
        "a --max-iterations 0",
        "a --max-iterations 1e10",
        "a --seed -1",
        "a --seed 18446744073709551616",
        "a --csv=",
        "a --json=1",
        "a --print",
        "a --jso",
        "a --jsonx",
        "a -j",
        "a --contact-solver dart",
        "a --only hard",
        "a --only _",
        "a --kt-ratio 0",
        "a --kt-ratio 10.01",
        "a --kt-ratio inf",
        "a --config=",
        "a --stats",
    };
    char words[256];
    options o;
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++)
        if (parse(&probe, lines[i], words, &o) != OPTIONS_WRONG) fail_msg("taken: %s", lines[i]);
    assert_int_equal(parse(&probe, "--help", words, &o), OPTIONS_HELP);
    assert_int_equal(parse(&probe, "x --version", words, &o), OPTIONS_VERSION);
}

/* Which solver does which formulation. A run with the linearized cone is left to the test of that run. */
static void test_pairs(void **state)
{
    (void)state;
    static const struct {
        pinch_solver solver;
        bool static_coulomb, run_coulomb;
    } rows[] = {
        {PINCH_SOLVER_NSNMGK, true, true},  {PINCH_SOLVER_NSNGRK, false, true}, {PINCH_SOLVER_NEWTON, true, true},
        {PINCH_SOLVER_LEMKE, false, false}, {PINCH_SOLVER_PGS, false, false},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        pinch_solver s = rows[i].solver;
        assert_true(scene_pair_exists(SCENE_FOR_STATICS, s, SCENE_LCP));
        assert_int_equal(scene_pair_exists(SCENE_FOR_STATICS, s, SCENE_COULOMB), rows[i].static_coulomb);
        assert_int_equal(scene_pair_exists(SCENE_FOR_RUN, s, SCENE_COULOMB), rows[i].run_coulomb);
    }
    char text[SCENE_SOLVER_TEXT];
    scene_solver pgs = {.name = PINCH_SOLVER_PGS, .formulation = SCENE_COULOMB};
    assert_false(scene_check_pair(SCENE_FOR_RUN, &pgs, text));
    assert_non_null(strstr(text, "solver pgs does not do formulation coulomb here; there are nsnmgk with coulomb"));
    assert_non_null(strstr(text, ", pgs with lcp"));
    pgs.formulation = SCENE_LCP;
    assert_true(scene_check_pair(SCENE_FOR_STATICS, &pgs, text));
}

static void test_counts(void **state)
{
    (void)state;
    char words[256];
    options o;
    assert_int_equal(parse(&probe, "a --quickstep-iterations 20,1,1000000 --contacts pinch", words, &o), OPTIONS_RUN);
    assert_int_equal(o.quickstep_iterations.count, 3);
    assert_int_equal(o.quickstep_iterations.values[1], 1);
    assert_int_equal(o.contacts, OPTION_CONTACTS_PINCH);
    static const char *const wrong[] = {"a --quickstep-iterations _",
                                        "a --quickstep-iterations 1,,2",
                                        "a --quickstep-iterations 1,2,",
                                        "a --quickstep-iterations 1000001",
                                        "a --quickstep-iterations 1,2,1",
                                        "a --quickstep-iterations 1;2",
                                        "a --contacts both"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(parse(&probe, wrong[i], words, &o), OPTIONS_WRONG);
}

/* The command line again, in quotes where a shell needs them. */
static void test_print(void **state)
{
    (void)state;
    char words[256], *text = NULL;
    size_t size;
    options o;
    assert_int_equal(parse(&probe, "a.json --json --csv=it's.csv --step 1e-3 --duration 2", words, &o), OPTIONS_RUN);
    static const char *const arguments[] = {"-odd name.json"};
    FILE *stream = open_memstream(&text, &size);
    assert_non_null(stream);
    options_print(&o, OPTION_DURATION, arguments, 1, stream);
    assert_int_equal(fclose(stream), 0);
    assert_string_equal(text, "pinch probe --step 1e-3 --json --csv 'it'\\''s.csv' -- '-odd name.json'");
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values),
        cmocka_unit_test(test_defaults),
        cmocka_unit_test(test_program_keeps_its_options),
        cmocka_unit_test(test_exec_options),
        cmocka_unit_test(test_keys),
        cmocka_unit_test(test_wrong),
        cmocka_unit_test(test_pairs),
        cmocka_unit_test(test_counts),
        cmocka_unit_test(test_print),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
