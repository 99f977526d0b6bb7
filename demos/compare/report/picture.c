#include "report.h"

#include "common/vector.h"
#include "compare/access.h"

#include <stdlib.h>

enum { SIDE = 360, CIRCLE = 32 };

/* A view of the scene from one side, and how much of it is shown. */
typedef struct view {
    int axes[2];
    double centre[2], size; /* m: half of the picture's width */
    bool pushing;           /* arrows end at their contacts, as pushes; otherwise they begin there */
} view;

const char *picture_run_class(size_t run)
{
    static const char *const classes[] = {"s0", "s1", "s2", "s3", "s4", "s5", "s6", "s7", "s8", "s9"};
    return classes[run % 10];
}

static void vector_at(const json_t *list, double v[3])
{
    for (size_t i = 0; i < 3; i++) v[i] = access_value(json_array_get(list, i));
}

static void project(const view *v, const double point[3], double place[2])
{
    place[0] = SIDE / 2.0 * (1 + (point[v->axes[0]] - v->centre[0]) / v->size);
    place[1] = SIDE / 2.0 * (1 - (point[v->axes[1]] - v->centre[1]) / v->size);
}

static void write_outline(const view *v, const json_t *outline, FILE *stream)
{
    const json_t *points = json_object_get(outline, "points");
    fprintf(stream, "<path class=\"%s\" d=\"", access_text(outline, "kind"));
    for (size_t i = 0; i < json_array_size(points); i++) {
        const json_t *point = json_array_get(points, i);
        double at[3] = {0}, place[2];
        at[v->axes[0]] = access_value(json_array_get(point, 0));
        at[v->axes[1]] = access_value(json_array_get(point, 1));
        project(v, at, place);
        for (int k = 0; k < 2; k++) place[k] = fmin(fmax(place[k], -9999), 9999);
        fprintf(stream, "%s%.1f %.1f", i ? "L" : "M", place[0], place[1]);
    }
    fputs("Z\"><title>", stream);
    page_text(access_text(outline, "name"), stream);
    fputs("</title></path>\n", stream);
}

static int left_to_right(const void *a, const void *b)
{
    const double *p = a, *q = b;
    if (p[0] != q[0]) return (p[0] > q[0]) - (p[0] < q[0]);
    return (p[1] > q[1]) - (p[1] < q[1]);
}

static double turn(const double *a, const double *b, const double *c)
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* The convex hull by monotone chains. The points are sorted in place; `hull` has room for twice as many. */
static int convex_hull(double (*points)[2], int count, double (*hull)[2])
{
    int n = 0;
    qsort(points, (size_t)count, sizeof *points, left_to_right);
    for (int pass = 0; pass < 2; pass++) {
        int start = n;
        for (int k = 0; k < count; k++) {
            const double *p = points[pass ? count - 1 - k : k];
            while (n - start >= 2 && turn(hull[n - 2], hull[n - 1], p) <= 0) n--;
            memcpy(hull[n++], p, sizeof *hull);
        }
        n--;
    }
    return n;
}

/* The friction cone has its tip at the contact and its axis along the normal; it is `length` (m) high. */
static void write_cone(const view *v, const double *position, const double *normal, double friction, double length,
                       FILE *stream)
{
    double points[CIRCLE + 1][2], hull[2 * CIRCLE + 4][2], t1[3], t2[3];
    int least = fabs(normal[0]) < fabs(normal[1]) ? 0 : 1;
    if (fabs(normal[2]) < fabs(normal[least])) least = 2;
    double size = sqrt(1 - normal[least] * normal[least]);
    for (int i = 0; i < 3; i++) t1[i] = ((i == least) - normal[least] * normal[i]) / size;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        t2[i] = normal[j] * t1[k] - normal[k] * t1[j];
    }
    project(v, position, points[CIRCLE]);
    for (int c = 0; c < CIRCLE; c++) {
        double angle = 2 * SCENE_PI * c / CIRCLE, at[3];
        for (int i = 0; i < 3; i++)
            at[i] = position[i] + length * (normal[i] + friction * (cos(angle) * t1[i] + sin(angle) * t2[i]));
        project(v, at, points[c]);
    }
    int corners = convex_hull(points, CIRCLE + 1, hull);
    fputs("<path class=\"cone\" d=\"", stream);
    for (int i = 0; i < corners; i++) fprintf(stream, "%s%.1f %.1f", i ? "L" : "M", hull[i][0], hull[i][1]);
    fputs("Z\"/>\n", stream);
}

