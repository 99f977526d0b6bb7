#ifndef PINCH_VIEW_PAGE_H
#define PINCH_VIEW_PAGE_H

#include "film.h"

#include "common/command_status.h"

#include <jansson.h>
#include <stdio.h>

/*
 * Pages with the viewer: one HTML file that works without network. The libraries that draw (three.js, dygraphs) are
 * Debian's packages libjs-three and libjs-dygraphs, read when a page is written and put into it. They are looked for in
 * /usr/share/javascript, or in the folder that the environment variable PINCH_JAVASCRIPT names.
 */

/* The libraries' texts. */
typedef struct page_libraries page_libraries;

/* Reads the libraries. Where one is missing, a message of the command `name` says which package has it, and
 * *libraries is NULL; COMMAND_SYSTEM. Call it before a long run. */
command_status page_libraries_load(const char *name, page_libraries **libraries);
void page_libraries_free(page_libraries *libraries); /* NULL is fine */

/* A film as the page reads it (page/film.js): a description, with all numbers packed in its member "data". Without
 * `meshes` it is a ghost, which borrows them from another film of the same scene. NULL when memory runs out. */
json_t *page_film(const film *f, bool meshes);

/* The page's own parts, in this order. `sheet` and `scripts` (ends with NULL) are further texts of its own.
 * page_data writes a JSON document where scripts find it by its id. */
void page_begin(const page_libraries *libraries, const char *title, const char *sheet, FILE *stream);
void page_data(const char *id, const json_t *document, FILE *stream);
void page_end(const page_libraries *libraries, const char *const *scripts, FILE *stream);

/* Writes a text as HTML shows it: & < > " ' are escaped, control characters left out. */
void page_text(const char *text, FILE *stream);

/* A run and what `pinch run --json` prints of it. */
typedef struct page_run {
    film *film;
    json_t *document;
} page_run;

/* Writes the page of a run: five answers, and the viewer. `ghost` is another run of the scene, shown beside it; NULL:
 * none. Returns false when memory runs out. */
bool page_write_run(const page_libraries *libraries, const page_run *run, const page_run *ghost, FILE *stream);

#endif
