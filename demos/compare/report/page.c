/* The report's page. What it says is made in the browser from the document's numbers (view/page/report.js); here they
 * are put together. */
#define _POSIX_C_SOURCE 200809L

#include "report.h"

#include "common/output.h"
#include "compare/access.h"
#include "view/page_texts.h"

#include <stdlib.h>

/* ---- A solver's error under its own law, and how far that law is from the scene's. ---- */

/* The largest difference between two answers over the sampled steps, of each step's force scale. An answer is a run's
 * name, or "exact". NAN where no step has both. */
static double largest_difference(const json_t *of_scene, const char *one, const char *other)
{
    const json_t *samples = json_object_get(of_scene, "samples");
    double largest = NAN;
    for (size_t i = 0; i < json_array_size(samples); i++) {
        const json_t *sample = json_array_get(samples, i), *contacts = json_object_get(sample, "contacts");
        double scale = access_number(sample, "force_scale");
        for (size_t k = 0; k < json_array_size(contacts) && scale > 0; k++) {
            const json_t *contact = json_array_get(contacts, k), *forces = json_object_get(contact, "forces");
            const json_t *exact = json_object_get(contact, "exact");
            const json_t *a = strcmp(one, "exact") == 0 ? exact : json_object_get(forces, one);
            const json_t *b = strcmp(other, "exact") == 0 ? exact : json_object_get(forces, other);
            double off = 0;
            for (size_t n = 0; n < 3; n++)
                off = hypot(off, access_value(json_array_get(a, n)) - access_value(json_array_get(b, n)));
            if (!isnan(off) && !(off / scale <= largest)) largest = off / scale;
        }
    }
    return largest;
}

/* Pinch's law is the scene's, of which the exact answer is known. ODE's law is solved directly by worldstep, from the
 * same contacts: what quickstep misses of that is its own error, and what worldstep's answer differs from the exact one
 * is the difference of the laws. */
static void add_errors(const json_t *of_scene, const json_t *run, json_t *entry)
{
    const char *solver = access_text(run, "contact_solver"), *name = access_text(run, "run");
    bool pinch = strcmp(solver, "pinch") == 0, direct = strcmp(solver, "worldstep") == 0;
    double own = pinch    ? access_metric(run, METRIC_FORCE_ERROR_MAX)
                 : direct ? NAN
                          : largest_difference(of_scene, name, "worldstep");
    double model = pinch ? NAN : largest_difference(of_scene, "worldstep", "exact");
    json_object_set_new(entry, "own_error", json_number(own));
    json_object_set_new(entry, "model_difference", json_number(model));
}

/* ---- The page's data. ---- */

/* A copy of an object with these keys of it; NULL ends them. */
static json_t *part_of(const json_t *object, const char *const *keys)
{
    json_t *part = json_object();
    for (; *keys; keys++) {
        json_t *value = json_object_get(object, *keys);
        if (value) json_object_set(part, *keys, value);
    }
    return part;
}

/* The scene at its last sampled step, or where no step was sampled the frame of its film. */
static json_t *thumbnail(const json_t *of_scene)
{
    char *text = NULL;
    size_t size;
    FILE *stream = open_memstream(&text, &size);
    if (!stream) return json_null();
    picture_write_thumbnail(of_scene, stream);
    json_t *value = fclose(stream) != 0 ? json_null() : json_string(size ? text : access_text(of_scene, "thumb"));
    free(text);
    return value;
}

static json_t *scene_data(const json_t *of_scene)
{
    static const char *const of_page[] = {"name", "steps", "time_s", "step_s", "contacts", "films", NULL};
    static const char *const of_run[] = {"run",     "contact_solver", "quickstep_iterations", "status",
                                         "metrics", "events",         "not_expressed",        NULL};
    json_t *entry = part_of(of_scene, of_page), *list = json_array();
    const json_t *runs = json_object_get(of_scene, "runs");
    for (size_t k = 0; k < json_array_size(runs); k++) {
        const json_t *run = json_array_get(runs, k);
        json_t *part = part_of(run, of_run);
        add_errors(of_scene, run, part);
        json_array_append_new(list, part);
    }
    json_object_set_new(entry, "runs", list);
    json_object_set_new(entry, "thumb", thumbnail(of_scene));
    return entry;
}

static json_t *metrics_data(void)
{
    json_t *list = json_array();
    for (int m = 0; m < METRIC_COUNT; m++) {
        const metric_info *about = metric_about((metric)m);
        json_array_append_new(list, json_pack("{s:s, s:s, s:s, s:s}", "key", about->key, "unit", about->unit, "label",
                                              about->label, "about", about->about));
    }
    return list;
}

void report_write(const json_t *document, const page_libraries *libraries, FILE *stream)
{
    const json_t *scenes = json_object_get(document, "scenes");
    json_t *data = json_pack("{s:o, s:O?, s:[]}", "metrics", metrics_data(), "check",
                             json_object_get(document, "check"), "scenes");
    for (size_t i = 0; i < json_array_size(scenes); i++)
        json_array_append_new(json_object_get(data, "scenes"), scene_data(json_array_get(scenes, i)));
    page_begin(libraries, "Pinch beside quickstep and worldstep", view_report_css, stream);
    fputs("<header><h1>Pinch beside quickstep and worldstep</h1></header>\n<main id=\"report-page\">"
          "<noscript>The report is shown by scripts, which this browser does not run.</noscript></main>\n",
          stream);
    page_data("report", data, stream);
    page_end(libraries, (const char *const[]){view_report_js, NULL}, stream);
    json_decref(data);
}
