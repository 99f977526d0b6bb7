/* The real `pinch run` and `pinch compare`: exit status, what stands on standard output, JSON fields, CSV rows. */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/program.h"

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define SCENE(name) PINCH_SOURCE_DIR "/assets/scenes/" name

/* Runs the command with up to seven arguments, NULL ends them. */
static program_result pinch(const char *folder, const char *const arguments[])
{
    char executable[] = PINCH_EXECUTABLE, text[12][512];
    char *argv[13] = {executable};
    int count = 0;
    for (; arguments[count]; count++) {
        assert_true(count < 11);
        snprintf(text[count], sizeof text[count], "%s", arguments[count]);
        argv[1 + count] = text[count];
    }
    argv[1 + count] = NULL;
    return program_run(folder, argv);
}

#define PINCH(folder, ...) pinch(folder, (const char *const[]){__VA_ARGS__, NULL})

/* The whole of standard output is one JSON document. */
static json_t *document_of(const program_result *r)
{
    json_error_t error;
    json_t *document = json_loads(r->out, 0, &error);
    if (!document) fail_msg("%s\n%s", error.text, r->out);
    assert_true(json_is_object(document));
    return document;
}

typedef enum field_type { TEXT, NUMBER, COUNT, VECTOR3, VECTOR4, BOOLEAN, LIST, OBJECT } field_type;

typedef struct field {
    const char *path; /* keys with dots between; "fingers" stands for each finger */
    field_type type;
    bool pinch_only; /* null with ODE's own solvers */
    bool may_be_null;
} field;

static const field run_fields[] = {
    {"command", TEXT, false, false},
    {"scene", TEXT, false, false},
    {"status", TEXT, false, false},
    {"steps", COUNT, false, false},
    {"time_s", NUMBER, false, false},
    {"step_us", NUMBER, false, false},
    {"collide_us", NUMBER, false, false},
    {"solve_us", NUMBER, false, false},
    {"iterations_mean", NUMBER, true, false},
    {"iterations_max", COUNT, true, false},
    {"unconverged_steps", COUNT, true, false},
    {"residual_max", NUMBER, true, false},
    {"verification.passed", BOOLEAN, true, false},
    {"verification.cone", NUMBER, true, false},
    {"verification.complementarity", NUMBER, true, false},
    {"verification.slip_direction", NUMBER, true, false},
    {"equilibrium.force_error", NUMBER, false, false},
    {"equilibrium.torque_error", NUMBER, false, false},
    {"object.position", VECTOR3, false, false},
    {"object.orientation", VECTOR4, false, false},
    {"object.linear_velocity", VECTOR3, false, false},
    {"object.angular_velocity", VECTOR3, false, false},
    {"object.displacement", VECTOR3, false, false},
    {"object.creep", NUMBER, false, false},
    {"object.creep_angular", NUMBER, false, false},
    {"object.speed_max", NUMBER, false, false},
    {"max_penetration", NUMBER, false, false},
    {"energy.kinetic", NUMBER, true, false},
    {"energy.gravity", NUMBER, true, false},
    {"energy.elastic", NUMBER, true, false},
    {"energy.work_drives", NUMBER, true, false},
    {"energy.work_external", NUMBER, true, false},
    {"energy.friction", NUMBER, true, false},
    {"energy.damping", NUMBER, true, false},
    {"energy.integrator", NUMBER, true, false},
    {"energy.closure", NUMBER, true, false},
    {"events", LIST, false, false},
    {"not_expressed", LIST, false, false},
    {"hash", TEXT, false, false},
};

static const field finger_fields[] = {
    {"name", TEXT, false, false},
    {"state", TEXT, false, false},
    {"normal_force", NUMBER, false, false},
    {"tangential_force", VECTOR3, false, false},
    {"torsional_moment", NUMBER, false, false},
    {"force", VECTOR3, false, false},
    {"moment", VECTOR3, false, false},
    {"point", VECTOR3, false, false},
    {"normal_displacement", NUMBER, false, false},
    {"tangential_displacement", VECTOR3, false, false},
    {"slip", VECTOR3, false, false},
    {"slip_total", NUMBER, false, false},
    {"slip_margin", NUMBER, false, true},
    {"peak_normal_force", NUMBER, false, false},
};

