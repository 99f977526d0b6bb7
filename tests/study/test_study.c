/* Studies as documents: draws, designs, and what is refused. */
#include "support/cmocka_all.h"

#include "study/trial.h"
#include "support/command.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char scene_text[] =
    "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.1, 0.1, 0.1]}, \"mass\": "
    "0.5},"
    " \"fingers\": ["
    "{\"name\": \"left\", \"point\": [-0.05, 0, 0], \"normal\": [1, 0, 0], \"model\": \"soft\", \"stiffness\": "
    "{\"normal\": "
    "20000, \"torsional\": 1}, \"friction\": 0.6, \"torsional_friction\": 0.002, \"closing\": 0.0005},"
    "{\"name\": \"right\", \"point\": [0.05, 0, 0], \"normal\": [-1, 0, 0], \"model\": \"soft\", \"stiffness\": "
    "{\"normal\": "
    "20000, \"torsional\": 1}, \"friction\": 0.6, \"torsional_friction\": 0.002, \"closing\": 0.0005}],"
    " \"simulation\": {\"duration\": 0.05}}";

static char *folder, *scene_path;

static int make_folder(void **state)
{
    (void)state;
    folder = program_make_folder();
    scene_path = program_write_file(folder, "cube.json", scene_text);
    free(program_write_file(folder, "grasps.csv", "x,y,\"mass, kg\"\n1,2,0.5\n3,4,0.25\r\n5,6,1\n"));
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    free(scene_path);
    program_remove_folder(folder);
    return 0;
}

static study *load(const char *text)
{
    study *s;
    scene_error error;
    char *path = program_write_file(folder, "study.json", text);
    if (study_load(path, &s, &error) != SCENE_OK) fail_msg("%s", error.text);
    free(path);
    return s;
}

static double drawn(const study *s, long index, const char *place)
{
    json_t *inputs = study_draw(s, index);
    const json_t *value = json_object_get(inputs, place);
    assert_true(json_is_number(value));
    double number = json_number_value(value);
    json_decref(inputs);
    return number;
}

/* Every interval of 2^-k holds one of 2^k points in each dimension, whatever the shift. Dimensions differ from each
 * other: of two, every square of a grid of 2^4 x 2^4 holds about as many points as any other. */
static void test_sobol(void **state)
{
    (void)state;
    enum { POINTS = 1024, SIDE = 16 };
    for (size_t d = 0; d < STUDY_MOST_SOBOL; d++) {
        int seen[POINTS] = {0}, squares[SIDE][SIDE] = {{0}};
        for (long i = 0; i < POINTS; i++) {
            double x = study_sobol(5, i, d), y = study_sobol(5, i, (d + 1) % STUDY_MOST_SOBOL);
            assert_true(x > 0 && x < 1);
            assert_int_equal(seen[(int)(x * POINTS)]++, 0);
            squares[(int)(x * SIDE)][(int)(y * SIDE)]++;
        }
        for (int i = 0; i < SIDE * SIDE; i++) assert_in_range(squares[i / SIDE][i % SIDE], 0, 16);
    }
}

static void test_distributions(void **state)
{
    (void)state;
    const char *const designs[] = {"random", "sobol"};
    for (int k = 0; k < 2; k++) {
        char text[2048];
        enum { SAMPLES = 4096 };
        snprintf(text, sizeof text,
                 "{\"format\": \"pinch-study/1\", \"scene\": \"cube.json\", \"trials\": {\"samples\": %d, \"seed\": 3, "
                 "\"design\": \"%s\"}, \"vary\": ["
                 "{\"path\": \"/object/mass\", \"uniform\": [1, 3]},"
                 "{\"path\": \"/fingers/*/friction\", \"normal\": [0.5, 0.2], \"at_least\": 0.5},"
                 "{\"path\": \"/fingers/*/stiffness/normal\", \"log_uniform\": [100, 10000], \"common\": true},"
                 "{\"path\": \"/solver/name\", \"values\": [\"nsnmgk\", \"newton\"]}]}",
                 SAMPLES, designs[k]);
        study *s = load(text);
        assert_int_equal(s->draw_count, 5);
        double mass = 0, friction = 0, differs = 0, log_stiffness = 0, newton = 0;
        for (long i = 0; i < SAMPLES; i++) {
            mass += drawn(s, i, "/object/mass") / SAMPLES;
            double left = drawn(s, i, "/fingers/0/friction"), right = drawn(s, i, "/fingers/1/friction");
            assert_true(left >= 0.5 && right >= 0.5);
            friction += left / SAMPLES;
            differs += fabs(left - right) > 1e-6;
            log_stiffness += log10(drawn(s, i, "/fingers/0/stiffness/normal")) / SAMPLES;
            assert_close(drawn(s, i, "/fingers/0/stiffness/normal"), drawn(s, i, "/fingers/1/stiffness/normal"), 0);
            json_t *inputs = study_draw(s, i);
            newton += strcmp(json_string_value(json_object_get(inputs, "/solver/name")), "newton") == 0;
            json_decref(inputs);
        }
        /* half of a normal distribution has its mean at sigma sqrt(2/pi) */
        double tolerance = k ? 0.002 : 0.03;
        assert_close(mass, 2, tolerance);
        assert_close(friction, 0.5 + 0.2 * 0.7978845608028654, tolerance);
        assert_close(log_stiffness, 3, tolerance);
        assert_close(newton / SAMPLES, 0.5, tolerance);
        assert_true(differs > 0.99 * SAMPLES);
        study_free(s);
    }
}

