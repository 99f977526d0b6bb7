/* pinch bench paper: the paper's examples by its two methods and by others, beside the published values. */
#include "paper/paper.h"
#include "bench.h"
#include "common/measure.h"
#include "common/output.h"
#include "common/whole_file.h"
#include "view/plot.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FACES = 5, MOST_ROWS = PAPER_EXAMPLES * FACES };
static const int faces_tried[FACES] = {4, 5, 6, 8, 16};

/* "703" or "-" */
static const char *figure(const json_t *value, const char *format, char text[16])
{
    if (!value)
        snprintf(text, 16, "-");
    else
        snprintf(text, 16, format, json_number_value(value)); /* the formats are this file's own */
    return text;
}

static void print_others(const paper_row *r)
{
    char lemke[16] = "";
    if (r->lemke.status == PINCH_SOLVE_CONVERGED)
        snprintf(lemke, sizeof lemke, "%.1f", 1e6 * r->lemke.time.median);
    else
        snprintf(lemke, sizeof lemke, "%s", pinch_solve_status_text(r->lemke.status));
    printf(" | %4.0f %9.1e %8.1f %7.1f | %10s", r->standard.iterations, r->standard.residual,
           1e6 * r->standard.time.median, r->pair.nsnmgk.time.median / r->standard.time.median, lemke);
}

static void print_row(const paper_row *r, bool faithful, const json_t *published)
{
    const paper_pair *p = &r->pair;
    char a[16], b[16], c[16], faces[16] = "-";
    if (r->faces > 0) snprintf(faces, sizeof faces, "%d", r->faces);
    const json_t *random = paper_published_value(published, r->example, r->faces, "nsngrk", "iterations"),
                 *sweeps = paper_published_value(published, r->example, r->faces, "nsnmgk", "iterations"),
                 *speedup = paper_published_value(published, r->example, r->faces, "both", "speedup");
    printf("%-3s %5s | %8.1f %6s %9.2e %9.1f | %7.0f %6s %9.2e %9.1f | %5.2f %4.2f-%-4.2f %6s", r->example, faces,
           p->nsngrk.iterations, figure(random, "%.0f", a), p->nsngrk.residual, 1e6 * p->nsngrk.time.median,
           p->nsnmgk.iterations, figure(sweeps, "%.0f", b), p->nsnmgk.residual, 1e6 * p->nsnmgk.time.median,
           p->speedup.median, p->speedup.low, p->speedup.high, figure(speedup, "%.2f", c));
    if (!faithful) print_others(r);
    putchar('\n');
}

static void print_table(const paper_row *rows, int count, bool faithful, const json_t *published)
{
    printf("Example | NSNGRK, %d seeds                     | NSNMGK                             | speed-up in CPU "
           "time%s\n",
           PAPER_SEEDS, faithful ? "" : " | default mode                  | Lemke");
    printf("%-3s %5s | %8s %6s %9s %9s | %7s %6s %9s %9s | %5s %9s %6s", "", "faces", "IT mean", "paper", "FRES",
           "TIME us", "IT", "paper", "FRES", "TIME us", "here", "quartiles", "paper");
    if (!faithful) printf(" | %4s %9s %8s %7s | %10s", "IT", "residual", "us", "faster", "us");
    putchar('\n');
    for (int i = 0; i < count; i++) print_row(&rows[i], faithful, published);
}

/* Every method of Pinch's must have converged. Lemke's method may end on a ray, which is a result. */
static bool all_converged(const paper_row *rows, int count, bool faithful)
{
    for (int i = 0; i < count; i++)
        if (rows[i].pair.nsngrk.status != PINCH_SOLVE_CONVERGED ||
            rows[i].pair.nsnmgk.status != PINCH_SOLVE_CONVERGED ||
            (!faithful && rows[i].standard.status != PINCH_SOLVE_CONVERGED))
            return false;
    return true;
}

/* ---- The paper's figures: the residual against the iterations. ---- */

/* Figures 2, 4, 6, 8 and 10 of the paper. */
static const struct {
    const char *example;
    int faces;
    int figure;
} figures[] = {{"1", 4, 2}, {"1b", 4, 4}, {"2", 5, 6}, {"3", 5, 8}, {"4", 8, 10}};
enum { FIGURES = sizeof figures / sizeof figures[0] };

/* The residuals of a solve, as they are found. */
typedef struct curve {
    size_t count, room;
    double *iterations, *residuals;
    bool failed;
} curve;

static void add_residual(void *context, int iteration, double residual)
{
    curve *c = context;
    if (c->count == c->room) {
        size_t room = 2 * c->room + 256;
        double *iterations = realloc(c->iterations, room * sizeof *iterations);
        if (iterations) c->iterations = iterations;
        double *residuals = iterations ? realloc(c->residuals, room * sizeof *residuals) : NULL;
        if (residuals) c->residuals = residuals;
        c->failed = c->failed || !residuals;
        if (c->failed) return;
        c->room = room;
    }
    c->iterations[c->count] = iteration;
    c->residuals[c->count++] = residual;
}

