/* pinch bench paper: iterations, residuals and times on the paper's examples, beside the published values. */
#include "bench.h"
#include "common/measure.h"
#include "common/output.h"
#include "plots.h"
#include "scenes/grasp.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { EXAMPLES = 5, FACES = 5, SEEDS = 50, REPEATS = 60 };
static const char *const names[EXAMPLES] = {"1", "1b", "2", "3", "4"};
static const int faces_tried[FACES] = {4, 5, 6, 8, 16};

/* The published values that are known (Ai and Li, Actuators 2025, 14(7), 307). faces 0: any number; NAN: not known. */
typedef struct published {
    const char *example;
    int faces;
    double speedup;
    double nsngrk_iterations, nsngrk_residual, nsngrk_time;
    double nsnmgk_iterations, nsnmgk_residual, nsnmgk_time;
} published;

static const published table[] = {
    {"1", 0, 1.1333, 703, 9.1901e-5, 0.26563, 458, 8.7787e-5, 0.23438},
    {"1b", 0, 1.9655, 3088, 9.7665e-5, 0.89063, 1637, 8.7375e-5, 0.45313},
    {"2", 4, 3.0, NAN, NAN, NAN, NAN, NAN, NAN},
    {"2", 8, 5.0, NAN, NAN, NAN, NAN, NAN, NAN},
    {"3", 4, 1.8182, NAN, NAN, NAN, NAN, NAN, NAN},
    {"3", 8, 3.9231, NAN, NAN, NAN, NAN, NAN, NAN},
};

/* One of the paper's examples, ready to be solved. */
typedef struct paper_example {
    const char *name; /* "1", "1b", "2", "3", "4" */
    scene *s;
    pinch_finger *fingers;
    pinch_finger_result *results;
    pinch_grasp grasp;
    bool frictional;
} paper_example;

typedef struct measurement {
    pinch_solve_status status; /* the worst of all runs */
    double iterations, residual;
    double time; /* s */
} measurement;

typedef struct row {
    const char *example;
    int faces; /* 0: no friction */
    measurement nsngrk, nsnmgk;
    measurement standard, lemke; /* not with --faithful */
} row;

static const published *find_published(const row *r)
{
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        if (strcmp(table[i].example, r->example) == 0 && table[i].faces == r->faces) return &table[i];
    return NULL;
}

static double speedup(const row *r)
{
    return r->nsngrk.time / r->nsnmgk.time;
}

/* The paper's own settings. */
static pinch_statics_settings paper_settings(int faces, pinch_solver solver, uint64_t seed)
{
    pinch_statics_settings settings = pinch_default_statics_settings();
    settings.formulation = PINCH_FORMULATION_LCP;
    settings.faces = faces;
    settings.solver.solver = solver;
    settings.solver.seed = seed;
    settings.faithful = true;
    return settings;
}

static pinch_statics_result solve_once(const paper_example *e, pinch_statics *statics,
                                       const pinch_statics_settings *settings, double *seconds)
{
    pinch_statics_result result = {.solve = {.status = PINCH_SOLVE_DIVERGED}};
    double start = clock_seconds();
    pinch_statics_solve(statics, &e->grasp, settings, e->results, &result);
    *seconds = clock_seconds() - start;
    return result;
}

/* The mean over the seeds, as in the paper. `first` is the first seed. */
static measurement measure_seeds(const paper_example *e, pinch_statics *statics, int faces, uint64_t first)
{
    measurement m = {.status = PINCH_SOLVE_CONVERGED};
    for (uint64_t k = 0; k < SEEDS; k++) {
        pinch_statics_settings settings = paper_settings(faces, PINCH_SOLVER_NSNGRK, first + k);
        double seconds;
        pinch_statics_result r = solve_once(e, statics, &settings, &seconds);
        if (r.solve.status != PINCH_SOLVE_CONVERGED) m.status = r.solve.status;
        m.iterations += (double)r.solve.iterations / SEEDS;
        m.residual += r.solve.residual / SEEDS;
        m.time += seconds / SEEDS;
    }
    return m;
}

