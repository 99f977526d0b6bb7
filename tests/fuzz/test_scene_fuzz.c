/*
 * Scene texts are damaged at random. Each must be taken, or refused with one line; the sanitizers see that nothing else
 * happens.
 */

#include "support/cmocka_all.h"

#include "cli/broken_scenes.h"
#include "scenes/scene.h"
#include "support/program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint32_t draw(uint64_t *state, uint32_t below)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(((*state >> 32) * below) >> 32);
}

/* pieces that mean something to a JSON reader or to the loader */
static const char *const pieces[] = {
    "{",        "}",         "[",          "]",        "\"",         ",",  ":",       "\\",
    "null",     "-1",        "0",          "1e308",    "1e-320",     "\n", "\\u0000", "[1,2,3]",
    "\"type\"", "\"prism\"", "\"convex\"", "\"path\"", "\"sphere\"", "{}",
};
enum { PIECES = sizeof pieces / sizeof pieces[0] };

static char *damage(const char *text, uint64_t *random)
{
    size_t length = strlen(text);
    char *result = malloc(length + 256);
    assert_non_null(result);
    memcpy(result, text, length + 1);
    for (uint32_t k = 1 + draw(random, 3); k > 0; k--) {
        size_t at = draw(random, (uint32_t)length + 1), cut = draw(random, 12);
        if (cut > length - at) cut = length - at;
        const char *piece = draw(random, 3) ? pieces[draw(random, PIECES)] : "";
        size_t grown = strlen(piece);
        memmove(result + at + grown, result + at + cut, length - at - cut + 1);
        memcpy(result + at, piece, grown);
        length = length + grown - cut;
    }
    return result;
}

static void try_one(const char *folder, const char *text)
{
    char *path = program_write_file(folder, "scene.json", text);
    scene *s;
    scene_error error;
    scene_status status = scene_load(path, &s, &error);
    if (status == SCENE_OK) {
        assert_non_null(s);
    } else {
        assert_int_equal(status, SCENE_BAD_INPUT);
        assert_null(s);
        assert_non_null(strstr(error.text, "scene.json:"));
        assert_null(strchr(error.text, '\n'));
        if (!strstr(error.text, ": expected ")) fail_msg("%s", error.text);
    }
    scene_free(s);
    free(path);
}

static void test_damaged_texts(void **state)
{
    (void)state;
    const char *given = getenv("PINCH_FUZZ_ROUNDS");
    long rounds = given ? strtol(given, NULL, 10) : 3000;
    uint64_t random = 1;
    char *folder = program_make_folder();
    for (long i = 0; i < rounds; i++) {
        char *text = damage(i % 2 ? good_scene : good_plane, &random);
        try_one(folder, text);
        free(text);
    }
    program_remove_folder(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_damaged_texts)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
