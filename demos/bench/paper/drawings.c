/* The drawings of the report: configurations and residual curves, as inline SVG. */
#include "paper.h"

#include <math.h>
#include <string.h>

static double at(const json_t *list, size_t i)
{
    return json_number_value(json_array_get(list, i));
}

/* ---- Configurations. ---- */

enum { SIDE = 260, EDGE = 44 };

/* Where points of the configuration are drawn: x to the right and y up in the plane, an oblique view in space. */
typedef struct view {
    bool planar;
    double low[2], high[2]; /* of the projected points */
} view;

static void project(const view *v, const double p[3], double q[2])
{
    q[0] = v->planar ? p[0] : 0.85 * p[0] - 0.5 * p[1];
    q[1] = v->planar ? p[1] : p[2] - 0.2 * p[0] - 0.35 * p[1];
}

static void place(const view *v, const double p[3], double q[2])
{
    double span = fmax(v->high[0] - v->low[0], v->high[1] - v->low[1]), scale = (SIDE - 2 * EDGE) / span;
    project(v, p, q);
    q[0] = 0.5 * SIDE + scale * (q[0] - 0.5 * (v->low[0] + v->high[0]));
    q[1] = 0.5 * SIDE - scale * (q[1] - 0.5 * (v->low[1] + v->high[1]));
}

static void read_point(const json_t *list, double p[3])
{
    for (size_t j = 0; j < 3; j++) p[j] = at(list, j);
}

static view view_of(const json_t *example)
{
    view v = {.planar = json_integer_value(json_object_get(example, "dimension")) == 2,
              .low = {INFINITY, INFINITY},
              .high = {-INFINITY, -INFINITY}};
    size_t i;
    json_t *edge;
    json_array_foreach(json_object_get(example, "edges"), i, edge) for (size_t end = 0; end < 2; end++)
    {
        double p[3], q[2];
        read_point(json_array_get(edge, end), p);
        project(&v, p, q);
        for (int j = 0; j < 2; j++) {
            v.low[j] = fmin(v.low[j], q[j]);
            v.high[j] = fmax(v.high[j], q[j]);
        }
    }
    return v;
}

/* The parameter `finger name`; NULL where there is none. */
static const json_t *parameter(const json_t *example, const char *finger, const char *name)
{
    char full[96];
    snprintf(full, sizeof full, "%s%s%s", finger, *finger ? " " : "", name);
    size_t i;
    json_t *p;
    json_array_foreach(json_object_get(example, "parameters"), i, p)
    {
        if (strcmp(json_string_value(json_object_get(p, "name")), full) == 0) return json_object_get(p, "value");
    }
    return NULL;
}

/* An arrow that ends at `to` where it is pushed, or starts at it where it is pulled. */
static void draw_arrow(const double from[2], const double to[2], const char *class, FILE *stream)
{
    double dx = to[0] - from[0], dy = to[1] - from[1], length = hypot(dx, dy);
    if (!(length > 1.0)) return;
    dx *= 7.0 / length;
    dy *= 7.0 / length;
    fprintf(stream, "<path class=\"%s\" d=\"M%.1f %.1fL%.1f %.1f\"/>", class, from[0], from[1], to[0], to[1]);
    fprintf(stream, "<path class=\"%s head\" d=\"M%.1f %.1fL%.1f %.1fL%.1f %.1fZ\"/>\n", class, to[0], to[1],
            to[0] - dx - 0.5 * dy, to[1] - dy + 0.5 * dx, to[0] - dx + 0.5 * dy, to[1] - dy - 0.5 * dx);
}

static void draw_finger(const json_t *example, const view *v, const char *name, bool far, FILE *stream)
{
    double p[3], n[3], tip[2], base[2], way[2];
    const double centre = 26.0, aside = far ? 16.0 : 8.0; /* names of neighbours do not meet */
    read_point(parameter(example, name, "position"), p);
    read_point(parameter(example, name, "normal"), n);
    place(v, p, tip);
    project(v, n, way);
    double length = fmax(hypot(way[0], way[1]), 0.2);
    base[0] = tip[0] - centre * way[0] / length;
    base[1] = tip[1] + centre * way[1] / length;
    draw_arrow(base, tip, parameter(example, name, "friction") ? "finger" : "finger smooth", stream);
    fprintf(stream, "<text class=\"mid\" x=\"%.1f\" y=\"%.1f\">%s</text>\n", base[0] - aside * way[0] / length,
            base[1] + aside * way[1] / length + 4.0, name);
}

