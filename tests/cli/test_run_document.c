/*
 * Checks what `pinch run` writes: every field of its document, every row of its table, and what it does where it cannot
 * write.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/command.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

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
    {"outcome", TEXT, false, false},
    {"interrupted", BOOLEAN, false, false},
    {"steps", COUNT, false, false},
    {"time_s", NUMBER, false, false},
    {"step_us", NUMBER, false, false},
    {"collide_us", NUMBER, false, false},
    {"solve_us", NUMBER, false, false},
    {"iterations_mean", NUMBER, true, false},
    {"iterations_max", COUNT, true, false},
    {"islands_by.projections", COUNT, true, false},
    {"islands_by.newton", COUNT, true, false},
    {"islands_by.flow", COUNT, true, false},
    {"islands_by.lcp", COUNT, true, false},
    {"unconverged_steps", COUNT, true, false},
    {"too_soft_islands", COUNT, true, false},
    {"floor_residual_max", NUMBER, true, false},
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
    {"object.motion_in_hand.displacement", VECTOR3, false, false},
    {"object.motion_in_hand.creep", NUMBER, false, false},
    {"object.motion_in_hand.creep_angular", NUMBER, false, false},
    {"statics.status", TEXT, false, false},
    {"statics.moment_s", NUMBER, false, false},
    {"statics.fingers", LIST, false, false},
    {"statics.difference", NUMBER, false, false},
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
    {"remarks", LIST, false, false},
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
    {"least_margin", NUMBER, false, true},
    {"peak_normal_force", NUMBER, false, false},
};

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
        return cli_is_vector(value, 3);
    case VECTOR4:
        return cli_is_vector(value, 4);
    case BOOLEAN:
        return json_is_boolean(value);
    case LIST:
        return json_is_array(value);
    default:
        return json_is_object(value);
    }
}

static void check_fields(const json_t *document, const field *fields, size_t count, bool is_pinch)
{
    int wrong = 0;
    for (size_t i = 0; i < count; i++) {
        const json_t *value = cli_at(document, fields[i].path);
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
        json_t *d = cli_document(&r);
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
    json_t *d = cli_document(&r);
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

/* With several hands every joint says whose it is, wherever it is named. */
static void test_joints_of_two_hands(void **state)
{
    (void)state;
    static const char *const hands[] = {"giver", "taker"};
    char *folder = program_make_folder();
    program_result r = PINCH(folder, "run", SCENE("hands/parallel-gripper-hand-over.json"), "--json", "--csv",
                             "table.csv", "--duration", "0.01", "--contact-solver", "quickstep");
    json_t *d = cli_document(&r), *left_out = json_object_get(d, "not_expressed"), *text;
    char path[512], name[64];
    snprintf(path, sizeof path, "%s/table.csv", folder);
    char *table = program_read_file(path);
    size_t index;
    json_array_foreach(left_out, index, text)
    {
        const char *of = json_string_value(text);
        assert_true(!strstr(of, "_slide:") || strncmp(of, "giver/", 6) == 0 || strncmp(of, "taker/", 6) == 0);
    }
    for (size_t i = 0; i < 2; i++) {
        snprintf(name, sizeof name, ",%s/left_finger_slide.position,", hands[i]);
        assert_non_null(strstr(table, name));
        snprintf(name, sizeof name, "%s/right_finger_slide", hands[i]);
        assert_string_equal(json_string_value(json_object_get(json_array_get(json_object_get(d, "ties"), i), "name")),
                            name);
    }
    assert_null(strstr(table, ",left_finger_slide"));
    free(table);
    json_decref(d);
    program_free(&r);
    r = PINCH(folder, "run", SCENE("hands/parallel-gripper-hand-over.json"), "--duration", "0.01");
    assert_non_null(strstr(r.out, "  giver/left_finger_slide "));
    assert_non_null(strstr(r.out, "  taker/left_finger_slide "));
    program_free(&r);
    program_remove_folder(folder);
}

/* Where facets are odd in number, the friction polygon of a run is that of the static problem: with three it is half as
 * wide towards -y as towards y. */
