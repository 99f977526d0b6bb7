/*
 * The page of `pinch compare --report` must be self-contained and escaped. In a real browser it must raise no console
 * errors, show the numbers of the JSON document in its tables, be no wider than the window, and have pictures in light
 * and dark.
 *
 * Without a browser the browser's part is skipped, unless PINCH_REQUIRE_BROWSER is set; tests/run sets it where the
 * system has the package.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/command.h"

#include <ctype.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char *folder;      /* with page.html */
static json_t *document_; /* what it was made from */

static const char EVIL[] = "</title><script>alert('x')</script>&\"<b>";

/* The egg under a name that would like to be more than a name. */
static char *evil_scene(void)
{
    json_t *egg = json_load_file(COMPARE_SCENE("egg.json"), 0, NULL);
    assert_non_null(egg);
    json_object_set_new(egg, "name", json_string(EVIL));
    json_object_set_new(json_array_get(json_object_get(egg, "fingers"), 0), "name", json_string(EVIL));
    char *text = json_dumps(egg, 0), *path = program_write_file(folder, "evil.json", text);
    free(text);
    json_decref(egg);
    return path;
}

static int make_page(void **state)
{
    (void)state;
    folder = program_make_folder();
    char *evil = evil_scene();
    document_ = compare_document(COMPARE(folder, evil, COMPARE_SCENE("example-2.json"), COMPARE_SCENE("twist.json"),
                                         COMPARE_SCENE("mug.json"), "--json", "--report", "page.html", "--duration",
                                         "1.2", "--samples", "8"),
                                 0);
    free(evil);
    return 0;
}

