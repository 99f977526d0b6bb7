/* pinch lcp: a bare linear complementarity problem {"M": [[...]], "q": [...]}. */
#include "command.h"
#include "common/input_file.h"
#include "common/output.h"

#include <pinch/lcp.h>

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct problem {
    int size;
    double *m, *q, *z, *w;
} problem;

static command_status refuse(const char *file, const char *what)
{
    command_error("lcp", "%s: %s", file, what);
    return COMMAND_BAD_INPUT;
}

/* Returns false unless the value is a list of `size` numbers. The JSON parser lets no infinite ones through. */
static bool read_numbers(const json_t *list, size_t size, double *values)
{
    if (!json_is_array(list) || json_array_size(list) != size) return false;
    for (size_t i = 0; i < size; i++) {
        const json_t *value = json_array_get(list, i);
        if (!json_is_number(value)) return false;
        values[i] = json_number_value(value);
    }
    return true;
}

static command_status read_problem(const char *file, const json_t *root, problem *p)
{
    const json_t *m = json_object_get(root, "M"), *q = json_object_get(root, "q");
    if (!json_is_object(root)) return refuse(file, "$: expected an object with M and q");
    if (!m || !q || json_object_size(root) != 2) return refuse(file, "$: expected the keys M and q and no others");
    size_t n = json_array_size(q);
    if (n < 1 || n > 5000) return refuse(file, "$.q: expected a list of 1 to 5000 numbers");
    p->size = (int)n;
    p->m = calloc(n * n + 3 * n, sizeof *p->m);
    if (!p->m) return COMMAND_SYSTEM;
    p->q = p->m + n * n;
    p->z = p->q + n;
    p->w = p->z + n;
    if (!read_numbers(q, n, p->q)) return refuse(file, "$.q: expected a list of numbers");
    char text[96];
    snprintf(text, sizeof text, "$.M: expected %zu rows of %zu numbers, as many as q has", n, n);
    if (!json_is_array(m) || json_array_size(m) != n) return refuse(file, text);
    for (size_t i = 0; i < n; i++)
        if (!read_numbers(json_array_get(m, i), n, p->m + i * n)) {
            snprintf(text, sizeof text, "$.M[%zu]: expected a list of %zu numbers", i, n);
            return refuse(file, text);
        }
    return COMMAND_DONE;
}

static command_status load(const char *file, problem *p)
{
    json_error_t error;
    FILE *stream = input_open(file);
    if (!stream) {
        command_status status = errno == ENOMEM ? COMMAND_SYSTEM : COMMAND_BAD_INPUT;
        command_error("lcp", "%s: cannot be read: %s", file, strerror(errno));
        return status;
    }
    json_t *root = input_load_json(stream, &error);
    fclose(stream);
    if (!root) {
        command_error("lcp", "%s:%d: expected JSON: %s", file, error.line, input_json_fault(&error));
        return COMMAND_BAD_INPUT;
    }
    command_status status = read_problem(file, root, p);
    json_decref(root);
    return status;
}

static void print_text(const problem *p, const pinch_solver_settings *settings, const pinch_solver_result *r)
{
    char n[48];
    printf("%s by %s: %d iterations, residual %s\n", pinch_solve_status_text(r->status),
           pinch_solver_name(settings->solver), r->iterations,
           isinf(r->residual) ? "beyond double precision" : number_for_people("%.3g", r->residual, n));
    if (r->status != PINCH_SOLVE_CONVERGED) return;
    printf("  %4s %22s %22s\n", "", "z", "w");
    for (int i = 0; i < p->size; i++) printf("  %4d %22.15g %22.15g\n", i + 1, p->z[i], p->w[i]);
}

static bool print_document(const problem *p, const pinch_solver_settings *settings, const pinch_solver_result *r)
{
    json_t *document = json_pack("{s:s, s:s, s:s, s:o, s:o, s:o, s:i}", "command", "lcp", "status",
                                 pinch_solve_status_text(r->status), "solver", pinch_solver_name(settings->solver), "z",
                                 json_numbers(p->z, (size_t)p->size), "w", json_numbers(p->w, (size_t)p->size),
                                 "residual", json_number(r->residual), "iterations", r->iterations);
    return json_print_new(document, stdout);
}

static command_status solve(const options *o, problem *p)
{
    pinch_solver_settings settings = pinch_default_solver_settings();
    if (o->given[OPTION_SOLVER]) settings.solver = o->solver;
    if (o->given[OPTION_TOLERANCE]) settings.tolerance = o->tolerance;
    if (o->given[OPTION_MAX_ITERATIONS]) settings.max_iterations = o->max_iterations;
    /* At z = 0 the residual has the size of q, so the tolerance has to be small where q is. */
    double largest = 0;
    for (int i = 0; i < p->size; i++) largest = fmax(largest, fabs(p->q[i]));
    if (largest > 0 && largest < 1) settings.tolerance = fmax(settings.tolerance * largest, DBL_MIN);
    settings.goal = fmin(settings.goal, settings.tolerance);
    settings.newton_finish = !o->no_newton;
    settings.seed = o->seed;

    pinch_lcp_workspace *workspace;
    if (pinch_lcp_workspace_create(p->size, &workspace) != PINCH_OK) return COMMAND_SYSTEM;
    pinch_lcp lcp = {.size = p->size, .m = p->m, .q = p->q};
    pinch_solver_result result;
    pinch_status status = pinch_lcp_solve(&lcp, &settings, workspace, p->z, p->w, &result);
    if (status == PINCH_OK && result.status != PINCH_SOLVE_CONVERGED) {
        /* w is used for the vector of the proof, which is not shown */
        if (pinch_lcp_prove_infeasible(&lcp, workspace, p->w)) result.status = PINCH_SOLVE_INFEASIBLE;
        for (int i = 0; i < p->size; i++) p->w[i] = NAN;
    }
    /* Rounding may leave a negative z as large as the tolerance; printed is 0. */
    for (int i = 0; i < p->size && result.status == PINCH_SOLVE_CONVERGED && status == PINCH_OK; i++)
        if (p->z[i] < 0 && p->z[i] >= -2 * settings.tolerance) p->z[i] = 0;
    pinch_lcp_workspace_destroy(workspace);
    if (status != PINCH_OK) {
        command_error("lcp", "%s", pinch_status_text(status));
        return COMMAND_BAD_INPUT;
    }
    if (o->json) {
        if (!print_document(p, &settings, &result)) return COMMAND_SYSTEM;
    } else if (!o->quiet) {
        print_text(p, &settings, &result);
    }
    return result.status == PINCH_SOLVE_CONVERGED ? COMMAND_DONE : COMMAND_FAILED;
}

static command_status run_lcp(const options *o)
{
    problem p = {0};
    command_status status = load(o->arguments[0], &p);
    if (status == COMMAND_DONE) status = solve(o, &p);
    if (status == COMMAND_SYSTEM) command_error("lcp", "out of memory");
    free(p.m);
    return status;
}

static const option_id lcp_options[] = {OPTION_SOLVER,    OPTION_TOLERANCE, OPTION_MAX_ITERATIONS, OPTION_SEED,
                                        OPTION_NO_NEWTON, OPTION_JSON,      OPTION_QUIET,          OPTION_COUNT};

const command command_lcp = {
    .name = "lcp",
    .arguments = "FILE",
    .summary = "solves a bare linear complementarity problem {\"M\": [[...]], \"q\": [...]} with any solver",
    .min_arguments = 1,
    .max_arguments = 1,
    .files = "json",
    .options = lcp_options,
    .run = run_lcp,
};
