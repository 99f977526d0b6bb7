/* Every JSON document of the command is as its schema says: of answers, of failures, and of interrupted or empty runs.
 */
#include "support/cmocka_all.h"
#include "support/command.h"
#include "support/program.h"
#include "support/schema.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static json_t *schema_of(const char *name)
{
    char path[512];
    json_error_t error;
    snprintf(path, sizeof path, PINCH_SOURCE_DIR "/assets/schema/pinch-%s-1.json", name);
    json_t *schema = json_load_file(path, JSON_REJECT_DUPLICATES, &error);
    if (!schema) fail_msg("%s:%d: %s", path, error.line, error.text);
    return schema;
}

/* Runs the command, whatever its exit status, and checks the document that it prints, which the caller releases. */
static json_t *follows(const char *name, const char *const words[])
{
    json_t *schema = schema_of(name);
    program_result r = command_run(NULL, words);
    json_t *document = json_loads(r.out, JSON_REJECT_DUPLICATES, NULL);
    if (!document) fail_msg("%s: no document: %s", words[0], r.err);
    assert_int_equal(schema_faults(schema, document), 0);
    const char *matters = json_object_get(document, "rows")     ? "rows"
                          : json_object_get(document, "status") ? "status"
                                                                : "command";
    json_t *poorer = json_copy(document);
    assert_int_equal(json_object_del(poorer, matters), 0);
    assert_true(schema_faults(schema, poorer) > 0); /* the schema asks for what matters */
    json_decref(poorer);
    json_decref(schema);
    program_free(&r);
    return document;
}

#define DOCUMENT(name, ...) follows(name, (const char *const[]){__VA_ARGS__, "--json", NULL})
#define FOLLOWS(name, ...)  json_decref(DOCUMENT(name, __VA_ARGS__))

static void test_run(void **state)
{
    (void)state;
    FOLLOWS("run", "run", SCENE("lift.json"), "--duration", "0.2");
    FOLLOWS("run", "run", SCENE("example-4.json"), "--duration", "0.1");
    FOLLOWS("run", "run", SCENE("egg.json"), "--duration", "0");
    FOLLOWS("run", "run", SCENE("twist.json"), "--duration", "0.1", "--contact-solver", "quickstep");
    FOLLOWS("run", "run", SCENE("example-3.json"), "--duration", "0.1", "--max-iterations", "1");
    /* hands, with couplings, loops and several objects */
    FOLLOWS("run", "run", SCENE("hands/robotiq-like-peg.json"), "--duration", "0.02");
    FOLLOWS("run", "run", SCENE("hands/shadow-like-lift.json"), "--duration", "0.02");
    FOLLOWS("run", "run", SCENE("hands/parallel-gripper-hand-over.json"), "--duration", "0.02", "--contact-solver",
            "quickstep");
}

static void test_solve(void **state)
{
    (void)state;
    FOLLOWS("solve", "solve", SCENE("example-3.json"), "--at-end");
    FOLLOWS("solve", "solve", SCENE("example-3.json"), "--formulation", "lcp", "--solver", "pgs", "--max-iterations",
            "3");
    FOLLOWS("solve", "solve", SCENE("paper/example-2.json"), "--faithful", "--no-reserves");
    FOLLOWS("solve", "solve", SCENE("example-3.json"), "--directions");
    FOLLOWS("solve", "solve", SCENE("hands/robotiq-like-precision-cube.json"), "--at-end");
}

static void test_lcp(void **state)
{
    (void)state;
    char *folder = program_make_folder(), file[512];
    static const char *const texts[] = {"{\"M\": [[2, 1], [1, 2]], \"q\": [-1, -1]}",
                                        "{\"M\": [[0, -1], [1, 0]], \"q\": [-1, -1]}",
                                        "\xEF\xBB\xBF{\"M\": [[1]], \"q\": [-1]}"}; /* with a byte order mark */
    for (int i = 0; i < 3; i++) {
        snprintf(file, sizeof file, "%s/lcp.json", folder);
        FILE *stream = fopen(file, "w");
        assert_non_null(stream);
        assert_true(fputs(texts[i], stream) >= 0 && fclose(stream) == 0);
        FOLLOWS("lcp", "lcp", file, "--solver", "lemke");
    }
    program_remove_folder(folder);
}

