#define _POSIX_C_SOURCE 200809L

#include "plot.h"

#include "canvas.h"
#include "common/whole_file.h"

#include <errno.h>
#include <math.h>
#include <string.h>
#include <sys/stat.h>

/* The picture, and the place of the axes in it. The labels of curves stand right of the axes. */
enum { WIDTH = 860, HEIGHT = 520, LEFT = 82, RIGHT = 640, TOP = 52, BOTTOM = 456, LABEL_HEIGHT = 19 };

static const char INK[] = "#1b1f24", DIM[] = "#57606a", RULE[] = "#d0d7de";
/* Blue, purple and grey are Pinch, quickstep and worldstep on the pages. */
static const char *const colours[PLOT_MOST_LINES] = {"#0062a8", "#b0307f", "#5c5f62", "#007a5a",
                                                     "#b35900", "#6639ba", "#8a6d00", "#006d77"};

/* An axis maps values, or their decimal logarithms, to places. */
typedef struct axis {
    bool log;
    double low, high, from, to;
} axis;

static double place_of(const axis *a, double value)
{
    double v = a->log ? log10(value) : value;
    return a->from + (v - a->low) / (a->high - a->low) * (a->to - a->from);
}

static bool shows(const plot *p, double x, double y)
{
    return isfinite(x) && isfinite(y) && (!p->log_x || x > 0) && (!p->log_y || y > 0);
}

/* A step of 1, 2 or 5 times a power of ten, so that about `count` steps fill the span. */
static double nice_step(double span, int count)
{
    double rough = span / count, power = pow(10, floor(log10(rough))), part = rough / power;
    return power * (part < 1.5 ? 1 : part < 3.5 ? 2 : part < 7.5 ? 5 : 10);
}

/* Linear axes begin at zero where that is near, and end at a step. Logarithmic ones have a little air. */
static axis make_axis(const plot *p, bool of_y)
{
    axis a = {of_y ? p->log_y : p->log_x, INFINITY, -INFINITY, of_y ? BOTTOM : LEFT, of_y ? TOP : RIGHT};
    for (int k = 0; k < p->count; k++)
        for (size_t i = 0; i < p->lines[k].count; i++) {
            double x = p->lines[k].x[i], y = p->lines[k].y[i];
            if (!shows(p, x, y)) continue;
            double v = of_y ? y : x;
            a.low = fmin(a.low, a.log ? log10(v) : v);
            a.high = fmax(a.high, a.log ? log10(v) : v);
        }
    if (!(a.low <= a.high)) a.low = a.high = 0;
    if (a.log) {
        double air = of_y ? 0.05 * fmax(a.high - a.low, 1) : 0.03 * fmax(a.high - a.low, 0.3);
        a.low -= air;
        a.high += air;
        return a;
    }
    if (a.low > 0 && a.low < 0.5 * a.high) a.low = 0;
    double span = a.high > a.low ? a.high - a.low : fmax(fabs(a.high), 1), step = nice_step(span, 6);
    a.low = floor(a.low / step + 1e-9) * step;
    a.high = of_y ? fmax(ceil(a.high / step - 1e-9) * step, a.low + step) : fmax(a.high, a.low + step);
    return a;
}

static void draw_tick(canvas *c, const axis *a, bool of_y, double place, const char *text)
{
    const canvas_pen thin = {RULE, 0.8, 0, 0};
    const canvas_type type = {DIM, 14, of_y ? CANVAS_END : CANVAS_MIDDLE, false, false};
    const double line[2][2] = {{of_y ? LEFT : place, of_y ? place : TOP},
                               {of_y ? RIGHT : place, of_y ? place : BOTTOM}};
    (void)a;
    canvas_path(c, line, 2, &thin);
    if (of_y)
        canvas_text(c, LEFT - 9, place + 5, text, &type);
    else
        canvas_text(c, place, BOTTOM + 21, text, &type);
}

