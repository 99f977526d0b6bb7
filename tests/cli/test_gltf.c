/*
 * `pinch run --gltf`: the file is read again, by nothing that the writer uses, and held against the rules of glTF 2.0
 * and against the run's own numbers: positions against the CSV file, forces against the JSON document.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/command.h"
#include "support/sanitized.h"

#include <dirent.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char *folder;

static int make_folder(void **state)
{
    (void)state;
    folder = program_make_folder();
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    char command[600];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    free(folder);
    return system(command);
}

static const char *path_of(const char *name)
{
    static char paths[2][512];
    static int next;
    char *path = paths[next++ % 2];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

/* ---- Reading the file. ---- */

typedef struct glb {
    unsigned char *file;
    size_t size;
    json_t *json;
    const unsigned char *bytes; /* the binary chunk */
    size_t byte_count;
} glb;

static size_t word_at(const unsigned char *bytes)
{
    return bytes[0] + 256u * bytes[1] + 65536u * bytes[2] + (size_t)16777216u * bytes[3];
}

static glb read_glb(const char *name)
{
    glb g = {.size = 0};
    FILE *stream = fopen(path_of(name), "rb");
    assert_non_null(stream);
    fseek(stream, 0, SEEK_END);
    g.size = (size_t)ftell(stream);
    rewind(stream);
    g.file = malloc(g.size);
    assert_non_null(g.file);
    assert_int_equal(fread(g.file, 1, g.size, stream), g.size);
    fclose(stream);
    assert_true(g.size > 28 && memcmp(g.file, "glTF\2\0\0\0", 8) == 0);
    assert_int_equal(word_at(g.file + 8), g.size);
    size_t length = word_at(g.file + 12);
    assert_memory_equal(g.file + 16, "JSON", 4);
    assert_true(length % 4 == 0 && 28 + length <= g.size);
    g.json = json_loadb((const char *)g.file + 20, length, 0, NULL);
    assert_non_null(g.json);
    g.byte_count = word_at(g.file + 20 + length);
    assert_memory_equal(g.file + 24 + length, "BIN\0", 4);
    assert_true(g.byte_count % 4 == 0 && 28 + length + g.byte_count == g.size);
    g.bytes = g.file + 28 + length;
    return g;
}

static void free_glb(glb *g)
{
    json_decref(g->json);
    free(g->file);
}

static const json_t *list_of(const glb *g, const char *name)
{
    return json_object_get(g->json, name);
}

/* A reference of `object` into a list of the document. */
static const json_t *referred(const glb *g, const json_t *object, const char *key, const char *list)
{
    const json_t *index = json_object_get(object, key);
    assert_true(json_is_integer(index) && json_integer_value(index) >= 0);
    const json_t *found = json_array_get(list_of(g, list), (size_t)json_integer_value(index));
    assert_non_null(found);
    return found;
}

typedef struct numbers {
    size_t count;
    int width;
    const float *values; /* NULL: they are indices */
    const unsigned *indices;
} numbers;

static numbers numbers_of(const glb *g, const json_t *accessor)
{
    static const char *const types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    numbers n = {.count = (size_t)json_integer_value(json_object_get(accessor, "count"))};
    const json_t *view = referred(g, accessor, "bufferView", "bufferViews");
    size_t offset = (size_t)json_integer_value(json_object_get(view, "byteOffset"));
    size_t length = (size_t)json_integer_value(json_object_get(view, "byteLength"));
    for (int i = 1; i <= 4; i++)
        if (strcmp(json_string_value(json_object_get(accessor, "type")), types[i]) == 0) n.width = i;
    json_int_t component = json_integer_value(json_object_get(accessor, "componentType"));
    assert_true(n.width > 0 && n.count > 0 && (component == 5126 || component == 5125));
    assert_true(offset % 4 == 0 && offset + length <= g->byte_count && length == 4 * n.count * (size_t)n.width);
    if (component == 5126)
        n.values = (const float *)(const void *)(g->bytes + offset);
    else
        n.indices = (const unsigned *)(const void *)(g->bytes + offset);
    for (size_t k = 0; n.values && k < n.count * (size_t)n.width; k++) assert_true(isfinite(n.values[k]));
    return n;
}