/* A force on the object as an arrow at its contact. */
static void write_arrow(const view *v, const double *position, const double *force, double metres_per_newton,
                        const char *class, FILE *stream)
{
    double tip[3], from[2], to[2];
    for (int i = 0; i < 3; i++) tip[i] = position[i] + (v->pushing ? -1 : 1) * metres_per_newton * force[i];
    project(v, position, v->pushing ? to : from);
    project(v, tip, v->pushing ? from : to);
    double length = hypot(to[0] - from[0], to[1] - from[1]);
    if (!(length >= 1) || length > 5000) return;
    double along[2] = {(to[0] - from[0]) / length, (to[1] - from[1]) / length}, head = fmin(9, 0.5 * length);
    fprintf(stream, "<path class=\"arrow %s\" d=\"M%.1f %.1fL%.1f %.1fM%.1f %.1fL%.1f %.1fL%.1f %.1f\"/>\n", class,
            from[0], from[1], to[0], to[1], to[0] - head * (along[0] - 0.4 * along[1]),
            to[1] - head * (along[1] + 0.4 * along[0]), to[0], to[1], to[0] - head * (along[0] + 0.4 * along[1]),
            to[1] - head * (along[1] - 0.4 * along[0]));
}

static double length_of(const double *v)
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static double largest_force(const json_t *contacts)
{
    double largest = 0, force[3];
    for (size_t i = 0; i < json_array_size(contacts); i++) {
        vector_at(json_object_get(json_array_get(contacts, i), "exact"), force);
        largest = fmax(largest, length_of(force));
    }
    return largest;
}

static void write_contacts(const view *v, const json_t *of_scene, const json_t *contacts, FILE *stream)
{
    const json_t *peer = json_array_get(json_object_get(of_scene, "runs"), 1);
    double largest = largest_force(contacts);
    for (size_t i = 0; i < json_array_size(contacts); i++) {
        const json_t *contact = json_array_get(contacts, i);
        double position[3], normal[3], force[3], friction = access_number(contact, "friction");
        vector_at(json_object_get(contact, "position"), position);
        vector_at(json_object_get(contact, "normal"), normal);
        if (friction > 0) write_cone(v, position, normal, fmin(friction, 2), 0.18 * v->size, stream);
        if (!(largest > 0)) continue;
        if (peer) {
            vector_at(json_object_get(json_object_get(contact, "forces"), access_text(peer, "run")), force);
            write_arrow(v, position, force, 0.5 * v->size / largest, picture_run_class(1), stream);
        }
        vector_at(json_object_get(json_object_get(contact, "forces"), "pinch"), force);
        write_arrow(v, position, force, 0.5 * v->size / largest, picture_run_class(0), stream);
    }
}

static const json_t *drawn_sample(const json_t *of_scene, const json_t *drawing)
{
    const json_t *samples = json_object_get(of_scene, "samples");
    for (size_t i = 0; i < json_array_size(samples); i++) {
        const json_t *sample = json_array_get(samples, i);
        if (access_number(sample, "step") == access_number(drawing, "step")) return sample;
    }
    return NULL;
}

static view view_of(const json_t *entry)
{
    view v = {.size = access_number(entry, "size")};
    for (size_t i = 0; i < 2; i++) {
        v.axes[i] = (int)access_value(json_array_get(json_object_get(entry, "axes"), i));
        v.centre[i] = access_value(json_array_get(json_object_get(entry, "centre"), i));
    }
    return v;
}

static void draw_view(const json_t *of_scene, const json_t *drawing, const json_t *entry, const view *v, FILE *stream)
{
    static const char *const back_to_front[] = {"environment", "finger", "object"};
    const json_t *outlines = json_object_get(entry, "outlines");
    for (int layer = 0; layer < 3; layer++)
        for (size_t i = 0; i < json_array_size(outlines); i++)
            if (strcmp(access_text(json_array_get(outlines, i), "kind"), back_to_front[layer]) == 0)
                write_outline(v, json_array_get(outlines, i), stream);
    const json_t *sample = drawn_sample(of_scene, drawing);
    write_contacts(v, of_scene, json_object_get(sample, "contacts"), stream);
}

/* The view that shows most of the forces. */
static const json_t *best_view(const json_t *of_scene, const json_t *drawing)
{
    const json_t *views = json_object_get(drawing, "views"), *best = NULL;
    const json_t *contacts = json_object_get(drawn_sample(of_scene, drawing), "contacts");
    double most = -1;
    for (size_t i = 0; i < json_array_size(views); i++) {
        const view v = view_of(json_array_get(views, i));
        double shown = 0, force[3];
        for (size_t k = 0; k < json_array_size(contacts); k++) {
            vector_at(json_object_get(json_array_get(contacts, k), "exact"), force);
            shown += hypot(force[v.axes[0]], force[v.axes[1]]);
        }
        if (shown <= most) continue;
        most = shown;
        best = json_array_get(views, i);
    }
    return best;
}

void picture_write_thumbnail(const json_t *of_scene, FILE *stream)
{
    const json_t *drawing = json_object_get(of_scene, "drawing"), *entry = best_view(of_scene, drawing);
    if (!entry) return;
    view v = view_of(entry);
    v.size = fmin(v.size, 1.6 * access_number(of_scene, "radius"));
    fprintf(stream, "<svg viewBox=\"0 0 %d %d\" aria-hidden=\"true\">", SIDE, SIDE);
    draw_view(of_scene, drawing, entry, &v, stream);
    fputs("</svg>", stream);
}

/* ---- A file by itself. ---- */

