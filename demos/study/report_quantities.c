/* The trials as columns of numbers, and success over each of them. */
#define _POSIX_C_SOURCE 200809L

#include "report_parts.h"

#include "view/page.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- The trials as columns of numbers. ---- */

/* The place of the text among the column's labels; NaN where there are too many different ones. */
static double label_place(report_column *c, const char *text)
{
    size_t i = 0;
    while (i < c->label_count && strcmp(c->labels[i], text) != 0) i++;
    if (i == REPORT_LABELS) return NAN;
    if (i == c->label_count) {
        c->labels[i] = strdup(text);
        if (!c->labels[i]) return NAN;
        c->label_count++;
    }
    return (double)i;
}

static double number_of(report_column *c, const json_t *cell)
{
    if (json_is_number(cell)) return json_number_value(cell);
    return json_is_string(cell) ? label_place(c, json_string_value(cell)) : NAN;
}

/* The view's first columns are trial, status, success, exit, wall_time and hash. */
enum { FIXED = 6 };

static bool make_columns(report_trials *t, const json_t *names)
{
    for (size_t i = FIXED; i < json_array_size(names) && t->column_count < REPORT_COLUMNS; i++) {
        report_column *c = &t->columns[t->column_count++];
        c->name = strdup(json_string_value(json_array_get(names, i)));
        if (!c->name) return false;
        c->is_input = c->name[0] == '/';
    }
    return true;
}

static bool grow(report_trials *t)
{
    size_t room = 2 * t->room + 256;
    double *index = realloc(t->index, room * sizeof *index);
    if (index) t->index = index;
    bool *success = realloc(t->success, room * sizeof *success);
    if (success) t->success = success;
    bool good = index && success;
    for (size_t i = 0; i < t->column_count && good; i++) {
        double *values = realloc(t->columns[i].values, room * sizeof *values);
        if (values) t->columns[i].values = values;
        good = values != NULL;
    }
    if (good) t->room = room;
    return good;
}

static bool take_trial(void *context, const json_t *names, json_t *row)
{
    report_trials *t = context;
    if (t->count == 0 && !make_columns(t, names)) t->failed = true;
    if (!t->failed && t->count == t->room && !grow(t)) t->failed = true;
    if (t->failed) return false;
    t->index[t->count] = json_number_value(json_array_get(row, 0));
    t->success[t->count] = json_integer_value(json_array_get(row, 2)) != 0;
    for (size_t i = 0; i < t->column_count; i++)
        t->columns[i].values[t->count] = number_of(&t->columns[i], json_array_get(row, FIXED + i));
    t->count++;
    return true;
}

void report_trials_free(report_trials *t)
{
    if (!t) return;
    for (size_t i = 0; i < t->column_count; i++) {
        free(t->columns[i].name);
        free(t->columns[i].values);
        for (size_t k = 0; k < t->columns[i].label_count; k++) free(t->columns[i].labels[k]);
    }
    free(t->index);
    free(t->success);
    free(t);
}

report_trials *report_trials_read(results *r, results_error *error)
{
    report_trials *t = calloc(1, sizeof *t);
    *error = (results_error){.status = COMMAND_SYSTEM, .text = "out of memory"};
    bool good = t && results_make_view(r, error) &&
                results_query(r, "SELECT * FROM results ORDER BY trial", take_trial, t, error);
    if (good && t->failed) {
        *error = (results_error){.status = COMMAND_SYSTEM, .text = "out of memory"};
        good = false;
    }
    if (good) return t;
    report_trials_free(t);
    return NULL;
}

/* ---- Rates over a quantity. ---- */

enum { MOST_BINS = 12 };

typedef struct bin {
    double low, high; /* the smallest and the largest value in it */
    size_t count, succeeded;
} bin;

typedef struct pair {
    double value;
    bool success;
} pair;

static int by_value(const void *a, const void *b)
{
    double x = ((const pair *)a)->value, y = ((const pair *)b)->value;
    return (x > y) - (x < y);
}

