/* One step of one island: mobility, velocity system, solve, read the answer back, check it. */
#include <pinch/problem.h>

#include "velocity/velocity_lcp.h"
#include "velocity/velocity_system.h"
#include "step/validate.h"
#include "kinematics/wrenches.h"
#include "force/force_floors.h"
#include "force/force_result.h"
#include "support/arena.h"
#include "verify/step_check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct pinch_step_solver {
    pinch_arena arena;
};

const char *pinch_contact_state_text(pinch_contact_state state)
{
    switch (state) {
    case PINCH_CONTACT_OPEN:
        return "open";
    case PINCH_CONTACT_STICK:
        return "stick";
    case PINCH_CONTACT_SLIP:
        return "slip";
    case PINCH_CONTACT_YIELD:
        return "yield";
    }
    return "unknown";
}

pinch_status pinch_step_solver_create(pinch_step_solver **solver)
{
    if (!solver) return PINCH_INVALID_ARGUMENT;
    *solver = malloc(sizeof **solver);
    if (!*solver) return PINCH_OUT_OF_MEMORY;
    pinch_arena_init(&(*solver)->arena);
    return PINCH_OK;
}

void pinch_step_solver_destroy(pinch_step_solver *solver)
{
    if (!solver) return;
    pinch_arena_free(&solver->arena);
    free(solver);
}

size_t pinch_step_solver_memory(const pinch_step_solver *solver, size_t *high_water)
{
    if (high_water) *high_water = pinch_arena_high_water(&solver->arena);
    return pinch_arena_held(&solver->arena);
}

void pinch_step_solver_trim(pinch_step_solver *solver, size_t least)
{
    pinch_arena_trim(&solver->arena, least);
}

/*
 * The elastic state at the end of the step follows from r_t = -kt e+ - ct (e+ - e)/h, the force of the spring and
 * damper that moved from e to e+:   e+ = (ct e / h - r_t) / (kt + ct / h);   what of the motion h w_t did not go into
 * e+ is slip.
 */
static void end_of_contact(double h, const pinch_element *element, pinch_contact *c)
{
    const double *w = element->w, *r = element->r;
    memset(c->force, 0, sizeof c->force);
    memset(c->relative_velocity, 0, sizeof c->relative_velocity);
    memcpy(c->force, r, sizeof *r * (size_t)element->law.rows);
    memcpy(c->relative_velocity, w, sizeof *w * (size_t)element->law.rows);
    c->state = element->state;
    for (int i = 0; i < 3; i++) {
        double k = c->stiffness[i < 2 ? 1 : 2], d = c->damping[i < 2 ? 1 : 2];
        bool acts = 1 + i < element->law.rows && c->state != PINCH_CONTACT_OPEN;
        c->elastic_end[i] = c->slip[i] = 0;
        if (!acts) continue;
        double moved = c->elastic[i] + h * w[1 + i];
        if (c->state == PINCH_CONTACT_STICK) {
            c->elastic_end[i] = moved;
        } else {
            c->elastic_end[i] = (d * c->elastic[i] / h - r[1 + i]) / (k + d / h);
            c->slip[i] = moved - c->elastic_end[i];
        }
    }
    if (r[0] >= c->max_force) c->state = PINCH_CONTACT_YIELD;
}

/* Everything the problem asks for, from the reduced coordinates x. scratch: 12 doubles per body. */
static void read_back(pinch_problem *problem, pinch_velocity_system *vs, const int *row_element, const double *x,
                      double *scratch)
{
    if (memcmp(vs->evaluated, x, sizeof(double) * (size_t)vs->unknowns) != 0) pinch_velocity_system_evaluate(vs, x);
    for (int b = 0; b < problem->body_count; b++)
        pinch_mobility_velocity(vs->mobility, b, x, problem->bodies[b].velocity_end);
    for (int k = 0; k < problem->contact_count; k++)
        end_of_contact(problem->step, &vs->elements[k], &problem->contacts[k]);
    bool eliminated = false;
    for (int j = 0; j < problem->row_count; j++) {
        if (row_element[j] < 0) {
            eliminated = true;
            continue;
        }
        const pinch_element *element = &vs->elements[row_element[j]];
        problem->rows[j].force = element->multiplier >= 0 ? pinch_element_multiplier(vs, element, x) : element->r[0];
    }
    if (eliminated) pinch_joint_forces(problem, vs->mobility, row_element, scratch);
}

/* What is no answer must not pass for one. */
static void poison(pinch_problem *problem)
{
    for (int b = 0; b < problem->body_count; b++)
        for (int i = 0; i < 6; i++) problem->bodies[b].velocity_end[i] = NAN;
    for (int k = 0; k < problem->contact_count; k++) {
        pinch_contact *c = &problem->contacts[k];
        for (int i = 0; i < 4; i++) c->force[i] = c->relative_velocity[i] = NAN;
        for (int i = 0; i < 3; i++) c->elastic_end[i] = c->slip[i] = NAN;
        for (int i = 0; i < 2; i++) c->rolling_elastic_end[i] = c->rolling_moment[i] = NAN;
    }
    for (int j = 0; j < problem->row_count; j++) problem->rows[j].force = NAN;
}

