#include "report.h"

#include "compare/access.h"
#include "view/page.h"

#include <stdlib.h>

/* The size of the drawing and the place of the plot in it, in user units. */
enum { WIDTH = 360, HEIGHT = 200, LEFT = 52, RIGHT = 350, TOP = 10, BOTTOM = 164 };

/* An axis maps values to places. */
typedef struct axis {
    bool log;
    double low, high; /* of the value, or of its decimal logarithm */
    double from, to;  /* places */
} axis;

static double place_of(const axis *a, double value)
{
    double v = a->log ? log10(value) : value;
    return a->from + (v - a->low) / (a->high - a->low) * (a->to - a->from);
}

/* A step of 1, 2 or 5 times a power of ten, so that about `count` steps fill the span. */
static double nice_step(double span, int count)
{
    double rough = span / count, power = pow(10, floor(log10(rough))), part = rough / power;
    return power * (part < 1.5 ? 1 : part < 3.5 ? 2 : part < 7.5 ? 5 : 10);
}

static double value_at(const json_t *list, size_t i)
{
    return access_value(json_array_get(list, i));
}

/* The smallest and largest value of the series that set the range. Returns false where there is none. */
static bool range_of(const chart *c, bool of_y, double *low, double *high)
{
    *low = INFINITY;
    *high = -INFINITY;
    for (int k = 0; k < c->count; k++) {
        const chart_series *s = &c->series[k];
        if (of_y && !s->sets_range) continue;
        for (size_t i = 0; i < json_array_size(s->x); i++) {
            double v = of_y ? value_at(s->y, i) : value_at(s->x, i);
            if (isnan(v)) continue;
            if (of_y && c->log_y) v = fmax(v, c->floor);
            *low = fmin(*low, v);
            *high = fmax(*high, v);
        }
    }
    return *low <= *high;
}

static bool make_axis(const chart *c, bool of_y, axis *a)
{
    double low, high;
    a->log = of_y ? c->log_y : c->log_x;
    a->from = of_y ? BOTTOM : LEFT;
    a->to = of_y ? TOP : RIGHT;
    if (!range_of(c, of_y, &low, &high)) return false;
    if (a->log) {
        a->low = floor(log10(low) + 1e-9);
        a->high = fmax(ceil(log10(high) - 1e-9), a->low + 1);
        return true;
    }
    if (of_y) { /* zero is shown where it is near, and a constant is not magnified to its rounding */
        if (low > 0 && low < 0.6 * high) low = 0;
        double least = fmax(1e-3 * fmax(fabs(low), fabs(high)), c->least);
        if (high - low < least) {
            double middle = 0.5 * (low + high);
            low = middle - least;
            high = middle + least;
        }
        double margin = 0.04 * (high - low);
        high += margin;
        if (low != 0) low -= margin;
    }
    a->low = low;
    a->high = high > low ? high : low + 1;
    return true;
}

/* Lengths are shown in the unit that people use for them. */
static double unit_factor(const chart *c, const axis *y, const char **unit)
{
    *unit = c->y_unit;
    if (strcmp(c->y_unit, "m") != 0 || c->log_y) return 1;
    double largest = fmax(fabs(y->low), fabs(y->high));
    *unit = largest < 1e-3 ? "&micro;m" : largest < 1 ? "mm" : "m";
    return largest < 1e-3 ? 1e6 : largest < 1 ? 1e3 : 1;
}

static void write_power(int exponent, FILE *stream)
{
    fprintf(stream, "10<tspan dy=\"-4\" class=\"power\">%s%d</tspan>", exponent < 0 ? "&minus;" : "", abs(exponent));
}