/* This method is deterministic: it has one answer, and the median of the times is taken. */
static measurement measure(const paper_example *e, pinch_statics *statics, const pinch_statics_settings *settings)
{
    double times[REPEATS];
    pinch_statics_result r = {0};
    for (int i = 0; i < REPEATS; i++) r = solve_once(e, statics, settings, &times[i]);
    return (measurement){.status = r.solve.status,
                         .iterations = r.solve.iterations,
                         .residual = r.solve.residual,
                         .time = median(times, REPEATS)};
}

static row measure_row(const bench_request *o, const paper_example *e, pinch_statics *statics, int faces)
{
    row r = {.example = e->name, .faces = e->frictional ? faces : 0};
    pinch_statics_settings faithful = paper_settings(faces, PINCH_SOLVER_NSNMGK, 1), standard = faithful;
    standard.faithful = false;
    r.nsnmgk = measure(e, statics, &faithful);
    r.nsngrk = measure_seeds(e, statics, faces, o->seed);
    if (o->faithful) return r;
    r.standard = measure(e, statics, &standard);
    standard.solver.solver = PINCH_SOLVER_LEMKE;
    r.lemke = measure(e, statics, &standard);
    return r;
}

static json_t *measurement_document(const measurement *m)
{
    bool solved = m->status == PINCH_SOLVE_CONVERGED;
    return json_pack("{s:s, s:o, s:o, s:o}", "status", pinch_solve_status_text(m->status), "iterations",
                     json_number(m->iterations), "residual", json_number(solved ? m->residual : NAN), "time_s",
                     json_number(m->time));
}

static json_t *published_document(const published *p)
{
    if (!p) return json_null();
    return json_pack("{s:o, s:{s:o, s:o, s:o}, s:{s:o, s:o, s:o}}", "speedup", json_number(p->speedup), "nsngrk",
                     "iterations", json_number(p->nsngrk_iterations), "residual", json_number(p->nsngrk_residual),
                     "time_s", json_number(p->nsngrk_time), "nsnmgk", "iterations", json_number(p->nsnmgk_iterations),
                     "residual", json_number(p->nsnmgk_residual), "time_s", json_number(p->nsnmgk_time));
}

static bool print_document(const bench_request *o, const row *rows, int count)
{
    json_t *list = json_array();
    for (int i = 0; i < count; i++) {
        const row *r = &rows[i];
        json_t *document =
            json_pack("{s:s, s:o, s:o, s:o, s:o, s:o}", "example", r->example, "faces",
                      r->faces > 0 ? json_integer(r->faces) : json_null(), "speedup", json_number(speedup(r)), "nsngrk",
                      measurement_document(&r->nsngrk), "nsnmgk", measurement_document(&r->nsnmgk), "published",
                      published_document(find_published(r)));
        if (!o->faithful) {
            json_object_set_new(document, "default", measurement_document(&r->standard));
            json_object_set_new(document, "lemke", measurement_document(&r->lemke));
        }
        json_array_append_new(list, document);
    }
    json_t *document = json_pack("{s:s, s:s, s:o}", "command", "bench", "benchmark", "paper", "rows", list);
    return json_print_new(document, stdout);
}

/* "703" or "-" */
static const char *figure(double value, const char *format, char text[16])
{
    if (isnan(value))
        snprintf(text, 16, "-");
    else
        snprintf(text, 16, format, value); /* the formats are this file's own */
    return text;
}

static void print_others(const row *r)
{
    char lemke[16] = "";
    if (r->lemke.status == PINCH_SOLVE_CONVERGED)
        snprintf(lemke, sizeof lemke, "%.1f", 1e6 * r->lemke.time);
    else
        snprintf(lemke, sizeof lemke, "%s", pinch_solve_status_text(r->lemke.status));
    printf(" | %4.0f %9.1e %8.1f %7.1f | %10s", r->standard.iterations, r->standard.residual, 1e6 * r->standard.time,
           r->nsnmgk.time / r->standard.time, lemke);
}

