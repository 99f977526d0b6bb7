/* What an example is, what its methods answer, and how their residuals fall. */
#include "paper.h"

#include "common/output.h"
#include "common/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- The configuration. ---- */

static bool is_published(const json_t *about, const char *what)
{
    size_t i;
    json_t *name;
    json_array_foreach(json_object_get(about, "published"), i,
                       name) if (strcmp(json_string_value(name), what) == 0) return true;
    return false;
}

/* Appends one parameter, `of` what (NULL: the whole), with its value, which is taken over. */
static void add_parameter(json_t *list, const json_t *about, const char *of, const char *quantity, const char *unit,
                          json_t *value)
{
    char what[96];
    snprintf(what, sizeof what, "%s%s%s", of ? of : "", of ? " " : "", quantity);
    json_array_append_new(list, json_pack("{s:s, s:s, s:o, s:s}", "name", what, "unit", unit, "value", value, "source",
                                          is_published(about, what) ? "published" : "chosen"));
}

static void add_finger(json_t *list, const json_t *about, const paper_example *e, int i)
{
    const pinch_finger *f = &e->fingers[i];
    const char *name = e->s->fingers[i].name;
    bool frictional = f->model != PINCH_CONTACT_FRICTIONLESS;
    add_parameter(list, about, name, "position", "m", json_numbers(e->s->fingers[i].point, 3));
    add_parameter(list, about, name, "normal", "", json_numbers(f->normal, 3));
    if (!f->force_controlled) add_parameter(list, about, name, "normal stiffness", "N/m", json_number(f->stiffness[0]));
    if (frictional) {
        add_parameter(list, about, name, "tangential stiffness", "N/m", json_number(f->stiffness[1]));
        add_parameter(list, about, name, "first tangent", "", json_numbers(f->tangent1, 3));
        add_parameter(list, about, name, "friction", "", json_number(f->friction));
    }
    if (f->force_controlled)
        add_parameter(list, about, name, "normal force", "N", json_number(f->normal_force));
    else
        add_parameter(list, about, name, "closing", "m", json_number(f->closing));
}

static json_t *parameters_document(const paper_example *e, const json_t *about)
{
    json_t *list = json_array();
    add_parameter(list, about, NULL, "dimension", "", json_integer(e->s->dimension));
    add_parameter(list, about, NULL, "number of fingers", "", json_integer(e->grasp.finger_count));
    add_parameter(list, about, NULL, "force on the object", "N", json_numbers(e->grasp.wrench, 3));
    add_parameter(list, about, NULL, "moment about the centre of mass", "N m", json_numbers(e->grasp.wrench + 3, 3));
    for (int i = 0; i < e->grasp.finger_count; i++) add_finger(list, about, e, i);
    return list;
}

static json_t *segment(const double a[3], const double b[3])
{
    return json_pack("[o, o]", json_numbers(a, 3), json_numbers(b, 3));
}