/* The last variation counts fastest, the table's rows slowest. */
static void test_grid_and_table(void **state)
{
    (void)state;
    study *s = load("{\"format\": \"pinch-study/1\", \"scene\": \"cube.json\", \"table\": \"grasps.csv\","
                    " \"trials\": {\"design\": \"grid\"}, \"vary\": ["
                    "{\"path\": \"/object/mass\", \"columns\": [\"mass, kg\"]},"
                    "{\"path\": \"/fingers/*/friction\", \"values\": [0.1, 0.2]},"
                    "{\"path\": \"/simulation/step\", \"values\": [0.001, 0.002, 0.003]}]}");
    assert_int_equal(s->samples, 3 * 2 * 2 * 3);
    assert_close(drawn(s, 0, "/object/mass"), 0.5, 0);
    assert_close(drawn(s, 35, "/object/mass"), 1, 0);
    assert_close(drawn(s, 1, "/simulation/step"), 0.002, 0);
    assert_close(drawn(s, 3, "/fingers/1/friction"), 0.2, 0);
    assert_close(drawn(s, 3, "/fingers/0/friction"), 0.1, 0);
    study_free(s);
    s = load("{\"format\": \"pinch-study/1\", \"scene\": \"cube.json\", \"table\": \"grasps.csv\","
             " \"trials\": {\"design\": \"table\"}, \"vary\": ["
             "{\"path\": \"/object/position\", \"columns\": [\"y\", \"x\", \"y\"]}]}");
    assert_int_equal(s->samples, 3);
    json_t *inputs = study_draw(s, 2);
    const json_t *position = json_object_get(inputs, "/object/position");
    assert_close(json_number_value(json_array_get(position, 0)), 6, 0);
    assert_close(json_number_value(json_array_get(position, 1)), 5, 0);
    json_decref(inputs);
    study_free(s);
}

#define HEAD  "{\"format\": \"pinch-study/1\", \"scene\": \"cube.json\",\n\"trials\": {\"samples\": 10},\n"
#define GRID  "{\"format\": \"pinch-study/1\", \"scene\": \"cube.json\",\n\"trials\": {\"design\": \"grid\"},\n"
#define VARY  "\"vary\": [{\"path\": \"/object/mass\", "
#define TABLE "\"table\": \"grasps.csv\",\n"