static void print_row(const row *r, bool faithful)
{
    const published *p = find_published(r);
    char a[16], b[16], c[16], faces[16] = "-";
    if (r->faces > 0) snprintf(faces, sizeof faces, "%d", r->faces);
    printf("%-3s %5s | %8.1f %6s %9.2e %9.1f | %7.0f %6s %9.2e %9.1f | %7.2f %6s", r->example, faces,
           r->nsngrk.iterations, figure(p ? p->nsngrk_iterations : NAN, "%.0f", a), r->nsngrk.residual,
           1e6 * r->nsngrk.time, r->nsnmgk.iterations, figure(p ? p->nsnmgk_iterations : NAN, "%.0f", b),
           r->nsnmgk.residual, 1e6 * r->nsnmgk.time, speedup(r), figure(p ? p->speedup : NAN, "%.2f", c));
    if (!faithful) print_others(r);
    putchar('\n');
}

static void print_table(const row *rows, int count, bool faithful)
{
    printf("Example | NSNGRK, mean of %d seeds           | NSNMGK, median of %d           | speed-up in time%s\n",
           SEEDS, REPEATS, faithful ? "" : " | default mode                  | Lemke");
    printf("%-3s %5s | %8s %6s %9s %9s | %7s %6s %9s %9s | %7s %6s", "", "faces", "IT", "paper", "FRES", "TIME us",
           "IT", "paper", "FRES", "TIME us", "here", "paper");
    if (!faithful) printf(" | %4s %9s %8s %7s | %10s", "IT", "residual", "us", "faster", "us");
    putchar('\n');
    for (int i = 0; i < count; i++) print_row(&rows[i], faithful);
}

/* Every method of Pinch's must have converged. Lemke's method may end on a ray, which is a result. */
static bool all_converged(const row *rows, int count, bool faithful)
{
    for (int i = 0; i < count; i++)
        if (rows[i].nsngrk.status != PINCH_SOLVE_CONVERGED || rows[i].nsnmgk.status != PINCH_SOLVE_CONVERGED ||
            (!faithful && rows[i].standard.status != PINCH_SOLVE_CONVERGED))
            return false;
    return true;
}

/* ---- The paper's figures: log10 of the residual against the iterations, drawn by gnuplot. ---- */

/* Figures 2, 4, 6, 8 and 10 of the paper. */
static const struct {
    const char *example;
    int faces;
    int figure;
} figures[] = {{"1", 4, 2}, {"1b", 4, 4}, {"2", 5, 6}, {"3", 5, 8}, {"4", 8, 10}};
enum { FIGURES = sizeof figures / sizeof figures[0] };

static void write_progress(void *context, int iteration, double residual)
{
    fprintf(context, "%d %.6g\n", iteration, log10(residual));
}

static bool write_curve(const char *folder, const char *stem, const char *method, const paper_example *e,
                        pinch_statics_settings settings, pinch_statics *statics)
{
    char name[128];
    snprintf(name, sizeof name, "%s-%s", stem, method);
    FILE *stream = plots_data(folder, name);
    if (!stream) return false;
    fprintf(stream, "# iteration log10(residual)\n");
    settings.solver.progress = write_progress;
    settings.solver.progress_context = stream;
    pinch_statics_result result;
    pinch_statics_solve(statics, &e->grasp, &settings, e->results, &result);
    bool written = !ferror(stream);
    return fclose(stream) == 0 && written;
}

static bool draw(const char *folder, const char *stem, const char *title, uint64_t seed)
{
    char settings[512], plots[512];
    snprintf(settings, sizeof settings,
             "set title '%s'\nset xlabel 'IT (iterations)'\nset ylabel 'log10 RES'\nset grid\nset key top right\n",
             title);
    snprintf(plots, sizeof plots,
             "'%%s%s-nsngrk.dat' with lines lw 2 title 'NSNGRK (seed %" PRIu64 ")', "
             "'%%s%s-nsnmgk.dat' with lines lw 2 title 'NSNMGK'",
             stem, seed, stem);
    return plots_draw(folder, stem, settings, plots);
}

static command_status plot_figure(const char *folder, uint64_t seed, int figure, const paper_example *e,
                                  pinch_statics *statics)
{
    char stem[64], title[128], faces[32] = "";
    int n = figures[figure].faces;
    if (e->frictional) snprintf(faces, sizeof faces, "-%d-faces", n);
    snprintf(stem, sizeof stem, "example-%s%s", e->name, faces);
    snprintf(title, sizeof title, "Example %s%s%.0d%s: residual against iterations (Figure %d of the paper)", e->name,
             e->frictional ? ", " : "", e->frictional ? n : 0, e->frictional ? " faces" : "", figures[figure].figure);
    if (!write_curve(folder, stem, "nsngrk", e, paper_settings(n, PINCH_SOLVER_NSNGRK, seed), statics) ||
        !write_curve(folder, stem, "nsnmgk", e, paper_settings(n, PINCH_SOLVER_NSNMGK, seed), statics))
        return COMMAND_SYSTEM;
    if (draw(folder, stem, title, seed)) return COMMAND_DONE;
    plots_complain(folder, stem);
    return COMMAND_SYSTEM;
}