static void test_odd_facets(void **state)
{
    (void)state;
    static const char text[] =
        "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0], \"object\": {\"shape\": {\"type\": \"box\", "
        "\"size\": [0.1, 0.1, 0.1]}, \"mass\": 0.3}, \"fingers\": ["
        "{\"name\": \"L\", \"point\": [-0.05, 0, 0], \"normal\": [1, 0, 0], %s}, "
        "{\"name\": \"R\", \"point\": [0.05, 0, 0], \"normal\": [-1, 0, 0], %s}], \"schedule\": [{\"time\": 0}, "
        "{\"time\": 0.5, \"force\": [0, 0, 0]}, {\"time\": 2, \"force\": [0, %d, 0]}], "
        "\"simulation\": {\"step\": 0.001, \"duration\": 2.5}, "
        "\"solver\": {\"formulation\": \"lcp\", \"pyramid_faces\": 3}}";
    static const char tip[] = "\"model\": \"hard\", \"stiffness\": {\"normal\": 20000}, \"closing\": 0.0005, "
                              "\"ramp\": 0.2, \"friction\": 0.5, \"damping\": {\"normal\": 50, \"tangential\": 100}";
    for (int sign = -1; sign <= 1; sign += 2) {
        char *folder = program_make_folder(), scene[1500];
        snprintf(scene, sizeof scene, text, tip, tip, 15 * sign);
        free(program_write_file(folder, "s.json", scene));
        program_result run = PINCH(folder, "run", "s.json", "--json");
        program_result solve = PINCH(folder, "solve", "s.json", "--at-end", "--json");
        json_t *ran = cli_document(&run), *solved = cli_document(&solve);
        const char *outcome = json_string_value(json_object_get(ran, "outcome"));
        const char *status = json_string_value(json_object_get(solved, "status"));
        assert_string_equal(status, sign > 0 ? "converged" : "unstable");
        assert_string_equal(outcome, sign > 0 ? "held" : "dropped");
        json_decref(ran);
        json_decref(solved);
        program_free(&run);
        program_free(&solve);
        program_remove_folder(folder);
    }
}

/* A place that cannot be written: status 3, no document; a full device is left where it is. (Reached through a link, so
 * that a mistake would remove the link alone.) */
static void test_csv_that_cannot_be_written(void **state)
{
    (void)state;
    char *folder = program_make_folder(), path[512];
    cli_refused(
        PINCH(folder, "run", SCENE("example-3.json"), "--json", "--csv", "no/such/folder.csv", "--duration", "0.1"), 3,
        "no/such/folder.csv");
    snprintf(path, sizeof path, "%s/full.csv", folder);
    if (access("/dev/full", W_OK) == 0) {
        struct stat about;
        assert_int_equal(symlink("/dev/full", path), 0);
        cli_refused(PINCH(folder, "run", SCENE("example-3.json"), "--json", "--csv", "full.csv", "--duration", "0.5"),
                    3, "full.csv");
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

/* A tendon over two joints whose ranges, and so their middles, are not about zero. */
static const char tendon_hand[] =
    "<mujoco model='h'><worldbody><body name='palm'><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>"
    "<body name='a' pos='0 0 0.1'><joint name='a' axis='0 1 0' range='-60 90'/>"
    "<inertial pos='0 0 0.1' mass='0.1' diaginertia='1e-3 1e-3 1e-3'/></body>"
    "<body name='b' pos='0 0.1 0.1'><joint name='b' axis='0 1 0' range='-60 90'/>"
    "<inertial pos='0 0 0.1' mass='0.1' diaginertia='1e-3 1e-3 1e-3'/></body></body></worldbody>"
    "<tendon><fixed name='t'><joint joint='a' coef='1'/><joint joint='b' coef='1'/></fixed></tendon></mujoco>";

/* The target that the run's document gives for the tendon under this control. */
static double tendon_target(const char *folder, const char *control, const char *solver)
{
    char text[1024];
    snprintf(text, sizeof text,
             "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"sphere\", \"radius\": 0.02}, "
             "\"mass\": 0.1, \"position\": [0, 0, -1]}, \"hand\": {\"file\": \"h.xml\", \"control\": {\"t\": %s}}}",
             control);
    free(program_write_file(folder, "scene.json", text));
    program_result r = PINCH(folder, "run", "scene.json", "--json", "--duration", "0.01", "--contact-solver", solver);
    json_t *d = cli_document(&r);
    const json_t *tie = json_array_get(json_object_get(d, "ties"), 0), *target = json_object_get(tie, "target");
    assert_string_equal(json_string_value(json_object_get(tie, "type")), "drive");
    double value = json_is_null(target) ? NAN : json_number_value(target);
    json_decref(d);
    program_free(&r);
    return value;
}

/* Only position control pulls to a place; where the tendon begins is none. */
static void test_target_of_a_tendon(void **state)
{
    (void)state;
    static const char *const solvers[] = {"pinch", "quickstep"};
    char *folder = program_make_folder();
    free(program_write_file(folder, "h.xml", tendon_hand));
    for (size_t i = 0; i < 2; i++) {
        assert_true(isnan(tendon_target(folder, "{\"type\": \"torque\", \"target\": 0.6}", solvers[i])));
        assert_true(isnan(tendon_target(folder, "{\"type\": \"velocity\", \"kd\": 1, \"target\": 0.6}", solvers[i])));
        assert_true(tendon_target(folder, "{\"type\": \"position\", \"kp\": 1, \"kd\": 1, \"target\": 0.6}",
                                  solvers[i]) == 0.6);
    }
    program_remove_folder(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_json_is_complete),           cmocka_unit_test(test_csv),
        cmocka_unit_test(test_joints_of_two_hands),        cmocka_unit_test(test_odd_facets),
        cmocka_unit_test(test_csv_that_cannot_be_written), cmocka_unit_test(test_full_standard_output),
        cmocka_unit_test(test_target_of_a_tendon),
    };
    return cmocka_run_group_tests_name("what pinch run writes", tests, NULL, NULL);
}
