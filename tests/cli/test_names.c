/* Names that would command a terminal, in every command that prints them: of scenes, fingers, hands, joints, studies
 * and files. They are shown and not obeyed, and names of any language stay as they are. */
#include "support/cmocka_all.h"
#include "support/command.h"
#include "support/program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* clears the screen, in 7 bits and in the 8 bits of C1; deletes; ends the line; turns the direction of what follows */
#define HOSTILE                                                                                                        \
    "pr\xc3\xa9henseur\x1b[2J\xc2\x9b"                                                                                 \
    "2J\x7f\n\xe2\x80\xae"
#define HOSTILE_JSON "pr\xc3\xa9henseur\\u001b[2J\\u009b2J\\u007f\\n\\u202e"
/* XML has no escape character at all */
#define HOSTILE_XML "pr\xc3\xa9henseur&#x9b;2J&#x7f;&#10;"
#define FILE_NAME   "pr\xc3\xa9henseur\x1b[2J\n\x9b.json" /* no UTF-8 at its end */

static const char finger[] = "{\"name\": \"%s" HOSTILE_JSON "\", \"point\": [%s0.05, 0, 0], \"normal\": [%s1, 0, 0],"
                             " \"model\": \"hard\", \"stiffness\": {\"normal\": 20000, \"tangential\": 20000},"
                             " \"friction\": 0.6, \"closing\": 0.0005}";

static char *scene_text(void)
{
    static char text[4096], left[512], right[512];
    snprintf(left, sizeof left, finger, "l", "-", "");
    snprintf(right, sizeof right, finger, "r", "", "-");
    snprintf(text, sizeof text,
             "{\"format\": \"pinch-scene/1\", \"name\": \"" HOSTILE_JSON "\","
             " \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.1, 0.1, 0.1]}, \"mass\": 0.5},"
             " \"fingers\": [%s, %s], \"simulation\": {\"duration\": 0.05}}",
             left, right);
    return text;
}

static const char hand_text[] =
    "<robot name=\"" HOSTILE_XML "\">"
    "<link name=\"base" HOSTILE_XML "\"/>"
    "<link name=\"tip" HOSTILE_XML "\"><inertial><mass value=\"1\"/>"
    "<inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
    "<joint name=\"j" HOSTILE_XML "\" type=\"revolute\"><parent link=\"base" HOSTILE_XML
    "\"/><child link=\"tip" HOSTILE_XML
    "\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint></robot>";

/* Control characters are those of ASCII but the line feed, DEL, and U+0080 to U+009F as a byte or in UTF-8. */
static void assert_harmless(const char *text)
{
    const char *turn = strstr(text, "\xe2\x80\xae");
    if (turn && *text != '{') fail_msg("the direction of text is turned: %s", text);
    for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
        bool begins = *c >= 0xc2 && (c[1] & 0xc0) == 0x80;
        if ((*c < 0x20 && *c != '\n') || *c == 0x7f || (*c >= 0x80 && !begins) || (*c == 0xc2 && c[1] < 0xa0))
            fail_msg("a terminal would obey byte 0x%02x of: %s", *c, text);
        while (begins && (c[1] & 0xc0) == 0x80) c++;
    }
}

/* Runs a command that prints `name` as a terminal shows it, and ends with `status`. */
static void shown(program_result r, int status, const char *name)
{
    if (r.status != status) fail_msg("status %d: %s", r.status, r.err);
    assert_harmless(r.out);
    assert_harmless(r.err);
    if (!strstr(r.out, name) && !strstr(r.err, name)) fail_msg("%s is not in: %s%s", name, r.out, r.err);
    program_free(&r);
}

/* Runs a command whose JSON document has this name at `place`. */
static void document_has(program_result r, const char *place, const char *name)
{
    assert_harmless(r.out);
    json_t *document = cli_document(&r);
    assert_string_equal(json_string_value(cli_at(document, place)), name);
    json_decref(document);
    program_free(&r);
}

#define AS_SHOWN "pr\xc3\xa9henseur\\x1b[2J\\xc2\\x9b2J\\x7f\\x0a\\xe2\\x80\\xae"

static void scenes(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    free(program_write_file(folder, FILE_NAME, scene_text()));
    free(program_write_file(folder, "other.json", scene_text()));
    shown(PINCH(folder, "run", FILE_NAME), 0, "l" AS_SHOWN " stick");
    shown(PINCH(folder, "solve", FILE_NAME), 0, AS_SHOWN ": converged");
    shown(PINCH(folder, "compare", FILE_NAME, "other.json", "--samples", "1", "--quickstep-iterations", "20"), 0,
          AS_SHOWN ": 0.05 s");
    shown(PINCH(folder, "validate", FILE_NAME), 0, "pr\xc3\xa9henseur\\x1b[2J\\x0a\\x9b.json: valid");
    document_has(PINCH(folder, "solve", FILE_NAME, "--json"), "scene", HOSTILE);
    document_has(PINCH(folder, "validate", FILE_NAME, "--print"), "name", HOSTILE);
    program_remove_folder(folder);
}