/* The object's edges. The examples have boxes and one prism, which is drawn by its two cross-sections and its sides. */
static json_t *edges_document(const paper_example *e)
{
    static const double corner[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    const scene_shape *shape = &e->s->objects[0].shape;
    const double *centre = e->s->objects[0].position;
    const bool is_box = shape->type == SCENE_BOX;
    const size_t count = is_box ? 4 : shape->u.prism.count;
    const double height = is_box ? shape->u.box.size[2] : shape->u.prism.height;
    json_t *edges = json_array();
    for (size_t i = 0; i < count; i++) {
        double ends[2][2][3]; /* of this corner and the next, at the bottom and at the top */
        for (size_t k = 0; k < 2; k++) {
            const size_t c = (i + k) % count;
            for (int top = 0; top < 2; top++) {
                for (int j = 0; j < 2; j++)
                    ends[k][top][j] = centre[j] + (is_box ? 0.5 * corner[c][j] * shape->u.box.size[j]
                                                          : shape->u.prism.vertices[2 * c + (size_t)j]);
                ends[k][top][2] = centre[2] + (top ? 0.5 : -0.5) * height;
            }
        }
        json_array_append_new(edges, segment(ends[0][0], ends[1][0]));
        if (e->s->dimension == 2) continue;
        json_array_append_new(edges, segment(ends[0][1], ends[1][1]));
        json_array_append_new(edges, segment(ends[0][0], ends[0][1]));
    }
    return edges;
}

/* ---- The answers. ---- */

/* Sums of the numbers that are reported of a finger, over one or many solves. */
typedef struct finger_sums {
    double normal, tangential, depth, slip;
} finger_sums;

typedef struct answer {
    int solves, failed;
    finger_sums fingers[PAPER_MOST_FINGERS];
    double translation[3], rotation[3];
    double errors[PAPER_SEEDS]; /* N, largest distance of a finger's force from the exact one, by solve */
} answer;

static void add_solve(const paper_example *e, const pinch_statics_result *r, const pinch_finger_result *exact,
                      answer *sum)
{
    if (r->solve.status != PINCH_SOLVE_CONVERGED) {
        sum->failed++;
        return;
    }
    double worst = 0.0;
    for (int i = 0; i < e->grasp.finger_count; i++) {
        const pinch_finger_result *f = &e->results[i];
        sum->fingers[i].normal += f->r[0];
        sum->fingers[i].tangential += hypot(f->r[1], f->r[2]);
        sum->fingers[i].depth += f->normal_displacement;
        sum->fingers[i].slip += scene_norm(f->slip);
        double apart[3] = {f->r[0] - exact[i].r[0], f->r[1] - exact[i].r[1], f->r[2] - exact[i].r[2]};
        worst = fmax(worst, scene_norm(apart));
    }
    for (int j = 0; j < 3; j++) {
        sum->translation[j] += r->translation[j];
        sum->rotation[j] += r->rotation[j];
    }
    sum->errors[sum->solves++] = worst;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static json_t *answer_document(const paper_example *e, answer *sum)
{
    const double part = 1.0 / sum->solves; /* of none: NaN, which is null */
    json_t *fingers = json_array();
    for (int i = 0; i < e->grasp.finger_count; i++) {
        const finger_sums *f = &sum->fingers[i];
        json_array_append_new(fingers, json_pack("{s:s, s:o, s:o, s:o, s:o}", "name", e->s->fingers[i].name,
                                                 "normal_force", json_number(part * f->normal), "tangential_force",
                                                 json_number(part * f->tangential), "normal_displacement",
                                                 json_number(part * f->depth), "slip", json_number(part * f->slip)));
    }
    for (int j = 0; j < 3; j++) {
        sum->translation[j] *= part;
        sum->rotation[j] *= part;
    }
    qsort(sum->errors, (size_t)sum->solves, sizeof *sum->errors, ascending);
    return json_pack("{s:i, s:i, s:o, s:{s:o, s:o}, s:{s:o, s:o}}", "solves", sum->solves, "failed", sum->failed,
                     "fingers", fingers, "object", "translation", json_numbers(sum->translation, 3), "rotation",
                     json_numbers(sum->rotation, 3), "force_error_N", "median",
                     json_number(sum->solves > 0 ? sum->errors[sum->solves / 2] : NAN), "worst",
                     json_number(sum->solves > 0 ? sum->errors[sum->solves - 1] : NAN));
}

static json_t *answers_document(paper_example *e, pinch_statics *statics, int faces, uint64_t first)
{
    pinch_finger_result exact[PAPER_MOST_FINGERS];
    pinch_statics_settings settings = pinch_default_statics_settings();
    pinch_statics_result r = {.load_fraction = NAN};
    answer default_mode = {0}, random = {0}, sweeps = {0};
    settings.formulation = PINCH_FORMULATION_LCP;
    settings.faces = faces;
    pinch_statics_solve(statics, &e->grasp, &settings, e->results, &r);
    memcpy(exact, e->results, (size_t)e->grasp.finger_count * sizeof *exact);
    add_solve(e, &r, exact, &default_mode);
    for (int k = 0; k <= PAPER_SEEDS; k++) {
        bool is_sweep = k == PAPER_SEEDS;
        settings = paper_settings(faces, is_sweep ? PINCH_SOLVER_NSNMGK : PINCH_SOLVER_NSNGRK, first + (uint64_t)k);
        pinch_statics_solve(statics, &e->grasp, &settings, e->results, &r);
        add_solve(e, &r, exact, is_sweep ? &sweeps : &random);
    }
    return json_pack("{s:o, s:o, s:o}", "nsngrk", answer_document(e, &random), "nsnmgk", answer_document(e, &sweeps),
                     "default", answer_document(e, &default_mode));
}

/* ---- The residual curves: log10 of the residual at some iterations. ---- */

enum { POINTS = 120 };

/* Notes the residual at each point of a grid. */
typedef struct curve {
    double step; /* iterations between points */
    int count;   /* points noted */
    double log_residual[POINTS];
} curve;

static void note_residual(void *context, int iteration, double residual)
{
    curve *c = context;
    while (c->count < POINTS && iteration >= c->step * c->count) c->log_residual[c->count++] = log10(residual);
}

static int trace(paper_problem *problem, pinch_solver solver, uint64_t seed, curve *c)
{
    pinch_solver_settings settings = paper_settings(problem->faces, solver, seed).solver;
    c->count = 0;
    settings.progress = note_residual;
    settings.progress_context = c;
    return paper_problem_solve(problem, &settings).iterations;
}

static json_t *points_document(const curve *c)
{
    json_t *list = json_array();
    for (int i = 0; i < c->count; i++)
        json_array_append_new(list, json_pack("[f, f]", c->step * i, c->log_residual[i]));
    return list;
}

/* The least, median and largest over the seeds at each point of the grid, as long as half of the seeds still run. */
static json_t *band_document(curve *seeds)
{
    json_t *list = json_array();
    for (int i = 0; i < POINTS; i++) {
        double at[PAPER_SEEDS];
        int running = 0;
        for (int k = 0; k < PAPER_SEEDS; k++)
            if (i < seeds[k].count) at[running++] = seeds[k].log_residual[i];
        if (2 * running < PAPER_SEEDS) break;
        qsort(at, (size_t)running, sizeof *at, ascending);
        json_array_append_new(list,
                              json_pack("[f, f, f, f]", seeds->step * i, at[0], at[running / 2], at[running - 1]));
    }
    return list;
}

static json_t *curves_document(paper_problem *problem, uint64_t first)
{
    curve sweeps = {.step = 1e9}, *seeds = calloc(PAPER_SEEDS, sizeof *seeds);
    if (!seeds) return NULL;
    int longest = 1;
    for (uint64_t k = 0; k < PAPER_SEEDS; k++) {
        seeds[k].step = 1e9;
        int iterations = trace(problem, PINCH_SOLVER_NSNGRK, first + k, &seeds[k]);
        if (iterations > longest) longest = iterations;
    }
    for (uint64_t k = 0; k < PAPER_SEEDS; k++) {
        seeds[k].step = (double)longest / (POINTS - 1);
        trace(problem, PINCH_SOLVER_NSNGRK, first + k, &seeds[k]);
    }
    sweeps.step = seeds->step;
    int iterations = trace(problem, PINCH_SOLVER_NSNMGK, 1, &sweeps);
    sweeps.step = (double)iterations / (POINTS - 1);
    trace(problem, PINCH_SOLVER_NSNMGK, 1, &sweeps);
    json_t *document = json_pack("{s:o, s:o}", "nsngrk", band_document(seeds), "nsnmgk", points_document(&sweeps));
    free(seeds);
    return document;
}

json_t *paper_example_document(paper_example *e, pinch_statics *statics, uint64_t first_seed, const json_t *about)
{
    enum { ANSWER_FACES = 5 };
    const json_t *figure_faces = json_object_get(about, "figure_faces");
    paper_problem problem;
    int faces = json_is_integer(figure_faces) ? (int)json_integer_value(figure_faces) : ANSWER_FACES;
    json_t *curves = NULL;
    if (paper_problem_create(statics, e, faces, &problem)) curves = curves_document(&problem, first_seed);
    paper_problem_free(&problem);
    if (!curves) return NULL;
    return json_pack("{s:s, s:s, s:s, s:i, s:o, s:o, s:o, s:o, s:i, s:o, s:o}", "example", e->name, "kind",
                     json_string_value(json_object_get(about, "kind")), "facts",
                     json_string_value(json_object_get(about, "facts")), "dimension", e->s->dimension, "edges",
                     edges_document(e), "parameters", parameters_document(e, about), "faces",
                     e->frictional ? json_integer(ANSWER_FACES) : json_null(), "answers",
                     answers_document(e, statics, ANSWER_FACES, first_seed), "figure",
                     (int)json_integer_value(json_object_get(about, "figure")), "figure_faces",
                     json_deep_copy(figure_faces), "curves", curves);
}