static void test_bench(void **state)
{
    (void)state;
    FOLLOWS("bench", "bench", "paper", "--faithful", "--faces", "4");
    FOLLOWS("bench", "bench", "step", "--max-size", "2", "--budget", "0.02");
    FOLLOWS("bench", "bench", "collide", "--budget", "0.02");
    FOLLOWS("bench", "bench", "pareto", "--min-size", "2", "--max-size", "2", "--budget", "0.02");
    FOLLOWS("bench", "bench", "threads", "--max-size", "100", "--threads", "2", "--budget", "0.02");
}

static void test_stats(void **state)
{
    (void)state;
    char *folder = program_make_folder(), file[512], *program = exec_program("stack");
    snprintf(file, sizeof file, "%s/stats.json", folder);
    program_result r = PINCH(NULL, "exec", "--stats", file, "--", program, "--steps", "20");
    assert_int_equal(r.status, 0);
    program_free(&r);
    json_t *schema = schema_of("stats"), *document = json_load_file(file, JSON_REJECT_DUPLICATES, NULL);
    assert_non_null(document);
    assert_int_equal(schema_faults(schema, document), 0);
    json_decref(document);
    json_decref(schema);
    program_remove_folder(folder);
}

static void test_hand(void **state)
{
    (void)state;
    static const char *const files[] = {"three-finger.urdf", "allegro-like.urdf", "parallel-gripper.urdf",
                                        "robotiq-like.xml", "shadow-like.xml"};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char path[512];
        snprintf(path, sizeof path, PINCH_SOURCE_DIR "/assets/hands/%s", files[i]);
        FOLLOWS("hand", "hand", path);
    }
    FOLLOWS("hand", "hand", PINCH_SOURCE_DIR "/assets/hands/parallel-gripper.urdf", "--at", "left_finger_slide=0.01");
}

/* A hand that has what the shipped ones lack: parts that are ignored and not modelled, a mesh, joints without limits.
 */
static void test_odd_hand(void **state)
{
    static const char urdf[] =
        "<robot name='r'><link name='base'/><link name='arm'><inertial><mass value='1'/>"
        "<inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial><collision><geometry>"
        "<mesh filename='corner.obj' scale='2 2 2'/></geometry></collision><sensor/></link>"
        "<joint name='j' type='continuous'><parent link='base'/><child link='arm'/><axis xyz='0 0 1'/></joint></robot>";
    static const char mesh[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    (void)state;
    char *folder = program_make_folder(), *file = program_write_file(folder, "odd.urdf", urdf);
    free(program_write_file(folder, "corner.obj", mesh));
    FOLLOWS("hand", "hand", file);
    free(file);
    program_remove_folder(folder);
}

static void test_replay(void **state)
{
    (void)state;
    static const char *const files[] = {"jointed-circle", "jointed-closed", "jointed-contacts", "jointed-stop"};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char path[512];
        snprintf(path, sizeof path, PINCH_SOURCE_DIR "/tests/cli/recorded/%s.json", files[i]);
        FOLLOWS("replay", "replay", path);
        FOLLOWS("replay", "replay", path, "--max-iterations", "1", "--cold-start");
    }
}

static void test_study(void **state)
{
    (void)state;
    char *folder = program_make_folder(), file[512];
    snprintf(file, sizeof file, "%s/results.sqlite", folder);
    FOLLOWS("study-result", "study", PINCH_SOURCE_DIR "/assets/studies/friction-and-stiffness.json", "--out", file,
            "--limit", "2");
    program_remove_folder(folder);
}

static void test_validate(void **state)
{
    (void)state;
    FOLLOWS("validate", "validate", SCENE("egg.json"));
    FOLLOWS("validate", "validate", SCENE("egg.json"), SCENE("lift.json"));
}

static void test_compare(void **state)
{
    (void)state;
    FOLLOWS("compare", "compare", SCENE("twist.json"), "--duration", "0.1", "--samples", "2");
}

/* Fingers that crush what they let slip and drop; an object of two, so that the events say which one. */
static const char unlucky_grasp[] =
    "{\"format\": \"pinch-scene/1\", \"objects\": ["
    "{\"name\": \"held\", \"shape\": {\"type\": \"box\", \"size\": [0.1, 0.1, 0.1]}, \"mass\": 0.5},"
    "{\"name\": \"other\", \"shape\": {\"type\": \"sphere\", \"radius\": 0.05}, \"mass\": 0.5, \"position\": [0, 1, "
    "0]}],"
    "\"fingers\": [{\"name\": \"left\", \"point\": [-0.05, 0, 0], \"normal\": [1, 0, 0], \"model\": \"hard\","
    "\"stiffness\": {\"normal\": 20000}, \"friction\": 0.1, \"closing\": 0.0005, \"damage\": {\"max_force\": 5}},"
    "{\"name\": \"right\", \"point\": [0.05, 0, 0], \"normal\": [-1, 0, 0], \"model\": \"hard\","
    "\"stiffness\": {\"normal\": 20000}, \"friction\": 0.1, \"closing\": 0.0005, \"damage\": {\"max_slip\": 1e-4}}],"
    "\"simulation\": {\"duration\": 0.4}}";

