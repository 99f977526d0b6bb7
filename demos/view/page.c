#include "page.h"

#include "page_texts.h"

#include <stdlib.h>
#include <string.h>

/* ---- The libraries. ---- */

enum { THREE = 0, CONTROLS, DYGRAPHS, DYGRAPHS_SHEET, LIBRARY_COUNT };

static const struct {
    const char *file, *package;
} libraries_known[LIBRARY_COUNT] = {
    [THREE] = {"three/three.min.js", "libjs-three"},
    [CONTROLS] = {"three/examples/js/controls/OrbitControls.js", "libjs-three"},
    [DYGRAPHS] = {"dygraphs/dygraph.min.js", "libjs-dygraphs"},
    [DYGRAPHS_SHEET] = {"dygraphs/dygraph.min.css", "libjs-dygraphs"},
};

struct page_libraries {
    char *texts[LIBRARY_COUNT];
};

static char *read_text(const char *path)
{
    FILE *stream = fopen(path, "rb");
    if (!stream) return NULL;
    char *text = NULL;
    long size = fseek(stream, 0, SEEK_END) == 0 ? ftell(stream) : -1;
    if (size > 0 && fseek(stream, 0, SEEK_SET) == 0) text = malloc((size_t)size + 1);
    if (text) {
        text[size] = '\0';
        if (fread(text, 1, (size_t)size, stream) != (size_t)size) {
            free(text);
            text = NULL;
        }
    }
    fclose(stream);
    return text;
}

command_status page_libraries_load(const char *name, page_libraries **libraries)
{
    const char *folder = getenv("PINCH_JAVASCRIPT");
    if (!folder || !*folder) folder = "/usr/share/javascript";
    page_libraries *l = calloc(1, sizeof *l);
    *libraries = NULL;
    if (!l) {
        command_error(name, "out of memory");
        return COMMAND_SYSTEM;
    }
    for (int i = 0; i < LIBRARY_COUNT; i++) {
        char path[4096];
        int length = snprintf(path, sizeof path, "%s/%s", folder, libraries_known[i].file);
        if (length > 0 && (size_t)length < sizeof path) l->texts[i] = read_text(path);
        if (l->texts[i]) continue;
        command_error(name, "the page needs %s, which cannot be read: install the package %s", path,
                      libraries_known[i].package);
        page_libraries_free(l);
        return COMMAND_SYSTEM;
    }
    *libraries = l;
    return COMMAND_DONE;
}

void page_libraries_free(page_libraries *l)
{
    for (int i = 0; l && i < LIBRARY_COUNT; i++) free(l->texts[i]);
    free(l);
}

/* ---- The parts of a page. ---- */

void page_text(const char *text, FILE *stream)
{
    for (; *text; text++) {
        switch (*text) {
        case '&':
            fputs("&amp;", stream);
            break;
        case '<':
            fputs("&lt;", stream);
            break;
        case '>':
            fputs("&gt;", stream);
            break;
        case '"':
            fputs("&quot;", stream);
            break;
        case '\'':
            fputs("&#39;", stream);
            break;
        default:
            if ((unsigned char)*text >= ' ' && *text != 127) fputc(*text, stream);
        }
    }
}

/* A script must not contain the end of its own element. In strings and comments, which is where it could stand, a
 * backslash before the slash changes nothing. */
static void write_script(const char *text, FILE *stream)
{
    fputs("<script>\n", stream);
    for (const char *end; (end = strstr(text, "</script")) != NULL; text = end + 2) {
        fwrite(text, 1, (size_t)(end - text), stream);
        fputs("<\\/", stream);
    }
    fputs(text, stream);
    fputs("\n</script>\n", stream);
}

void page_begin(const page_libraries *l, const char *title, const char *sheet, FILE *stream)
{
    fputs("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
          "content=\"width=device-width, initial-scale=1\"><title>",
          stream);
    page_text(title, stream);
    fputs("</title><link rel=\"icon\" href=\"data:,\"><style>\n", stream);
    fputs(l->texts[DYGRAPHS_SHEET], stream);
    fputs(view_style_css, stream);
    fputs(sheet, stream);
    fputs("</style></head><body>\n", stream);
}

/* In JSON a < stands in strings only, where its number does as well. */
void page_data(const char *id, const json_t *document, FILE *stream)
{
    char *text = json_dumps(document, JSON_COMPACT);
    fprintf(stream, "<script type=\"application/json\" id=\"%s\">", id);
    for (const char *c = text ? text : "null"; *c; c++) {
        if (*c == '<')
            fputs("\\u003c", stream);
        else
            fputc(*c, stream);
    }
    fputs("</script>\n", stream);
    free(text);
}

void page_end(const page_libraries *l, const char *const *scripts, FILE *stream)
{
    const char *const own[] = {l->texts[THREE], l->texts[CONTROLS], l->texts[DYGRAPHS], view_film_js,
                               view_stage_js,   view_charts_js,     view_viewer_js,     NULL};
    for (const char *const *text = own; *text; text++) write_script(*text, stream);
    for (; *scripts; scripts++) write_script(*scripts, stream);
    fputs("</body></html>\n", stream);
}

/* ---- The page of a run. ---- */

bool page_write_run(const page_libraries *libraries, const page_run *run, const page_run *ghost, FILE *stream)
{
    json_t *main_film = page_film(run->film, true), *ghost_film = ghost ? page_film(ghost->film, false) : json_null();
    bool done = main_film && ghost_film;
    if (done) {
        json_t *all = json_pack("{s:O, s:O, s:O, s:O}", "run", run->document, "ghost_run",
                                ghost ? ghost->document : json_null(), "film", main_film, "ghost", ghost_film);
        const scene *s = run->film->scene;
        page_begin(libraries, s->name, "", stream);
        fputs("<header><h1>", stream);
        page_text(s->name, stream);
        fprintf(stream, "</h1><p class=\"note\">%.6g&nbsp;s in steps of %.4g&nbsp;ms, contacts by %s. ",
                run->film->frames[run->film->frame_count - 1].time, 1e3 * s->step,
                world_solver_name(run->film->solver));
        page_text(s->source, stream);
        fputs("</p></header>\n<main><section class=\"answers\" id=\"answers\"></section>\n"
              "<section id=\"view\"></section></main>\n",
              stream);
        page_data("film", all, stream);
        page_end(libraries, (const char *const[]){view_run_js, NULL}, stream);
        json_decref(all);
    }
    json_decref(main_film);
    json_decref(ghost_film);
    return done;
}