static command_status paper_plot(const char *folder, uint64_t seed, paper_example *examples, int count,
                                 pinch_statics *statics)
{
    command_status made = plots_folder(folder);
    if (made != COMMAND_DONE) return made;
    for (int i = 0; i < FIGURES; i++)
        for (int k = 0; k < count; k++) {
            if (strcmp(examples[k].name, figures[i].example) != 0) continue;
            command_status status = plot_figure(folder, seed, i, &examples[k], statics);
            if (status != COMMAND_DONE) return status;
        }
    return COMMAND_DONE;
}

static void unload(paper_example *examples)
{
    for (int i = 0; i < EXAMPLES; i++) {
        if (examples[i].s) scene_free(examples[i].s);
        free(examples[i].fingers);
        free(examples[i].results);
    }
}

static command_status load(paper_example *examples)
{
    for (int i = 0; i < EXAMPLES; i++) {
        paper_example *e = &examples[i];
        char file[512];
        snprintf(file, sizeof file, "%s/scenes/paper/example-%s.json", PINCH_ASSETS_DIR, names[i]);
        scene_error error;
        scene_status loaded = scene_load(file, &e->s, &error);
        if (loaded != SCENE_OK) {
            message_print(error.text, stderr);
            fputc('\n', stderr);
            return loaded == SCENE_NO_MEMORY ? COMMAND_SYSTEM : COMMAND_BAD_INPUT;
        }
        e->name = names[i];
        e->fingers = calloc(e->s->finger_count, sizeof *e->fingers);
        e->results = calloc(e->s->finger_count, sizeof *e->results);
        if (!e->fingers || !e->results) return COMMAND_SYSTEM;
        scene_static_grasp(e->s, e->fingers, &e->grasp);
        for (int f = 0; f < e->grasp.finger_count; f++)
            if (e->fingers[f].model != PINCH_CONTACT_FRICTIONLESS) e->frictional = true;
    }
    return COMMAND_DONE;
}

static command_status measure_all(const bench_request *o, paper_example *examples, pinch_statics *statics)
{
    row rows[EXAMPLES * FACES];
    int count = 0;
    const bool one = o->faces > 0;
    for (int i = 0; i < EXAMPLES; i++)
        for (int k = 0; k < (examples[i].frictional && !one ? FACES : 1); k++)
            rows[count++] = measure_row(o, &examples[i], statics, one ? o->faces : faces_tried[k]);
    if (o->json) {
        if (!print_document(o, rows, count)) return COMMAND_SYSTEM;
    } else if (!o->quiet) {
        print_table(rows, count, o->faithful);
    }
    command_status status = all_converged(rows, count, o->faithful) ? COMMAND_DONE : COMMAND_FAILED;
    if (o->plot) {
        command_status plotted = paper_plot(o->plot, o->seed, examples, EXAMPLES, statics);
        if (plotted > status) status = plotted;
    }
    return status;
}

command_status bench_paper(const bench_request *o)
{
    enum { MOST_FINGERS = 6 };
    const int most_faces = o->faces > faces_tried[FACES - 1] ? o->faces : faces_tried[FACES - 1];
    paper_example examples[EXAMPLES] = {{0}};
    pinch_statics *statics = NULL;
    command_status status = load(examples);
    if (status == COMMAND_DONE && pinch_statics_create(MOST_FINGERS, most_faces, &statics) != PINCH_OK)
        status = COMMAND_SYSTEM;
    if (status == COMMAND_DONE) status = measure_all(o, examples, statics);
    if (status == COMMAND_SYSTEM) command_error("bench", "the system failed: memory or disk");
    pinch_statics_destroy(statics);
    unload(examples);
    return status;
}