static bool is_vector(const json_t *value, size_t length)
{
    if (json_array_size(value) != length) return false;
    for (size_t i = 0; i < length; i++)
        if (!json_is_number(json_array_get(value, i))) return false;
    return true;
}

static bool has_type(const json_t *value, field_type type)
{
    switch (type) {
    case TEXT:
        return json_is_string(value) && json_string_length(value) > 0;
    case NUMBER:
        return json_is_number(value);
    case COUNT:
        return json_is_integer(value) && json_integer_value(value) >= 0;
    case VECTOR3:
        return is_vector(value, 3);
    case VECTOR4:
        return is_vector(value, 4);
    case BOOLEAN:
        return json_is_boolean(value);
    case LIST:
        return json_is_array(value);
    default:
        return json_is_object(value);
    }
}

static const json_t *at_path(const json_t *document, const char *path)
{
    char key[64];
    const char *dot = strchr(path, '.');
    if (!dot) return json_object_get(document, path);
    snprintf(key, sizeof key, "%.*s", (int)(dot - path), path);
    return at_path(json_object_get(document, key), dot + 1);
}

static void check_fields(const json_t *document, const field *fields, size_t count, bool is_pinch)
{
    int wrong = 0;
    for (size_t i = 0; i < count; i++) {
        const json_t *value = at_path(document, fields[i].path);
        bool null = json_is_null(value);
        bool good = value && (null ? (fields[i].pinch_only && !is_pinch) || fields[i].may_be_null
                                   : has_type(value, fields[i].type) && (is_pinch || !fields[i].pinch_only));
        if (good) continue;
        wrong++;
        print_error("%s is %s\n", fields[i].path, !value ? "missing" : null ? "null" : "of the wrong kind");
    }
    assert_int_equal(wrong, 0);
}

#define CHECK_FIELDS(document, fields, pinch) check_fields(document, fields, sizeof fields / sizeof fields[0], pinch)

static void test_json_is_complete(void **state)
{
    (void)state;
    static const char *const solvers[] = {"pinch", "quickstep", "worldstep"};
    for (int i = 0; i < 3; i++) {
        program_result r =
            PINCH(NULL, "run", SCENE("example-2.json"), "--json", "--duration", "0.3", "--contact-solver", solvers[i]);
        assert_int_equal(r.status, 0);
        assert_string_equal(r.err, "");
        json_t *d = document_of(&r);
        CHECK_FIELDS(d, run_fields, i == 0);
        assert_string_equal(json_string_value(json_object_get(d, "command")), "run");
        assert_string_equal(json_string_value(json_object_get(d, "scene")), SCENE("example-2.json"));
        assert_string_equal(json_string_value(json_object_get(d, "status")), "converged");
        assert_int_equal(json_integer_value(json_object_get(d, "steps")), 300);
        assert_int_equal(strlen(json_string_value(json_object_get(d, "hash"))), 16);
        const json_t *fingers = json_object_get(d, "fingers");
        assert_int_equal(json_array_size(fingers), 3);
        for (size_t f = 0; f < 3; f++) CHECK_FIELDS(json_array_get(fingers, f), finger_fields, i == 0);
        /* what ODE cannot say is listed, and only there */
        assert_true((json_array_size(json_object_get(d, "not_expressed")) > 0) == (i > 0));
        json_decref(d);
        program_free(&r);
    }
}

static void test_no_steps_at_all(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "run", SCENE("example-2.json"), "--json", "--duration", "0");
    assert_int_equal(r.status, 0);
    json_t *d = document_of(&r);
    assert_int_equal(json_integer_value(json_object_get(d, "steps")), 0);
    assert_true(json_is_null(json_object_get(d, "step_us"))); /* means of nothing */
    assert_true(json_is_null(json_object_get(d, "iterations_mean")));
    json_decref(d);
    program_free(&r);
}

static void test_step_and_duration(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "run", SCENE("example-3.json"), "--json", "--step=0.002", "--duration=0.5");
    assert_int_equal(r.status, 0);
    json_t *d = document_of(&r);
    assert_int_equal(json_integer_value(json_object_get(d, "steps")), 250);
    assert_close(json_number_value(json_object_get(d, "time_s")), 0.5, 1e-12);
    json_decref(d);
    program_free(&r);
}

