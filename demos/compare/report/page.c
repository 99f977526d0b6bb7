/* The page: its style sheet, tables and sections. */
#include "report.h"

#include "common/output.h"
#include "compare/access.h"

/* The page's style sheet, for light and dark, screen and paper. The colours follow Okabe and Ito's palette, darker on
 * white and lighter on black, so that lines keep a contrast of 3:1 and text one of 4.5:1. Runs are told apart by colour
 * and by dashes. */
static const char *const sheet[] = {
    ":root{--ink:#1b1f24;--dim:#57606a;--paper:#fff;--card:#f6f8fa;--rule:#d0d7de;--link:#0550ae;",
    "--s0:#0059b3;--s1:#c2410c;--s2:#9a6700;--s3:#a3357a;--s4:#0a7a55;--s5:#6639ba;--s6:#5c5f62;--s7:#006d77;",
    "--s8:#8a4b08;--s9:#b42318;--good:#dafbe1;--fair:#fff8c5;--bad:#ffe2dd;--shape:#d8dee4;--tip:#c8d7ea;",
    "color-scheme:light dark}\n",
    "@media (prefers-color-scheme:dark){:root{--ink:#e6edf3;--dim:#9da7b1;--paper:#0d1117;--card:#161b22;",
    "--rule:#3d444d;--link:#6cb6ff;--s0:#58a6ff;--s1:#ff8a5c;--s2:#e3b341;--s3:#f08bc4;--s4:#3fcf95;--s5:#b794f6;",
    "--s6:#b1bac4;--s7:#5fc9d4;--s8:#e0a36a;--s9:#ff7b72;--good:#12321f;--fair:#332a09;--bad:#42180f;",
    "--shape:#30363d;--tip:#26384f}}\n",
    "*{box-sizing:border-box}body{margin:0 auto;padding:1rem 1.5rem 3rem;max-width:78rem;color:var(--ink);",
    "background:var(--paper);font:16px/1.5 system-ui,'DejaVu Sans',sans-serif}\n",
    "h1{font-size:1.7rem;line-height:1.2;margin:.6rem 0}h2{font-size:1.35rem;margin:2.2rem 0 .4rem;padding-top:.6rem;",
    "border-top:2px solid var(--rule)}h3{font-size:1.05rem;margin:1.2rem 0 .3rem}p{max-width:60rem;margin:.5rem 0}\n",
    "a{color:var(--link)}.note{color:var(--dim);font-size:.9rem}.defs{position:absolute}\n",
    ".wide{overflow-x:auto;margin:.8rem 0}table{border-collapse:collapse;font-size:.88rem;",
    "font-variant-numeric:tabular-nums;width:100%}caption{text-align:left;color:var(--dim);padding:.3rem 0;",
    "font-size:.9rem}th,td{padding:.22rem .6rem;border-bottom:1px solid "
    "var(--rule);text-align:right;white-space:nowrap}",
    "th:first-child,td.text,.metrics th:nth-child(2){text-align:left}thead th{border-bottom:2px solid "
    "var(--rule);vertical-align:bottom}",
    "tbody th{font-weight:500}td.unit{color:var(--dim);text-align:left}sup{line-height:0}\n",
    "td.exact{background:var(--good)}td.close{background:var(--fair)}td.off,td.dropped{background:var(--bad)}\n",
    ".verdicts{list-style:none;padding:0;margin:.6rem 0}.verdicts li{margin:.2rem 0;padding-left:1.3rem;",
    "text-indent:-1.3rem}.key{display:inline-block;width:.8rem;height:.8rem;margin-right:.5rem;border-radius:2px;",
    "background:var(--c);vertical-align:-1px}.legend{white-space:nowrap;margin-left:.6rem}",
    ".swatch{width:30px;height:8px;margin-right:.3rem;vertical-align:middle}\n",
    ".figures{display:grid;grid-template-columns:repeat(auto-fill,minmax(19rem,1fr));gap:.9rem}",
    ".chart{margin:0;padding:.5rem .6rem;background:var(--card);border:1px solid var(--rule);border-radius:6px}",
    ".chart figcaption{font-size:.85rem;font-weight:600;margin-bottom:.2rem}.chart svg{display:block;width:100%;",
    "height:auto}svg text{font:11px system-ui,'DejaVu Sans',sans-serif;fill:var(--ink)}svg .mid{text-anchor:middle}",
    "svg .end{text-anchor:end}svg .power{font-size:8px}\n",
    ".grid{stroke:var(--rule);stroke-width:.7;fill:none}.frame{stroke:var(--dim);stroke-width:1;fill:none}",
    ".line{fill:none;stroke:var(--c);stroke-width:1.5;stroke-linejoin:round}.line.s0{stroke-width:2}",
    ".line.s1{stroke-dasharray:6 3}.line.s2{stroke-dasharray:2 2}.line.s3{stroke-dasharray:8 2 2 2}",
    ".line.s4{stroke-dasharray:10 4}.line.s5{stroke-dasharray:4 4}.bar{fill:var(--c)}\n",
    ".arrow{fill:none;stroke:var(--c);stroke-width:2.4}.arrow.s1{stroke-width:1.8;stroke-dasharray:5 3}",
    ".cone{fill:var(--s4);fill-opacity:.14;stroke:var(--s4);stroke-width:.8}.paper{fill:var(--paper)}",
    ".object{fill:var(--shape);fill-opacity:.7;stroke:var(--ink);stroke-width:1.2}.finger{fill:var(--tip);fill-opacity:"
    ".75;",
    "stroke:var(--dim);stroke-width:1}.environment{fill:var(--rule);fill-opacity:.5;stroke:var(--dim)}\n",
    ".s0{--c:var(--s0)}.s1{--c:var(--s1)}.s2{--c:var(--s2)}.s3{--c:var(--s3)}.s4{--c:var(--s4)}.s5{--c:var(--s5)}",
    ".s6{--c:var(--s6)}.s7{--c:var(--s7)}.s8{--c:var(--s8)}.s9{--c:var(--s9)}\n",
    "@media print{:root{--ink:#000;--dim:#444;--paper:#fff;--card:#fff;--rule:#bbb;--link:#000;--s0:#0059b3;",
    "--s1:#c2410c;--s2:#9a6700;--s3:#a3357a;--s4:#0a7a55;--s5:#6639ba;--good:#dafbe1;--fair:#fff8c5;--bad:#ffe2dd;",
    "--shape:#d8dee4;--tip:#c8d7ea;color-scheme:light}body{max-width:none;padding:0;font-size:10pt}",
    "section{break-before:page}section:first-of-type{break-before:auto}.chart,tr{break-inside:avoid}",
    "h2,h3{break-after:avoid}.figures{grid-template-columns:repeat(3,1fr);gap:.4rem}table{font-size:7.5pt}",
    "th,td{padding:.1rem .3rem}.wide{overflow:visible}*{-webkit-print-color-adjust:exact;print-color-adjust:exact}",
    ".chart figcaption{font-size:7.5pt}@page{margin:14mm}}\n",
};

