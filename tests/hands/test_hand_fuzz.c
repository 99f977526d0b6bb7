/*
 * Hand files are damaged at random: bytes are turned over, pieces are cut out, moved or put in. Each file must be
 * taken, or refused with one line that names it; the sanitizers see that nothing else happens.
 */

#include "support/cmocka_all.h"

#include "hand_case.h"
#include "hands/listing.h"
#include "support/draw.h"
#include "support/program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const files[] = {"three-finger.urdf", "parallel-gripper.urdf", "robotiq-like.xml",
                                    "shadow-like.xml"};
enum { FILES = sizeof files / sizeof files[0] };

/* pieces that mean something to one of the readers */
static const char *const pieces[] = {
    "<",
    ">",
    "/>",
    "\"",
    "<body>",
    "</body>",
    "<joint/>",
    "<include file=\"h\"/>",
    "-1",
    "1e308",
    "nan",
    "0",
    "&lt;",
    "&#0;",
    "<frame pos=\"1 0 0\"><geom size=\"1\"/></frame>",
    "mesh=\"m\"",
    "<mesh name=\"m\" vertex=\"0 0 0 1 0 0 0 1 0 0 0 1\" face=\"0 1 9\"/>",
    "type=\"mesh\"",
    "<!DOCTYPE x>",
    "<inertial mass=\"1\" pos=\"0 0 0\" diaginertia=\"1 1 1\"/>",
    "class=\"x\"",
    "limited=\"true\"",
};
enum { PIECES = sizeof pieces / sizeof pieces[0] };

static char *damage(const char *text, pinch_random *random)
{
    size_t length = strlen(text);
    char *result = malloc(length + 1024);
    assert_non_null(result);
    memcpy(result, text, length + 1);
    for (int k = 1 + draw_index(random, 4); k > 0; k--) {
        size_t at = (size_t)draw_index(random, (int)length), cut = (size_t)draw_index(random, 16);
        if (draw_chance(random, 0.5)) {
            result[at] = (char)(result[at] ^ (1 << draw_index(random, 8)));
            if (!result[at]) result[at] = ' ';
            continue;
        }
        if (cut > length - at) cut = length - at;
        const char *piece = pieces[draw_index(random, PIECES)];
        size_t grown = strlen(piece);
        memmove(result + at + grown, result + at + cut, length - at - cut + 1);
        memcpy(result + at, piece, grown);
        length = length + grown - cut;
    }
    return result;
}

/* What is taken can be shown, and put anywhere. */
static void use(const hand *h)
{
    json_t *document = hand_document(h);
    assert_non_null(document);
    json_decref(document);
    double *positions = calloc(h->joint_count + 1, sizeof *positions);
    bool *given = calloc(h->joint_count + 1, sizeof *given);
    hand_pose *poses = calloc(h->link_count + 1, sizeof *poses);
    hand_follow_couplings(h, given, positions);
    hand_kinematics(h, positions, poses);
    free(positions);
    free(given);
    free(poses);
}

static void damaged_hands(void **state)
{
    (void)state;
    char *folder = program_make_folder(), *texts[FILES];
    int taken = 0, rounds = draw_count(50000);
    pinch_random random;
    pinch_random_seed(&random, 5);
    for (int i = 0; i < FILES; i++) {
        char path[512];
        snprintf(path, sizeof path, PINCH_SOURCE_DIR "/assets/hands/%s", files[i]);
        texts[i] = program_read_file(path);
    }
    for (int i = 0; i < rounds; i++) {
        char *text = damage(texts[i % FILES], &random), *path = program_write_file(folder, "h", text);
        hand *h;
        hand_error error;
        hand_status status = hand_load(path, NULL, 0, &h, &error);
        if (status == HAND_OK) {
            taken++;
            use(h);
        } else {
            assert_int_equal(status, HAND_BAD_INPUT);
            assert_null(h);
            if (strncmp(error.text, path, strlen(path)) != 0 || strchr(error.text, '\n'))
                fail_msg("round %d: %s", i, error.text);
        }
        hand_free(h);
        free(text);
        free(path);
    }
    /* the damage must leave the readers something to do */
    assert_true(taken > rounds / 20 && taken < rounds);
    for (int i = 0; i < FILES; i++) free(texts[i]);
    program_remove_folder(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(damaged_hands)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
