/* The trials as columns of numbers, and success over each of them. */
#define _POSIX_C_SOURCE 200809L

#include "report_parts.h"

#include "view/page.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- The trials as columns of numbers. ---- */

/* The place of the text among the column's texts. Below zero, which no place is, where memory ran out. */
static double text_place(report_column *c, const char *text)
{
    if (!c->texts) c->texts = json_object();
    const json_t *known = json_object_get(c->texts, text);
    if (known) return json_number_value(known);
    size_t place = json_object_size(c->texts);
    return json_object_set_new(c->texts, text, json_integer((json_int_t)place)) == 0 ? (double)place : -1;
}

/* A number beside texts is a text, too: the places of texts are no quantity in which a number could have its own. */
static bool take_cell(report_column *c, const json_t *cell, double *value)
{
    char text[32];
    *value = NAN;
    if (json_is_null(cell) || (c->kind == REPORT_PARTS && !c->is_input)) return true;
    *value = json_number_value(cell);
    if (c->kind == REPORT_NUMBERS) return true;
    snprintf(text, sizeof text, "%.10g", *value);
    *value = text_place(c, json_is_string(cell) ? json_string_value(cell) : text);
    return *value >= 0;
}

static bool take_kind(void *context, const json_t *names, json_t *row)
{
    (void)names;
    report_trials *t = context;
    const char *name = json_string_value(json_array_get(row, 0)), *type = json_string_value(json_array_get(row, 1));
    if (!name || !type) return true;
    report_kind kind = strcmp(type, "array") == 0 || strcmp(type, "object") == 0 ? REPORT_PARTS
                       : strcmp(type, "text") == 0                               ? REPORT_TEXTS
                                                                                 : REPORT_NUMBERS;
    if (kind > json_integer_value(json_object_get(t->kinds, name)))
        t->failed = json_object_set_new(t->kinds, name, json_integer(kind)) != 0;
    return !t->failed;
}

static bool read_kinds(results *r, report_trials *t, results_error *error)
{
    t->kinds = json_object();
    return t->kinds &&
           results_query(r, "SELECT DISTINCT key, type FROM trials, json_each(inputs)", take_kind, t, error) &&
           results_query(r, "SELECT DISTINCT key, type FROM trials, json_each(recorded)", take_kind, t, error);
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
        c->kind = (report_kind)json_integer_value(json_object_get(t->kinds, c->name));
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
    for (size_t i = 0; i < t->column_count && !t->failed; i++)
        t->failed = !take_cell(&t->columns[i], json_array_get(row, FIXED + i), &t->columns[i].values[t->count]);
    t->count++;
    return !t->failed;
}

void report_trials_free(report_trials *t)
{
    if (!t) return;
    for (size_t i = 0; i < t->column_count; i++) {
        free(t->columns[i].name);
        free(t->columns[i].values);
        json_decref(t->columns[i].texts);
    }
    json_decref(t->kinds);
    free(t->index);
    free(t->success);
    free(t);
}