static void write_style(FILE *stream)
{
    for (size_t i = 0; i < sizeof sheet / sizeof *sheet; i++) fputs(sheet[i], stream);
}

/* A cell shows a rounded number for people and has the exact one for programs. */
static void write_cell(const json_t *of_scene, const json_t *run, metric m, FILE *stream)
{
    double value = access_metric(run, m);
    const metric_info *about = metric_about(m);
    char text[32] = "";
    if (!isnan(value)) json_number_text(value, text);
    fputs("<td data-scene=\"", stream);
    html_text(access_text(of_scene, "name"), stream);
    fprintf(stream, "\" data-run=\"%s\" data-metric=\"%s\" data-value=\"%s\">", access_text(run, "run"), about->key,
            text);
    if (*about->unit || isnan(value))
        html_number(value, stream);
    else
        fputs(value != 0 ? "yes" : "no", stream);
    fputs("</td>", stream);
}

static void write_run_heads(const json_t *runs, FILE *stream)
{
    for (size_t k = 0; k < json_array_size(runs); k++) {
        fprintf(stream, "<th scope=\"col\"><span class=\"key %s\"></span>", html_run_class(k));
        html_text(access_text(json_array_get(runs, k), "run"), stream);
        fputs("</th>", stream);
    }
}

static void write_metrics(const json_t *of_scene, FILE *stream)
{
    const json_t *runs = json_object_get(of_scene, "runs");
    fputs("<div class=\"wide\"><table class=\"metrics\"><caption>Metrics of ", stream);
    html_text(access_text(of_scene, "name"), stream);
    fputs("</caption><thead><tr><th scope=\"col\">metric</th><th scope=\"col\">unit</th>", stream);
    write_run_heads(runs, stream);
    fputs("</tr></thead><tbody>\n", stream);
    for (int m = 0; m < METRIC_COUNT; m++) {
        const metric_info *about = metric_about((metric)m);
        fputs("<tr><th scope=\"row\" title=\"", stream);
        html_text(about->about, stream);
        fprintf(stream, "\">%s</th><td class=\"unit\">%s</td>", about->label,
                strcmp(about->unit, "us") == 0  ? "&micro;s"
                : strcmp(about->unit, "1") == 0 ? ""
                                                : about->unit);
        for (size_t k = 0; k < json_array_size(runs); k++)
            write_cell(of_scene, json_array_get(runs, k), (metric)m, stream);
        fputs("</tr>\n", stream);
    }
    fputs("</tbody></table></div>\n", stream);
}