/* What happened in Pinch's run, as a comparison tells it: as pinch run does, but for value and limit. Counts by type.
 */
static void count_events(const char *scene, const char *duration, int counts[4])
{
    static const char *const types[] = {"crush", "slip", "dropped", "limit"};
    json_t *run = DOCUMENT("run", "run", scene, "--duration", duration), *event,
           *compared = DOCUMENT("compare", "compare", scene, "--duration", duration, "--samples", "1");
    json_t *events = json_object_get(run, "events");
    size_t k;
    json_array_foreach(events, k, event)
    {
        for (int i = 0; i < 4; i++)
            counts[i] += strcmp(json_string_value(json_object_get(event, "type")), types[i]) == 0;
        assert_int_equal(json_object_del(event, "value") | json_object_del(event, "limit"), 0);
    }
    const json_t *pinch = json_array_get(json_object_get(compared, "scenes"), 0);
    pinch = json_array_get(json_object_get(pinch, "runs"), 0);
    assert_true(json_equal(json_object_get(pinch, "events"), events));
    json_decref(run);
    json_decref(compared);
}

static void test_events_of_every_type(void **state)
{
    (void)state;
    int counts[4] = {0};
    char *folder = program_make_folder(), *scene = program_write_file(folder, "unlucky.json", unlucky_grasp);
    count_events(scene, "0.4", counts);
    count_events(SCENE("hands/shadow-like-peg.json"), "0.08", counts);
    for (int i = 0; i < 4; i++) assert_true(counts[i] > 0);
    free(scene);
    program_remove_folder(folder);
}

/* The key `scene` is the file as it was given, but the scene's own name in pinch solve; and so say the schemas. */
static void test_what_scene_is(void **state)
{
    (void)state;
    static const char *const commands[] = {"run", "solve", "validate"};
    char *folder = program_make_folder(), *file = program_write_file(folder, "file.json", unlucky_grasp);
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++) {
        json_t *schema = schema_of(commands[i]), *d = DOCUMENT(commands[i], commands[i], file);
        bool of_solve = strcmp(commands[i], "solve") == 0;
        assert_string_equal(json_string_value(json_object_get(d, "scene")), of_solve ? "file" : file);
        const json_t *first = json_array_get(json_object_get(schema, "anyOf"), 0); /* of one scene */
        const json_t *about = cli_at(first ? first : schema, "properties.scene.description");
        assert_non_null(strstr(json_string_value(about), of_solve ? "name" : "the file, as it was given"));
        json_decref(d);
        json_decref(schema);
    }
    free(file);
    program_remove_folder(folder);
}

/* Where a command has learnt to print JSON, its document is to have a schema, and this file a test. */
static void test_every_command_is_here(void **state)
{
    (void)state;
    static const char *const known[] = {"run",    "solve", "compare", "lcp",      "bench",
                                        "replay", "study", "hand",    "validate", "friction"};
    static const char *const others[] = {"exec"}; /* prints none; it writes its statistics into a file */
    program_result list = PINCH(NULL, "--help");
    size_t printing = 0;
    for (size_t i = 0; i < sizeof known / sizeof *known + sizeof others / sizeof *others; i++) {
        const char *name = i < sizeof known / sizeof *known ? known[i] : others[i - sizeof known / sizeof *known];
        program_result r = PINCH(NULL, name, "--help");
        assert_non_null(strstr(list.out, name));
        printing += strstr(r.out, "--json") != NULL;
        program_free(&r);
    }
    assert_int_equal(printing, sizeof known / sizeof *known);
    program_free(&list);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_run),           cmocka_unit_test(test_solve),
        cmocka_unit_test(test_lcp),           cmocka_unit_test(test_bench),
        cmocka_unit_test(test_stats),         cmocka_unit_test(test_hand),
        cmocka_unit_test(test_odd_hand),      cmocka_unit_test(test_replay),
        cmocka_unit_test(test_study),         cmocka_unit_test(test_validate),
        cmocka_unit_test(test_compare),       cmocka_unit_test(test_events_of_every_type),
        cmocka_unit_test(test_what_scene_is), cmocka_unit_test(test_every_command_is_here),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