report_trials *report_trials_read(results *r, results_error *error)
{
    report_trials *t = calloc(1, sizeof *t);
    *error = (results_error){.status = COMMAND_SYSTEM, .text = "out of memory"};
    bool good = t && read_kinds(r, t, error) && results_make_view(r, error) &&
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

enum { MOST_BINS = 12, MOST_TEXTS = 16 };

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

/* A drawing of 360 x 180, and where the rates have their dots in it. */
static const double left = 40, right = 350, top = 10, bottom = 150;

static void draw_grid(FILE *stream)
{
    fputs("<svg viewBox=\"0 0 360 180\" role=\"img\">", stream);
    for (int k = 0; k <= 4; k++)
        fprintf(stream,
                "<path class=\"grid\" d=\"M%g %gH%g\"/><text x=\"%g\" y=\"%g\" text-anchor=\"end\">%d %%</text>", left,
                bottom - (bottom - top) * k / 4, right, left - 4, bottom - (bottom - top) * k / 4 + 3, 25 * k);
}

/* From the left (0) to the right (1). */
static double dot_place(double part)
{
    return left + 12 + (right - left - 24) * part;
}

/* A rate as a dot with its interval. Its title is left open. */
static void begin_dot(double x, size_t succeeded, size_t count, FILE *stream)
{
    double from, to, height = bottom - top;
    wilson_interval(succeeded, count, &from, &to);
    fprintf(stream, "<path class=\"bar\" d=\"M%.1f %.1fV%.1f\"/><circle cx=\"%.1f\" cy=\"%.1f\" r=\"3\"><title>", x,
            bottom - height * from, bottom - height * to, x, bottom - height * (double)succeeded / (double)count);
    fprintf(stream, "%zu of %zu", succeeded, count);
}

static void begin_figure(const report_column *c, FILE *stream)
{
    fputs("<figure><figcaption>", stream);
    page_text(c->name, stream);
    fputs("</figcaption>", stream);
    draw_grid(stream);
}

/* A figure has all trials, or says how many it has not. */
static void end_figure(const report_trials *t, const report_column *c, FILE *stream)
{
    size_t missing = 0;
    for (size_t i = 0; i < t->count; i++) missing += isnan(c->values[i]);
    if (missing > 0) fprintf(stream, "<p>Left out: %zu trial%s without a value.</p>", missing, missing == 1 ? "" : "s");
    fputs("</figure>\n", stream);
}

static void draw_numbers(const report_trials *t, const report_column *c, FILE *stream)
{
    bin bins[MOST_BINS];
    int count = make_bins(t, c, bins);
    if (count < 2) return;
    double low = bins[0].low, span = bins[count - 1].high - low;
    begin_figure(c, stream);
    for (int i = 0; i < count; i++) {
        double middle = 0.5 * (bins[i].low + bins[i].high);
        begin_dot(dot_place(span > 0 ? (middle - low) / span : 0.5), bins[i].succeeded, bins[i].count, stream);
        fprintf(stream, " between %.4g and %.4g</title></circle>", bins[i].low, bins[i].high);
    }
    fprintf(stream,
            "<text x=\"%g\" y=\"170\">%.4g</text><text x=\"%g\" y=\"170\" text-anchor=\"end\">%.4g</text></svg>", left,
            low, right, bins[count - 1].high);
    end_figure(t, c, stream);
}

/* ---- Rates of texts. ---- */

typedef struct text_rate {
    const char *text; /* NULL: all others */
    size_t count, succeeded;
} text_rate;

static int by_frequency(const void *a, const void *b)
{
    const text_rate *x = a, *y = b;
    return x->count != y->count ? (x->count < y->count) - (x->count > y->count) : strcmp(x->text, y->text);
}

/* A text; of an object its name or the file that it is read from, else what it has without quotation marks. */
static void write_text(const report_column *c, const char *label, FILE *stream)
{
    json_t *value = c->kind == REPORT_PARTS && *label == '{' ? json_loads(label, 0, NULL) : NULL;
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

/* The rates of all texts, the most frequent first. NULL when memory runs out. */
static text_rate *rates_of_texts(const report_trials *t, const report_column *c, size_t count)
{
    text_rate *list = calloc(count + 1, sizeof *list);
    const char *text;
    json_t *place;
    if (!list) return NULL;
    json_object_foreach(c->texts, text, place) list[json_integer_value(place)].text = text;
    for (size_t i = 0; i < t->count; i++) {
        if (isnan(c->values[i])) continue;
        text_rate *of = &list[(size_t)c->values[i]];
        of->count++;
        of->succeeded += t->success[i];
    }
    qsort(list, count, sizeof *list, by_frequency);
    return list;
}

/* Texts have no order and nothing between them: each has its own dot, with a number that is explained below. */
static void draw_texts(const report_trials *t, const report_column *c, FILE *stream)
{
    size_t count = json_object_size(c->texts), shown = count <= MOST_TEXTS ? count : MOST_TEXTS;
    text_rate *list = count > 1 ? rates_of_texts(t, c, count) : NULL;
    if (!list) return;
    if (count > shown) {
        text_rate others = {NULL, 0, 0};
        for (size_t i = shown - 1; i < count; i++) {
            others.count += list[i].count;
            others.succeeded += list[i].succeeded;
        }
        list[shown - 1] = others;
    }
    begin_figure(c, stream);
    for (size_t i = 0; i < shown; i++) {
        double x = dot_place((double)i / (double)(shown - 1));
        begin_dot(x, list[i].succeeded, list[i].count, stream);
        fputs(": ", stream);
        if (list[i].text)
            write_text(c, list[i].text, stream);
        else
            fputs("others", stream);
        fprintf(stream, "</title></circle><text x=\"%.1f\" y=\"170\" text-anchor=\"middle\">%zu</text>", x, i + 1);
    }
    fputs("</svg><p>", stream);
    for (size_t i = 0; i < shown; i++) {
        fprintf(stream, "%s%zu: ", i ? "; " : "", i + 1);
        if (list[i].text)
            write_text(c, list[i].text, stream);
        else
            fprintf(stream, "others, %zu different ones", count - (shown - 1));
        fprintf(stream, " (%zu of %zu)", list[i].succeeded, list[i].count);
    }
    fputs("</p>", stream);
    end_figure(t, c, stream);
    free(list);
}

/* ---- All quantities. ---- */

bool report_is_verdict(const char *name)
{
    static const char *const names[] = {"outcome", "displacement", "rotation"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(name, names[i]) == 0) return true;
    return false;
}

/* Lists and objects are drawn where a study chooses between a few of them. */
static bool can_be_drawn(const report_column *c)
{
    return c->kind != REPORT_PARTS || (c->is_input && json_object_size(c->texts) <= MOST_TEXTS);
}

void report_quantities(const report_trials *t, bool inputs, FILE *stream)
{
    const char *before = inputs ? "Lists and objects of which there are more different ones than can be drawn: "
                                : "Lists and objects, which are not drawn: ";
    bool any = false;
    fputs("<div class=\"quantities\">", stream);
    for (size_t i = 0; i < t->column_count; i++) {
        const report_column *c = &t->columns[i];
        if (c->is_input != inputs || report_is_verdict(c->name) || !can_be_drawn(c)) continue;
        if (c->kind == REPORT_NUMBERS)
            draw_numbers(t, c, stream);
        else
            draw_texts(t, c, stream);
    }
    fputs("</div>\n", stream);
    for (size_t i = 0; i < t->column_count; i++) {
        const report_column *c = &t->columns[i];
        if (c->is_input != inputs || can_be_drawn(c)) continue;
        fputs(any ? ", " : "<p class=\"note\">", stream);
        if (!any) fputs(before, stream);
        page_text(c->name, stream);
        any = true;
    }
    if (any) fputs(".</p>\n", stream);
}