static void test_refusals(void **state)
{
    (void)state;
    static const struct {
        const char *text, *says;
    } cases[] = {
        {"{}", "study.json:1: format: expected this key"},
        {"{\"format\": \"pinch-study/1\",\n \"scene\": \"nowhere.json\", \"trials\": {\"samples\": 1}}",
         "study.json:2: scene: expected a scene file that can be read (No such file or directory), got "
         "\"nowhere.json\""},
        {"{\"format\": \"pinch-study/2\",\n \"scene\": \"cube.json\", \"trials\": {\"samples\": 1}}", "pinch-study/1"},
        {"{\"format\": \"pinch-study/1\", \"scene\": \"cube.json\",\n\"trials\": {}}", "study.json:2: trials.samples"},
        {"{\"format\": \"pinch-study/1\", \"scene\": \"cube.json\",\n\"trials\": {\"samples\": 0}}", "trials.samples"},
        {"{\"format\": \"pinch-study/1\", \"scene\": \"cube.json\",\n\"trials\": {\"samples\": 2, \"seed\": -1}}",
         "trials.seed"},
        {"{\"format\": \"pinch-study/1\", \"scene\": \"cube.json\",\n\"trials\": {\"design\": \"table\"}}",
         "table: expected"},
        {HEAD VARY "\"uniform\": [2, 1]}]}", "study.json:3: vary[0].uniform"},
        {HEAD VARY "\"log_uniform\": [0, 1]}]}", "vary[0].log_uniform"},
        {HEAD VARY "\"normal\": [1, 0]}]}", "vary[0].normal"},
        {HEAD VARY "\"normal\": [1, 0.1], \"at_least\": 9}]}", "vary[0].at_least"},
        {HEAD VARY "\"uniform\": [1, 2], \"at_least\": 0}]}", "vary[0].at_least"},
        {HEAD VARY "\"values\": []}]}", "vary[0].values"},
        {HEAD VARY "\"columns\": [\"x\"]}]}", "vary[0].columns[0]"},
        {HEAD TABLE VARY "\"columns\": [\"z\"]}]}", "vary[0].columns[0]: expected a column of"},
        {HEAD VARY "\"uniform\": [1, 2], \"values\": [1]}]}", "vary[0]: expected one of"},
        {HEAD VARY "\"uniform\": [1, 2]}, {\"path\": \"/object/mass\", \"uniform\": [1, 2]}]}", "vary[1].path"},
        {HEAD VARY "\"uniform\": [1, 2]},\n{\"path\": \"/object\", \"values\": [{}]}]}",
         "study.json:4: vary[1].path: expected a path that sets nothing again, got /object, and /object/mass varies "},
        {HEAD "\"vary\": [{\"path\": \"/object/position\", \"values\": [[0, 0, 0]]}, {\"path\": "
              "\"/object/position/2\", \"uniform\": [0, 1]}]}",
         "vary[1].path: expected a path that sets nothing again, got /object/position/2"},
        {HEAD VARY "\"uniform\": [1, 2]}],\n\"least\": {\"path\": \"/object/mass\", \"from\": 1, \"to\": 2}}",
         "study.json:4: least.path: expected a path that does not vary already"},
        {HEAD "\"vary\": [{\"path\": \"/fingers/0/friction\", \"uniform\": [0, 1]}],\n\"least\": {\"path\": "
              "\"/fingers/*\", \"from\": 1, \"to\": 2}}",
         "least.path: expected a path that sets nothing again"},
        {HEAD "\"vary\": [{\"path\": \"/fingers/00/friction\", \"uniform\": [0, 1]}]}", "vary[0].path"},
        {HEAD "\"vary\": [{\"path\": \"/schedule/0/gravity\", \"values\": [[0, 0, 0]]}]}",
         "vary[0].path: expected a path that the scene has; the list that /schedule/0/gravity lies in is left to its "},
        {HEAD "\"vary\": [{\"path\": \"/object/colour\", \"uniform\": [1, 2]}]}", "study.json:3: vary[0].path"},
        {HEAD "\"vary\": [{\"path\": \"object.mass\", \"uniform\": [1, 2]}]}", "vary[0].path"},
        {HEAD "\"vary\": [{\"path\": \"/fingers/7/friction\", \"uniform\": [1, 2]}]}", "vary[0].path"},
        {GRID VARY "\"uniform\": [1, 2]}]}", "vary[0]: expected values or columns"},
        {HEAD "\"protocol\": {\"name\": \"throw\"}}", "protocol.name"},
        {HEAD "\"protocol\": {\"name\": \"lift\", \"force_per_mass\": 3}}", "protocol.force_per_mass"},
        {HEAD "\"protocol\": {\"name\": \"lift\", \"distance\": 0}}", "protocol.distance"},
        {HEAD "\"success\": {\"displacement\": -1}}", "success.displacement"},
        {HEAD "\"success\": {\"no_events\": [\"fell\"]}}", "success.no_events[0]"},
        {HEAD "\"least\": {\"path\": \"/object/mass\", \"from\": 2, \"to\": 1}}", "least.to"},
        {HEAD "\"record\": [\"object.colour\"]}", "study.json:3: record[0]"},
        {HEAD "\"record\": [\"grasp.beauty\"]}", "record[0]"},
        {HEAD "\"record\": [\"object.creep\", \"fingers.*.beauty\"]}", "record[1]"},
        {HEAD "\"record\": [\"fingers.thumb.beauty\"]}", "record[0]"},
        {HEAD "\"record\": [\"fingers.thumb.slip_total\"]}", "record[0]"},
        {HEAD "\"record\": [\"joints.thumb.torque\"]}", "record[0]"},
        {HEAD "\"record\": [\"statics.nope\"]}", "record[0]"},
        {HEAD "\"record\": [\"statics.status\", \"statics_of_all\"]}", "record[1]"},
        {HEAD "\"least\": {\"path\": \"/object/name\", \"from\": 1, \"to\": 2}}",
         "study.json: least: no trial tried is a legal scene; in trial 0, "},
        {HEAD VARY "\"values\": [\"heavy\"]}]}", "object.mass: expected a number"},
        {HEAD VARY "\"uniform\": [-2, -1]}]}", "study.json: vary: no trial tried is a legal scene; in trial 0, "},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char *path = program_write_file(folder, "study.json", cases[i].text);
        cli_refused(PINCH(folder, "study", "study.json", "--out", "r.sqlite"), 2, cases[i].says);
        free(path);
    }
    free(program_write_file(folder, "grasps2.csv", "x,y\n1,2\n3\n"));
    free(program_write_file(folder, "study.json",
                            "{\"format\": \"pinch-study/1\", \"scene\": \"cube.json\", \"trials\": {\"samples\": 1}, "
                            "\"table\": \"grasps2.csv\"}"));
    cli_refused(PINCH(folder, "study", "study.json", "--out", "r.sqlite"), 2, "grasps2.csv:3: expected 2 fields");
    free(program_write_file(folder, "grasps2.csv", "x,y,x\n1,2,3\n"));
    cli_refused(PINCH(folder, "study", "study.json", "--out", "r.sqlite"), 2,
                "grasps2.csv:1: expected each column once, got \"x\" as columns 1 and 3");
    static const char *const tables[][2] = {
        {"x,y\n1,0x10\n", "grasps2.csv:2: column y: expected a number, got \"0x10\""},
        {"x,\"y\n1,2\n", "grasps2.csv:1: expected quotation marks that begin and end a field"},
        {"x,\"y\"z\n1,2\n", "grasps2.csv:1: expected quotation marks"},
        {"x,y\n1,\"2\n", "grasps2.csv:2: expected quotation marks"},
    };
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++) {
        free(program_write_file(folder, "grasps2.csv", tables[i][0]));
        cli_refused(PINCH(folder, "study", "study.json", "--out", "r.sqlite"), 2, tables[i][1]);
    }
    /* as a spreadsheet writes it, with a byte order mark and line ends of two characters */
    free(program_write_file(folder, "grasps2.csv", "\xEF\xBB\xBFx,y\r\n1,2\r\n"));
    study_free(load(HEAD "\"table\": \"grasps2.csv\", " VARY "\"columns\": [\"x\"]}]}"));
    cli_refused(PINCH(folder, "study", "study.json"), 2, "--out");
    cli_refused(PINCH(folder, "study", "study.json", "--out", "r.sqlite", "--out", "study.json"), 2, "");
}