/* Whole powers of ten; where the axis has fewer than two of them, their doubles and fivefolds as well. */
static void draw_log_ticks(canvas *c, const axis *a, bool of_y)
{
    static const int parts[] = {1, 2, 5};
    bool fine = a->high - a->low < 2.2;
    int step = (int)ceil((a->high - a->low) / 9);
    for (int e = (int)floor(a->low); e <= (int)ceil(a->high); e++)
        for (int k = 0; k < (fine ? 3 : 1); k++) {
            double at = e + log10(parts[k]);
            if (at < a->low || at > a->high || (!fine && e % step != 0)) continue;
            char text[32];
            if (fine && e >= -2 && e <= 4)
                snprintf(text, sizeof text, "%g", parts[k] * pow(10, e));
            else if (k > 0)
                snprintf(text, sizeof text, "%d x 10^%d", parts[k], e);
            else
                snprintf(text, sizeof text, "10^%d", e);
            draw_tick(c, a, of_y, place_of(a, pow(10, at)), text);
        }
}

static void draw_ticks(canvas *c, const axis *a, bool of_y)
{
    if (a->log) {
        draw_log_ticks(c, a, of_y);
        return;
    }
    double step = nice_step(a->high - a->low, of_y ? 6 : 8);
    for (double v = ceil(a->low / step - 1e-9) * step; v <= a->high + 1e-9 * step; v += step) {
        char text[32];
        snprintf(text, sizeof text, "%.6g", fabs(v) < 1e-9 * step ? 0 : v);
        draw_tick(c, a, of_y, place_of(a, v), text);
    }
}

/* Draws a curve in its unbroken parts. What lies within a third of a pixel of the last point is left out. */
static void draw_line(canvas *c, const plot *p, int number, const axis *x, const axis *y)
{
    enum { PART = 512 };
    const plot_line *line = &p->lines[number];
    const canvas_pen pen = {colours[number], 2.2, line->dashed ? 7 : 0, 5}, dot = {colours[number], 7, 0, 0};
    double part[PART][2];
    int count = 0;
    for (size_t i = 0; i < line->count; i++) {
        if (!shows(p, line->x[i], line->y[i])) {
            canvas_path(c, (const double(*)[2])part, count, &pen);
            count = 0;
            continue;
        }
        double at[2] = {place_of(x, line->x[i]), place_of(y, line->y[i])};
        bool last = i + 1 == line->count;
        if (count > 0 && !last && hypot(at[0] - part[count - 1][0], at[1] - part[count - 1][1]) < 0.33) continue;
        if (count == PART) {
            canvas_path(c, (const double(*)[2])part, count, &pen);
            memcpy(part[0], part[PART - 1], sizeof part[0]);
            count = 1;
        }
        memcpy(part[count++], at, sizeof at);
        if (line->marked) canvas_path(c, (const double(*)[2]) & at, 1, &dot);
    }
    canvas_path(c, (const double(*)[2])part, count, &pen);
}

/* Where a curve ends. Returns false for one without a point. */
static bool end_of(const plot *p, int number, const axis *x, const axis *y, double end[2])
{
    const plot_line *line = &p->lines[number];
    for (size_t i = line->count; i-- > 0;)
        if (shows(p, line->x[i], line->y[i])) {
            end[0] = place_of(x, line->x[i]);
            end[1] = place_of(y, line->y[i]);
            return true;
        }
    return false;
}

/* The labels, from the highest end to the lowest, each below the one before, joined to its curve by a thin line. */
static void draw_labels(canvas *c, const plot *p, const axis *x, const axis *y)
{
    int order[PLOT_MOST_LINES], count = 0;
    double ends[PLOT_MOST_LINES][2], places[PLOT_MOST_LINES];
    for (int k = 0; k < p->count; k++) {
        if (!end_of(p, k, x, y, ends[k])) continue;
        int at = count++;
        for (; at > 0 && ends[order[at - 1]][1] > ends[k][1]; at--) order[at] = order[at - 1];
        order[at] = k;
    }
    for (int i = 0; i < count; i++) places[i] = fmax(ends[order[i]][1], i ? places[i - 1] + LABEL_HEIGHT : TOP);
    for (int i = count - 1; i >= 0; i--)
        places[i] = fmin(places[i], i + 1 < count ? places[i + 1] - LABEL_HEIGHT : BOTTOM);
    for (int i = 0; i < count; i++) {
        int k = order[i];
        const canvas_pen thin = {colours[k], 0.9, 2, 3};
        const canvas_type type = {colours[k], 14.5, CANVAS_START, false, true};
        const double lead[3][2] = {{ends[k][0] + 5, ends[k][1]}, {RIGHT + 4, ends[k][1]}, {RIGHT + 14, places[i]}};
        canvas_path(c, lead, 3, &thin);
        canvas_text(c, RIGHT + 18, places[i] + 5, p->lines[k].label, &type);
    }
}