/* The residual is measured body by body, the solver's tolerance over the island: a light body among heavy ones may show
 * more. The laws are evaluated, not iterated: they hold to rounding or something is wrong. */
static bool verified(const pinch_solver_settings *settings, const pinch_step_result *result)
{
    static const double LAW_TOLERANCE = 1e-9, SMALLEST_FORCE = 1e-12; /* relative; N, for contacts that hardly touch */
    double law = LAW_TOLERANCE * result->force_scale + SMALLEST_FORCE;
    return result->residual_max <= 100 * settings->tolerance && result->cone <= law && result->complementarity <= law &&
           result->slip_direction <= law;
}

static void check_answer(const pinch_problem *problem, double *scratch, pinch_step_result *result)
{
    pinch_step_check check;
    pinch_check_step(problem, scratch, &check);
    result->residual_max = check.residual_max;
    result->cone = check.cone;
    result->complementarity = check.complementarity;
    result->slip_direction = check.slip_direction;
    result->force_scale = check.force_scale;
}

/* What a solve works on. */
typedef struct attempt {
    pinch_arena *arena;
    pinch_problem *problem;
    pinch_velocity_system *vs;
    const int *row_element;
    double *solver_scratch, *body_scratch;
    double *x, *start; /* unknowns each: the point, and the warm start to come back to */
    pinch_step_result *result;
} attempt;

/* Are Newton's steps part of the solver asked for? */
static bool newton_steps(const pinch_solver_settings *settings)
{
    return settings->solver == PINCH_SOLVER_NEWTON ||
           (settings->solver == PINCH_SOLVER_NSNMGK && settings->newton_finish);
}

/*
 * The solver asked for, a limited number of iterations from the warm start; where Newton's steps are part of it and
 * that does not do, the same from no forces, then the implicit flow from both. Leaves the outcome in result->solve.
 */
static pinch_status solve_robustly(attempt *a, const pinch_solver_settings *settings)
{
    enum { FIRST_TRIES = 50 };
    if (settings->solver == PINCH_SOLVER_LEMKE || settings->solver == PINCH_SOLVER_PGS)
        return pinch_velocity_lcp_solve(a->arena, a->vs, settings, a->x, &a->result->solve);
    bool newton = newton_steps(settings);
    size_t bytes = sizeof(double) * (size_t)a->vs->unknowns;
    pinch_system system = pinch_velocity_system_interface(a->vs);
    pinch_solver_settings limited = *settings;
    pinch_solver_result *solve = &a->result->solve, total = {.status = PINCH_SOLVE_CONVERGED};
    if (newton && settings->max_iterations > FIRST_TRIES) limited.max_iterations = FIRST_TRIES;
    for (int try = 0; try < 2; try++) {
        if (try == 1) memset(a->x, 0, bytes);
        pinch_status status = pinch_solve_system(&system, &limited, a->solver_scratch, a->x, solve);
        if (status != PINCH_OK) return status;
        solve->iterations += total.iterations;
        solve->projections += total.projections;
        solve->newton_steps += total.newton_steps;
        if (solve->status == PINCH_SOLVE_CONVERGED || !newton || settings->max_iterations <= FIRST_TRIES)
            return PINCH_OK;
        total = *solve;
    }
    for (int try = 0; try < 2 && solve->status != PINCH_SOLVE_CONVERGED; try++) {
        if (try == 0)
            memset(a->x, 0, bytes);
        else
            memcpy(a->x, a->start, bytes);
        if (!pinch_velocity_flow(a->arena, a->vs, settings, a->solver_scratch, a->x, solve)) return PINCH_OUT_OF_MEMORY;
    }
    return PINCH_OK;
}

/*
 * Solves, reads the answer back and checks it. The solver's tolerance counts in the forces that act at the start of the
 * solve; where hardly any are left at the end (a contact that just opens), that is too coarse for the check, and the
 * solve goes on from where it is, measured by what acts there.
 */
static pinch_status solve_and_check(attempt *a, const pinch_solver_settings *settings)
{
    enum { MEASURES = 3 };
    pinch_solver_result total = {.status = PINCH_SOLVE_CONVERGED}, *solve = &a->result->solve;
    memcpy(a->start, a->x, sizeof(double) * (size_t)a->vs->unknowns);
    for (int measure = 0; measure < MEASURES; measure++) {
        if (measure > 0) pinch_velocity_system_rescale(a->vs, a->x);
        pinch_status status = solve_robustly(a, settings);
        if (status != PINCH_OK) return status;
        solve->iterations += total.iterations;
        solve->projections += total.projections;
        solve->newton_steps += total.newton_steps;
        total = *solve;
        read_back(a->problem, a->vs, a->row_element, a->x, a->body_scratch);
        check_answer(a->problem, a->body_scratch, a->result);
        if (solve->status != PINCH_SOLVE_CONVERGED || verified(settings, a->result)) return PINCH_OK;
    }
    solve->status = PINCH_SOLVE_UNVERIFIED;
    return PINCH_OK;
}

