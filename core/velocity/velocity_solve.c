/* Solves a velocity system, from the warm start to the results that the problem asks for. */
#include "kinematics/wrenches.h"
#include "solvers/methods.h"
#include "support/extremes.h"
#include "velocity/velocity_system.h"

#include <math.h>
#include <string.h>

/*
 * Follows a path of solutions, equation (56), and lets Newton's method find the last digits. This is for islands with
 * massless drives; others have their forces as unknowns where all else fails. Returns false when memory ran out.
 */
static bool solve_along_path(pinch_arena *arena, pinch_velocity_system *vs, const pinch_solver_settings *settings,
                             pinch_solver_result *result)
{
    enum { LAST_STEPS = 25 };
    int steps = settings->max_iterations - result->iterations;
    if (steps <= 0 || vs->unknowns > PINCH_PATH_MOST_UNKNOWNS) return true;
    if (steps > PINCH_PATH_MOST_STEPS) steps = PINCH_PATH_MOST_STEPS;
    double *anchor = PINCH_ARENA_ARRAY(arena, double, vs->unknowns);
    double *scratch = PINCH_ARENA_ARRAY(arena, double, pinch_path_scratch(vs->unknowns));
    if (arena->failed) return false;
    pinch_system system = pinch_velocity_system_interface(vs);
    pinch_path_start start = {.anchor = anchor, .size = vs->scale};
    pinch_solver_settings last = *settings;
    pinch_solver_result total = *result;
    memset(anchor, 0, sizeof(double) * (size_t)vs->unknowns);
    vs->in_flow = true; /* an idle drive is led back by the path itself */
    bool arrived = pinch_path(&system, &start, scratch, vs->x, &steps);
    result->iterations += steps;
    if (!arrived) return true;
    total.iterations += steps;
    last.solver = PINCH_SOLVER_NEWTON;
    last.max_iterations = LAST_STEPS;
    if (pinch_solve_system(&system, &last, vs->solver_scratch, vs->x, result) != PINCH_OK) return false;
    pinch_add_solver_counts(result, &total);
    result->by_flow = true;
    return true;
}

/*
 * Runs the solver asked for, for a limited number of iterations from where x is. Where that does not do and Newton's
 * steps are part of it, it runs again from no forces, and then the implicit flow from both.
 */
static pinch_status solve_nonsmooth(pinch_arena *arena, pinch_velocity_system *vs,
                                    const pinch_solver_settings *settings, pinch_solver_result *result)
{
    enum { FIRST_TRIES = 50 };
    bool newton = pinch_solver_takes_newton_steps(settings);
    size_t bytes = sizeof(double) * (size_t)vs->unknowns;
    pinch_system system = pinch_velocity_system_interface(vs);
    pinch_solver_settings limited = *settings;
    pinch_solver_result total = {.status = PINCH_SOLVE_CONVERGED};
    if (newton && settings->max_iterations > FIRST_TRIES) limited.max_iterations = FIRST_TRIES;
    for (int try = 0; try < 2; try++) {
        if (try == 1) memset(vs->x, 0, bytes);
        pinch_status status = pinch_solve_system(&system, &limited, vs->solver_scratch, vs->x, result);
        if (status != PINCH_OK) return status;
        pinch_add_solver_counts(result, &total);
        if (result->status == PINCH_SOLVE_CONVERGED || !newton || settings->max_iterations <= FIRST_TRIES)
            return PINCH_OK;
        total = *result;
    }
    for (int try = 0; try < 2 && result->status != PINCH_SOLVE_CONVERGED; try++) {
        if (try == 0)
            memset(vs->x, 0, bytes);
        else
            memcpy(vs->x, vs->start, bytes);
        if (!pinch_velocity_flow(arena, vs, settings, result)) return PINCH_OUT_OF_MEMORY;
    }
    if (result->status != PINCH_SOLVE_CONVERGED && vs->has_drive && !solve_along_path(arena, vs, settings, result))
        return PINCH_OUT_OF_MEMORY;
    return PINCH_OK;
}

pinch_status pinch_velocity_solve(pinch_arena *arena, pinch_velocity_system *vs, const pinch_solver_settings *settings,
                                  pinch_solver_result *result)
{
    if (vs->unknowns == 0) { /* joints hold everything */
        pinch_velocity_system_evaluate(vs, vs->x);
        result->status = PINCH_SOLVE_CONVERGED;
        return PINCH_OK;
    }
    if (settings->solver == PINCH_SOLVER_LEMKE || settings->solver == PINCH_SOLVER_PGS)
        return pinch_velocity_lcp_solve(arena, vs, settings, result);
    return solve_nonsmooth(arena, vs, settings, result);
}

static void finish_contact(const pinch_element *element, double step, pinch_contact *contact)
{
    pinch_contact_end end = {.rows = element->law.rows,
                             .state = element->state,
                             .force = element->r,
                             .velocity = element->w,
                             .sticking = element->state == PINCH_CONTACT_STICK ? ~0u : 0,
                             .exact_velocity = true};
    pinch_contact_law_finish(&end, step, contact);
}

/* The force of a hard row. One for more than two bodies is held at the bound itself, which the row's scale rounds. */
static double multiplier_force(const pinch_velocity_system *vs, const pinch_element *element,
                               const pinch_joint_row *row, int parts)
{
    const pinch_multiplier *m = pinch_multiplier_of(vs, element);
    if (element->blocks == 0) return 0;
    double force = pinch_element_multiplier(vs, element, vs->x);
    if (parts == 1) return force;
    if (m->trial <= m->unit.low) return row->low;
    if (m->trial >= m->unit.high) return row->high;
    return fmin(fmax(force, row->low), row->high);
}

void pinch_velocity_read_back(pinch_velocity_system *vs, pinch_problem *problem)
{
    const double *x = vs->x;
    if (memcmp(vs->evaluated, x, sizeof(double) * (size_t)vs->unknowns) != 0) pinch_velocity_system_evaluate(vs, x);
    for (int b = 0; b < problem->body_count; b++)
        pinch_mobility_velocity(vs->mobility, b, x, problem->bodies[b].velocity_end);
    for (int k = 0; k < problem->contact_count; k++)
        finish_contact(&vs->elements[k], problem->step, &problem->contacts[k]);
    for (int k = 0; k < vs->mobility->remaining_count; k++) {
        int j = vs->mobility->remaining[k], part = vs->part_of_row[k];
        pinch_joint_row *row = &problem->rows[j];
        row->pivot = 1;
        if (part >= 0)
            row->force = pinch_clamp(pinch_rate_row_force(vs, &vs->rates[part]), row->low, row->high); /* to the bit */
        else if (row->continues)
            row->force = row[-1].force;
        else
            row->force = vs->elements[~part].multiplier >= 0
                             ? multiplier_force(vs, &vs->elements[~part], row, pinch_row_parts(problem, j))
                             : vs->elements[~part].r[0];
    }
    pinch_joint_forces(problem, vs->mobility, vs->body_scratch);
}