static curve solve_curve(const paper_example *e, pinch_statics_settings settings, pinch_statics *statics)
{
    curve c = {.count = 0};
    pinch_statics_result result;
    settings.solver.progress = add_residual;
    settings.solver.progress_context = &c;
    pinch_statics_solve(statics, &e->grasp, &settings, e->results, &result);
    return c;
}

static command_status plot_figure(const char *folder, uint64_t seed, int figure, const paper_example *e,
                                  pinch_statics *statics)
{
    char stem[64], title[128], label[64], faces[32] = "";
    int n = figures[figure].faces;
    if (e->frictional) snprintf(faces, sizeof faces, "-%d-faces", n);
    snprintf(stem, sizeof stem, "example-%s%s", e->name, faces);
    snprintf(title, sizeof title, "Example %s%s%.0d%s: residual against iterations (Figure %d of the paper)", e->name,
             e->frictional ? ", " : "", e->frictional ? n : 0, e->frictional ? " faces" : "", figures[figure].figure);
    snprintf(label, sizeof label, "NSNGRK (seed %" PRIu64 ")", seed);
    curve random = solve_curve(e, paper_settings(n, PINCH_SOLVER_NSNGRK, seed), statics);
    curve greedy = solve_curve(e, paper_settings(n, PINCH_SOLVER_NSNMGK, seed), statics);
    plot p = {.title = title, .x_label = "iterations", .y_label = "residual", .log_y = true, .count = 2};
    p.lines[0] = (plot_line){"NSNMGK", greedy.count, greedy.iterations, greedy.residuals, false, false};
    p.lines[1] = (plot_line){label, random.count, random.iterations, random.residuals, true, false};
    command_status status = COMMAND_SYSTEM;
    if (random.failed || greedy.failed)
        command_error("bench", "out of memory");
    else
        status = plot_write("bench", folder, stem, &p);
    free(random.iterations);
    free(random.residuals);
    free(greedy.iterations);
    free(greedy.residuals);
    return status;
}

static command_status paper_plot(const char *folder, uint64_t seed, paper_example *examples, int count,
                                 pinch_statics *statics)
{
    command_status made = plot_folder("bench", folder);
    if (made != COMMAND_DONE) return made;
    for (int i = 0; i < FIGURES; i++)
        for (int k = 0; k < count; k++) {
            if (strcmp(examples[k].name, figures[i].example) != 0) continue;
            command_status status = plot_figure(folder, seed, i, &examples[k], statics);
            if (status != COMMAND_DONE) return status;
        }
    return COMMAND_DONE;
}

/* ---- The document. ---- */

static json_t *timing_document(const bench_request *o)
{
    return json_pack("{s:s, s:I, s:i, s:s, s:o}", "clock", "CPU time of the thread, the solve alone", "first_seed",
                     (json_int_t)o->seed, "seeds", PAPER_SEEDS, "order",
                     "runs of NSNGRK, each with one seed, and runs of NSNMGK take turns; a seed's time is the median "
                     "of its rounds; its speed-up is the median of its time over the mean of the two runs of NSNMGK "
                     "around it; the speed-up is the median of the seeds, its quartiles are theirs",
                     "instructions_counted", json_boolean(instructions_counted()));
}

static const char reconstruction[] = "The second algorithm survives without its formulas. What is solved here is a "
                                     "reconstruction: the threshold and the "
                                     "candidate rows are those of the first algorithm, whose text survives; an "
                                     "iteration projects onto the candidates in the order of their "
                                     "indices, with the Jacobian of the iteration's start, and evaluates the residual "
                                     "of a row anew where the iterate then is.";

static const char operations[] =
    "A row operation is a product of a row with a vector, or a sum with a multiple of one. An iteration of NSNGRK "
    "evaluates the residual of each of the n rows and updates the iterate once: n + 1 row operations. An iteration of "
    "NSNMGK does so, too, and makes p projections, each with an update and, but for the first, a residual of its row: "
    "n + 2 p - 1. Since p is at least one, its iteration is never the cheaper one, and the ratio of operations stays "
    "below the ratio of iterations, which the lost parameters decide. The last column says how many iterations NSNGRK "
    "would need, beside ours of NSNMGK, for the published ratio. Residuals that every projection keeps up to date, by "
    "products of the rows with each other, would take p (n + 1) row operations in place of n + 2 p - 1, which is more "
    "as soon as p is above one, and end in other last digits.";