static void write_verdicts(const json_t *of_scene, FILE *stream)
{
    const json_t *runs = json_object_get(of_scene, "runs");
    fputs("<ul class=\"verdicts\">\n", stream);
    for (size_t k = 0; k < json_array_size(runs); k++) {
        const json_t *run = json_array_get(runs, k);
        fprintf(stream, "<li><span class=\"key %s\"></span><strong>", html_run_class(k));
        html_text(access_text(run, "run"), stream);
        fputs("</strong>: ", stream);
        verdict_write(of_scene, run, stream);
        fputs("</li>\n", stream);
    }
    fputs("</ul>\n", stream);
}

/* A chart with the same curve of every run. `finger` is the finger that it is about, or -1. A run in which the object
 * was dropped does not set the range. */
static void write_curves(const json_t *of_scene, const char *title, const char *key, const char *unit, int finger,
                         FILE *stream)
{
    const json_t *runs = json_object_get(of_scene, "runs");
    chart c = {.title = title, .x_label = "time, s", .y_unit = unit, .least = 1e-8}; /* 10 nm, 10 nN, ... */
    for (size_t k = 0; k < json_array_size(runs) && c.count < CHART_MOST_SERIES; k++) {
        const json_t *run = json_array_get(runs, k), *curves = json_object_get(run, "curves"), *from = curves;
        if (finger >= 0) from = json_array_get(json_object_get(curves, "fingers"), (size_t)finger);
        if (k == 0 && strcmp(key, "divergence") == 0) continue; /* Pinch's distance from itself */
        c.series[c.count++] = (chart_series){html_run_class(k), json_object_get(curves, "time"),
                                             json_object_get(from, key), !(access_metric(run, METRIC_DROPPED) > 0)};
    }
    if (c.count > 0) c.series[0].sets_range = true;
    c.log_y = strcmp(key, "divergence") == 0 || strcmp(key, "balance") == 0;
    c.floor = strcmp(key, "divergence") == 0 ? 1e-12 : 1e-17;
    chart_write(&c, stream);
}

static void write_finger_curves(const json_t *of_scene, FILE *stream)
{
    const json_t *pinch = json_array_get(json_object_get(of_scene, "runs"), 0);
    const json_t *fingers = json_object_get(json_object_get(pinch, "curves"), "fingers");
    fputs("<h3>Forces and slip, finger by finger</h3><div class=\"figures\">\n", stream);
    for (size_t f = 0; f < json_array_size(fingers); f++) {
        static const char *const keys[] = {"normal", "tangential", "slip"}, *const units[] = {"N", "N", "m"};
        static const char *const names[] = {"normal force", "tangential force", "slip path"};
        for (int i = 0; i < 3; i++) {
            char title[160];
            snprintf(title, sizeof title, "%.100s: %s", access_text(json_array_get(fingers, f), "name"), names[i]);
            write_curves(of_scene, title, keys[i], units[i], (int)f, stream);
        }
    }
    fputs("</div>\n", stream);
}

/* Pinch's residuals in the sampled solve that took most iterations, against 1, 2, ... */
static json_t *longest_solve(const json_t *of_scene, json_t *iterations)
{
    const json_t *samples = json_object_get(of_scene, "samples");
    const json_t *longest = NULL;
    for (size_t i = 0; i < json_array_size(samples); i++) {
        const json_t *residuals = json_object_get(json_array_get(samples, i), "residuals");
        if (json_array_size(residuals) > json_array_size(longest)) longest = residuals;
    }
    for (size_t i = 0; i < json_array_size(longest); i++)
        (void)json_array_append_new(iterations, json_integer((int)i + 1));
    return json_incref((json_t *)longest);
}

