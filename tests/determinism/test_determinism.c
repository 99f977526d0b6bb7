/*
 * The same input gives the same bits: side by side in one process, run to run, and as in assets/reference/hashes.json.
 * tests/determinism/same_bits compares builds.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/platform.h"
#include "support/program.h"
#include "support/scene_run.h"

#include <inttypes.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const files[] = {
    "pinched-capsule.json", "example-1.json", "example-2.json", "example-3.json", "example-4.json",
};
enum { FILES = sizeof files / sizeof files[0] };

/* Two worlds of one scene take turns with a third of another, whose allocations lie between theirs: the same state
 * after every step. */
static void test_side_by_side(void **state)
{
    (void)state;
    for (int f = 0; f < FILES; f++) {
        scene *s = scene_shipped(files[f]), *other = scene_shipped(files[(f + 1) % FILES]);
        world *a = world_of(s), *between = world_of(other);
        void *shift = malloc(12345); /* the second world's memory lies otherwise than the first's */
        world *b = world_of(s);
        for (int step = 0; step < 2500; step++) {
            assert_int_equal(world_advance(a), WORLD_OK);
            assert_int_equal(world_advance(between), WORLD_OK);
            assert_int_equal(world_advance(b), WORLD_OK);
            if (world_hash(a) == world_hash(b)) continue;
            fail_msg("%s: states differ after step %d", files[f], step + 1);
        }
        free(shift);
        world_free(a);
        world_free(b);
        world_free(between);
        scene_free(s);
        scene_free(other);
    }
}

/* The hash sees what it should: a last bit of the state. */
static void test_hash_sees_a_bit(void **state)
{
    (void)state;
    scene *s = scene_shipped("example-3.json");
    world *w = world_of(s);
    world_run_until(w, 0.1);
    uint64_t before = world_hash(w);
    assert_true(before == world_hash(w));
    const double *v = dBodyGetLinearVel(w->object);
    dBodySetLinearVel(w->object, nextafter(v[0], 1), v[1], v[2]);
    assert_true(before != world_hash(w));
    world_free(w);
    scene_free(s);
}

static char *hash_of_run(const char *file)
{
    char executable[] = PINCH_EXECUTABLE, command[] = "run", json[] = "--json", duration[] = "--duration=1.5",
         path[512];
    snprintf(path, sizeof path, "%s/assets/scenes/%s", PINCH_SOURCE_DIR, file);
    char *argv[] = {executable, command, path, json, duration, NULL};
    program_result r = program_run(NULL, argv);
    assert_int_equal(r.status, 0);
    const char *at = strstr(r.out, "\"hash\": \"");
    assert_non_null(at);
    char *hash = strndup(at + 9, 16);
    program_free(&r);
    return hash;
}

static void test_run_to_run(void **state)
{
    (void)state;
    for (int f = 0; f < FILES; f++) {
        char *first = hash_of_run(files[f]), *second = hash_of_run(files[f]);
        assert_int_equal(strlen(first), 16);
        assert_string_equal(first, second);
        free(first);
        free(second);
    }
}

static const char *text_of(const json_t *document, const char *key)
{
    const char *text = json_string_value(json_object_get(document, key));
    if (!text) fail_msg("no %s in hashes.json", key);
    return text;
}

/* Every shipped scene ends in the bits that hashes.json has, where it was made on a platform that computes as this one
 * does. Elsewhere nothing can be said, and the test is skipped. */
static void test_golden_hashes(void **state)
{
    (void)state;
    json_error_t error;
    json_t *golden = json_load_file(PINCH_SOURCE_DIR "/assets/reference/hashes.json", JSON_REJECT_DUPLICATES, &error);
    if (!golden) fail_msg("hashes.json: %s", error.text);
    char hash[17];
    snprintf(hash, sizeof hash, "%016" PRIx64, platform_fingerprint());
    const char *versions = text_of(golden, "versions"), *fingerprint = text_of(golden, "fingerprint");
    if (strcmp(versions, platform_versions()) != 0 || strcmp(fingerprint, hash) != 0) {
        print_message("Golden hashes are not compared: they were made with %s, fingerprint %s; this is %s, %s.\n",
                      versions, fingerprint, platform_versions(), hash);
        json_decref(golden);
        skip();
    }
    const json_t *hashes = json_object_get(golden, "scenes");
    int wrong = 0, count = 0;
    for (const char *const *path = shipped_scenes(); *path; path++, count++) {
        const char *name = file_name(*path);
        scene *s = scene_shipped(name);
        world *w = world_of(s);
        world_run_until(w, s->duration);
        snprintf(hash, sizeof hash, "%016" PRIx64, world_hash(w));
        world_free(w);
        scene_free(s);
        if (strcmp(text_of(hashes, name), hash) == 0) continue;
        print_error("%s ends in %s, not in %s as it did\n", name, hash, text_of(hashes, name));
        wrong++;
    }
    assert_int_equal(count, json_object_size(hashes));
    json_decref(golden);
    if (!wrong) return;
    fail_msg("%d of %d scenes end in other bits. If that is meant, make the golden files anew: "
             "tests/README.md says how.",
             wrong, count);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_side_by_side),
        cmocka_unit_test(test_hash_sees_a_bit),
        cmocka_unit_test(test_run_to_run),
        cmocka_unit_test(test_golden_hashes),
    };
    int failed = cmocka_run_group_tests_name("determinism", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