/* Where an accessor has bounds, they are the bounds of its floats, exactly. */
static void check_bounds(const json_t *accessor, const numbers *n)
{
    for (int i = 0; i < n->width; i++) {
        double low = INFINITY, high = -INFINITY;
        for (size_t k = 0; k < n->count; k++) {
            low = fmin(low, n->values[k * (size_t)n->width + (size_t)i]);
            high = fmax(high, n->values[k * (size_t)n->width + (size_t)i]);
        }
        assert_true(json_number_value(json_array_get(json_object_get(accessor, "min"), (size_t)i)) == low);
        assert_true(json_number_value(json_array_get(json_object_get(accessor, "max"), (size_t)i)) == high);
    }
}

static void check_units(const numbers *n)
{
    for (size_t k = 0; k < n->count; k++) {
        double sum = 0;
        for (int i = 0; i < n->width; i++) sum += pow(n->values[k * (size_t)n->width + (size_t)i], 2);
        assert_true(fabs(sum - 1) < 1e-5);
    }
}

/* Triangles look outwards: the surfaces of all bodies are closed or, for cones and arrows, turned about the origin's
 * axis, so that the volume under their faces is positive. */
static void check_mesh(const glb *g, const json_t *mesh, bool closed)
{
    const json_t *primitive = json_array_get(json_object_get(mesh, "primitives"), 0);
    const json_t *attributes = json_object_get(primitive, "attributes");
    const json_t *position = referred(g, attributes, "POSITION", "accessors");
    numbers p = numbers_of(g, position), n = numbers_of(g, referred(g, attributes, "NORMAL", "accessors"));
    numbers t = numbers_of(g, referred(g, primitive, "indices", "accessors"));
    (void)referred(g, primitive, "material", "materials");
    assert_true(p.width == 3 && n.width == 3 && p.count == n.count && t.indices && t.count % 3 == 0);
    check_bounds(position, &p);
    check_units(&n);
    double volume = 0;
    for (size_t k = 0; k < t.count; k += 3) {
        const float *c[3];
        for (size_t i = 0; i < 3; i++) {
            assert_true(t.indices[k + i] < p.count);
            c[i] = p.values + 3 * (size_t)t.indices[k + i];
        }
        assert_true(t.indices[k] != t.indices[k + 1] && t.indices[k + 1] != t.indices[k + 2]);
        volume += (double)c[0][0] * (c[1][1] * c[2][2] - c[1][2] * c[2][1]) +
                  (double)c[0][1] * (c[1][2] * c[2][0] - c[1][0] * c[2][2]) +
                  (double)c[0][2] * (c[1][0] * c[2][1] - c[1][1] * c[2][0]);
    }
    if (closed) assert_true(volume > 0);
}

/* Every node but the root is the child of one other. */
static void check_tree(const glb *g)
{
    const json_t *nodes = list_of(g, "nodes");
    size_t count = json_array_size(nodes), i, k;
    int *parents = calloc(count, sizeof *parents);
    const json_t *node, *child;
    json_array_foreach(nodes, i, node)
    {
        if (json_object_get(node, "mesh")) (void)referred(g, node, "mesh", "meshes");
        json_array_foreach(json_object_get(node, "children"), k, child)
        {
            assert_true((size_t)json_integer_value(child) < count);
            parents[json_integer_value(child)]++;
        }
    }
    for (i = 0; i < count; i++) assert_int_equal(parents[i], i > 0);
    free(parents);
}

static const json_t *animation_of(const glb *g)
{
    return json_array_get(list_of(g, "animations"), 0);
}

static numbers sampler_numbers(const glb *g, const json_t *channel, const char *side)
{
    size_t index = (size_t)json_integer_value(json_object_get(channel, "sampler"));
    const json_t *sampler = json_array_get(json_object_get(animation_of(g), "samplers"), index);
    assert_non_null(sampler);
    return numbers_of(g, referred(g, sampler, side, "accessors"));
}

static void check_animation(const glb *g)
{
    size_t i;
    const json_t *channel;
    json_array_foreach(json_object_get(animation_of(g), "channels"), i, channel)
    {
        const json_t *target = json_object_get(channel, "target");
        (void)referred(g, target, "node", "nodes");
        numbers times = sampler_numbers(g, channel, "input"), values = sampler_numbers(g, channel, "output");
        bool turns = strcmp(json_string_value(json_object_get(target, "path")), "rotation") == 0;
        assert_true(times.count == values.count && times.width == 1 && values.width == (turns ? 4 : 3));
        for (size_t k = 1; k < times.count; k++) assert_true(times.values[k] > times.values[k - 1]);
        if (turns) check_units(&values);
    }
}