static void remove_timings(json_t *document)
{
    assert_int_equal(json_object_del(document, "step_us"), 0);
    assert_int_equal(json_object_del(document, "collide_us"), 0);
    assert_int_equal(json_object_del(document, "solve_us"), 0);
}

static void test_same_document_again(void **state)
{
    (void)state;
    static const char *const scenes[] = {SCENE("example-2.json"), SCENE("pinched-capsule.json")};
    for (int i = 0; i < 2; i++) {
        json_t *d[2];
        for (int run = 0; run < 2; run++) {
            program_result r = PINCH(NULL, "run", scenes[i], "--json", "--duration", "1.5");
            assert_int_equal(r.status, 0);
            d[run] = document_of(&r);
            remove_timings(d[run]);
            program_free(&r);
        }
        assert_true(json_equal(d[0], d[1]));
        json_decref(d[0]);
        json_decref(d[1]);
    }
}

static void test_quiet(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "run", SCENE("example-3.json"), "--quiet", "--duration", "0.1");
    assert_int_equal(r.status, 0);
    assert_string_equal(r.out, "");
    assert_string_equal(r.err, "");
    program_free(&r);
    r = PINCH(NULL, "run", SCENE("example-3.json"), "--duration", "0.1");
    assert_int_equal(r.status, 0);
    assert_non_null(strstr(r.out, "F1")); /* a table with the fingers */
    program_free(&r);
    r = PINCH(NULL, "run", SCENE("example-3.json"), "--quiet", "--json", "--duration", "0.1");
    assert_int_equal(r.status, 0);
    json_decref(document_of(&r));
    program_free(&r);
    r = PINCH(NULL, "compare", SCENE("example-3.json"), "--quiet", "--duration", "0.1");
    assert_int_equal(r.status, 0);
    assert_string_equal(r.out, "");
    program_free(&r);
}

/* Asserts the exit status, nothing on standard output, and a message that contains `says`. */
static void refused(program_result r, int status, const char *says)
{
    if (r.status != status || *r.out || !strstr(r.err, says))
        fail_msg("status %d (wanted %d), said \"%s\" (wanted \"%s\"), printed \"%s\"", r.status, status, r.err, says,
                 r.out);
    program_free(&r);
}

static void test_usage_and_bad_input(void **state)
{
    (void)state;
    refused(PINCH(NULL, "run"), 2, "SCENE");
    refused(PINCH(NULL, "run", SCENE("example-2.json"), SCENE("example-3.json")), 2, "SCENE");
    refused(PINCH(NULL, "run", "nowhere.json", "--json"), 2, "nowhere.json");
    refused(PINCH(NULL, "run", PINCH_SOURCE_DIR, "--json"), 2, PINCH_SOURCE_DIR);
    refused(PINCH(NULL, "run", SCENE("example-2.json"), "--nonsense"), 2, "--nonsense");
    refused(PINCH(NULL, "run", SCENE("example-2.json"), "--duration", "-1"), 2, "--duration");
    refused(PINCH(NULL, "run", SCENE("example-2.json"), "--step", "0"), 2, "--step");
    refused(PINCH(NULL, "run", SCENE("example-2.json"), "--step", "nan"), 2, "--step");
    refused(PINCH(NULL, "run", SCENE("example-2.json"), "--solver", "magic"), 2, "magic");
    refused(PINCH(NULL, "run", SCENE("example-2.json"), "--contact-solver", "bullet"), 2, "bullet");
    refused(PINCH(NULL, "compare"), 2, "SCENE");
    refused(PINCH(NULL, "compare", "nowhere.json"), 2, "nowhere.json");
    refused(PINCH(NULL, "frobnicate"), 2, "frobnicate");
}

/* A solver that cannot do what is asked for is refused, with the pairs that exist. */
static void test_refused_pairs(void **state)
{
    (void)state;
    static const char *const solvers[] = {"lemke", "pgs"};
    static const char *const commands[] = {"run", "compare"};
    for (int c = 0; c < 2; c++)
        for (int i = 0; i < 2; i++) {
            program_result r = PINCH(NULL, commands[c], SCENE("example-2.json"), "--solver", solvers[i]);
            assert_int_equal(r.status, 2);
            assert_string_equal(r.out, "");
            assert_non_null(strstr(r.err, solvers[i]));
            assert_non_null(strstr(r.err, "nsnmgk"));
            assert_non_null(strstr(r.err, "newton"));
            program_free(&r);
        }
}

