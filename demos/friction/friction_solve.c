#include "friction_solve.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { AXES = 3, MOST_CORRECTIONS = 20 };

/* Writes W r + q into the contacts' velocities, by the file's own W and q, and the file's q into their
 * `free`. */
static void velocities_of_file(const friction_file *f, pinch_friction_contact *contacts)
{
    int d = f->dimension;
    for (int c = 0; c < f->contacts; c++)
        for (int i = 0; i < d; i++) contacts[c].velocity[i] = contacts[c].free[i] = f->free[c * d + i];
    for (size_t k = 0; k < f->w.count; k++) {
        const friction_entry *e = &f->w.entries[k];
        contacts[e->row / d].velocity[e->row % d] += e->value * contacts[e->column / d].impulse[e->column % d];
    }
}

/* Solves a local problem until the impulses are those of its own W. */
static pinch_status solve_local(const friction_file *f, const pinch_solver_settings *settings, friction_rows *rows,
                                friction_answer *answer)
{
    pinch_friction_problem *p = &rows->problem;
    pinch_friction_result result;
    double least = INFINITY, *own = malloc(sizeof *own * AXES * ((size_t)p->contact_count + 1));
    pinch_status status = own ? PINCH_OK : PINCH_OUT_OF_MEMORY;
    for (int round = 0; status == PINCH_OK && round <= MOST_CORRECTIONS; round++) {
        status = pinch_friction_solve(p, settings, &result);
        if (status != PINCH_OK) break;
        answer->iterations += result.solve.iterations;
        /* what the rows make of the impulses, without q */
        for (int c = 0; c < p->contact_count; c++)
            for (int i = 0; i < AXES; i++) own[AXES * c + i] = p->contacts[c].velocity[i] - p->contacts[c].free[i];
        velocities_of_file(f, p->contacts);
        double error = pinch_friction_missed(p->contacts, p->contact_count);
        if (!(error < least)) break;
        least = error;
        answer->error = error;
        answer->compliance = result.compliance;
        answer->corrections = round;
        answer->status = result.solve.status;
        memcpy(answer->contacts, p->contacts, sizeof *p->contacts * (size_t)p->contact_count);
        if (error <= settings->tolerance) break;
        for (int c = 0; c < p->contact_count; c++)
            for (int i = 0; i < AXES; i++) p->contacts[c].free[i] = p->contacts[c].velocity[i] - own[AXES * c + i];
    }
    free(own);
    return status;
}

static pinch_status solve_global(const pinch_solver_settings *settings, friction_rows *rows, friction_answer *answer)
{
    pinch_friction_problem *p = &rows->problem;
    pinch_friction_result result;
    pinch_status status = pinch_friction_solve(p, settings, &result);
    if (status != PINCH_OK) return status;
    memcpy(answer->contacts, p->contacts, sizeof *p->contacts * (size_t)p->contact_count);
    answer->status = result.solve.status;
    answer->iterations = result.solve.iterations;
    answer->error = result.error;
    answer->compliance = result.compliance;
    return status;
}

command_status friction_solve(const friction_file *file, double tolerance, int max_iterations, friction_answer *answer,
                              char *error)
{
    friction_rows rows;
    memset(answer, 0, sizeof *answer);
    command_status status = friction_rows_make(file, &rows, error);
    if (status != COMMAND_DONE) return status;
    pinch_solver_settings settings = pinch_default_solver_settings();
    settings.tolerance = tolerance;
    settings.max_iterations = max_iterations;
    answer->contacts = calloc((size_t)file->contacts + 1, sizeof *answer->contacts);
    pinch_status solved = !answer->contacts ? PINCH_OUT_OF_MEMORY
                          : file->global    ? solve_global(&settings, &rows, answer)
                                            : solve_local(file, &settings, &rows, answer);
    if (answer->status == PINCH_SOLVE_CONVERGED && !(answer->error <= tolerance))
        answer->status = PINCH_SOLVE_UNVERIFIED;
    if (answer->error <= tolerance) answer->status = PINCH_SOLVE_CONVERGED;
    for (int c = 0; c < file->contacts && solved == PINCH_OK; c++) /* the rows do not outlive this */
        answer->contacts[c].g[0] = answer->contacts[c].g[1] = NULL;
    friction_rows_free(&rows);
    if (solved == PINCH_OK) return COMMAND_DONE;
    friction_answer_free(answer);
    snprintf(error, 512, "%s", pinch_status_text(solved));
    return solved == PINCH_OUT_OF_MEMORY ? COMMAND_SYSTEM : COMMAND_BAD_INPUT;
}

void friction_answer_free(friction_answer *answer)
{
    free(answer->contacts);
    answer->contacts = NULL;
}