static void check_document(const glb *g)
{
    size_t i;
    const json_t *mesh;
    assert_string_equal(json_string_value(json_object_get(list_of(g, "asset"), "version")), "2.0");
    const json_t *buffer = json_array_get(list_of(g, "buffers"), 0);
    assert_int_equal(json_integer_value(json_object_get(buffer, "byteLength")), g->byte_count);
    check_tree(g);
    json_array_foreach(list_of(g, "meshes"), i, mesh)
    {
        const char *name = json_string_value(json_object_get(mesh, "name"));
        bool cone = strcmp(name, "stick") == 0 || strcmp(name, "slip") == 0 || strcmp(name, "open") == 0;
        check_mesh(g, mesh, !cone);
    }
    check_animation(g);
}

/* The values that move a node. `count` is 0 where nothing does. */
static numbers track_of(const glb *g, size_t node, const char *path, numbers *times)
{
    size_t i;
    const json_t *channel;
    json_array_foreach(json_object_get(animation_of(g), "channels"), i, channel)
    {
        const json_t *target = json_object_get(channel, "target");
        if ((size_t)json_integer_value(json_object_get(target, "node")) != node) continue;
        if (strcmp(json_string_value(json_object_get(target, "path")), path) != 0) continue;
        *times = sampler_numbers(g, channel, "input");
        return sampler_numbers(g, channel, "output");
    }
    return (numbers){.count = 0};
}

static size_t node_called(const glb *g, const char *name)
{
    size_t i;
    const json_t *node;
    json_array_foreach(list_of(g, "nodes"), i,
                       node) if (strcmp(json_string_value(json_object_get(node, "name")), name) == 0) return i;
    fail_msg("no node %s", name);
    return 0;
}

/* ---- The tests. ---- */

static json_t *run_scene(const char *scene, const char *fps)
{
    program_result r = PINCH(folder, "run", scene, "--json", "--gltf", "run.glb", "--csv", "run.csv", "--fps", fps);
    assert_int_equal(r.status, 0);
    json_t *document = cli_document(&r);
    program_free(&r);
    return document;
}

/* The object's rows of the CSV file, of the times that the file has, one after the other. */
static void check_positions(const glb *g, double rate)
{
    numbers times, moved = track_of(g, node_called(g, "object"), "translation", &times);
    assert_true(moved.count > 1);
    char *text = program_read_file(path_of("run.csv")), *line = strchr(text, '\n') + 1;
    size_t k = 1;
    double last = 0, step = 0;
    for (; *line; line = strchr(line, '\n') + 1) {
        double time, at[3];
        assert_int_equal(sscanf(line, "%lf,%lf,%lf,%lf", &time, &at[0], &at[1], &at[2]), 4);
        step = time - last;
        last = time;
        if (k >= times.count || (float)time != times.values[k]) continue;
        for (int i = 0; i < 3; i++) assert_true(fabs(at[i] - moved.values[3 * k + (size_t)i]) <= 1e-6);
        k++;
    }
    assert_int_equal(k, times.count);
    /* the first frame is before the first step, the last one the end, and the others come at the rate asked for */
    assert_true(times.values[0] == 0 && times.values[k - 1] == (float)last);
    for (size_t i = 1; i + 1 < k; i++) assert_true(fabs(times.values[i] - (double)i / rate) <= 0.5001 * step);
    free(text);
}

static void test_every_scene(void **state)
{
    (void)state;
    DIR *scenes = opendir(PINCH_SOURCE_DIR "/assets/scenes");
    assert_non_null(scenes);
    int count = 0, entries = 0;
    for (struct dirent *entry; (entry = readdir(scenes));) {
        char path[512];
        if (!strstr(entry->d_name, ".json") || (SANITIZED && entries++ % 3)) continue;
        snprintf(path, sizeof path, "%s/assets/scenes/%s", PINCH_SOURCE_DIR, entry->d_name);
        json_decref(run_scene(path, count++ % 2 ? "60" : "24"));
        glb g = read_glb("run.glb");
        check_document(&g);
        check_positions(&g, count % 2 ? 24 : 60);
        free_glb(&g);
    }
    closedir(scenes);
    assert_true(count >= (SANITIZED ? 5 : 16));
}