static void test_solvers_that_exist(void **state)
{
    (void)state;
    static const char *const solvers[] = {"nsnmgk", "nsngrk", "newton"};
    double force[3];
    for (int i = 0; i < 3; i++) {
        program_result r =
            PINCH(NULL, "run", SCENE("example-3.json"), "--json", "--solver", solvers[i], "--duration", "0.3");
        assert_int_equal(r.status, 0);
        json_t *d = document_of(&r);
        assert_string_equal(json_string_value(json_object_get(d, "solver")), solvers[i]);
        const json_t *finger = json_array_get(json_object_get(d, "fingers"), 0);
        force[i] = json_number_value(json_object_get(finger, "normal_force"));
        json_decref(d);
        program_free(&r);
    }
    /* the same forces; the row methods stop at a residual of 1e-10, 300 steps of it at 10 N and a stiffness ratio of
     * h (h kn + cn)/m = 0.14 */
    assert_close(force[1], force[0], 1e-6);
    assert_close(force[2], force[0], 1e-9);
}

static const char ellipsoid_scene[] =
    "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"ellipsoid\", \"radii\": [0.02, 0.02, 0.03]}, "
    "\"mass\": 0.1}, \"fingers\": [{\"point\": [-0.02, 0, 0], \"normal\": [1, 0, 0], \"model\": \"hard\", "
    "\"stiffness\": "
    "{\"normal\": 1e4}, \"friction\": 0.5}]}";

/* A shape without a collider: an error that names it, or, once there is one, a run; never a world without contacts. */
static void test_unsupported_shapes(void **state)
{
    (void)state;
    char *folder = program_make_folder(), *path = program_write_file(folder, "ellipsoid.json", ellipsoid_scene);
    static const char *const commands[] = {"run", "compare"};
    for (int c = 0; c < 2; c++) {
        program_result r = PINCH(folder, commands[c], "ellipsoid.json", "--duration", "0.01");
        if (r.status == 2)
            assert_non_null(strstr(r.err, "ellipsoid"));
        else
            assert_int_equal(r.status, 0);
        program_free(&r);
    }
    free(path);
    program_remove_folder(folder);
}

static int count_of(const char *line, char what)
{
    int count = 0;
    for (; *line && *line != '\n'; line++) count += *line == what;
    return count;
}

static void test_csv(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    program_result r =
        PINCH(folder, "run", SCENE("example-3.json"), "--json", "--csv", "table.csv", "--duration", "0.4");
    assert_int_equal(r.status, 0);
    json_t *d = document_of(&r);
    char path[512];
    snprintf(path, sizeof path, "%s/table.csv", folder);
    char *table = program_read_file(path);
    int columns = count_of(table, ',') + 1, rows = 0;
    /* time, pose and twist (1 + 7 + 6), and for each of three fingers force, slip and state */
    assert_int_equal(columns, 14 + 3 * 7);
    static const char *const words[] = {"time", "x", "qw", "vx", "wz", "F1.fx", "F2.slip_z", "F3.state"};
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        const char *at = strstr(table, words[i]);
        assert_true(at && at < strchr(table, '\n'));
    }
    double time = 0, x = 0, y = 0, z = 0;
    for (const char *line = strchr(table, '\n') + 1; *line; line = strchr(line, '\n') + 1) {
        assert_int_equal(count_of(line, ','), columns - 1);
        assert_int_equal(sscanf(line, "%lf,%lf,%lf,%lf", &time, &x, &y, &z), 4);
        assert_close(time, ++rows * 1e-3, 1e-12);
        const char *end = strchr(line, '\n');
        assert_true(strncmp(end - 4, "open", 4) == 0 || strncmp(end - 5, "stick", 5) == 0 ||
                    strncmp(end - 4, "slip", 4) == 0 || strncmp(end - 5, "yield", 5) == 0);
    }
    assert_int_equal(rows, 400);
    const json_t *position = json_object_get(json_object_get(d, "object"), "position");
    assert_close(x, json_number_value(json_array_get(position, 0)), 0); /* digits enough for the same double */
    assert_close(y, json_number_value(json_array_get(position, 1)), 0);
    assert_close(z, json_number_value(json_array_get(position, 2)), 0);
    json_decref(d);
    free(table);
    program_free(&r);
    program_remove_folder(folder);
}