static bool draw(const plot *p, canvas *c)
{
    if (!c) return false;
    const axis x = make_axis(p, false), y = make_axis(p, true);
    const canvas_pen frame = {DIM, 1.2, 0, 0};
    const double corner[3][2] = {{LEFT, TOP}, {LEFT, BOTTOM}, {RIGHT, BOTTOM}};
    draw_ticks(c, &x, false);
    draw_ticks(c, &y, true);
    canvas_path(c, corner, 3, &frame);
    for (int k = p->count - 1; k >= 0; k--) draw_line(c, p, k, &x, &y); /* the first lies on top */
    draw_labels(c, p, &x, &y);
    canvas_text(c, LEFT - 58, 28, p->title, &(canvas_type){INK, 17, CANVAS_START, false, true});
    canvas_text(c, (LEFT + RIGHT) / 2.0, BOTTOM + 48, p->x_label, &(canvas_type){INK, 15, CANVAS_MIDDLE, false, false});
    canvas_text(c, 24, (TOP + BOTTOM) / 2.0, p->y_label, &(canvas_type){INK, 15, CANVAS_MIDDLE, true, false});
    return canvas_close(c);
}

static bool plot_svg(const plot *p, FILE *stream)
{
    return draw(p, canvas_svg(stream, WIDTH, HEIGHT, p->title));
}

static bool plot_png(const plot *p, FILE *stream)
{
    return draw(p, canvas_png(stream, WIDTH, HEIGHT));
}

/* ---- The files. ---- */

command_status plot_folder(const char *command, const char *folder)
{
    for (const char *c = folder; *c; c++)
        if ((unsigned char)*c < 0x20) {
            command_error(command, "--plot: expected a name without control characters, got \"%s\"", folder);
            return COMMAND_BAD_INPUT;
        }
    if (mkdir(folder, 0777) == 0 || errno == EEXIST) return COMMAND_DONE;
    command_error(command, "%s: cannot be created: %s", folder, strerror(errno));
    return COMMAND_SYSTEM;
}

static bool plot_numbers(const plot *p, FILE *stream)
{
    fprintf(stream, "# %s: %s, %s\n", p->title, p->x_label, p->y_label);
    for (int k = 0; k < p->count; k++) {
        fprintf(stream, "# %s\n", p->lines[k].label);
        for (size_t i = 0; i < p->lines[k].count; i++)
            fprintf(stream, "%.9g %.9g\n", p->lines[k].x[i], p->lines[k].y[i]);
        fputs("\n\n", stream);
    }
    return true;
}

command_status plot_write(const char *command, const char *folder, const char *stem, const plot *p)
{
    static const struct {
        const char *suffix;
        bool (*write)(const plot *p, FILE *stream);
    } files[] = {{"svg", plot_svg}, {"png", plot_png}, {"dat", plot_numbers}};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char path[4096];
        whole_file file;
        int length = snprintf(path, sizeof path, "%s/%s.%s", folder, stem, files[i].suffix);
        if (length < 0 || (size_t)length >= sizeof path) {
            errno = ENAMETOOLONG;
            return command_cannot_write(command, folder);
        }
        bool open = whole_file_open(&file, path);
        bool made = open && files[i].write(p, file.stream);
        if (open && whole_file_close(&file, made) && made) continue;
        return command_cannot_write(command, path);
    }
    return COMMAND_DONE;
}