/* A finger with one contact point: its arrow's length at the end is its force. */
static void test_forces(void **state)
{
    (void)state;
    json_t *document = run_scene(SCENE("cube-spheres.json"), "60");
    glb g = read_glb("run.glb");
    const json_t *extras = json_object_get(json_array_get(list_of(&g, "nodes"), 0), "extras");
    double scale = json_number_value(json_object_get(extras, "largest_force")) /
                   json_number_value(json_object_get(extras, "longest_arrow"));
    size_t i;
    const json_t *finger;
    json_array_foreach(json_object_get(document, "fingers"), i, finger)
    {
        char name[128];
        double force = 0;
        numbers times;
        snprintf(name, sizeof name, "%s on object, contact 1", json_string_value(json_object_get(finger, "name")));
        const json_t *node = json_array_get(list_of(&g, "nodes"), node_called(&g, name));
        json_int_t arrow = json_integer_value(json_array_get(json_object_get(node, "children"), 0));
        numbers sizes = track_of(&g, (size_t)arrow, "scale", &times);
        assert_int_equal(json_integer_value(json_object_get(finger, "points")), 1);
        assert_true(sizes.count > 1);
        for (size_t k = 0; k < 3; k++)
            force = hypot(force, json_number_value(json_array_get(json_object_get(finger, "force"), k)));
        assert_true(force > 0.1);
        assert_true(fabs(scale * sizes.values[3 * sizes.count - 1] - force) < 1e-6 * force);
    }
    free_glb(&g);
    json_decref(document);
}

/* Every shape, as an object between two fingers that only look on. */
static void test_every_shape(void **state)
{
    (void)state;
    static const char *const shapes[] = {
        "{\"type\": \"box\", \"size\": [0.1, 0.06, 0.08]}",
        "{\"type\": \"box\", \"size\": [0.1, 0.06, 0.08], \"rounding\": 0.01}",
        "{\"type\": \"sphere\", \"radius\": 0.05}",
        "{\"type\": \"capsule\", \"radius\": 0.05, \"length\": 0.1}",
        "{\"type\": \"cylinder\", \"radius\": 0.05, \"length\": 0.1}",
        "{\"type\": \"cylinder\", \"radius\": 0.05, \"length\": 0.1, \"rounding\": 0.01}",
        "{\"type\": \"flat_capsule\", \"radius\": 0.05, \"length\": 0.1}",
        "{\"type\": \"ellipsoid\", \"radii\": [0.05, 0.03, 0.02]}",
        "{\"type\": \"superellipsoid\", \"radii\": [0.05, 0.03, 0.02], \"exponents\": [0.3, 1.5]}",
        "{\"type\": \"convex\", \"vertices\": [[0,0,0],[0.1,0,0],[0,0.1,0],[0,0,0.1]]}",
        "{\"type\": \"prism\", \"vertices\": [[0,0],[0.1,0],[0,0.1]], \"height\": 0.05}",
    };
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        char text[1024];
        snprintf(text, sizeof text,
                 "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"sphere\", \"radius\": 0.05}, "
                 "\"mass\": 1}, \"fingers\": [{\"point\": [0.05, 0, 0], \"normal\": [-1, 0, 0], \"model\": \"hard\", "
                 "\"stiffness\": {\"normal\": 1000}, \"friction\": 0.5, \"closing\": 0.001}], \"environment\": "
                 "[{\"name\": \"it\", \"position\": [3, 0, 0], \"orientation\": [0.6, 0, 0.8, 0], \"shape\": %s, "
                 "\"stiffness\": {\"normal\": 1000}, \"friction\": 0.5}], \"simulation\": {\"duration\": 0.1}}",
                 shapes[i]);
        free(program_write_file(folder, "shape.json", text));
        json_decref(run_scene("shape.json", "60"));
        glb g = read_glb("run.glb");
        check_document(&g);
        free_glb(&g);
    }
}