/* A place that cannot be written: status 3, no document; a full device is left where it is. (Reached through a link, so
 * that a mistake would remove the link alone.) */
static void test_csv_that_cannot_be_written(void **state)
{
    (void)state;
    char *folder = program_make_folder(), path[512];
    refused(PINCH(folder, "run", SCENE("example-3.json"), "--json", "--csv", "no/such/folder.csv", "--duration", "0.1"),
            3, "no/such/folder.csv");
    snprintf(path, sizeof path, "%s/full.csv", folder);
    if (access("/dev/full", W_OK) == 0) {
        struct stat about;
        assert_int_equal(symlink("/dev/full", path), 0);
        refused(PINCH(folder, "run", SCENE("example-3.json"), "--json", "--csv", "full.csv", "--duration", "0.5"), 3,
                "full.csv");
        assert_int_equal(lstat(path, &about), 0);
    }
    program_remove_folder(folder);
}

/* Standard output that is full is a failure, too, with and without --json. */
static void test_full_standard_output(void **state)
{
    (void)state;
    if (access("/dev/full", W_OK) != 0) return;
    for (int json = 0; json < 2; json++) {
        char executable[] = "/bin/sh", option[] = "-c", command[1024];
        snprintf(command, sizeof command, "'%s' run '%s' %s --duration 0.1 >/dev/full", PINCH_EXECUTABLE,
                 SCENE("example-3.json"), json ? "--json" : "");
        char *argv[] = {executable, option, command, NULL};
        program_result r = program_run(NULL, argv);
        assert_int_equal(r.status, 3);
        assert_non_null(strstr(r.err, "standard output"));
        program_free(&r);
    }
}

static const char dropped_scene[] = "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"box\", "
                                    "\"size\": [0.04, 0.04, 0.04]}, \"mass\": 0.2}, "
                                    "\"fingers\": [{\"point\": [-0.02, 0, 0], \"normal\": [1, 0, 0], \"model\": "
                                    "\"hard\", \"stiffness\": {\"normal\": 1e4}, "
                                    "\"friction\": 0.2, \"closing\": 1e-4}, {\"name\": \"other\", \"point\": [0.02, 0, "
                                    "0], \"normal\": [-1, 0, 0], \"model\": "
                                    "\"hard\", \"stiffness\": {\"normal\": 1e4}, \"friction\": 0.2, \"closing\": 1e-4, "
                                    "\"damage\": {\"max_force\": 0.5}}], "
                                    "\"simulation\": {\"duration\": 1}}";

/* Dropping what was held is a result: status 0 and an event; so is crushing. */
static void test_events(void **state)
{
    (void)state;
    char *folder = program_make_folder(), *path = program_write_file(folder, "drop.json", dropped_scene);
    program_result r = PINCH(folder, "run", "drop.json", "--json");
    assert_int_equal(r.status, 0);
    json_t *d = document_of(&r);
    const json_t *events = json_object_get(d, "events");
    bool dropped = false, crushed = false;
    for (size_t i = 0; i < json_array_size(events); i++) {
        const json_t *e = json_array_get(events, i);
        const char *type = json_string_value(json_object_get(e, "type"));
        assert_true(json_is_number(json_object_get(e, "time")) && json_is_number(json_object_get(e, "value")) &&
                    json_is_number(json_object_get(e, "limit")));
        if (strcmp(type, "dropped") == 0) dropped = true;
        if (strcmp(type, "crush") != 0) continue;
        crushed = true;
        assert_string_equal(json_string_value(json_object_get(e, "finger")), "other");
        assert_close(json_number_value(json_object_get(e, "limit")), 0.5, 0);
        assert_true(json_number_value(json_object_get(e, "value")) > 0.5);
    }
    assert_true(dropped && crushed);
    json_decref(d);
    program_free(&r);
    free(path);
    program_remove_folder(folder);
}