/* One legal trial is enough, wherever it stands among the others. */
static void test_bad_draws(void **state)
{
    (void)state;
    static const char *const orders[] = {"-1, 0.5", "0.5, -1"};
    for (int k = 0; k < 2; k++) {
        char text[1024];
        scene_error error;
        snprintf(text, sizeof text,
                 GRID "\"vary\": [{\"path\": \"/object/mass\", \"values\": [%s]}, {\"path\": \"/simulation/step\", "
                      "\"values\": [1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3, 7e-3, 8e-3, 9e-3]}]}",
                 orders[k]);
        study *s = load(text);
        dInitODE2(0);
        assert_int_equal(trial_check(s, &error), SCENE_OK);
        json_t *trial = trial_run(s, k == 0 ? 0 : 9);
        assert_string_equal(json_string_value(json_object_get(trial, "status")), "bad_draw");
        json_decref(trial);
        world_close_ode();
        study_free(s);
    }
}

/* A scene whose solver does not do its formulation is a bad draw with the reason, and no lack of memory. */
static void test_solver_pairs(void **state)
{
    (void)state;
    study *s = load(GRID "\"vary\": [{\"path\": \"/solver/name\", \"values\": [\"pgs\", \"newton\"]}]}");
    scene_error error;
    dInitODE2(0);
    assert_int_equal(trial_check(s, &error), SCENE_OK);
    json_t *trial = trial_run(s, 0);
    const json_t *fault = json_array_get(json_object_get(trial, "errors"), 0);
    assert_string_equal(json_string_value(json_object_get(trial, "status")), "bad_draw");
    assert_non_null(strstr(json_string_value(json_object_get(fault, "message")), "solver pgs does not do formulation"));
    json_decref(trial);
    world_close_ode();
    study_free(s);
    cli_refused(PINCH(folder, "study", "study.json", "--trial", "0"), 2, "solver pgs does not do formulation coulomb");
}

