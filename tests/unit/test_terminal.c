/* What is printed for people: texts from elsewhere cannot command a terminal, and formats mean what they mean to C. */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"
#include "support/draw.h"

#include "common/terminal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROOM = 4096 };

/* What a text is written as. */
static char *shown(const char *text)
{
    static char made[ROOM];
    FILE *stream = fmemopen(made, sizeof made, "w");
    terminal_text(text, stream);
    fclose(stream);
    return made;
}

/* The UTF-8 of a character, without the rules for which characters there are. */
static void encode(unsigned long code, char text[5])
{
    unsigned char *t = (unsigned char *)text;
    int more = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    static const unsigned char first[] = {0, 0xc0, 0xe0, 0xf0};
    t[0] = (unsigned char)(first[more] | (code >> 6 * more));
    for (int i = 1; i <= more; i++) t[i] = (unsigned char)(0x80 | ((code >> 6 * (more - i)) & 0x3f));
    t[more + 1] = '\0';
}

static bool has_to_be_a_number(unsigned long code)
{
    static const unsigned long ranges[][2] = {{0x01, 0x1f},     {0x7f, 0x9f},     {0x2028, 0x2029},
                                              {0x202a, 0x202e}, {0x2066, 0x2069}, {0xd800, 0xdfff}};
    for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++)
        if (code >= ranges[i][0] && code <= ranges[i][1]) return true;
    return false;
}

static void every_character(void **state)
{
    (void)state;
    for (unsigned long code = 1; code < 0x110000; code += code < 0x3000 ? 1 : 97) {
        char text[5];
        encode(code, text);
        const char *got = shown(text);
        bool number = has_to_be_a_number(code);
        if (terminal_shows(text) == number || (strcmp(got, text) != 0) != number)
            fail_msg("U+%04lX is written as %s", code, got);
        for (const char *c = got; *c && number; c++)
            if (*c < 0x20 || *c > 0x7e) fail_msg("U+%04lX is written raw", code);
    }
    assert_string_equal(shown("pr\xc3\xa9henseur \xe6\x89\x8b"), "pr\xc3\xa9henseur \xe6\x89\x8b");
    assert_string_equal(shown("\x1b[2J\x7f\n"), "\\x1b[2J\\x7f\\x0a");
    assert_string_equal(shown("\xc2\x9b"), "\\xc2\\x9b");
    /* no UTF-8: a byte of C1, an overlong slash, a character that is cut off, one beyond the last */
    assert_string_equal(shown("\x9b"), "\\x9b");
    assert_string_equal(shown("\xc0\xaf"), "\\xc0\\xaf");
    assert_string_equal(shown("\xe0\x80\xaf"), "\\xe0\\x80\\xaf");
    assert_string_equal(shown("a\xe6\x89"), "a\\xe6\\x89");
    assert_string_equal(shown("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");
}

/* Whatever bytes come: what is written is UTF-8 of characters that a terminal shows. */
static void random_bytes(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 1);
    for (int i = 0, n = draw_count(1000000); i < n; i++) {
        char text[64];
        int length = draw_index(&random, 60);
        for (int k = 0; k < length; k++) text[k] = (char)(1 + draw_index(&random, 255));
        text[length] = '\0';
        const char *got = shown(text);
        if (!terminal_shows(got)) fail_msg("a random text is written as %s", got);
    }
}

#define SAME(...)                                                                                                      \
    do {                                                                                                               \
        char expected[ROOM], got[ROOM];                                                                                \
        snprintf(expected, sizeof expected, __VA_ARGS__);                                                              \
        FILE *stream = fmemopen(got, sizeof got, "w");                                                                 \
        terminal_print(stream, __VA_ARGS__);                                                                           \
        fclose(stream);                                                                                                \
        assert_string_equal(got, expected);                                                                            \
    } while (0)

static void formats(void **state)
{
    (void)state;
    SAME("nothing of it\n");
    SAME("%d %5d %-5d| %+d %05d %ld %12ld %zu %6zu %lld\n", 1, 2, 3, 4, -5, 6L, -7L, (size_t)8, (size_t)9, -10LL);
    SAME("%g %12.6f %-12.3g|%.2e %.0f %*.*g\n", 0.1, 1.0 / 3, 2e300, -1e-300, 0.5, 9, 3, 3.14159);
    SAME("%s|%12s|%-12s|%.3s|%-6.2s|%*s|%c%c\n", "a", "left", "right", "shortened", "cut", 8, "star", 'x', 'y');
    SAME("100 %% of %s, %d%%\n", "it", 50);
    SAME("%s: %g s in %ld steps, contacts by %s\n", "cube", 5.0, 5000L, "pinch");
}

static void assert_printed(const char *expected, const char *format, const char *text)
{
    char got[ROOM];
    FILE *stream = fmemopen(got, sizeof got, "w");
    terminal_print(stream, format, text);
    fclose(stream);
    assert_string_equal(got, expected);
}

/* Columns stay in line: a character of several bytes is one, and one that is written as a number is four a byte. */
static void columns(void **state)
{
    (void)state;
    assert_printed("\xc3\xa9   |\n", "%-4s|\n", "\xc3\xa9");
    assert_printed("   \xc3\xa9|\n", "%4s|\n", "\xc3\xa9");
    assert_printed("\\x1b  |\n", "%-6s|\n", "\x1b");
    assert_printed("\xc3\xa9\xc3\xa9|\n", "%.2s|\n", "\xc3\xa9\xc3\xa9\xc3\xa9");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_character),
        cmocka_unit_test(random_bytes),
        cmocka_unit_test(formats),
        cmocka_unit_test(columns),
    };
    return cmocka_run_group_tests_name("terminal", tests, NULL, NULL);
}
