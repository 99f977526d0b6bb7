/* The report as a page that needs no network. Every number on it is in the document: it stands in a <data> element,
 * whose value is the document's number to the last digit. */
#include "paper.h"

#include "common/output.h"
#include "view/page_texts.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

static const char *text_of(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

static void put_text(const char *text, FILE *stream)
{
    for (; *text; text++) {
        if (*text == '&')
            fputs("&amp;", stream);
        else if (*text == '<')
            fputs("&lt;", stream);
        else
            fputc(*text, stream);
    }
}

/* A number of the document, shown times `scale` by the format; a dash for null. */
static void put_number(const json_t *value, double scale, const char *format, FILE *stream)
{
    char full[32], shown[48];
    if (!json_is_number(value)) {
        fputs("&ndash;", stream);
        return;
    }
    json_number_text(json_number_value(value), full);
    snprintf(shown, sizeof shown, format, scale * json_number_value(value)); /* the formats are this file's own */
    fprintf(stream, "<data value=\"%s\">%s</data>", full, shown);
}

static void cell(const json_t *value, double scale, const char *format, FILE *stream)
{
    fputs("<td>", stream);
    put_number(value, scale, format, stream);
    fputs("</td>", stream);
}

static void text_cell(const char *text, const char *class, FILE *stream)
{
    fprintf(stream, "<td class=\"%s\">", class);
    put_text(text, stream);
    fputs("</td>", stream);
}

/* Opens a table with a heading for each text up to the last, which is NULL. '<' puts a heading to the left. */
static void open_table(const char *const *headings, FILE *stream)
{
    fputs("<div class=\"wide\"><table><thead><tr>", stream);
    for (; *headings; headings++) {
        const bool left = **headings == '<';
        fprintf(stream, "<th%s>%s</th>", left ? " class=\"text\"" : "", *headings + left);
    }
    fputs("</tr></thead><tbody>\n", stream);
}

static void close_table(FILE *stream)
{
    fputs("</tbody></table></div>\n", stream);
}

static void quartiles_cell(const json_t *spread, double scale, const char *format, FILE *stream)
{
    fputs("<td>", stream);
    put_number(json_object_get(spread, "low"), scale, format, stream);
    fputs(" to ", stream);
    put_number(json_object_get(spread, "high"), scale, format, stream);
    fputs("</td>", stream);
}

/* ---- Sections. ---- */

static void put_claims(const json_t *document, FILE *stream)
{
    size_t i, k;
    json_t *claim, *figure;
    fputs("<h2>What the paper claims</h2>\n", stream);
    open_table((const char *const[]){"<claim", "<verdict", "<figures", "<remark", NULL}, stream);
    json_array_foreach(json_object_get(document, "claims"), i, claim)
    {
        const char *verdict = text_of(claim, "verdict");
        fputs("<tr>", stream);
        text_cell(text_of(claim, "claim"), "long", stream);
        text_cell(verdict,
                  strcmp(verdict, "reproduced") == 0 ? "text good"
                  : *verdict == 'n'                  ? "text bad"
                                                     : "text",
                  stream);
        fputs("<td class=\"long\">", stream);
        json_array_foreach(json_object_get(claim, "figures"), k, figure)
        {
            if (k) fputs(", ", stream);
            put_text(text_of(figure, "name"), stream);
            fputs(": ", stream);
            put_number(json_object_get(figure, "value"), 1, "%.4g", stream);
        }
        fputs("</td>", stream);
        text_cell(text_of(claim, "remark"), "long", stream);
        fputs("</tr>\n", stream);
    }
    close_table(stream);
}

static void put_method(const json_t *m, bool random, FILE *stream)
{
    cell(json_object_get(m, "iterations"), 1, random ? "%.1f" : "%.0f", stream);
    if (random) quartiles_cell(json_object_get(m, "iterations_quartiles"), 1, "%.0f", stream);
    cell(json_object_get(m, "residual"), 1, "%.3e", stream);
    cell(json_object_get(m, "time_s"), 1e6, "%.1f", stream);
    quartiles_cell(json_object_get(m, "time_quartiles_s"), 1e6, "%.1f", stream);
}

static void put_rows(const json_t *document, FILE *stream)
{
    size_t i;
    json_t *row;
    const json_t *timing = json_object_get(document, "timing");
    fputs("<h2>Iterations, residuals and times</h2>\n<p>Clock: ", stream);
    put_text(text_of(timing, "clock"), stream);
    fputs(". Order: ", stream);
    put_text(text_of(timing, "order"), stream);
    fputs(". Seeds: ", stream);
    put_number(json_object_get(timing, "seeds"), 1, "%.0f", stream);
    fputs(json_is_true(json_object_get(timing, "instructions_counted"))
              ? ". Instructions of the thread are counted."
              : ". This machine does not let a program count its instructions, so that they are left out.",
          stream);
    fputs(
        " Ranges are quartiles. Row operations are products of a matrix row with a vector and sums with a multiple of "
        "one.</p>\n",
        stream);
    open_table((const char *const[]){"example", "faces", "unknowns", "NSNGRK<br>iterations", "quartiles", "residual",
                                     "&micro;s", "quartiles", "NSNMGK<br>iterations", "residual", "&micro;s",
                                     "quartiles", "speed-up", "quartiles", "published", "ratio of<br>iterations",
                                     "of row<br>operations", "of instruc-<br>tions", NULL},
               stream);
    json_array_foreach(json_object_get(document, "rows"), i, row)
    {
        fputs("<tr>", stream);
        text_cell(text_of(row, "example"), "text", stream);
        cell(json_object_get(row, "faces"), 1, "%.0f", stream);
        cell(json_object_get(row, "unknowns"), 1, "%.0f", stream);
        put_method(json_object_get(row, "nsngrk"), true, stream);
        put_method(json_object_get(row, "nsnmgk"), false, stream);
        cell(json_object_get(row, "speedup"), 1, "%.2f", stream);
        quartiles_cell(json_object_get(row, "speedup_quartiles"), 1, "%.2f", stream);
        cell(json_object_get(json_object_get(row, "published"), "speedup"), 1, "%.2f", stream);
        cell(json_object_get(row, "iteration_ratio"), 1, "%.2f", stream);
        cell(json_object_get(row, "row_operation_ratio"), 1, "%.2f", stream);
        cell(json_object_get(row, "instruction_ratio"), 1, "%.2f", stream);
        fputs("</tr>\n", stream);
    }
    close_table(stream);
}

/* Only rows with a published speed-up are here: the question is whether it can be had. */
static void put_operations(const json_t *document, FILE *stream)
{
    size_t i;
    json_t *row;
    fputs("<h2>What the published speed-ups would take</h2>\n<p>", stream);
    put_text(text_of(document, "operations"), stream);
    fputs("</p>\n", stream);
    open_table((const char *const[]){"<example", "faces", "n", "NSNGRK<br>iterations", "NSNMGK<br>iterations", "p",
                                     "operations of an<br>iteration: NSNGRK", "NSNMGK", "NSNMGK, kept<br>up to date",
                                     "ratio of<br>iterations", "of opera-<br>tions", "of times", "published",
                                     "NSNGRK iterations<br>for that", NULL},
               stream);
    json_array_foreach(json_object_get(document, "rows"), i, row)
    {
        const json_t *o = json_object_get(row, "operations"),
                     *published = json_object_get(json_object_get(row, "published"), "speedup");
        if (!json_is_number(published)) continue;
        fputs("<tr>", stream);
        text_cell(text_of(row, "example"), "text", stream);
        cell(json_object_get(row, "faces"), 1, "%.0f", stream);
        cell(json_object_get(row, "unknowns"), 1, "%.0f", stream);
        cell(json_object_get(json_object_get(row, "nsngrk"), "iterations"), 1, "%.1f", stream);
        cell(json_object_get(json_object_get(row, "nsnmgk"), "iterations"), 1, "%.0f", stream);
        cell(json_object_get(o, "projections_of_an_iteration"), 1, "%.2f", stream);
        cell(json_object_get(o, "nsngrk"), 1, "%.0f", stream);
        cell(json_object_get(o, "nsnmgk"), 1, "%.1f", stream);
        cell(json_object_get(o, "nsnmgk_kept_up_to_date"), 1, "%.1f", stream);
        cell(json_object_get(row, "iteration_ratio"), 1, "%.2f", stream);
        cell(json_object_get(row, "row_operation_ratio"), 1, "%.2f", stream);
        cell(json_object_get(row, "speedup"), 1, "%.2f", stream);
        cell(published, 1, "%.2f", stream);
        cell(json_object_get(o, "nsngrk_iterations_for_published"), 1, "%.0f", stream);
        fputs("</tr>\n", stream);
    }
    close_table(stream);
}

static void put_comparison(const json_t *document, FILE *stream)
{
    size_t i;
    json_t *value;
    fputs("<h2>Published values beside ours</h2>\n<p>Only these numbers of the paper are known to us. An explanation "
          "stands where ours may differ by more than the tolerance.</p>\n",
          stream);
    open_table((const char *const[]){"<example", "faces", "<method", "<finger", "<quantity", "published", "ours",
                                     "difference", "tolerance", "<", "<where, and why ours differs", NULL},
               stream);
    json_array_foreach(json_object_get(document, "comparison"), i, value)
    {
        const json_t *within = json_object_get(value, "within_tolerance");
        bool relative = json_is_true(json_object_get(value, "relative"));
        fputs("<tr>", stream);
        text_cell(text_of(value, "example"), "text", stream);
        cell(json_object_get(value, "faces"), 1, "%.0f", stream);
        text_cell(text_of(value, "method"), "text", stream);
        text_cell(text_of(value, "finger"), "text", stream);
        text_cell(text_of(value, "quantity"), "text", stream);
        cell(json_object_get(value, "value"), 1, "%.5g", stream);
        cell(json_object_get(value, "ours"), 1, "%.5g", stream);
        cell(json_object_get(value, relative ? "relative_difference" : "difference"), relative ? 100 : 1,
             relative ? "%+.1f %%" : "%+.4f", stream);
        cell(json_object_get(value, "tolerance"), relative ? 100 : 1, relative ? "%.3g %%" : "%.3g", stream);
        text_cell(json_is_null(within)   ? "not compared"
                  : json_is_true(within) ? "within"
                                         : "misses",
                  json_is_null(within)   ? "text"
                  : json_is_true(within) ? "text good"
                                         : "text bad",
                  stream);
        fputs("<td class=\"long\">", stream);
        put_text(text_of(value, "where"), stream);
        if (!json_is_true(within)) {
            fputs(". ", stream);
            put_text(text_of(value, "explanation"), stream);
        }
        fputs("</td></tr>\n", stream);
    }
    close_table(stream);
}

static void put_vector(const json_t *value, double scale, const char *format, FILE *stream)
{
    if (!json_is_array(value)) {
        put_number(value, scale, format, stream);
        return;
    }
    fputc('(', stream);
    for (size_t i = 0; i < json_array_size(value); i++) {
        if (i) fputs(", ", stream);
        put_number(json_array_get(value, i), scale, format, stream);
    }
    fputc(')', stream);
}

static void put_parameters(const json_t *example, FILE *stream)
{
    size_t i;
    json_t *p;
    fputs("<details open><summary>Parameters</summary>\n", stream);
    open_table((const char *const[]){"<parameter", "value", "<unit", "<source", NULL}, stream);
    json_array_foreach(json_object_get(example, "parameters"), i, p)
    {
        fputs("<tr>", stream);
        text_cell(text_of(p, "name"), "text", stream);
        fputs("<td>", stream);
        put_vector(json_object_get(p, "value"), 1, "%.4g", stream);
        fputs("</td>", stream);
        text_cell(text_of(p, "unit"), "text", stream);
        text_cell(text_of(p, "source"), strcmp(text_of(p, "source"), "published") == 0 ? "text good" : "text", stream);
        fputs("</tr>\n", stream);
    }
    close_table(stream);
    fputs("</details>\n", stream);
}

static void put_answer(const json_t *answers, const char *method, const char *label, FILE *stream)
{
    const json_t *answer = json_object_get(answers, method), *object = json_object_get(answer, "object");
    size_t i;
    json_t *f;
    json_array_foreach(json_object_get(answer, "fingers"), i, f)
    {
        fputs("<tr>", stream);
        text_cell(i ? "" : label, "text", stream);
        text_cell(text_of(f, "name"), "text", stream);
        cell(json_object_get(f, "normal_force"), 1, "%.5f", stream);
        cell(json_object_get(f, "tangential_force"), 1, "%.5f", stream);
        cell(json_object_get(f, "normal_displacement"), 1, "%.5f", stream);
        cell(json_object_get(f, "slip"), 1, "%.5f", stream);
        fputs("</tr>\n", stream);
    }
    fputs("<tr><td class=\"text\"></td><td class=\"text\">object</td><td colspan=\"4\">moves ", stream);
    put_vector(json_object_get(object, "translation"), 1, "%.4f", stream);
    fputs(" m, turns ", stream);
    put_vector(json_object_get(object, "rotation"), 1, "%.4f", stream);
    fputs(" rad; error of the forces: median ", stream);
    put_number(json_object_get(json_object_get(answer, "force_error_N"), "median"), 1, "%.2g", stream);
    fputs(" N, worst ", stream);
    put_number(json_object_get(json_object_get(answer, "force_error_N"), "worst"), 1, "%.2g", stream);
    fputs(" N</td></tr>\n", stream);
}

static void put_faces(const json_t *faces, FILE *stream)
{
    if (!json_is_number(faces)) return;
    fputs(", ", stream);
    put_number(faces, 1, "%.0f", stream);
    fputs(" faces", stream);
}

static void put_example(const json_t *example, FILE *stream)
{
    const json_t *answers = json_object_get(example, "answers");
    fprintf(stream, "<h2>Example %s</h2>\n<p>", text_of(example, "example"));
    put_text(text_of(example, "kind"), stream);
    fputc(' ', stream);
    put_text(text_of(example, "facts"), stream);
    fputs("</p>\n<div class=\"pair\"><figure>", stream);
    paper_draw_configuration(example, stream);
    fputs("<figcaption>Fingers (dashed: without friction) and the force on the object.</figcaption></figure><figure>",
          stream);
    paper_draw_curves(json_object_get(example, "curves"), stream);
    fputs("<figcaption>Figure ", stream);
    put_number(json_object_get(example, "figure"), 1, "%.0f", stream);
    fputs(" of the paper", stream);
    put_faces(json_object_get(example, "figure_faces"), stream);
    fputs(": the residual of NSNGRK over the seeds (least to largest, and the median) and of NSNMGK "
          "(below).</figcaption></figure></div>\n<p>Forces, slip and displacements",
          stream);
    put_faces(json_object_get(example, "faces"), stream);
    fputs("</p>\n", stream);
    open_table((const char *const[]){"<method", "<finger", "normal force N", "tangential force N", "fingertip gives m",
                                     "slip m", NULL},
               stream);
    put_answer(answers, "nsngrk", "NSNGRK, mean of the seeds", stream);
    put_answer(answers, "nsnmgk", "NSNMGK", stream);
    put_answer(answers, "default", "default mode", stream);
    close_table(stream);
    put_parameters(example, stream);
}

static void put_solvers(const json_t *document, FILE *stream)
{
    size_t i, k;
    json_t *of, *r;
    fputs(
        "<h2>Every solver on every example</h2>\n<p>&ldquo;The paper's&rdquo; is the paper's complementarity problem "
        "to its "
        "tolerance; the default mode solves for displacements by Newton steps and, where these fail, an implicit flow. "
        "ADMM is reimplemented from the published method. Its residual, and that of the exact cone, are not those of "
        "the complementarity problem: compare the errors of the forces.</p>\n",
        stream);
    open_table((const char *const[]){"<example", "faces", "<solver", "<problem", "<status", "iterations", "residual",
                                     "&micro;s", "error of the forces N", NULL},
               stream);
    json_array_foreach(json_object_get(document, "solvers"), i, of)
        json_array_foreach(json_object_get(of, "results"), k, r)
    {
        bool solved = strcmp(text_of(r, "status"), "converged") == 0;
        fputs("<tr>", stream);
        text_cell(k ? "" : text_of(of, "example"), "text", stream);
        cell(k ? NULL : json_object_get(of, "faces"), 1, "%.0f", stream);
        text_cell(text_of(r, "solver"), "text", stream);
        text_cell(text_of(r, "problem"), "text", stream);
        text_cell(text_of(r, "status"), solved ? "text good" : "text bad", stream);
        cell(json_object_get(r, "iterations"), 1, "%.0f", stream);
        cell(json_object_get(r, "residual"), 1, "%.1e", stream);
        cell(json_object_get(r, "time_s"), 1e6, "%.1f", stream);
        cell(json_object_get(r, "force_error_N"), 1, "%.1e", stream);
        fputs("</tr>\n", stream);
    }
    close_table(stream);
}

static void put_random(const json_t *document, FILE *stream)
{
    const json_t *random = json_object_get(document, "random_grasps");
    size_t i, k;
    json_t *size, *r;
    if (!json_is_object(random)) return; /* --faces asks for less */
    fputs("<h2>Random grasps</h2>\n<p>A ball with fingers all around it, units of one, friction pyramids of ", stream);
    put_number(json_object_get(random, "faces"), 1, "%.0f", stream);
    fputs(" faces where the solver is not said to take the exact cone, at most ", stream);
    put_number(json_object_get(random, "most_iterations"), 1, "%.0f", stream);
    fputs(" iterations. Some grasps hold nothing; the default mode says how many do. NSNMGK is without Newton "
          "steps.</p>\n",
          stream);
    open_table(
        (const char *const[]){"fingers", "<solver", "solved", "of", "iterations, mean", "&micro;s, median", NULL},
        stream);
    json_array_foreach(json_object_get(random, "sizes"), i, size)
        json_array_foreach(json_object_get(size, "results"), k, r)
    {
        fputs("<tr>", stream);
        cell(k ? NULL : json_object_get(size, "fingers"), 1, "%.0f", stream);
        text_cell(text_of(r, "solver"), "text", stream);
        cell(json_object_get(r, "solved"), 1, "%.0f", stream);
        cell(json_object_get(r, "grasps"), 1, "%.0f", stream);
        cell(json_object_get(r, "iterations"), 1, "%.1f", stream);
        cell(json_object_get(r, "time_s"), 1e6, "%.1f", stream);
        fputs("</tr>\n", stream);
    }
    close_table(stream);
}

static void put_dynamics(const json_t *document, FILE *stream)
{
    size_t i, k;
    json_t *of, *r;
    const json_t *scenes = json_object_get(document, "dynamics");
    if (!json_is_array(scenes)) return; /* --faces asks for less */
    fputs(
        "<h2>Dynamics by the paper's method</h2>\n<p>The run scenes with NSNMGK alone, without Newton's steps, on the "
        "exact cone and on the pyramid, beside the default mode. A solve that fails is tried again with Newton's "
        "steps. "
        "Islands at rest are not solved. Differences are from the default mode, at the end of the run; the pyramid is "
        "another law of friction. Where the scene ends in motion, small differences have had time to grow.</p>\n",
        stream);
    open_table((const char *const[]){"<scene", "<mode", "<status", "<outcome", "iterations<br>of a solve", "most",
                                     "solved by<br>projections", "by Newton", "along<br>a flow",
                                     "first solves<br>failed", "&micro;s a step", "of it solving", "force differs<br>N",
                                     "position<br>differs m", NULL},
               stream);
    json_array_foreach(scenes, i, of) json_array_foreach(json_object_get(of, "runs"), k, r)
    {
        fputs("<tr>", stream);
        text_cell(k ? "" : text_of(of, "scene"), "text", stream);
        text_cell(text_of(r, "mode"), "text", stream);
        text_cell(text_of(r, "status"), strcmp(text_of(r, "status"), "converged") == 0 ? "text good" : "text bad",
                  stream);
        text_cell(text_of(r, "outcome"), "text", stream);
        cell(json_object_get(r, "iterations_of_a_solve"), 1, "%.2f", stream);
        cell(json_object_get(r, "iterations_max"), 1, "%.0f", stream);
        cell(json_object_get(r, "by_projections"), 1, "%.0f", stream);
        cell(json_object_get(r, "by_newton"), 1, "%.0f", stream);
        cell(json_object_get(r, "by_flow"), 1, "%.0f", stream);
        cell(json_object_get(r, "first_solves_failed"), 1, "%.0f", stream);
        cell(json_object_get(r, "step_us"), 1, "%.2f", stream);
        cell(json_object_get(r, "solve_us"), 1, "%.2f", stream);
        cell(json_object_get(r, "force_difference_N"), 1, "%.1e", stream);
        cell(json_object_get(r, "position_difference_m"), 1, "%.1e", stream);
        fputs("</tr>\n", stream);
    }
    close_table(stream);
}

void paper_page(const json_t *document, FILE *stream)
{
    size_t i;
    json_t *example;
    fputs("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
          "content=\"width=device-width,initial-scale=1\"><title>The paper's examples by Pinch</title>"
          "<link rel=\"icon\" href=\"data:,\"><style>",
          stream);
    fputs(view_style_css, stream);
    fputs(view_paper_css, stream);
    fputs("</style></head><body>\n<h1>The examples of Ai and Li, reproduced</h1>\n<p>", stream);
    put_text(text_of(document, "source"), stream);
    fputs(" Parameters that the text has lost are chosen, and marked so.</p>\n<p>", stream);
    put_text(text_of(document, "reconstruction"), stream);
    fputs("</p>\n", stream);
    put_claims(document, stream);
    put_rows(document, stream);
    put_operations(document, stream);
    put_comparison(document, stream);
    json_array_foreach(json_object_get(document, "examples"), i, example) put_example(example, stream);
    put_solvers(document, stream);
    put_random(document, stream);
    put_dynamics(document, stream);
    fputs("</body></html>\n", stream);
}