/* Bins of about as many trials each; a bin for each value where there are few. Equal values stay together. */
static int make_bins(const report_trials *t, const report_column *c, bin bins[MOST_BINS])
{
    pair *list = malloc((t->count + 1) * sizeof *list);
    size_t n = 0, distinct = 0;
    int count = 0;
    if (!list) return 0;
    for (size_t i = 0; i < t->count; i++)
        if (!isnan(c->values[i])) list[n++] = (pair){c->values[i], t->success[i]};
    qsort(list, n, sizeof *list, by_value);
    for (size_t i = 0; i < n; i++) distinct += i == 0 || list[i].value > list[i - 1].value;
    size_t wanted = distinct <= MOST_BINS ? 1 : (n + MOST_BINS - 1) / MOST_BINS;
    for (size_t i = 0; i < n; i++) {
        bool same = i > 0 && list[i].value == list[i - 1].value;
        if (count == 0 || (!same && bins[count - 1].count >= wanted && count < MOST_BINS))
            bins[count++] = (bin){list[i].value, list[i].value, 0, 0};
        bins[count - 1].high = list[i].value;
        bins[count - 1].count++;
        bins[count - 1].succeeded += list[i].success;
    }
    free(list);
    return count;
}

/* A text; of an object its name or the file that it is read from, else what it has without quotation marks. */
static void write_label(const char *label, FILE *stream)
{
    json_t *value = *label == '{' ? json_loads(label, 0, NULL) : NULL;
    const char *file = json_string_value(json_object_get(value, "file")),
               *name = json_string_value(json_object_get(value, "name"));
    char *text = json_dumps(value, JSON_REAL_PRECISION(4) | JSON_COMPACT), *to = text;
    for (const char *from = text; text && *from; from++) {
        if (!strchr("\"{}", *from)) *to++ = *from == ':' ? ' ' : *from;
    }
    if (to) *to = '\0';
    if (name || file)
        page_text(name ? name : strrchr(file, '/') ? strrchr(file, '/') + 1 : file, stream);
    else
        page_text(text ? text : label, stream);
    free(text);
    json_decref(value);
}

/* Rates as dots with their intervals, in a drawing of 360 x 180. */
static void draw_bins(const report_column *c, const bin *bins, int count, FILE *stream)
{
    const double left = 40, right = 350, top = 10, bottom = 150;
    double low = bins[0].low, span = bins[count - 1].high - low;
    fputs("<svg viewBox=\"0 0 360 180\" role=\"img\">", stream);
    for (int k = 0; k <= 4; k++)
        fprintf(stream,
                "<path class=\"grid\" d=\"M%g %gH%g\"/><text x=\"%g\" y=\"%g\" text-anchor=\"end\">%d %%</text>", left,
                bottom - (bottom - top) * k / 4, right, left - 4, bottom - (bottom - top) * k / 4 + 3, 25 * k);
    for (int i = 0; i < count; i++) {
        double from, to, middle = 0.5 * (bins[i].low + bins[i].high);
        wilson_interval(bins[i].succeeded, bins[i].count, &from, &to);
        double x = span > 0 ? left + 12 + (right - left - 24) * (middle - low) / span : 0.5 * (left + right);
        double y = bottom - (bottom - top) * (double)bins[i].succeeded / (double)bins[i].count;
        fprintf(stream, "<path class=\"bar\" d=\"M%.1f %.1fV%.1f\"/><circle cx=\"%.1f\" cy=\"%.1f\" r=\"3\"><title>", x,
                bottom - (bottom - top) * from, bottom - (bottom - top) * to, x, y);
        fprintf(stream, "%zu of %zu between %.4g and %.4g</title></circle>", bins[i].succeeded, bins[i].count,
                bins[i].low, bins[i].high);
    }
    fprintf(stream, "<text x=\"%g\" y=\"170\">%.4g</text><text x=\"%g\" y=\"170\" text-anchor=\"end\">%.4g</text>",
            left, low, right, bins[count - 1].high);
    fputs("</svg>", stream);
    if (c->label_count == 0) return;
    fputs("<p>", stream);
    for (size_t k = 0; k < c->label_count; k++) {
        fprintf(stream, "%s%zu: ", k ? "; " : "", k);
        write_label(c->labels[k], stream);
    }
    fputs("</p>", stream);
}

void report_quantity(const report_trials *t, const report_column *c, FILE *stream)
{
    bin bins[MOST_BINS];
    int count = make_bins(t, c, bins);
    if (count < 2) return;
    fputs("<figure><figcaption>", stream);
    page_text(c->name, stream);
    fputs("</figcaption>", stream);
    draw_bins(c, bins, count, stream);
    fputs("</figure>\n", stream);
}