static void write_convergence(const json_t *of_scene, FILE *stream)
{
    const json_t *convergence = json_object_get(of_scene, "convergence");
    json_t *iterations = json_array(), *residuals = longest_solve(of_scene, iterations);
    chart c = {.title = "Residual of Pinch's longest sampled solve, and quickstep's force error, by iterations",
               .x_label = "evaluations of Pinch, iterations of quickstep",
               .y_unit = "",
               .log_x = true,
               .log_y = true,
               .floor = 1e-17,
               .count = 2};
    c.series[0] = (chart_series){html_run_class(0), iterations, residuals, true};
    c.series[1] = (chart_series){html_run_class(1), json_object_get(convergence, "iterations"),
                                 json_object_get(convergence, "quickstep"), true};
    chart_write(&c, stream);
    json_decref(iterations);
    json_decref(residuals);
}

static void write_scene(const json_t *of_scene, size_t number, FILE *stream)
{
    fprintf(stream, "<section id=\"scene-%zu\"><h2>", number);
    html_text(access_text(of_scene, "name"), stream);
    fprintf(stream, "</h2><p>%.6g&nbsp;s in %.0f steps; ODE&rsquo;s solvers get %s.</p>\n",
            access_number(of_scene, "time_s"), access_number(of_scene, "steps"),
            strcmp(access_text(of_scene, "contacts"), "pinch") == 0 ? "the points of Pinch&rsquo;s manifolds"
                                                                    : "their collider&rsquo;s contact points");
    write_verdicts(of_scene, stream);
    fputs("<div class=\"figures\">\n", stream);
    picture_write(of_scene, stream);
    bars_errors(of_scene, stream);
    bars_cost(of_scene, stream);
    write_convergence(of_scene, stream);
    write_curves(of_scene, "Distance from Pinch's run, m", "divergence", "", -1, stream);
    fputs("</div>\n<h3>The object&rsquo;s motion</h3><div class=\"figures\">\n", stream);
    write_curves(of_scene, "Displacement along x", "x", "m", -1, stream);
    write_curves(of_scene, "Displacement along y", "y", "m", -1, stream);
    write_curves(of_scene, "Displacement along z", "z", "m", -1, stream);
    write_curves(of_scene, "Rotation", "rotation", "rad", -1, stream);
    write_curves(of_scene, "What the forces leave of the momentum's change, N", "balance", "", -1, stream);
    fputs("</div>\n", stream);
    write_finger_curves(of_scene, stream);
    write_metrics(of_scene, stream);
    fputs("</section>\n", stream);
}

static void write_summary(const json_t *scenes, FILE *stream)
{
    const json_t *head = json_object_get(json_array_get(scenes, 0), "runs");
    fputs("<div class=\"wide\"><table class=\"summary\"><caption>Largest force error against the exact answer of the "
          "same "
          "step, over the largest force: <b>exact</b> to 10<sup>&minus;9</sup>, <b>close</b> to 1&nbsp;%, <b>off</b> "
          "beyond; <b>dropped</b>: the object fell</caption><thead><tr><th scope=\"col\">scene</th>",
          stream);
    write_run_heads(head, stream);
    fputs("<th scope=\"col\">Pinch&rsquo;s cost</th></tr></thead><tbody>\n", stream);
    for (size_t i = 0; i < json_array_size(scenes); i++) {
        const json_t *of_scene = json_array_get(scenes, i), *runs = json_object_get(of_scene, "runs");
        fprintf(stream, "<tr><th scope=\"row\"><a href=\"#scene-%zu\">", i);
        html_text(access_text(of_scene, "name"), stream);
        fputs("</a></th>", stream);
        for (size_t k = 0; k < json_array_size(runs); k++) {
            const json_t *run = json_array_get(runs, k);
            const char *word = verdict_word(verdict_of(run));
            fprintf(stream, "<td class=\"%s\"><b>%s</b> ", word, word);
            html_number(access_metric(run, METRIC_FORCE_ERROR_MAX), stream);
            fputs("</td>", stream);
        }
        fputs("<td>", stream);
        html_number(access_number(of_scene, "cost_ratio"), stream);
        fputs("&nbsp;&times;</td></tr>\n", stream);
    }
    fputs("</tbody></table></div>\n<p class=\"note\">Pinch&rsquo;s cost: of a step, over the fastest of ODE&rsquo;s "
          "solvers."
          "</p>\n",
          stream);
}