/* Above this number of unknowns a dense factorization is not tried. */
enum { DENSE_LIMIT = 600 };

static pinch_status solve_stiff(pinch_arena *arena, pinch_problem *problem, pinch_mobility *mobility,
                                const pinch_solver_settings *settings, pinch_step_result *result)
{
    pinch_force_system system;
    if (!pinch_force_solve(arena, problem, mobility, settings, &system, result))
        return arena->failed ? PINCH_OUT_OF_MEMORY : PINCH_INVALID_ARGUMENT;
    if (result->solve.status == PINCH_SOLVE_CONVERGED) {
        check_answer(problem, system.scratch, result);
        if (!verified(settings, result)) result->solve.status = PINCH_SOLVE_UNVERIFIED;
    }
    if (result->solve.status != PINCH_SOLVE_CONVERGED) pinch_force_undo(&system);
    return PINCH_OK;
}

/* In the velocities: up to moderately stiff contacts, and every method and friction polygon. */
static pinch_status solve_velocities(pinch_arena *arena, pinch_problem *problem, pinch_mobility *mobility,
                                     const pinch_solver_settings *settings, pinch_step_result *result)
{
    pinch_velocity_system vs;
    int *row_element;
    double *x, *scratch = PINCH_ARENA_ARRAY(arena, double, 12 * problem->body_count);
    if (!scratch) return PINCH_OUT_OF_MEMORY;
    if (!pinch_velocity_system_build(arena, problem, mobility, &vs, &row_element, &x))
        return arena->failed ? PINCH_OUT_OF_MEMORY : PINCH_INVALID_ARGUMENT;
    double *solver_scratch = PINCH_ARENA_ARRAY(arena, double, pinch_solver_scratch(vs.unknowns) + 1);
    if (arena->failed) return PINCH_OUT_OF_MEMORY;

    result->unknowns = vs.unknowns;
    if (vs.unknowns > 0) {
        attempt a = {arena, problem, &vs, row_element, solver_scratch, scratch, x, x + vs.unknowns, result};
        pinch_status status = solve_and_check(&a, settings);
        if (status != PINCH_OK) return status;
    } else { /* joints hold everything */
        pinch_velocity_system_evaluate(&vs, x);
        read_back(problem, &vs, row_element, x, scratch);
        check_answer(problem, scratch, result);
        result->solve.status = verified(settings, result) ? PINCH_SOLVE_CONVERGED : PINCH_SOLVE_UNVERIFIED;
    }
    pinch_velocity_remember(&vs, result->solve.status == PINCH_SOLVE_CONVERGED);
    return PINCH_OK;
}

pinch_status pinch_step_solve(pinch_step_solver *solver, pinch_problem *problem, const pinch_solver_settings *settings,
                              pinch_step_result *result)
{
    memset(result, 0, sizeof *result);
    if (!pinch_problem_valid(problem)) return PINCH_INVALID_ARGUMENT;
    bool needs_facets = settings->solver == PINCH_SOLVER_LEMKE || settings->solver == PINCH_SOLVER_PGS;
    bool needs_stiff = pinch_force_required(problem), takes_stiff = problem->faces == 0 && newton_steps(settings);
    if ((needs_facets && problem->faces == 0) || (needs_stiff && !takes_stiff)) return PINCH_UNSUPPORTED;
    for (int b = 0; b < problem->body_count && needs_stiff; b++)
        if (problem->bodies[b].mass == 0) return PINCH_UNSUPPORTED;

    pinch_arena *arena = &solver->arena;
    pinch_mobility mobility;
    pinch_arena_reset(arena);
    if (!pinch_mobility_build(arena, problem, &mobility))
        return arena->failed ? PINCH_OUT_OF_MEMORY : PINCH_INVALID_ARGUMENT;

    bool stiff = takes_stiff && (needs_stiff || pinch_force_preferred(problem, &mobility));
    pinch_status status = PINCH_OK;
    if (stiff) status = solve_stiff(arena, problem, &mobility, settings, result);
    bool try_velocities =
        !stiff || (status == PINCH_OK && result->solve.status != PINCH_SOLVE_CONVERGED && !needs_stiff &&
                   mobility.unknowns <= DENSE_LIMIT && result->solve.iterations < settings->max_iterations);
    if (try_velocities) status = solve_velocities(arena, problem, &mobility, settings, result);
    if (status == PINCH_OK && result->solve.status != PINCH_SOLVE_CONVERGED) poison(problem);
    return status;
}