/* What only the report and the whole document have. */
static bool add_details(json_t *document, const bench_request *o, paper_example *examples, pinch_statics *statics,
                        const json_t *published)
{
    json_t *list = json_array(), *solvers = json_array();
    for (int i = 0; i < PAPER_EXAMPLES; i++) {
        const json_t *about = json_array_get(json_object_get(published, "examples"), (size_t)i);
        progress_part(o->line, "what the examples answer");
        json_array_append_new(list, paper_example_document(&examples[i], statics, o->seed, about));
        for (int k = 0; k < (examples[i].frictional ? 2 : 1); k++)
            json_array_append_new(solvers, paper_solvers_document(&examples[i], statics, k == 0 ? 5 : 16));
    }
    return json_object_set_new(document, "examples", list) == 0 &&
           json_object_set_new(document, "reconstruction", json_string(reconstruction)) == 0 &&
           json_object_set_new(document, "operations", json_string(operations)) == 0 &&
           json_object_set(document, "source", json_object_get(published, "source")) == 0 &&
           json_object_set_new(document, "random_grasps", o->faces > 0 ? json_null() : paper_random_document(o)) == 0 &&
           json_object_set_new(document, "dynamics", o->faces > 0 ? json_null() : paper_dynamics_document(o)) == 0 &&
           json_object_set_new(document, "solvers", solvers) == 0 &&
           json_object_set_new(document, "comparison", paper_comparison_document(document, published)) == 0 &&
           json_object_set_new(document, "claims", paper_claims_document(document)) == 0;
}

static json_t *make_document(const bench_request *o, const paper_row *rows, int count, paper_example *examples,
                             pinch_statics *statics, const json_t *published)
{
    json_t *list = json_array();
    for (int i = 0; i < count; i++) json_array_append_new(list, paper_row_document(&rows[i], o->faithful, published));
    json_t *document = json_pack("{s:s, s:s, s:o, s:o}", "command", "bench", "benchmark", "paper", "timing",
                                 timing_document(o), "rows", list);
    if (document && !o->faithful && !add_details(document, o, examples, statics, published)) {
        json_decref(document);
        return NULL;
    }
    return document;
}

static command_status write_report(const char *path, const json_t *document)
{
    whole_file file;
    bool written = whole_file_open(&file, path);
    if (written) {
        paper_page(document, file.stream);
        written = whole_file_close(&file, true);
    }
    return written ? COMMAND_DONE : command_cannot_write("bench", path);
}

static command_status present(const bench_request *o, const paper_row *rows, int count, paper_example *examples,
                              pinch_statics *statics, const json_t *published)
{
    command_status status = all_converged(rows, count, o->faithful) ? COMMAND_DONE : COMMAND_FAILED;
    progress_end(o->line);
    if (!o->json && !o->quiet) print_table(rows, count, o->faithful, published);
    if (!o->json && !o->report) return status;
    json_t *document = make_document(o, rows, count, examples, statics, published);
    if (!document) return COMMAND_SYSTEM;
    if (o->report) {
        command_status wrote = write_report(o->report, document);
        if (wrote > status) status = wrote;
    }
    if (o->json) json_print(document, stdout);
    json_decref(document);
    return status;
}

/* How many parts the work has. A shipped scene takes about as long as an example with one number of faces. */
static int parts_of(const bench_request *o, const paper_example *examples)
{
    enum { SCENES = 16 };
    int parts = 0;
    for (int i = 0; i < PAPER_EXAMPLES; i++) parts += examples[i].frictional && o->faces == 0 ? FACES : 1;
    if ((!o->json && !o->report) || o->faithful) return parts;
    return parts + PAPER_EXAMPLES + (o->faces > 0 ? 0 : PAPER_RANDOM_SIZES + SCENES);
}

static command_status measure_all(const bench_request *o, paper_example *examples, pinch_statics *statics,
                                  const json_t *published)
{
    paper_row rows[MOST_ROWS];
    int count = 0;
    const bool one = o->faces > 0;
    o->line->parts = parts_of(o, examples);
    for (int i = 0; i < PAPER_EXAMPLES; i++)
        for (int k = 0; k < (examples[i].frictional && !one ? FACES : 1); k++) {
            progress_part(o->line, "the examples, by both methods");
            if (!paper_measure_row(o, &examples[i], statics, one ? o->faces : faces_tried[k], &rows[count++]))
                return COMMAND_SYSTEM;
        }
    command_status status = present(o, rows, count, examples, statics, published);
    if (o->plot) {
        command_status plotted = paper_plot(o->plot, o->seed, examples, PAPER_EXAMPLES, statics);
        if (plotted > status) status = plotted;
    }
    return status;
}

command_status bench_paper(const bench_request *o)
{
    if (o->report && o->faithful) {
        command_error("bench", "--report means nothing with --faithful, which leaves out what the report is about");
        return COMMAND_BAD_INPUT;
    }
    const int most_faces = o->faces > faces_tried[FACES - 1] ? o->faces : faces_tried[FACES - 1];
    paper_example examples[PAPER_EXAMPLES];
    pinch_statics *statics = NULL;
    command_status status = paper_load(examples);
    json_t *published = status == COMMAND_DONE ? paper_published() : NULL;
    if (status == COMMAND_DONE && (!published || pinch_statics_create(PAPER_MOST_FINGERS, most_faces, &statics) != 0))
        status = COMMAND_SYSTEM;
    if (status == COMMAND_DONE) status = measure_all(o, examples, statics, published);
    if (status == COMMAND_SYSTEM) command_error("bench", "the system failed: memory or disk");
    pinch_statics_destroy(statics);
    json_decref(published);
    paper_unload(examples);
    return status;
}
