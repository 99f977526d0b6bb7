#define _POSIX_C_SOURCE 200809L

#include "support/browser.h"
#include "support/sanitized.h"

#include "support/cmocka_all.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

char browser_laptop[] = "--window-size=1366,2200", browser_narrow[] = "--window-size=520,2200",
     browser_light[] = "--blink-settings=preferredColorScheme=1",
     browser_dark[] = "--blink-settings=preferredColorScheme=0";

static char *browser(void)
{
    static char *const places[] = {"/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++)
        if (access(places[i], X_OK) == 0) return places[i];
    return NULL;
}

static bool missing(bool there, const char *what)
{
    const char *required = getenv("PINCH_REQUIRE_BROWSER");
    if (there) return false;
    if (required && *required) fail_msg("not installed: %s", what);
    print_message("not installed: %s; not tested\n", what);
    return true;
}

bool browser_is_missing(void)
{
    if (SANITIZED) return true; /* the pages are the same bytes, and the browser has no sanitizers */
    return missing(browser() != NULL, "chromium");
}

bool browser_libraries_are_missing(void)
{
    return missing(access("/usr/share/javascript/three/three.min.js", R_OK) == 0 &&
                       access("/usr/share/javascript/dygraphs/dygraph.min.js", R_OK) == 0,
                   "libjs-three, libjs-dygraphs");
}

program_result browser_open(const char *folder, const char *name, char *const *options)
{
    char profile[600], address[600], headless[] = "--headless", sandbox[] = "--no-sandbox",
                                     bars[] = "--hide-scrollbars", logging[] = "--enable-logging=stderr",
                                     shm[] = "--disable-dev-shm-usage", angle[] = "--use-angle=swiftshader",
                                     software[] = "--enable-unsafe-swiftshader";
    snprintf(profile, sizeof profile, "--user-data-dir=%s/profile", folder);
    snprintf(address, sizeof address, "file://%s/%s", folder, name);
    char *argv[24] = {browser(), headless, sandbox, bars, logging, shm, angle, software, profile};
    int count = 9;
    while (*options && count < 22) argv[count++] = *options++;
    argv[count] = address;
    program_result r = program_run(folder, argv);
    if (r.status != 0) fail_msg("%s ended with %d: %.2000s", browser(), r.status, r.err);
    return r;
}

program_result browser_document(const char *folder, const char *name, char *size, char *scheme)
{
    char dump[] = "--dump-dom", wait[] = "--virtual-time-budget=5000";
    return browser_open(folder, name, (char *const[]){size, scheme, wait, dump, NULL});
}

void browser_add_script(const char *folder, const char *from, const char *name, const char *script)
{
    char path[600];
    snprintf(path, sizeof path, "%s/%s", folder, from);
    char *page = program_read_file(path), *end = NULL;
    for (char *found = page; (found = strstr(found, "</body>")); found++) end = found;
    assert_non_null(end);
    *end = '\0';
    char *text = malloc(strlen(page) + strlen(script) + 64);
    assert_non_null(text);
    sprintf(text, "%s<script>%s</script></body></html>", page, script);
    free(program_write_file(folder, name, text));
    free(text);
    free(page);
}

void browser_remove_folder(char *folder)
{
    char command[600];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    assert_int_equal(system(command), 0);
    free(folder);
}

json_t *browser_seen(const char *folder, const char *page, const char *script, char *size)
{
    return browser_seen_by(folder, page, (const char *const[]){script, NULL}, size);
}

json_t *browser_seen_by(const char *folder, const char *page, const char *const *scripts, char *size)
{
    static const char before[] =
        "(async()=>{while(!(window.viewer&&viewer.film))await new Promise(r=>setTimeout(r,20));const seen={};"
        "const q=s=>document.querySelector(s),all=s=>[...document.querySelectorAll(s)];"
        "const key=(k,o={})=>(document.activeElement||document.body).dispatchEvent(new "
        "KeyboardEvent('keydown',{key:k,bubbles:true,cancelable:true,...o}));"
        "const slide=t=>{q('input[type=range]').value=t;"
        "q('input[type=range]').dispatchEvent(new Event('input'));};";
    static const char after[] =
        "document.body.dataset.seen=btoa(unescape(encodeURIComponent(JSON.stringify(seen))));})();";
    char text[16384];
    int length_of = snprintf(text, sizeof text, "%s", before);
    for (; *scripts; scripts++)
        length_of += snprintf(text + length_of, sizeof text - (size_t)length_of, "{%s}", *scripts);
    length_of += snprintf(text + length_of, sizeof text - (size_t)length_of, "%s", after);
    assert_true((size_t)length_of < sizeof text);
    browser_add_script(folder, page, "seen.html", text);
    program_result r = browser_document(folder, "seen.html", size, browser_light);
    if (strstr(r.err, "CONSOLE")) fail_msg("%.2000s", strstr(r.err, "CONSOLE"));
    const char *start = strstr(r.out, "data-seen=\"");
    assert_non_null(start);
    start += strlen("data-seen=\"");
    /* base64 keeps quotes and names out of the attribute */
    char *decoded = malloc(strlen(start));
    assert_non_null(decoded);
    size_t length = 0;
    unsigned word = 0, bits = 0;
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (const char *c = start; *c != '"' && *c != '='; c++) {
        const char *digit = strchr(digits, *c);
        assert_non_null(digit);
        word = word << 6 | (unsigned)(digit - digits);
        bits += 6;
        if (bits < 8) continue;
        bits -= 8;
        decoded[length++] = (char)(word >> bits & 255u);
    }
    json_t *seen = json_loadb(decoded, length, 0, NULL);
    assert_non_null(seen);
    free(decoded);
    program_free(&r);
    return seen;
}

void browser_page_is_self_contained(const char *page)
{
    static const char *const outside[] = {"<script src", "<link rel=\"style", "@import", "url(h", "<img"};
    for (size_t i = 0; i < sizeof outside / sizeof *outside; i++) assert_null(strstr(page, outside[i]));
    assert_true(strncmp(page, "<!DOCTYPE html>\n<html lang=\"en\">", 32) == 0);
}

void browser_dark_viewer_has_no_errors(const char *folder, const char *page)
{
    program_result r = browser_document(folder, page, browser_laptop, browser_dark);
    if (strstr(r.err, "CONSOLE")) fail_msg("%.2000s", strstr(r.err, "CONSOLE"));
    assert_non_null(strstr(r.out, "class=\"readout\""));
    program_free(&r);
    /* an error would have been seen */
    free(program_write_file(folder, "wrong.html", "<!DOCTYPE html><body><script>undefinedFunction();</script></body>"));
    r = browser_document(folder, "wrong.html", browser_laptop, browser_light);
    assert_non_null(strstr(r.err, "CONSOLE"));
    program_free(&r);
}
