/* The results of a study as a page. */
#define _POSIX_C_SOURCE 200809L

#include "report.h"

#include "view/page.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- The trials as columns of numbers. ---- */

enum { MOST_COLUMNS = 256, MOST_LABELS = 16 };

typedef struct column {
    char *name;
    bool is_input;
    double *values; /* NaN for null; a text counts as the place of its label */
    size_t label_count;
    char *labels[MOST_LABELS];
} column;

typedef struct trials {
    size_t count, room, column_count;
    column columns[MOST_COLUMNS];
    double *index;
    bool *success;
    bool failed; /* memory ran out */
} trials;

/* The place of the text among the column's labels; NaN where there are too many different ones. */
static double label_place(column *c, const char *text)
{
    size_t i = 0;
    while (i < c->label_count && strcmp(c->labels[i], text) != 0) i++;
    if (i == MOST_LABELS) return NAN;
    if (i == c->label_count) {
        c->labels[i] = strdup(text);
        if (!c->labels[i]) return NAN;
        c->label_count++;
    }
    return (double)i;
}

static double number_of(column *c, const json_t *cell)
{
    if (json_is_number(cell)) return json_number_value(cell);
    return json_is_string(cell) ? label_place(c, json_string_value(cell)) : NAN;
}

/* The view's first columns are trial, status, success, exit, wall_time and hash. */
enum { FIXED = 6 };

static bool make_columns(trials *t, const json_t *names)
{
    for (size_t i = FIXED; i < json_array_size(names) && t->column_count < MOST_COLUMNS; i++) {
        column *c = &t->columns[t->column_count++];
        c->name = strdup(json_string_value(json_array_get(names, i)));
        if (!c->name) return false;
        c->is_input = c->name[0] == '/';
    }
    return true;
}

static bool grow(trials *t)
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
    trials *t = context;
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

static void free_trials(trials *t)
{
    for (size_t i = 0; i < t->column_count; i++) {
        free(t->columns[i].name);
        free(t->columns[i].values);
        for (size_t k = 0; k < t->columns[i].label_count; k++) free(t->columns[i].labels[k]);
    }
    free(t->index);
    free(t->success);
    free(t);
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
static int make_bins(const trials *t, const column *c, bin bins[MOST_BINS])
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

/* Rates as dots with their intervals, in a drawing of 360 x 180. */
static void draw_bins(const column *c, const bin *bins, int count, FILE *stream)
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
        fprintf(stream, "%s%zu: ", k ? ", " : "", k);
        page_text(c->labels[k], stream);
    }
    fputs("</p>", stream);
}

static void write_quantity(const trials *t, const column *c, FILE *stream)
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

/* ---- Tables. ---- */

static void write_rate(size_t succeeded, size_t count, FILE *stream)
{
    double low, high;
    wilson_interval(succeeded, count, &low, &high);
    fprintf(stream, "%.2f&nbsp;%% (%.2f to %.2f)", count ? 100.0 * (double)succeeded / (double)count : 0.0, 100 * low,
            100 * high);
}

typedef struct predictor {
    const char *name;
    double area;
} predictor;

static int by_strength(const void *a, const void *b)
{
    double x = fabs(((const predictor *)a)->area - 0.5), y = fabs(((const predictor *)b)->area - 0.5);
    return (x < y) - (x > y);
}

/* What the verdict is made of predicts it without telling anything. */
static bool is_verdict(const char *name)
{
    static const char *const names[] = {"outcome", "displacement", "rotation"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(name, names[i]) == 0) return true;
    return false;
}

static void write_predictors(const trials *t, FILE *stream)
{
    predictor list[MOST_COLUMNS];
    size_t count = 0;
    for (size_t i = 0; i < t->column_count; i++) {
        const column *c = &t->columns[i];
        if (is_verdict(c->name) || c->label_count > 0) continue;
        double area = area_under_roc(c->values, t->success, t->count);
        if (!isnan(area)) list[count++] = (predictor){c->name, area};
    }
    if (count == 0) return;
    qsort(list, count, sizeof *list, by_strength);
    fputs("<h2>What predicts success</h2><p>The area under the ROC curve says how likely a random success has a larger "
          "value "
          "than a random failure: 0.5 predicts nothing, 1 (larger is better) and 0 (smaller is better) everything.</p>"
          "<table><tr><th>quantity</th><th>area under the ROC curve</th></tr>\n",
          stream);
    for (size_t i = 0; i < count; i++) {
        fputs("<tr><td>", stream);
        page_text(list[i].name, stream);
        fprintf(stream, "</td><td>%.3f</td></tr>\n", list[i].area);
    }
    fputs("</table>\n", stream);
}

static bool put_direction(void *context, const json_t *names, json_t *row)
{
    (void)names;
    FILE *stream = context;
    fputs("<tr><td>", stream);
    page_text(json_string_value(json_array_get(row, 0)), stream);
    fputs("</td><td>", stream);
    write_rate((size_t)json_integer_value(json_array_get(row, 1)), (size_t)json_integer_value(json_array_get(row, 2)),
               stream);
    fputs("</td></tr>\n", stream);
    return true;
}

/* A list of trials, each with the command that runs it again. */
typedef struct trial_list {
    const char *command;
    FILE *stream;
} trial_list;

