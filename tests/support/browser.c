#define _POSIX_C_SOURCE 200809L

#include "support/browser.h"

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
