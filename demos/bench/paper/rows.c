/* The table of iterations, residuals and times: one row per example and number of faces. */
#include "paper.h"

#include "common/output.h"

#include <math.h>
#include <string.h>

bool paper_measure_row(const bench_request *o, paper_example *e, pinch_statics *statics, int faces, paper_row *row)
{
    enum { REPEATS = 25 };
    paper_problem problem;
    *row = (paper_row){.example = e->name, .faces = e->frictional ? faces : 0};
    bool made = paper_problem_create(statics, e, faces, &problem) &&
                paper_measure_pair(&problem, o->seed, o->budget, &row->pair);
    row->size = problem.lcp.size;
    if (made && !o->faithful) {
        pinch_statics_settings standard = pinch_default_statics_settings();
        standard.formulation = PINCH_FORMULATION_LCP;
        standard.faces = faces;
        row->standard = paper_measure_statics(e, statics, &standard, REPEATS);
        standard.solver.solver = PINCH_SOLVER_LEMKE;
        row->lemke = paper_measure_statics(e, statics, &standard, REPEATS);
    }
    paper_problem_free(&problem);
    return made;
}

static json_t *spread_document(const paper_spread *s)
{
    return json_pack("{s:o, s:o}", "low", json_number(s->low), "high", json_number(s->high));
}

json_t *paper_measurement_document(const paper_measurement *m)
{
    bool solved = m->status == PINCH_SOLVE_CONVERGED;
    return json_pack("{s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "status", pinch_solve_status_text(m->status),
                     "iterations", json_number(m->iterations), "iterations_quartiles",
                     spread_document(&m->iterations_spread), "projections", json_number(m->projections), "residual",
                     json_number(solved ? m->residual : NAN), "residual_quartiles",
                     solved ? spread_document(&m->residual_spread) : json_null(), "time_s", json_number(m->time.median),
                     "time_quartiles_s", spread_document(&m->time), "instructions", json_number(m->instructions));
}

static bool is_for(const json_t *value, const char *example, int faces)
{
    const json_t *of = json_object_get(value, "faces");
    return strcmp(json_string_value(json_object_get(value, "example")), example) == 0 &&
           (faces > 0 ? json_integer_value(of) == faces : json_is_null(of));
}

const json_t *paper_published_value(const json_t *published, const char *example, int faces, const char *method,
                                    const char *quantity)
{
    size_t i;
    json_t *value;
    json_array_foreach(json_object_get(published, "values"), i, value)
    {
        if (is_for(value, example, faces) && strcmp(json_string_value(json_object_get(value, "method")), method) == 0 &&
            strcmp(json_string_value(json_object_get(value, "quantity")), quantity) == 0)
            return json_object_get(value, "value");
    }
    return NULL;
}

static json_t *copy_or_null(const json_t *value)
{
    return value ? json_deep_copy(value) : json_null();
}

static json_t *published_method(const json_t *published, const paper_row *row, const char *method)
{
    return json_pack(
        "{s:o, s:o, s:o}", "iterations",
        copy_or_null(paper_published_value(published, row->example, row->faces, method, "iterations")), "residual",
        copy_or_null(paper_published_value(published, row->example, row->faces, method, "residual")), "time_s",
        copy_or_null(paper_published_value(published, row->example, row->faces, method, "time_s")));
}

static json_t *published_row(const json_t *published, const paper_row *row)
{
    const json_t *speedup = paper_published_value(published, row->example, row->faces, "both", "speedup");
    if (!speedup) return json_null();
    return json_pack("{s:o, s:o, s:o}", "speedup", copy_or_null(speedup), "nsngrk",
                     published_method(published, row, "nsngrk"), "nsnmgk", published_method(published, row, "nsnmgk"));
}

/* Products of matrix rows with vectors, and sums with multiples of them, that a run needs: the residual of all rows in
 * every iteration, an update per projection, and a residual per projection beyond an iteration's first. */
static double row_operations(const paper_measurement *m, int size)
{
    return m->iterations * size + m->projections + (m->projections - m->iterations);
}

/* Row operations of an iteration: see row_operations. */
static json_t *operations_document(const paper_row *row, const json_t *published)
{
    const paper_measurement *g = &row->pair.nsngrk, *m = &row->pair.nsnmgk;
    double n = row->size, p = m->projections / m->iterations;
    double of_random = row_operations(g, row->size) / g->iterations,
           of_sweep = row_operations(m, row->size) / m->iterations;
    const json_t *speedup = paper_published_value(published, row->example, row->faces, "both", "speedup");
    double wanted = speedup ? json_number_value(speedup) * m->iterations * of_sweep / of_random : NAN;
    return json_pack("{s:o, s:o, s:o, s:o, s:o}", "nsngrk", json_number(of_random), "nsnmgk", json_number(of_sweep),
                     "nsnmgk_kept_up_to_date", json_number(p * (n + 1)), "projections_of_an_iteration", json_number(p),
                     "nsngrk_iterations_for_published", json_number(wanted));
}

json_t *paper_row_document(const paper_row *row, bool faithful, const json_t *published)
{
    const paper_pair *p = &row->pair;
    double nsngrk = row_operations(&p->nsngrk, row->size), nsnmgk = row_operations(&p->nsnmgk, row->size);
    json_t *document = json_pack(
        "{s:s, s:o, s:i, s:o, s:o, s:o, s:o, s:o, s:i, s:o, s:o, s:o}", "example", row->example, "faces",
        row->faces > 0 ? json_integer(row->faces) : json_null(), "unknowns", row->size, "speedup",
        json_number(p->speedup.median), "speedup_quartiles", spread_document(&p->speedup), "iteration_ratio",
        json_number(p->nsngrk.iterations / p->nsnmgk.iterations), "row_operation_ratio", json_number(nsngrk / nsnmgk),
        "instruction_ratio", json_number(p->nsngrk.instructions / p->nsnmgk.instructions), "rounds", p->rounds,
        "nsngrk", paper_measurement_document(&p->nsngrk), "nsnmgk", paper_measurement_document(&p->nsnmgk), "published",
        published_row(published, row));
    if (document) json_object_set_new(document, "operations", operations_document(row, published));
    if (document && !faithful) {
        json_object_set_new(document, "default", paper_measurement_document(&row->standard));
        json_object_set_new(document, "lemke", paper_measurement_document(&row->lemke));
    }
    return document;
}