void paper_draw_configuration(const json_t *example, FILE *stream)
{
    view v = view_of(example);
    size_t i;
    json_t *edge, *finger;
    fprintf(stream,
            "<svg viewBox=\"0 0 %d %d\" role=\"img\" aria-label=\"The object with its fingers and its load\">\n", SIDE,
            SIDE);
    json_array_foreach(json_object_get(example, "edges"), i, edge)
    {
        double p[3], a[2], b[2];
        read_point(json_array_get(edge, 0), p);
        place(&v, p, a);
        read_point(json_array_get(edge, 1), p);
        place(&v, p, b);
        fprintf(stream, "<path class=\"edge\" d=\"M%.1f %.1fL%.1f %.1f\"/>\n", a[0], a[1], b[0], b[1]);
    }
    const json_t *answers = json_object_get(json_object_get(example, "answers"), "default");
    json_array_foreach(json_object_get(answers, "fingers"), i, finger)
        draw_finger(example, &v, json_string_value(json_object_get(finger, "name")), i % 2, stream);
    double force[3], load[2], middle[2] = {0.5 * SIDE, 0.5 * SIDE}, end[2];
    read_point(parameter(example, "", "force on the object"), force);
    project(&v, force, load);
    double length = hypot(load[0], load[1]);
    for (int j = 0; j < 2; j++) end[j] = middle[j] + (length > 0 ? 40.0 * (j ? -load[j] : load[j]) / length : 0);
    draw_arrow(middle, end, "load", stream);
    fputs("</svg>\n", stream);
}

/* ---- Residual curves. ---- */

enum { WIDTH = 420, HEIGHT = 240, LEFT = 46, RIGHT = 408, TOP = 12, BOTTOM = 196 };

typedef struct axes {
    double most_x, low_y, high_y;
} axes;

static double x_of(const axes *a, double x)
{
    return LEFT + (RIGHT - LEFT) * x / a->most_x;
}

static double y_of(const axes *a, double y)
{
    return BOTTOM - (BOTTOM - TOP) * (y - a->low_y) / (a->high_y - a->low_y);
}

static void widen(axes *a, const json_t *points, size_t columns)
{
    size_t i;
    json_t *p;
    json_array_foreach(points, i, p)
    {
        a->most_x = fmax(a->most_x, at(p, 0));
        for (size_t c = 1; c < columns; c++) {
            a->low_y = fmin(a->low_y, floor(at(p, c)));
            a->high_y = fmax(a->high_y, ceil(at(p, c)));
        }
    }
}

static void draw_axes(const axes *a, FILE *stream)
{
    for (double y = a->low_y; y <= a->high_y; y++)
        fprintf(stream,
                "<path class=\"grid\" d=\"M%d %.1fH%d\"/><text class=\"end\" x=\"%d\" y=\"%.1f\">10<tspan dy=\"-4\" "
                "class=\"power\">%.0f</tspan></text>\n",
                LEFT, y_of(a, y), RIGHT, LEFT - 4, y_of(a, y) + 4, y);
    double rough = a->most_x / 5, power = pow(10, floor(log10(rough))), part = rough / power;
    double step = power * (part < 1.5 ? 1 : part < 3.5 ? 2 : part < 7.5 ? 5 : 10);
    for (double x = 0; x <= a->most_x; x += step)
        fprintf(stream, "<path class=\"grid\" d=\"M%.1f %dV%d\"/><text class=\"mid\" x=\"%.1f\" y=\"%d\">%.0f</text>\n",
                x_of(a, x), TOP, BOTTOM, x_of(a, x), BOTTOM + 15, x);
    fprintf(stream, "<text class=\"mid\" x=\"%d\" y=\"%d\">iterations</text>\n", (LEFT + RIGHT) / 2, BOTTOM + 34);
}

static void draw_line(const axes *a, const json_t *points, size_t column, const char *class, FILE *stream)
{
    size_t i;
    json_t *p;
    fprintf(stream, "<path class=\"line %s\" d=\"", class);
    json_array_foreach(points, i, p)
        fprintf(stream, "%c%.1f %.1f", i ? 'L' : 'M', x_of(a, at(p, 0)), y_of(a, at(p, column)));
    fputs("\"/>\n", stream);
}

static void draw_band(const axes *a, const json_t *points, FILE *stream)
{
    size_t i, count = json_array_size(points);
    fputs("<path class=\"band\" d=\"", stream);
    for (i = 0; i < 2 * count; i++) {
        const json_t *p = json_array_get(points, i < count ? i : 2 * count - 1 - i);
        fprintf(stream, "%c%.1f %.1f", i ? 'L' : 'M', x_of(a, at(p, 0)), y_of(a, at(p, i < count ? 1 : 3)));
    }
    fputs("Z\"/>\n", stream);
}

void paper_draw_curves(const json_t *curves, FILE *stream)
{
    const json_t *random = json_object_get(curves, "nsngrk"), *sweeps = json_object_get(curves, "nsnmgk");
    axes a = {1.0, INFINITY, -INFINITY};
    widen(&a, random, 4);
    widen(&a, sweeps, 2);
    fprintf(stream, "<svg viewBox=\"0 0 %d %d\" role=\"img\" aria-label=\"The residual against the iterations\">\n",
            WIDTH, HEIGHT);
    draw_axes(&a, stream);
    draw_band(&a, random, stream);
    draw_line(&a, random, 2, "random", stream);
    draw_line(&a, sweeps, 1, "sweeps", stream);
    fputs("</svg>\n", stream);
}
