/* pinch friction: a rigid frictional contact problem from a file of the FCLIB collection. */
#include "command.h"
#include "common/output.h"
#include "friction/friction_solve.h"

#include <string.h>

static void print_text(const friction_file *f, const friction_answer *a)
{
    char n[48];
    printf("%s: %d contacts, %s problem in %d dimensions\n", pinch_solve_status_text(a->status), f->contacts,
           f->global ? "global" : "local", f->dimension);
    printf("  error %s after %d iterations", number_for_people("%.3g", a->error, n), a->iterations);
    if (a->corrections > 0) printf(" and %d corrections of a matrix that is not symmetric", a->corrections);
    printf("; compliance of the last solve %s of the diagonal of W\n", number_for_people("%.3g", a->compliance, n));
}

static bool print_document(const friction_file *f, const friction_answer *a)
{
    json_t *list = json_array();
    for (int c = 0; c < f->contacts; c++) {
        const pinch_friction_contact *k = &a->contacts[c];
        json_array_append_new(list, json_pack("{s:o, s:o}", "impulse", json_numbers(k->impulse, (size_t)f->dimension),
                                              "velocity", json_numbers(k->velocity, (size_t)f->dimension)));
    }
    json_t *document =
        json_pack("{s:s, s:s, s:s, s:i, s:o, s:o, s:i, s:i, s:o}", "command", "friction", "status",
                  pinch_solve_status_text(a->status), "problem", f->global ? "global" : "local", "dimension",
                  f->dimension, "error", json_number(a->error), "compliance", json_number(a->compliance), "iterations",
                  a->iterations, "corrections", a->corrections, "contacts", list);
    return json_print_new(document, stdout);
}

static command_status run_friction(const options *o)
{
    friction_file file;
    friction_answer answer;
    char error[512];
    command_status status = friction_file_read(o->arguments[0], &file, error);
    if (status == COMMAND_DONE) {
        double tolerance = o->given[OPTION_TOLERANCE] ? o->tolerance : 1e-8;
        int iterations = o->given[OPTION_MAX_ITERATIONS] ? o->max_iterations : 20000;
        status = friction_solve(&file, tolerance, iterations, &answer, error);
        if (status != COMMAND_DONE) friction_file_free(&file);
    }
    if (status != COMMAND_DONE) {
        command_error("friction", "%s: %s", o->arguments[0], error);
        return status;
    }
    if (o->json)
        status = print_document(&file, &answer) ? COMMAND_DONE : COMMAND_SYSTEM;
    else if (!o->quiet)
        print_text(&file, &answer);
    if (status == COMMAND_DONE && answer.status != PINCH_SOLVE_CONVERGED) status = COMMAND_FAILED;
    friction_answer_free(&answer);
    friction_file_free(&file);
    return status;
}

static const option_id friction_options[] = {OPTION_TOLERANCE, OPTION_MAX_ITERATIONS, OPTION_JSON, OPTION_QUIET,
                                             OPTION_COUNT};

const command command_friction = {
    .name = "friction",
    .arguments = "FILE",
    .summary = "solves a rigid frictional problem from a file of the FCLIB collection",
    .min_arguments = 1,
    .max_arguments = 1,
    .files = "hdf5",
    .options = friction_options,
    .run = run_friction,
};