static void write_tick(bool of_y, double place, FILE *stream)
{
    if (of_y)
        fprintf(stream, "<path class=\"grid\" d=\"M%d %.1fH%d\"/><text x=\"%d\" y=\"%.1f\" class=\"end\">", LEFT, place,
                RIGHT, LEFT - 4, place + 3.5);
    else
        fprintf(stream, "<path class=\"grid\" d=\"M%.1f %dV%d\"/><text x=\"%.1f\" y=\"%d\" class=\"mid\">", place, TOP,
                BOTTOM, place, BOTTOM + 13);
}

static void write_ticks(const axis *a, bool of_y, double factor, FILE *stream)
{
    if (a->log) {
        int step = (int)ceil((a->high - a->low) / (of_y ? 6 : 5));
        for (int e = (int)a->low; e <= (int)a->high; e += step) {
            write_tick(of_y, place_of(a, pow(10, e)), stream);
            write_power(e, stream);
            fputs("</text>\n", stream);
        }
        return;
    }
    double step = nice_step(a->high - a->low, of_y ? 4 : 5);
    for (double v = ceil(a->low / step - 1e-9) * step; v <= a->high + 1e-9 * step; v += step) {
        double shown = fabs(v) < 1e-9 * step ? 0 : v;
        write_tick(of_y, place_of(a, shown), stream);
        fprintf(stream, "%s%.6g</text>\n", shown < 0 ? "&minus;" : "", fabs(factor * shown));
    }
}

/* Renderers choke on very large coordinates. The plot clips them. */
static double limited(double place)
{
    return fmin(fmax(place, -2000), 2000);
}

/* A point that lies on the line between its neighbours, to a third of a pixel, is left out. */
static void write_line(const chart *c, const chart_series *s, const axis *x, const axis *y, FILE *stream)
{
    double kept[2] = {NAN, NAN}, last[2] = {NAN, NAN};
    bool open = false;
    fprintf(stream, "<path class=\"line %s\" d=\"", s->run);
    for (size_t i = 0; i < json_array_size(s->x); i++) {
        double v = value_at(s->y, i);
        if (isnan(v)) {
            if (open && last[0] != kept[0]) fprintf(stream, "L%.1f %.1f", last[0], last[1]);
            open = false;
            continue;
        }
        if (c->log_y) v = fmax(v, c->floor);
        double now[2] = {place_of(x, value_at(s->x, i)), limited(place_of(y, v))};
        bool straight = open && fabs(now[1] - last[1]) < 0.05 && fabs(last[1] - kept[1]) < 0.05;
        if (open && !straight && last[0] != kept[0]) {
            fprintf(stream, "L%.1f %.1f", last[0], last[1]);
            memcpy(kept, last, sizeof kept);
        }
        if (!open) {
            fprintf(stream, "M%.1f %.1f", now[0], now[1]);
            memcpy(kept, now, sizeof kept);
        }
        memcpy(last, now, sizeof last);
        open = true;
    }
    if (open && last[0] != kept[0]) fprintf(stream, "L%.1f %.1f", last[0], last[1]);
    fputs("\"/>\n", stream);
}

/* Returns false where there is no number to show. */
static bool make_axes(const chart *c, axis *x, axis *y)
{
    return make_axis(c, false, x) && make_axis(c, true, y);
}

void chart_draw(const chart *c, FILE *stream)
{
    axis x, y;
    const char *unit;
    if (!make_axes(c, &x, &y)) return;
    write_ticks(&x, false, 1, stream);
    write_ticks(&y, true, unit_factor(c, &y, &unit), stream);
    fprintf(stream, "<path class=\"frame\" d=\"M%d %dV%dH%d\"/><text x=\"%d\" y=\"%d\" class=\"mid\">", LEFT, TOP,
            BOTTOM, RIGHT, (LEFT + RIGHT) / 2, BOTTOM + 29);
    page_text(c->x_label, stream);
    fputs("</text><g clip-path=\"url(#plot)\">\n", stream);
    for (int k = c->count - 1; k >= 0; k--) write_line(c, &c->series[k], &x, &y, stream); /* the first lies on top */
    fputs("</g>", stream);
}