/* The colours are those of the page, written out: not every program that shows SVG knows variables. */
static const char file_style[] =
    "text{font:13px system-ui,'DejaVu Sans',sans-serif;fill:#1b1f24}.mid{text-anchor:middle}.end{text-anchor:end}"
    ".power{font-size:9px}.head{font-weight:600}\n"
    ".object{fill:#e0b96e;stroke:#1b1f24;stroke-width:1.2}.finger{fill:#8fa8c8;stroke:#57606a}"
    ".environment{fill:#d0d7de;fill-opacity:.5;stroke:#57606a}.cone{fill:#009e73;fill-opacity:.2;stroke:#007a5a;"
    "stroke-width:.8}.grid{fill:none;stroke:#d0d7de;stroke-width:.7}.frame{fill:none;stroke:#57606a}\n"
    ".arrow{fill:none;stroke-width:2.6}.line{fill:none;stroke-width:2.2}.s0{stroke:#0062a8}.s1{stroke:#b0307f;"
    "stroke-dasharray:6 3}\n"
    "@media(prefers-color-scheme:dark){text{fill:#e6edf3}.object{fill:#c49a4c;stroke:#e6edf3}.finger{fill:#6d88ab;"
    "stroke:#9da7b1}.environment{fill:#3d444d;stroke:#9da7b1}.cone{fill:#3fcf95;stroke:#3fcf95}.grid{stroke:#3d444d}"
    ".frame{stroke:#9da7b1}.s0{stroke:#58a6ff}.s1{stroke:#f08bc4}}\n";

/* Two digits, and a power of ten as people write it. */
static void write_number(double value, FILE *stream)
{
    char text[32];
    snprintf(text, sizeof text, "%.2g", value);
    char *power = strchr(text, 'e');
    int exponent = power ? atoi(power + 1) : 0;
    if (power) *power = '\0';
    if (!power || (exponent >= 0 && exponent < 4)) {
        fprintf(stream, power ? "%.0f" : "%.2g", value);
        return;
    }
    fprintf(stream, "%s &#215; 10<tspan dy=\"-4\" class=\"power\">%s%d</tspan><tspan dy=\"4\">&#8203;</tspan>", text,
            exponent < 0 ? "&#8722;" : "", abs(exponent));
}

/* A run's line in the legend: its name, and how fast the object goes on turning. */
static void write_legend(const json_t *run, size_t number, const char *name, FILE *stream)
{
    int y = 262 + 20 * (int)number;
    fprintf(stream,
            "<path class=\"line %s\" d=\"M400 %dh30\"/><text x=\"438\" y=\"%d\">%s: ", picture_run_class(number), y - 4,
            y, name);
    if (access_metric(run, METRIC_DROPPED) > 0) {
        fputs("drops the object</text>\n", stream);
        return;
    }
    fputs("angular creep ", stream);
    write_number(access_metric(run, METRIC_CREEP_ANGULAR), stream);
    fputs(" rad/s</text>\n", stream);
}

void picture_write_file(const json_t *of_scene, FILE *stream)
{
    const json_t *drawing = json_object_get(of_scene, "drawing"), *runs = json_object_get(of_scene, "runs");
    chart turn_chart = {.title = "", .x_label = "time, s", .y_unit = "rad", .least = 1e-8};
    fprintf(stream,
            "<!DOCTYPE svg [<!ENTITY minus \"&#8722;\"><!ENTITY micro \"&#181;\">]>\n"
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 760 300\" role=\"img\" aria-label=\"A held object "
            "with its contact forces and friction cones; how far it turns with Pinch and with quickstep\">\n"
            "<style>%s</style>\n<clipPath id=\"view\"><rect width=\"360\" height=\"360\" rx=\"8\"/></clipPath>"
            "<clipPath id=\"plot\"><rect x=\"52\" y=\"8\" width=\"299\" height=\"158\"/></clipPath>\n"
            "<g transform=\"translate(6 6) scale(0.8)\" clip-path=\"url(#view)\">\n",
            file_style);
    const json_t *entry = best_view(of_scene, drawing);
    view v = view_of(entry);
    v.size = fmin(v.size, 1.2 * access_number(of_scene, "radius"));
    v.pushing = true;
    draw_view(of_scene, drawing, entry, &v, stream);
    fputs("</g>\n<text x=\"400\" y=\"20\" class=\"head\">How far the held object turns, rad</text>\n"
          "<g transform=\"translate(372 26)\">\n",
          stream);
    for (size_t k = 0; k < 2 && k < json_array_size(runs); k++) {
        const json_t *run = json_array_get(runs, k), *curves = json_object_get(run, "curves");
        turn_chart.series[turn_chart.count++] =
            (chart_series){picture_run_class(k), json_object_get(curves, "time"), json_object_get(curves, "rotation"),
                           !(access_metric(run, METRIC_DROPPED) > 0)};
    }
    chart_draw(&turn_chart, stream);
    fputs("</g>\n", stream);
    for (size_t k = 0; k < 2 && k < json_array_size(runs); k++) {
        const json_t *run = json_array_get(runs, k);
        write_legend(run, k, k ? access_text(run, "run") : "Pinch", stream);
    }
    fputs("</svg>\n", stream);
}
