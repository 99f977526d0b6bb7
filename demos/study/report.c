/* The results of a study as a page. */
#define _POSIX_C_SOURCE 200809L

#include "report_parts.h"

#include "view/page_texts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Tables. ---- */

static void write_rate(size_t succeeded, size_t count, FILE *stream)
{
    double low, high;
    wilson_interval(succeeded, count, &low, &high);
    fprintf(stream, "%.2f&nbsp;%% (%.2f to %.2f)", count ? 100.0 * (double)succeeded / (double)count : 0.0, 100 * low,
            100 * high);
}

/* ---- What predicts success. ---- */

typedef struct predictor {
    const char *name;
    bool before; /* known before the trial, or before its protocol begins */
    size_t count;
    double area, low, high;
} predictor;

static int by_strength(const void *a, const void *b)
{
    double x = fabs(((const predictor *)a)->area - 0.5), y = fabs(((const predictor *)b)->area - 0.5);
    return (x < y) - (x > y);
}

static size_t list_predictors(const report_trials *t, predictor list[REPORT_COLUMNS])
{
    size_t count = 0;
    for (size_t i = 0; i < t->column_count; i++) {
        const report_column *c = &t->columns[i];
        /* what the verdict is made of predicts it without telling anything */
        if (report_is_verdict(c->name) || c->kind != REPORT_NUMBERS) continue;
        predictor p = {.name = c->name, .before = c->is_input || strncmp(c->name, "grasp.", 6) == 0};
        p.area = area_under_roc(c->values, t->success, t->count);
        p.count = area_interval(c->values, t->success, t->count, p.area, &p.low, &p.high);
        if (!isnan(p.area)) list[count++] = p;
    }
    qsort(list, count, sizeof *list, by_strength);
    return count;
}

/* A bar from one half to the area, and the interval as a line. */
static void draw_area(const predictor *p, FILE *stream)
{
    double from = 120 * fmin(p->area, 0.5), to = 120 * fmax(p->area, 0.5);
    fprintf(stream,
            "<svg class=\"area\" viewBox=\"0 0 120 14\" aria-hidden=\"true\"><path class=\"grid\" d=\"M60 0V14\"/>"
            "<rect x=\"%.1f\" y=\"3\" width=\"%.1f\" height=\"8\"/><path class=\"bar\" d=\"M%.1f 7H%.1f\"/></svg>",
            from, to - from, 120 * p->low, 120 * p->high);
}

static void write_predictors(const report_trials *t, FILE *stream)
{
    predictor list[REPORT_COLUMNS];
    size_t count = list_predictors(t, list);
    const predictor *best = NULL;
    if (count == 0) return;
    fputs("<h2 id=\"predictors\">What predicts success</h2><p>The area under the ROC curve says how likely a random "
          "success has a larger value than a random failure: 0.5 predicts nothing, 1 (larger is better) and 0 (smaller "
          "is better) everything. The intervals are those of Hanley and McNeil, 95&nbsp;%. Trials without a value are "
          "left out. Results of the trial itself come last: they are no forecast.</p>",
          stream);
    for (size_t i = 0; i < count && !best; i++)
        if (strncmp(list[i].name, "grasp.", 6) == 0) best = &list[i];
    if (best) {
        fputs("<p>Of the qualities of the grasp, <strong>", stream);
        page_text(best->name, stream);
        fprintf(stream, "</strong> predicts best: %.3f (%.3f to %.3f).</p>", best->area, best->low, best->high);
    }
    fputs("<div class=\"wide\"><table class=\"list\"><thead><tr><th>quantity</th><th>trials</th><th>area under the ROC "
          "curve</th><th></th></tr></thead><tbody>\n",
          stream);
    for (int before = 1; before >= 0; before--)
        for (size_t i = 0; i < count; i++) {
            if (list[i].before != (before == 1)) continue;
            fputs(before ? "<tr><td>" : "<tr class=\"result\"><td>", stream);
            page_text(list[i].name, stream);
            fprintf(stream, "</td><td>%zu</td><td>%.3f (%.3f to %.3f)</td><td>", list[i].count, list[i].area,
                    list[i].low, list[i].high);
            draw_area(&list[i], stream);
            fputs("</td></tr>\n", stream);
        }
    fputs("</tbody></table></div>\n", stream);
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
    const char *title; /* of a list that has not been begun; an empty one is left out */
} trial_list;

static bool put_trial(void *context, const json_t *names, json_t *row)
{
    (void)names;
    trial_list *l = context;
    if (l->title)
        fprintf(l->stream,
                "<h2>%s</h2><div class=\"wide\"><table "
                "class=\"list\"><tr><th>trial</th><th>status</th><th>time</th><th></th><th>again</th></tr>\n",
                l->title);
    l->title = NULL;
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
    l->title = title;
    bool good = results_query(r, query, put_trial, l, error);
    if (!l->title) fputs("</table></div>\n", l->stream);
    return good;
}

