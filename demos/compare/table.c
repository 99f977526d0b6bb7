#include "table.h"

#include "access.h"

#include <math.h>
#include <stdbool.h>

static const char *or_dash(double value, const char *format, char text[32])
{
    if (isnan(value))
        snprintf(text, 32, "-");
    else
        snprintf(text, 32, format, value); /* formats are this file's own */
    return text;
}

/* Pinch, the first of quickstep's runs, worldstep: more do not fit a terminal. */
static json_t *runs_to_show(const json_t *scene)
{
    const json_t *runs = json_object_get(scene, "runs");
    json_t *shown = json_array();
    bool quick = false;
    for (size_t k = 0; k < json_array_size(runs); k++) {
        json_t *run = json_array_get(runs, k);
        bool is_quick = json_is_integer(json_object_get(run, "quickstep_iterations"));
        if (!(is_quick && quick)) (void)json_array_append(shown, run);
        quick = quick || is_quick;
    }
    return shown;
}

static void print_fingers(const json_t *scene, FILE *stream)
{
    json_t *runs = runs_to_show(scene);
    size_t fingers = json_array_size(json_object_get(json_array_get(runs, 0), "fingers"));
    fprintf(stream, "  %-14s", "finger");
    for (size_t k = 0; k < json_array_size(runs); k++)
        fprintf(stream, " | %-24s %8s", access_text(json_array_get(runs, k), "run"), "slip um");
    fputc('\n', stream);
    for (size_t i = 0; i < fingers; i++) {
        const json_t *first = json_array_get(json_object_get(json_array_get(runs, 0), "fingers"), i);
        fprintf(stream, "  %-14.14s", access_text(first, "name"));
        for (size_t k = 0; k < json_array_size(runs); k++) {
            const json_t *f = json_array_get(json_object_get(json_array_get(runs, k), "fingers"), i);
            fprintf(stream, " | %-5s %9.4f %8.4f %8.3g", access_text(f, "state"), access_number(f, "normal_force"),
                    access_number(f, "tangential_force"), 1e6 * access_number(f, "slip"));
        }
        fputc('\n', stream);
    }
    json_decref(runs);
}

static void print_run(const json_t *run, FILE *stream)
{
    char text[8][32];
    const json_t *verified = json_object_get(json_object_get(run, "metrics"), "verified");
    fprintf(stream, "  %-16s %10s %10s %10s %12.6g %10.3g %10.3g %9s %9s %8s%s\n", access_text(run, "run"),
            or_dash(access_metric(run, METRIC_FORCE_ERROR_MAX), "%.2g", text[0]),
            or_dash(access_metric(run, METRIC_FORCE_ERROR_MEDIAN), "%.2g", text[1]),
            or_dash(access_metric(run, METRIC_FORCE_JITTER), "%.2g", text[2]),
            1e3 * access_metric(run, METRIC_DISPLACEMENT), 1e6 * access_metric(run, METRIC_CREEP),
            1e3 * access_metric(run, METRIC_CREEP_ANGULAR),
            or_dash(access_metric(run, METRIC_MOMENTUM_ERROR), "%.1e", text[3]),
            json_is_boolean(verified) ? (json_is_true(verified) ? "yes" : "no") : "-",
            or_dash(access_metric(run, METRIC_COST), "%.2f", text[4]),
            access_metric(run, METRIC_DROPPED) > 0 ? "  dropped" : "");
}

void table_scene(const json_t *scene, FILE *stream)
{
    const json_t *runs = json_object_get(scene, "runs");
    double ratio = access_number(scene, "cost_ratio");
    fprintf(stream, "%s: %g s, %.0f steps; at the end, normal and tangential forces in N:\n",
            access_text(scene, "name"), access_number(scene, "time_s"), access_number(scene, "steps"));
    print_fingers(scene, stream);
    fprintf(stream, "  %-16s %10s %10s %10s %12s %10s %10s %9s %9s %8s\n", "", "force err.", "median", "jitter N",
            "moved mm", "creep um/s", "mrad/s", "balance N", "verified", "us/step");
    for (size_t k = 0; k < json_array_size(runs); k++) print_run(json_array_get(runs, k), stream);
    if (!isnan(ratio)) fprintf(stream, "  a step with Pinch costs %.2f times the fastest of ODE's\n", ratio);
    fputc('\n', stream);
}

/* All scenes have the same runs. */
void table_summary(const json_t *scenes, FILE *stream)
{
    const json_t *head = json_object_get(json_array_get(scenes, 0), "runs");
    fprintf(stream, "largest force error against the exact step, over the force scale; * dropped\n  %-22s", "scene");
    for (size_t k = 0; k < json_array_size(head); k++)
        fprintf(stream, " %14s", access_text(json_array_get(head, k), "run"));
    fputc('\n', stream);
    for (size_t i = 0; i < json_array_size(scenes); i++) {
        const json_t *scene = json_array_get(scenes, i), *runs = json_object_get(scene, "runs");
        fprintf(stream, "  %-22.22s", access_text(scene, "name"));
        for (size_t k = 0; k < json_array_size(runs); k++) {
            char text[32];
            const json_t *run = json_array_get(runs, k);
            fprintf(stream, " %13s%s", or_dash(access_metric(run, METRIC_FORCE_ERROR_MAX), "%.2g", text),
                    access_metric(run, METRIC_DROPPED) > 0 ? "*" : " ");
        }
        fputc('\n', stream);
    }
}