/* Steps that no solver settled: the document is printed, says so, and the status is 1. */
static void test_unconverged_is_reported(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "run", SCENE("example-3.json"), "--json", "--solver", "nsngrk", "--max-iterations",
                             "1", "--duration", "0.3");
    assert_int_equal(r.status, 1);
    json_t *d = document_of(&r);
    assert_string_equal(json_string_value(json_object_get(d, "status")), "max_iterations");
    assert_true(json_integer_value(json_object_get(d, "unconverged_steps")) > 0);
    assert_true(json_is_false(at_path(d, "verification.passed")));
    json_decref(d);
    program_free(&r);
}

static void test_compare(void **state)
{
    (void)state;
    program_result r =
        PINCH(NULL, "compare", SCENE("example-3.json"), SCENE("example-2.json"), "--json", "--duration", "0.2");
    assert_int_equal(r.status, 0);
    assert_string_equal(r.err, "");
    json_t *d = document_of(&r);
    assert_string_equal(json_string_value(json_object_get(d, "command")), "compare");
    const json_t *scenes = json_object_get(d, "scenes");
    assert_int_equal(json_array_size(scenes), 2);
    static const char *const names[] = {"pinch", "quickstep", "worldstep"};
    for (size_t i = 0; i < 2; i++) {
        const json_t *scene = json_array_get(scenes, i), *list = json_object_get(scene, "contact_solvers");
        assert_true(json_number_value(json_object_get(scene, "cost_ratio")) > 0);
        assert_int_equal(json_array_size(list), 3);
        for (size_t k = 0; k < 3; k++) {
            const json_t *c = json_array_get(list, k);
            assert_string_equal(json_string_value(json_object_get(c, "contact_solver")), names[k]);
            assert_true(json_number_value(json_object_get(c, "step_us")) > 0);
            assert_true(is_vector(json_object_get(c, "displacement"), 3));
            assert_int_equal(json_array_size(json_object_get(c, "forces")), 3);
        }
    }
    json_decref(d);
    program_free(&r);
    /* the table names all three and ends well */
    r = PINCH(NULL, "compare", SCENE("example-3.json"), "--duration", "0.2");
    assert_int_equal(r.status, 0);
    for (int k = 0; k < 3; k++) assert_non_null(strstr(r.out, names[k]));
    program_free(&r);
    /* one missing scene does not hide the others, but is not forgotten */
    r = PINCH(NULL, "compare", "nowhere.json", SCENE("example-3.json"), "--json", "--duration", "0.1");
    assert_int_equal(r.status, 2);
    assert_non_null(strstr(r.err, "nowhere.json"));
    d = document_of(&r);
    assert_int_equal(json_array_size(json_object_get(d, "scenes")), 1);
    json_decref(d);
    program_free(&r);
}

static void test_help(void **state)
{
    (void)state;
    program_result r = PINCH(NULL, "run", "--help");
    assert_int_equal(r.status, 0);
    assert_string_equal(r.err, "");
    static const char *const options[] = {"--solver", "--contact-solver", "--duration", "--step", "--json",
                                          "--csv",    "--quiet"};
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) assert_non_null(strstr(r.out, options[i]));
    program_free(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_json_is_complete),
        cmocka_unit_test(test_no_steps_at_all),
        cmocka_unit_test(test_step_and_duration),
        cmocka_unit_test(test_same_document_again),
        cmocka_unit_test(test_quiet),
        cmocka_unit_test(test_usage_and_bad_input),
        cmocka_unit_test(test_refused_pairs),
        cmocka_unit_test(test_solvers_that_exist),
        cmocka_unit_test(test_unsupported_shapes),
        cmocka_unit_test(test_csv),
        cmocka_unit_test(test_csv_that_cannot_be_written),
        cmocka_unit_test(test_full_standard_output),
        cmocka_unit_test(test_events),
        cmocka_unit_test(test_unconverged_is_reported),
        cmocka_unit_test(test_compare),
        cmocka_unit_test(test_help),
    };
    return cmocka_run_group_tests_name("pinch run and compare", tests, NULL, NULL);
}