static char *path_of(const char *name)
{
    static char paths[4][512];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static int remove_page(void **state)
{
    (void)state;
    char command[600];
    snprintf(command, sizeof command, "rm -rf '%s'", folder); /* the browser leaves folders of its own */
    json_decref(document_);
    free(folder);
    return system(command);
}

static void test_self_contained(void **state)
{
    (void)state;
    char *page = program_read_file(path_of("page.html"));
    static const char *const outside[] = {"http:", "https:", "src=", "@import", "url(h", "<link rel=\"style"};
    for (size_t i = 0; i < sizeof outside / sizeof *outside; i++) assert_null(strstr(page, outside[i]));
    assert_true(strncmp(page, "<!DOCTYPE html>\n<html lang=\"en\">", 32) == 0);
    assert_non_null(strstr(page, "prefers-color-scheme:dark"));
    assert_non_null(strstr(page, "@media print"));
    assert_true(strlen(page) < 5000000 / 16 * 4); /* the share of 4 scenes of 16 in 5 MB */
    free(page);
}

static void test_names_are_escaped(void **state)
{
    (void)state;
    char *page = program_read_file(path_of("page.html"));
    assert_null(strstr(page, "<script"));
    assert_null(strstr(page, "<b>\""));
    assert_non_null(strstr(page, "&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;&amp;&quot;&lt;b&gt;"));
    free(page);
}

/* A browser's path, NULL: none. */
static char *browser(void)
{
    static char *const places[] = {"/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++)
        if (access(places[i], X_OK) == 0) return places[i];
    return NULL;
}

static bool skip_without_browser(void)
{
    const char *required = getenv("PINCH_REQUIRE_BROWSER");
    if (browser()) return false;
    if (required && *required) fail_msg("no browser: install chromium");
    print_message("no browser: not tested\n");
    return true;
}

/* Opens a page of the folder; `what` is the browser's option. */
static program_result open_page(const char *name, char *what, char *size, char *scheme)
{
    char profile[600], address[600];
    char headless[] = "--headless", sandbox[] = "--no-sandbox", gpu[] = "--disable-gpu", bars[] = "--hide-scrollbars",
         logging[] = "--enable-logging=stderr", shm[] = "--disable-dev-shm-usage";
    snprintf(profile, sizeof profile, "--user-data-dir=%s/profile", folder);
    snprintf(address, sizeof address, "file://%s/%s", folder, name);
    char *argv[] = {browser(), headless, sandbox, gpu, bars, logging, shm, profile, size, scheme, what, address, NULL};
    program_result r = program_run(folder, argv);
    if (r.status != 0) fail_msg("%s ended with %d: %.2000s", browser(), r.status, r.err);
    return r;
}

static char dump[] = "--dump-dom", laptop[] = "--window-size=1366,2200", narrow[] = "--window-size=720,2200",
            light[] = "--blink-settings=preferredColorScheme=1", dark[] = "--blink-settings=preferredColorScheme=0";

/* The page with a script at its end, as another file: what a script sees the tests can read from the document. */
static void write_with_script(const char *name, const char *script)
{
    char *page = program_read_file(path_of("page.html")), *end = strstr(page, "</body>");
    assert_non_null(end);
    *end = '\0';
    char *text = malloc(strlen(page) + strlen(script) + 64);
    assert_non_null(text);
    sprintf(text, "%s<script>%s</script></body></html>", page, script);
    free(program_write_file(folder, name, text));
    free(text);
    free(page);
}

static void test_no_console_errors(void **state)
{
    (void)state;
    if (skip_without_browser()) return;
    program_result r = open_page("page.html", dump, laptop, light);
    if (strstr(r.err, "CONSOLE")) fail_msg("%s", strstr(r.err, "CONSOLE"));
    assert_true(strlen(r.out) > 50000);
    program_free(&r);
    /* an error would have been seen */
    write_with_script("wrong.html", "undefinedFunction();");
    r = open_page("wrong.html", dump, laptop, light);
    assert_non_null(strstr(r.err, "CONSOLE"));
    program_free(&r);
}

/* The text of a cell as a number: "2.7", narrow spaces, "x10" and an exponent; NaN for a dash. */
static double number_of(const char *cell, const char *end)
{
    char text[64];
    size_t n = 0;
    for (const char *c = cell; c < end && n < sizeof text - 2; c++) {
        if (*c == '<') {
            while (c < end && *c != '>') c++;
        } else if (strncmp(c, "\xe2\x88\x92", 3) == 0) { /* minus */
            text[n++] = '-';
            c += 2;
        } else if (strncmp(c, "\xc3\x97", 2) == 0) { /* times, then 10 */
            text[n++] = 'e';
            c++;
            while (c + 1 < end && !isdigit((unsigned char)c[1])) c++;
            c += 2;
        } else if (strchr("0123456789.", *c)) {
            text[n++] = *c;
        }
    }
    text[n] = '\0';
    return n ? strtod(text, NULL) : NAN;
}

static void attribute(const char *cell, const char *name, char value[128])
{
    char key[32];
    snprintf(key, sizeof key, "%s=\"", name);
    const char *start = strstr(cell, key);
    assert_non_null(start);
    start += strlen(key);
    size_t n = strcspn(start, "\"");
    assert_true(n < 128);
    memcpy(value, start, n);
    value[n] = '\0';
}

/* One cell against the metric of the scene's run: in full in its attribute, to three digits in what is read. */
static void check_cell(const char *cell, const json_t *of_scene)
{
    char run[128], key[128], exact[128];
    attribute(cell, "data-run", run);
    attribute(cell, "data-metric", key);
    attribute(cell, "data-value", exact);
    const char *text = strchr(cell, '>') + 1, *end = strstr(text, "</td>");
    double value = compare_metric(compare_find(of_scene, run), key), shown = number_of(text, end);
    const json_t *entry = json_object_get(json_object_get(compare_find(of_scene, run), "metrics"), key);
    if (isnan(value)) {
        assert_string_equal(exact, "");
        assert_true(isnan(shown));
    } else if (json_is_boolean(entry)) {
        assert_true(strncmp(text, value != 0 ? "yes" : "no", value != 0 ? 3 : 2) == 0);
    } else {
        assert_true(strtod(exact, NULL) == value);
        if (!(fabs(shown - value) <= 0.006 * fabs(value))) fail_msg("%s, %s: %g shown as %g", run, key, value, shown);
    }
}

static void test_tables_hold_the_numbers(void **state)
{
    (void)state;
    if (skip_without_browser()) return;
    program_result r = open_page("page.html", dump, laptop, light);
    const json_t *scenes = json_object_get(document_, "scenes");
    size_t metrics = json_object_size(json_object_get(compare_find(json_array_get(scenes, 0), "pinch"), "metrics"));
    size_t per_scene = 5 * metrics, cells = 0;
    for (const char *cell = strstr(r.out, "<td data-scene="); cell; cell = strstr(cell + 1, "<td data-scene="))
        check_cell(cell, json_array_get(scenes, cells++ / per_scene));
    assert_int_equal(cells, json_array_size(scenes) * per_scene);
    program_free(&r);
}

/* What people with screen readers, narrow windows and sharp eyes need, as the browser sees it. */
static void test_layout(void **state)
{
    (void)state;
    if (skip_without_browser()) return;
    write_with_script(
        "layout.html",
        "const faults=[];const q=s=>[...document.querySelectorAll(s)];"
        "if(document.documentElement.scrollWidth>innerWidth)faults.push('wider than the window');"
        "q('table').forEach(t=>{if(!t.caption||!t.querySelector('th[scope=col]'))faults.push('table without heads');});"
        "q('figure').forEach(f=>{if(!f.querySelector('figcaption'))faults.push('figure without caption');});"
        "q('figure svg').forEach(s=>{const b=s.getBoundingClientRect();"
        "if(!s.getAttribute('aria-label')||b.width<100||b.height<60)faults.push('svg');"
        "s.querySelectorAll('text').forEach(t=>{const r=t.getBoundingClientRect();"
        "if(r.left<b.left-1||r.right>b.right+1||r.bottom>b.bottom+1)faults.push('text outside: '+t.textContent);});});"
        "if(/NaN|inf|nan/.test(q('path').map(p=>p.getAttribute('d')).join('')))faults.push('path without number');"
        "document.body.dataset.figures=q('figure').length;document.body.dataset.faults=faults.join('; ');");
    char *const sizes[] = {laptop, narrow};
    for (int i = 0; i < 2; i++) {
        char faults[128] = "", figures[128];
        program_result r = open_page("layout.html", dump, sizes[i], light);
        const char *body = strstr(r.out, "<body");
        assert_non_null(body);
        attribute(body, "data-figures", figures);
        assert_true(atoi(figures) >= 4 * 12);
        if (!strstr(body, "data-faults=\"\"")) attribute(body, "data-faults", faults);
        assert_string_equal(faults, "");
        program_free(&r);
    }
}

static unsigned char *picture(const char *name, char *scheme, long *size)
{
    char option[600];
    snprintf(option, sizeof option, "--screenshot=%s", path_of(name));
    program_result r = open_page("page.html", option, laptop, scheme);
    program_free(&r);
    FILE *stream = fopen(path_of(name), "rb");
    assert_non_null(stream);
    assert_int_equal(fseek(stream, 0, SEEK_END), 0);
    *size = ftell(stream);
    rewind(stream);
    unsigned char *bytes = malloc((size_t)*size);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, (size_t)*size, stream), *size);
    fclose(stream);
    return bytes;
}

static void test_pictures(void **state)
{
    (void)state;
    static const unsigned char png[8] = {0x89, 'P', 'N', 'G', 0x0d, 0x0a, 0x1a, 0x0a};
    if (skip_without_browser()) return;
    long size[2];
    unsigned char *bytes[2] = {picture("light.png", light, &size[0]), picture("dark.png", dark, &size[1])};
    for (int i = 0; i < 2; i++) {
        assert_memory_equal(bytes[i], png, sizeof png);
        assert_int_equal(bytes[i][18] * 256 + bytes[i][19], 1366); /* IHDR's width */
        assert_true(size[i] > 50000);                              /* more than an empty page */
    }
    assert_true(size[0] != size[1] || memcmp(bytes[0], bytes[1], (size_t)size[0]) != 0);
    free(bytes[0]);
    free(bytes[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_self_contained),
        cmocka_unit_test(test_names_are_escaped),
        cmocka_unit_test(test_no_console_errors),
        cmocka_unit_test(test_tables_hold_the_numbers),
        cmocka_unit_test(test_layout),
        cmocka_unit_test(test_pictures),
    };
    return cmocka_run_group_tests_name("the report", tests, make_page, remove_page);
}