/* A file name that is no UTF-8 stands in a document with the replacement character. */
static void bytes_that_are_no_text(void **state)
{
    (void)state;
    static const char name[] = "pr\xc3\xa9henseur\x1b[2J\n\xef\xbf\xbd.json";
    char *folder = program_make_folder();
    free(program_write_file(folder, FILE_NAME, scene_text()));
    free(program_write_file(folder, "\x9b.json", "{\"format\": \"pinch-scene/1\"}"));
    free(program_write_file(folder, "\x9b.urdf", hand_text));
    document_has(PINCH(folder, "run", FILE_NAME, "--json"), "scene", name);
    document_has(PINCH(folder, "validate", FILE_NAME, "--json"), "scene", name);
    document_has(PINCH(folder, "hand", "\x9b.urdf", "--json"), "file", "\xef\xbf\xbd.urdf");
    shown(PINCH(folder, "compare", FILE_NAME, "--samples", "1", "--quiet"), 0, "");
    shown(PINCH(folder, "compare", FILE_NAME, "--save", "b.json"), 2, "expected a file name in UTF-8");
    shown(PINCH(folder, "hand", "\x9b.urdf", "--gltf", "h.glb"), 2, "expected a name in UTF-8");
    shown(PINCH(folder, "validate", "\x9b.json"), 2, "\\x9b.json:1: object");
    assert_int_equal(program_count_entries(folder), 3);
    program_remove_folder(folder);
}

/* The command that repeats a failure can be pasted into a shell. */
static void repeated_command(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    free(program_write_file(folder, FILE_NAME, scene_text()));
    free(program_write_file(folder, "o'ther.json", "{}"));
    shown(PINCH(folder, "compare", "o'ther.json", FILE_NAME), 2, "pinch compare 'o'\\''ther.json'\n");
    free(program_write_file(folder, FILE_NAME, "{}"));
    shown(PINCH(folder, "compare", FILE_NAME, "o'ther.json"), 2,
          "pinch compare $'pr\\xc3\\xa9henseur\\x1b[2J\\x0a\\x9b.json'\n");
    program_remove_folder(folder);
}

static void hands(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    free(program_write_file(folder, "h.urdf", hand_text));
    shown(PINCH(folder, "hand", "h.urdf"), 0, "jpr\xc3\xa9henseur\\xc2\\x9b2J\\x7f\\x0a");
    shown(PINCH(folder, "hand", "h.urdf", "--at", "no\x1b=1"), 2, "not \"no\\x1b\"; there are jpr\xc3\xa9");
    free(program_write_file(folder, "bad.urdf", "<robot><link name=\"a&#x9b;\"/><link name=\"a&#x9b;\"/></robot>"));
    shown(PINCH(folder, "hand", "bad.urdf"), 2, "bad.urdf");
    program_remove_folder(folder);
}

static void studies(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    free(program_write_file(folder, "scene.json", scene_text()));
    free(program_write_file(
        folder, "s.json",
        "{\"format\": \"pinch-study/1\", \"name\": \"" HOSTILE_JSON "\", \"scene\": \"scene.json\","
        " \"trials\": {\"samples\": 2}, \"vary\": [{\"path\": \"/object/mass\", \"uniform\": [0.4, 0.5]}]}"));
    shown(PINCH(folder, "study", "s.json", "--out", "o.sqlite"), 0, AS_SHOWN ": 2 of 2 trials");
    shown(PINCH(folder, "study", "s.json", "--trial", "1"), 0, AS_SHOWN ": /object/mass");
    program_remove_folder(folder);
}

static void words_of_the_command_line(void **state)
{
    (void)state;
    shown(PINCH(NULL, "ru\x1b[2Jn"), 2, "\"ru\\x1b[2Jn\"");
    shown(PINCH(NULL, "run", "--\x1b[2J"), 2, "--\\x1b[2J");
    shown(PINCH(NULL, "run", "--step", "\x1b[2J", "x"), 2, "\\x1b[2J");
    shown(PINCH(NULL, "replay", "\x1b.json"), 2, ".json");
    shown(PINCH(NULL, "lcp", "\x1b.json"), 2, ".json");
    shown(PINCH(NULL, "study", "\x1b.json", "--print"), 2, ".json");
    shown(PINCH(NULL, "exec", "--", "/\x1b[2J"), 127, "[2J");
    shown(PINCH(NULL, "--manual", "/proc/\x1b[2J"), 3, "\\x1b[2J");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scenes),           cmocka_unit_test(bytes_that_are_no_text),
        cmocka_unit_test(repeated_command), cmocka_unit_test(hands),
        cmocka_unit_test(studies),          cmocka_unit_test(words_of_the_command_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
