#include "bars.h"

#include "compare/access.h"
#include "html.h"

enum { WIDTH = 360, NAME = 92, END = 350, ROW = 26 };
enum { SMALLEST = -17, LARGEST = 1, DECADES = LARGEST - SMALLEST }; /* of an error, as powers of ten */

static void begin(const char *title, const char *what, int height, FILE *stream)
{
    fprintf(stream,
            "<figure class=\"chart\"><figcaption>%s</figcaption><svg viewBox=\"0 0 %d %d\" role=\"img\" "
            "aria-label=\"%s\">\n",
            title, WIDTH, height, what);
}

static void write_name(const json_t *run, int y, FILE *stream)
{
    fprintf(stream, "<text x=\"%d\" y=\"%d\" class=\"end\">", NAME - 6, y);
    html_text(access_text(run, "run"), stream);
    fputs("</text>\n", stream);
}

void bars_cost(const json_t *of_scene, FILE *stream)
{
    const json_t *runs = json_object_get(of_scene, "runs");
    int count = (int)json_array_size(runs);
    double most = 0;
    for (int k = 0; k < count; k++) most = fmax(most, access_metric(json_array_get(runs, (size_t)k), METRIC_COST));
    begin("Cost of a step, &micro;s", "What a step costs with each solver", ROW * count + 8, stream);
    for (int k = 0; k < count; k++) {
        const json_t *run = json_array_get(runs, (size_t)k);
        double cost = access_metric(run, METRIC_COST), width = most > 0 ? (END - NAME - 50) * cost / most : 0;
        write_name(run, ROW * k + 20, stream);
        if (isnan(cost)) continue;
        fprintf(stream,
                "<rect class=\"bar %s\" x=\"%d\" y=\"%d\" width=\"%.1f\" height=\"%d\"/><text x=\"%.1f\" y=\"%d\">",
                html_run_class((size_t)k), NAME, ROW * k + 7, fmax(width, 1), ROW - 8, NAME + width + 5, ROW * k + 20);
        fprintf(stream, "%.3g</text>\n", cost);
    }
    fputs("</svg></figure>\n", stream);
}

/* A run's errors by decades; errors of 0 count as the smallest. */
static int count_errors(const json_t *of_scene, const char *run, int counts[DECADES])
{
    const json_t *samples = json_object_get(of_scene, "samples");
    int most = 0;
    memset(counts, 0, DECADES * sizeof *counts);
    for (size_t i = 0; i < json_array_size(samples); i++) {
        const json_t *contacts = json_object_get(json_array_get(samples, i), "contacts");
        for (size_t k = 0; k < json_array_size(contacts); k++) {
            double error = access_number(json_object_get(json_array_get(contacts, k), "errors"), run);
            if (isnan(error)) continue;
            int decade = error > 0 ? (int)floor(log10(error)) - SMALLEST : 0;
            decade = decade < 0 ? 0 : decade >= DECADES ? DECADES - 1 : decade;
            counts[decade]++;
            if (counts[decade] > most) most = counts[decade];
        }
    }
    return most;
}

static void write_row(const int counts[DECADES], int most, int y, size_t run, FILE *stream)
{
    double width = (double)(END - NAME) / DECADES;
    fprintf(stream, "<path class=\"grid\" d=\"M%d %dH%d\"/>\n", NAME, y, END);
    for (int d = 0; d < DECADES; d++) {
        if (counts[d] == 0) continue;
        double height = fmax(2, (ROW - 6.0) * counts[d] / most);
        fprintf(stream,
                "<rect class=\"bar %s\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"><title>%d contacts</title>"
                "</rect>\n",
                html_run_class(run), NAME + d * width + 0.5, y - height, width - 1, height, counts[d]);
    }
}

void bars_errors(const json_t *of_scene, FILE *stream)
{
    const json_t *runs = json_object_get(of_scene, "runs");
    int count = (int)json_array_size(runs), bottom = ROW * count + 4;
    begin("Force errors of the contacts, over the force scale", "Histogram of force errors for each solver",
          bottom + 32, stream);
    for (int k = 0; k < count; k++) {
        const json_t *run = json_array_get(runs, (size_t)k);
        int counts[DECADES], most = count_errors(of_scene, access_text(run, "run"), counts);
        write_name(run, ROW * k + 22, stream);
        write_row(counts, most > 0 ? most : 1, ROW * (k + 1), (size_t)k, stream);
    }
    for (int e = SMALLEST + 1; e <= 0; e += 4) {
        double x = NAME + (double)(END - NAME) * (e - SMALLEST) / DECADES;
        fprintf(stream,
                "<path class=\"grid\" d=\"M%.1f 4V%d\"/><text x=\"%.1f\" y=\"%d\" class=\"mid\">10<tspan dy=\"-4\" "
                "class=\"power\">%s%d</tspan></text>\n",
                x, bottom, x, bottom + 15, e < 0 ? "&minus;" : "", e < 0 ? -e : e);
    }
    fputs("</svg></figure>\n", stream);
}