/* A hand and two objects: every link is a node that moves with its body. */
static void test_hand(void **state)
{
    (void)state;
    free(program_write_file(
        folder, "hand.json",
        "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0], \"objects\": [{\"name\": \"ball\", \"shape\": "
        "{\"type\": "
        "\"sphere\", \"radius\": 0.03}, \"mass\": 0.1, \"position\": [0, 0, 0.08]}, {\"name\": \"cube\", \"shape\": "
        "{\"type\": \"box\", \"size\": [0.03, 0.03, 0.03]}, \"mass\": 0.05, \"position\": [0.2, 0, 0.08]}], \"hand\": "
        "{\"file\": \"" PINCH_SOURCE_DIR "/assets/hands/three-finger.urdf\", \"control\": {\"*\": {\"type\": "
        "\"position\", \"kp\": 2, \"kd\": 0.05, \"target\": [[0, 0.2], [0.5, 0.9]]}}, \"contacts\": {\"*\": "
        "{\"model\": "
        "\"hard\", \"stiffness\": {\"normal\": 10000}, \"friction\": 0.6}}}, \"simulation\": {\"duration\": 0.5}}"));
    json_decref(run_scene("hand.json", "30"));
    glb g = read_glb("run.glb");
    check_document(&g);
    static const char *const moving[] = {"f1_proximal", "f1_tip", "f2_distal", "f3_knuckle", "ball"};
    numbers times;
    for (size_t i = 0; i < sizeof moving / sizeof *moving; i++)
        assert_int_equal(track_of(&g, node_called(&g, moving[i]), "translation", &times).count, 16);
    (void)node_called(&g, "palm");
    (void)node_called(&g, "cube");
    free_glb(&g);
}

static void translation_of(const char *joints, const char *link, double at[3])
{
    program_result r = PINCH(folder, "hand", PINCH_SOURCE_DIR "/assets/hands/three-finger.urdf", "--gltf", "hand.glb",
                             "--quiet", joints ? "--at" : NULL, joints);
    assert_int_equal(r.status, 0);
    program_free(&r);
    glb g = read_glb("hand.glb");
    check_tree(&g);
    assert_true(json_array_size(list_of(&g, "meshes")) > 9);
    assert_null(json_object_get(g.json, "animations"));
    size_t i;
    const json_t *node;
    json_array_foreach(list_of(&g, "nodes"), i, node)
        assert_string_not_equal(json_string_value(json_object_get(node, "name")), "object");
    const json_t *x = json_object_get(json_array_get(list_of(&g, "nodes"), node_called(&g, link)), "translation");
    for (i = 0; i < 3; i++) at[i] = json_number_value(json_array_get(x, i));
    free_glb(&g);
}

/* A hand alone, in any posture: what --at moves stands elsewhere, and nothing else. */
static void test_posture(void **state)
{
    (void)state;
    double before[2][3], after[2][3];
    translation_of(NULL, "f1_tip", before[0]);
    translation_of(NULL, "f2_tip", before[1]);
    translation_of("f1_pip=0.5", "f1_tip", after[0]);
    translation_of("f1_pip=0.5", "f2_tip", after[1]);
    assert_true(fabs(after[0][0] - before[0][0]) + fabs(after[0][1] - before[0][1]) > 0.005);
    assert_memory_equal(after[1], before[1], sizeof before[1]);
    program_result r = PINCH(folder, "hand", PINCH_SOURCE_DIR "/assets/hands/three-finger.urdf", "--gltf", "no.glb",
                             "--at", "f1_pip=99");
    assert_int_equal(r.status, 2);
    assert_non_null(strstr(r.err, "pinch hand: --at: expected a position of f1_pip from"));
    program_free(&r);
    assert_null(fopen(path_of("no.glb"), "r"));
}

static void test_same_bits(void **state)
{
    (void)state;
    json_decref(run_scene(SCENE("mug.json"), "30"));
    glb one = read_glb("run.glb");
    json_decref(run_scene(SCENE("mug.json"), "30"));
    glb other = read_glb("run.glb");
    assert_int_equal(one.size, other.size);
    assert_memory_equal(one.file, other.file, one.size);
    free_glb(&one);
    free_glb(&other);
}

static void test_refusals(void **state)
{
    (void)state;
    cli_refused(PINCH(folder, "run", SCENE("egg.json"), "--gltf", "run.glb", "--fps", "0"), 2, "--fps");
    cli_refused(PINCH(folder, "run", SCENE("egg.json"), "--gltf", "a.glb", "--csv", "a.glb"), 2, "a.glb");
    cli_refused(PINCH(folder, "run", SCENE("egg.json"), "--gltf", "no/where.glb"), 3, "no/where.glb");
    /* a run without a step has one frame and nothing that moves */
    program_result r = PINCH(folder, "run", SCENE("egg.json"), "--quiet", "--duration", "0", "--gltf", "still.glb");
    assert_int_equal(r.status, 0);
    program_free(&r);
    glb g = read_glb("still.glb");
    check_document(&g);
    assert_null(list_of(&g, "animations"));
    free_glb(&g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_scene), cmocka_unit_test(test_forces),  cmocka_unit_test(test_every_shape),
        cmocka_unit_test(test_hand),        cmocka_unit_test(test_posture), cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
