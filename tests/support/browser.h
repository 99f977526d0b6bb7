#ifndef PINCH_TEST_BROWSER_H
#define PINCH_TEST_BROWSER_H

#include "support/program.h"

#include <jansson.h>
#include <stdbool.h>

/* Pages in a real browser without a window. All functions assert that they work. */

/* Without a browser the test is to be skipped, which this prints; unless PINCH_REQUIRE_BROWSER is set, as tests/run
 * does where the system has the package. */
bool browser_is_missing(void);
/* The same for the libraries that pages are made of. */
bool browser_libraries_are_missing(void);

/* Opens folder/name; `options` are further ones of the browser's, NULL at the end. */
program_result browser_open(const char *folder, const char *name, char *const *options);
/* The document after its scripts have run, for up to five seconds of their own time. Messages on the console are on
 * standard error, where they contain CONSOLE. */
program_result browser_document(const char *folder, const char *name, char *size, char *scheme);

/* Writes folder/name: the page `from` with a script at its end. What a script sees, tests read from the document. */
void browser_add_script(const char *folder, const char *from, const char *name, const char *script);
/* Runs a script in a page that has a viewer, once that is there, and returns the object `seen` that the script has
 * filled. The script may use q (one element), all (a list of them), key (presses one), slide (sets the time). */
json_t *browser_seen(const char *folder, const char *page, const char *script, char *size);
/* The same for several scripts, NULL at the end, one after the other in one opening of the page, which takes seconds.
 * None of them sees the others' constants. */
json_t *browser_seen_by(const char *folder, const char *page, const char *const *scripts, char *size);
/* The text of a page is a whole document that takes nothing from elsewhere. */
void browser_page_is_self_contained(const char *text);
/* A page with a viewer says nothing on the console in dark, and would have said an error; browser_seen looks in light.
 */
void browser_dark_viewer_has_no_errors(const char *folder, const char *page);
/* Removes a folder in which pages were opened: browsers leave folders of their own. */
void browser_remove_folder(char *folder);

extern char browser_laptop[], browser_narrow[], browser_light[], browser_dark[];

#endif