static void write_moves(const json_t *check, FILE *stream)
{
    const json_t *moves = json_object_get(check, "moved");
    if (!check) return;
    fputs("<section><h2>Against the baseline</h2><p>", stream);
    html_text(access_text(check, "baseline"), stream);
    fprintf(stream, ": %s</p>\n", json_array_size(moves) ? "these metrics moved." : "nothing moved.");
    if (json_array_size(moves) > 0) {
        fputs("<div class=\"wide\"><table><caption>What moved</caption><thead><tr><th scope=\"col\">scene</th><th "
              "scope=\"col\">run</th><th scope=\"col\">metric</th><th scope=\"col\">from</th><th "
              "scope=\"col\">to</th><th "
              "scope=\"col\">limit</th></tr></thead><tbody>\n",
              stream);
        for (size_t i = 0; i < json_array_size(moves); i++) {
            const json_t *move = json_array_get(moves, i);
            static const char *const texts[] = {"scene", "run", "metric"}, *const numbers[] = {"from", "to", "limit"};
            fputs("<tr>", stream);
            for (int k = 0; k < 3; k++) {
                fputs("<td class=\"text\">", stream);
                html_text(access_text(move, texts[k]), stream);
                fputs("</td>", stream);
            }
            for (int k = 0; k < 3; k++) {
                fputs("<td>", stream);
                html_number(access_number(move, numbers[k]), stream);
                fputs("</td>", stream);
            }
            fputs("</tr>\n", stream);
        }
        fputs("</tbody></table></div>", stream);
    }
    fputs("</section>\n", stream);
}

void report_write(const json_t *document, FILE *stream)
{
    const json_t *scenes = json_object_get(document, "scenes");
    fputs("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
          "content=\"width=device-width, initial-scale=1\"><title>Pinch beside quickstep and worldstep</title>"
          "<link rel=\"icon\" href=\"data:,\"><style>\n",
          stream);
    write_style(stream);
    fputs(
        "</style></head><body><svg width=\"0\" height=\"0\" class=\"defs\" aria-hidden=\"true\"><clipPath "
        "id=\"plot\"><rect "
        "x=\"52\" y=\"8\" width=\"299\" height=\"158\"/></clipPath></svg>\n"
        "<header><h1>Pinch beside quickstep and worldstep</h1>\n"
        "<p>Each scene ran with each solver from the same start. At sampled steps of Pinch&rsquo;s run the same "
        "contact "
        "problem was solved to machine precision by other means, and once by each of ODE&rsquo;s solvers: the force "
        "errors. ODE&rsquo;s contacts know neither tangential stiffness nor torsion, and their friction cone is a box: "
        "part of their error is the model&rsquo;s.</p></header>\n<main>\n",
        stream);
    if (json_array_size(scenes) > 0) {
        fputs("<section><h2>Summary</h2>\n", stream);
        write_summary(scenes, stream);
        fputs("<p class=\"note\">In the pictures: contact forces on the object by Pinch (solid) and by the first of "
              "ODE&rsquo;s runs (dashed), with the friction cones. In all charts:",
              stream);
        const json_t *runs = json_object_get(json_array_get(scenes, 0), "runs");
        for (size_t k = 0; k < json_array_size(runs); k++) {
            fprintf(stream,
                    " <span class=\"legend\"><svg viewBox=\"0 0 30 8\" class=\"swatch\"><path class=\"line %s\" "
                    "d=\"M0 4H30\"/></svg>",
                    html_run_class(k));
            html_text(access_text(json_array_get(runs, k), "run"), stream);
            fputs("</span>", stream);
        }
        fputs("</p></section>\n", stream);
    }
    write_moves(json_object_get(document, "check"), stream);
    for (size_t i = 0; i < json_array_size(scenes); i++) write_scene(json_array_get(scenes, i), i, stream);
    fputs("</main></body></html>\n", stream);
}