static bool write_lists(results *r, const study *s, const char *command, FILE *stream, results_error *error)
{
    trial_list l = {command, stream, NULL};
    bool good = true;
    if (s->protocol.type == STUDY_SIX_FORCES) {
        fputs("<h2>Directions, the hardest first</h2><table "
              "class=\"list\"><tr><th>direction</th><th>succeeded</th></tr>\n",
              stream);
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

/* ---- Beside other results. ---- */

static void write_verdicts(const json_t *list, FILE *stream)
{
    size_t i;
    json_t *v;
    fputs("<td class=\"verdicts\">", stream);
    json_array_foreach(list, i, v)
    {
        bool success = json_is_true(json_object_get(v, "success"));
        fprintf(stream, "<span class=\"%s\">%s</span>", success ? "yes" : "no", success ? "holds" : "fails");
    }
    fputs("</td>", stream);
}

static void write_refined(const json_t *refined, const char *here, const char *other, FILE *stream)
{
    size_t i;
    json_t *of;
    int count[4] = {0};
    static const char *const rights[] = {"here", "beside", "each of its own law", "open"};
    fprintf(stream,
            "<p>Each of these trials was run again by both, with the step halved until the verdict stayed for two "
            "halvings. Where both stay at the same verdict, who had it at first is right. Where they stay at different "
            "ones, no step decides between them: their contact laws differ.</p><div class=\"wide\"><table "
            "class=\"list\"><thead><tr><th>trial</th><th>%s</th><th>%s</th><th>right</th></tr></thead><tbody>\n",
            here, other);
    json_array_foreach(refined, i, of)
    {
        const char *right = json_string_value(json_object_get(of, "right"));
        for (int k = 0; k < 4; k++) count[k] += strcmp(right, rights[k]) == 0;
        fprintf(stream, "<tr><td>%ld</td>", (long)json_integer_value(json_object_get(of, "trial")));
        write_verdicts(json_object_get(of, "here"), stream);
        write_verdicts(json_object_get(of, "beside"), stream);
        fprintf(stream, "<td>%s</td></tr>\n",
                strcmp(right, "here") == 0     ? here
                : strcmp(right, "beside") == 0 ? other
                                               : right);
    }
    fprintf(stream, "</tbody></table></div><p>Right: %s %d, %s %d; each of its own law: %d; open: %d.</p>\n", here,
            count[0], other, count[1], count[2], count[3]);
}

static long count_of(const json_t *beside, const char *key)
{
    return (long)json_integer_value(json_object_get(json_object_get(beside, "trials"), key));
}

static void write_beside(const study *s, const json_t *beside, FILE *stream)
{
    const char *here = world_solver_name(s->contact_solver),
               *other = json_string_value(json_object_get(beside, "contact_solver"));
    const json_t *refined = json_object_get(beside, "refined"), *step = json_object_get(beside, "step");
    fprintf(stream, "<h2 id=\"beside\">Beside %s", other);
    if (json_is_number(step)) fprintf(stream, " with steps of %.4g s", json_number_value(step));
    fprintf(
        stream,
        "</h2><p>%ld trials that both have.</p><table class=\"list\"><thead><tr><th></th><th>%s succeeds</th><th>%s "
        "fails</th></tr></thead><tbody><tr><td>%s succeeds</td><td>%ld</td><td>%ld</td></tr><tr><td>%s fails</td>"
        "<td>%ld</td><td>%ld</td></tr></tbody></table>\n",
        count_of(beside, "compared"), other, other, here, count_of(beside, "both_succeed"),
        count_of(beside, "only_here"), here, count_of(beside, "only_beside"), count_of(beside, "both_fail"));
    if (json_array_size(refined) > 0) write_refined(refined, here, other, stream);
}

/* ---- The page. ---- */

static void write_head(const study *s, const results_counts *n, FILE *stream)
{
    fputs("<header><h1>", stream);
    page_text(s->name, stream);
    fprintf(stream, "</h1><p>%ld of %ld trials by %s. Succeeded: <strong>", n->done, n->trials,
            world_solver_name(s->contact_solver));
    write_rate((size_t)n->succeeded, (size_t)n->done, stream);
    fputs("</strong>, with Wilson&rsquo;s 95&nbsp;% interval.", stream);
    if (n->unsolved > 0) fprintf(stream, " %ld trials have no verified answer; they count as failures.", n->unsolved);
    if (n->refused > 0) fprintf(stream, " %ld draws are no legal scenes; they count as failures.", n->refused);
    fputs("</p><p class=\"note\">", stream);
    const char *source = json_string_value(json_object_get(s->document, "source"));
    page_text(source ? source : "", stream);
    fputs("</p></header>\n<main class=\"study\">\n", stream);
}

static void write_quantities(const report_trials *t, FILE *stream)
{
    fputs("<h2>Success over what varies</h2>\n", stream);
    report_quantities(t, true, stream);
    fputs("<h2>Success over what was recorded</h2>\n", stream);
    report_quantities(t, false, stream);
}

bool study_report(results *r, const study *s, const report_settings *settings, FILE *stream, results_error *error)
{
    results_counts n;
    json_t *films = NULL;
    report_trials *t = report_trials_read(r, error);
    bool good = t && results_count(r, &n, error);
    if (good) {
        page_begin(settings->libraries, s->name, view_study_css, stream);
        write_head(s, &n, stream);
        if (settings->beside) write_beside(s, settings->beside, stream);
        films = report_films(r, s, settings->command, settings->beside != NULL, stream, error);
        good = films != NULL;
    }
    if (good) {
        write_quantities(t, stream);
        write_predictors(t, stream);
        good = write_lists(r, s, settings->command, stream, error);
        fputs("</main>\n", stream);
        page_data("films", films, stream);
        page_end(settings->libraries, (const char *const[]){view_study_js, NULL}, stream);
    }
    json_decref(films);
    report_trials_free(t);
    return good;
}