static bool put_trial(void *context, const json_t *names, json_t *row)
{
    (void)names;
    const trial_list *l = context;
    long trial = (long)json_integer_value(json_array_get(row, 0));
    const char *status = json_string_value(json_array_get(row, 1)),
               *message = json_string_value(json_array_get(row, 3));
    fprintf(l->stream, "<tr><td>%ld</td><td>%s</td><td>%.3g s</td><td>", trial, status ? status : "",
            json_number_value(json_array_get(row, 2)));
    if (message) page_text(message, l->stream);
    fputs("</td><td><code>", l->stream);
    page_text(l->command, l->stream);
    fprintf(l->stream, " --trial %ld</code></td></tr>\n", trial);
    return true;
}

static bool write_trials(results *r, const char *title, const char *query, trial_list *l, results_error *error)
{
    fprintf(l->stream, "<h2>%s</h2><table><tr><th>trial</th><th>status</th><th>time</th><th></th><th>again</th></tr>\n",
            title);
    bool good = results_query(r, query, put_trial, l, error);
    fputs("</table>\n", l->stream);
    return good;
}

static bool write_lists(results *r, const study *s, const char *command, FILE *stream, results_error *error)
{
    trial_list l = {command, stream};
    bool good = true;
    if (s->protocol.type == STUDY_SIX_FORCES) {
        fputs("<h2>Directions, the hardest first</h2><table><tr><th>direction</th><th>succeeded</th></tr>\n", stream);
        good = results_query(r,
                             "SELECT direction, sum(success), count(*) FROM directions GROUP BY direction"
                             " ORDER BY avg(success), direction",
                             put_direction, stream, error);
        fputs("</table>\n", stream);
    }
    return good &&
           write_trials(r, "Trials without a verified answer, or refused",
                        "SELECT \"index\", t.status, wall_time, message FROM trials t LEFT JOIN errors e ON e.trial = "
                        "t.\"index\" WHERE exit <> 0 GROUP BY \"index\" ORDER BY exit, \"index\" LIMIT 20",
                        &l, error) &&
           write_trials(r, "Failures",
                        "SELECT \"index\", status, wall_time, NULL FROM trials WHERE exit = 0 AND success = 0 ORDER BY "
                        "\"index\" LIMIT 10",
                        &l, error) &&
           write_trials(r, "The slowest trials",
                        "SELECT \"index\", status, wall_time, NULL FROM trials ORDER BY wall_time DESC LIMIT 10", &l,
                        error);
}

/* ---- The page. ---- */

static void write_head(const study *s, const results_counts *n, FILE *stream)
{
    fputs("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>", stream);
    page_text(s->name, stream);
    fputs("</title><style>body{font:15px/1.5 system-ui,sans-serif;max-width:62em;margin:2em auto;padding:0 1em}"
          "figure{display:inline-block;width:360px;margin:0 1em 1em 0}figcaption{font-weight:600}"
          "svg{width:100%}svg text{font-size:10px;fill:#555}.grid{stroke:#ddd}.bar{stroke:#36c;stroke-width:2}"
          "circle{fill:#36c}table{border-collapse:collapse}td,th{padding:.1em .8em;text-align:left;"
          "border-bottom:1px solid #ddd}</style></head><body><h1>",
          stream);
    page_text(s->name, stream);
    fprintf(stream, "</h1><p>%ld of %ld trials by %s. Succeeded: <strong>", n->done, n->trials,
            world_solver_name(s->contact_solver));
    write_rate((size_t)n->succeeded, (size_t)n->done, stream);
    fputs("</strong>, with Wilson&rsquo;s 95&nbsp;% interval.", stream);
    if (n->unsolved > 0) fprintf(stream, " %ld trials have no verified answer; they count as failures.", n->unsolved);
    if (n->refused > 0) fprintf(stream, " %ld draws are no legal scenes; they count as failures.", n->refused);
    fputs("</p>\n", stream);
}

bool study_report(results *r, const study *s, const char *command, FILE *stream, results_error *error)
{
    results_counts n;
    trials *t = calloc(1, sizeof *t);
    *error = (results_error){.status = COMMAND_SYSTEM, .text = "out of memory"};
    if (!t) return false;
    bool good = results_count(r, &n, error) && results_make_view(r, error) &&
                results_query(r, "SELECT * FROM results ORDER BY trial", take_trial, t, error);
    if (good && t->failed) {
        *error = (results_error){.status = COMMAND_SYSTEM, .text = "out of memory"};
        good = false;
    }
    if (good) {
        write_head(s, &n, stream);
        fputs("<h2>Success over what varies</h2>\n", stream);
        for (size_t i = 0; i < t->column_count; i++)
            if (t->columns[i].is_input) write_quantity(t, &t->columns[i], stream);
        fputs("<h2>Success over what was recorded</h2>\n", stream);
        for (size_t i = 0; i < t->column_count; i++)
            if (!t->columns[i].is_input && !is_verdict(t->columns[i].name)) write_quantity(t, &t->columns[i], stream);
        write_predictors(t, stream);
        good = write_lists(r, s, command, stream, error);
        fputs("</body></html>\n", stream);
    }
    free_trials(t);
    return good;
}