/* A component of a vector that the scene leaves to its default: the others keep that. */
static void test_component_of_a_default(void **state)
{
    (void)state;
    study *s = load(HEAD "\"vary\": [{\"path\": \"/object/orientation/3\", \"uniform\": [0, 1e-9]}, {\"path\": "
                         "\"/gravity/0\", \"uniform\": [1, 2]}]}");
    scene_error error;
    scene *run;
    double begin;
    json_t *inputs = study_draw(s, 0);
    if (trial_scene(s, inputs, 0, &run, &begin, &error) != SCENE_OK) fail_msg("%s", error.text);
    assert_close(run->objects[0].orientation[0], 1, 1e-15);
    assert_close(run->gravity[0], drawn(s, 0, "/gravity/0"), 0);
    assert_close(run->gravity[2], -9.81, 0);
    scene_free(run);
    json_decref(inputs);
    study_free(s);
}

/* Phases that are appended to a schedule. */
static void test_protocols(void **state)
{
    (void)state;
    study *s =
        load(HEAD "\"protocol\": {\"name\": \"six-forces\", \"force_per_mass\": 4, \"hold\": 1, \"settle\": 0.25}}");
    scene_error error;
    scene *run;
    double begin;
    scene_loads before, during;
    json_t *inputs = study_draw(s, 0);
    assert_int_equal(protocol_runs(&s->protocol, 3), 6);
    for (int k = 0; k < 6; k++) {
        assert_int_equal(trial_scene(s, inputs, k, &run, &begin, &error), SCENE_OK);
        assert_close(begin, 0.25, 1e-15);
        assert_close(run->duration, 1.25, 1e-15);
        scene_schedule_at(run, begin - 1e-9, &before);
        scene_schedule_at(run, begin, &during);
        for (int j = 0; j < 3; j++) {
            assert_close(before.v[SCENE_FORCE][j], 0, 0);
            assert_close(during.v[SCENE_FORCE][j], j == k / 2 ? (k % 2 ? -2.0 : 2.0) : 0.0, 1e-12);
        }
        assert_close(during.v[SCENE_GRAVITY][2], -9.81, 0);
        scene_free(run);
    }
    study_free(s);
    s = load(HEAD "\"protocol\": {\"name\": \"lift\", \"distance\": 0.3, \"speed\": 0.1, \"hold\": 1}}");
    assert_int_equal(trial_scene(s, inputs, 0, &run, &begin, &error), SCENE_OK);
    assert_close(run->duration, begin + 4.5 + 1, 1e-12);
    double fastest = 0, last = 0;
    for (double t = begin; t < run->duration; t += 0.01) {
        scene_schedule_at(run, t, &during);
        fastest = fmax(fastest, (during.v[SCENE_HAND_TRANSLATION][2] - last) / 0.01);
        last = during.v[SCENE_HAND_TRANSLATION][2];
    }
    assert_close(last, 0.3, 1e-12);
    assert_close(fastest, 0.1, 0.001);
    scene_free(run);
    study_free(s);
    s = load(HEAD "\"protocol\": {\"name\": \"shake\", \"amplitude\": 0.01, \"frequency\": 2, \"axes\": [\"x\", "
                  "\"z\"], \"time\": 1}}");
    assert_int_equal(trial_scene(s, inputs, 0, &run, &begin, &error), SCENE_OK);
    scene_schedule_at(run, begin + 0.625, &during);
    assert_close(during.v[SCENE_BASE_ACCELERATION][0], 0.01 * pow(4 * 3.14159265358979323846, 2), 1e-9);
    scene_schedule_at(run, begin + 1.625, &during);
    assert_close(during.v[SCENE_BASE_ACCELERATION][0], 0, 0);
    assert_close(during.v[SCENE_BASE_ACCELERATION][2], 0.01 * pow(4 * 3.14159265358979323846, 2), 1e-9);
    scene_free(run);
    json_decref(inputs);
    study_free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sobol),          cmocka_unit_test(test_distributions),
        cmocka_unit_test(test_grid_and_table), cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_protocols),      cmocka_unit_test(test_bad_draws),
        cmocka_unit_test(test_solver_pairs),   cmocka_unit_test(test_component_of_a_default),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
