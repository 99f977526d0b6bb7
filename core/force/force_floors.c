/*
 * Solves an island with as little softening as it takes, by continuation in the compliance: equation (25) of
 * core/README.md, from floor level to floor level, each five times softer than the one below. The floor that an island
 * needed is remembered with its contacts, so that islands may part and merge. After a number of quiet steps it is
 * lowered little by little: what lies on soft contacts is pressed in deeper, and contacts that stiffened all at once
 * would throw it up.
 */
#include "force/force_system.h"

#include <math.h>
#include <string.h>

/* In small islands a raised floor is left at once, whatever step raised it: the solves are cheap. */
enum { SMALL = 120 };
enum { LEVELS = 7, SWEEPS = 30, FIRST_LIMIT = 20, LATER_LIMIT = 25, QUIET_STEPS = 20 };
/* Floors are parts of h W; above the softest a contact is no contact any more. */
static const double SOFTEST = 2, LOWEST_FLOOR = 1e-6, FIRST_FLOOR = 1e-4, LEVEL_FACTOR = 5, LOWERED = 0.95;

/* A floor is lowered only where it lets a contact sink by more than this part of the body's size. */
static const double SUNK_SHARE = 3e-4;

/* Returns the floor of the last step; *hold says for how many steps it is to stay. */
static double last_floor(const pinch_problem *problem, int *hold)
{
    double floor = 0;
    *hold = 0;
    for (int k = 0; k < problem->contact_count; k++) {
        const pinch_contact *c = &problem->contacts[k];
        if (c->floor > floor) floor = c->floor;
        if (c->hold > *hold) *hold = c->hold;
    }
    return floor > 0 ? floor : FIRST_FLOOR;
}

static void remember_floor(pinch_problem *problem, double floor, int hold)
{
    for (int k = 0; k < problem->contact_count; k++) {
        problem->contacts[k].floor = floor;
        problem->contacts[k].hold = hold;
    }
}

static bool may_soften(const pinch_problem *problem)
{
    for (int k = 0; k < problem->contact_count; k++)
        if (problem->contacts[k].may_soften) return true;
    return false;
}

/* An answer put aside: the forces, and the multipliers with what their passes have made of them. */
typedef struct answer {
    double *r, *base_q;
    pinch_force_multiplier *multipliers;
} answer;

static bool make_room(pinch_arena *arena, const pinch_force_system *s, answer *a)
{
    int forces = 0;
    for (int k = 0; k < s->element_count; k++) forces += s->elements[k].rows;
    a->r = PINCH_ARENA_ARRAY(arena, double, forces + 1);
    a->base_q = s->base_q ? PINCH_ARENA_ARRAY(arena, double, s->mobility->unknowns + 1) : NULL;
    a->multipliers = PINCH_ARENA_ARRAY(arena, pinch_force_multiplier, s->multiplier_count + 1);
    return !arena->failed;
}

static void copy(void *to, void *from, bool back, size_t bytes)
{
    memcpy(back ? from : to, back ? to : from, bytes);
}

/* Puts the answer aside, or brings it back. */
static void keep(pinch_force_system *s, answer *a, bool back)
{
    double *kept = a->r;
    for (int k = 0; k < s->element_count; kept += s->elements[k++].rows)
        copy(kept, pinch_force_values(&s->elements[k], PINCH_FORCE_R), back,
             sizeof *kept * (size_t)s->elements[k].rows);
    copy(a->multipliers, s->multipliers, back, sizeof *s->multipliers * (size_t)s->multiplier_count);
    if (s->base_q) copy(a->base_q, s->base_q, back, sizeof *s->base_q * (size_t)s->mobility->unknowns);
}

/*
 * Goes back down, from the forces at a softer floor to those at the next stiffer one: a much better start than the last
 * step's forces. That is done while the floor is one that the answer would not count with, equation (60); stiffer
 * floors would only make the next steps dearer. Where it does not converge, the last answer stays. Returns false when
 * memory ran out.
 */
static bool stiffen(pinch_arena *arena, pinch_force_system *s, const pinch_solver_settings *settings, answer *kept,
                    double first, double *floor, pinch_solver_result *total)
{
    pinch_solver_result part;
    while (*floor > fmax(first, PINCH_FORCE_MOST_MISSED) && s->work <= s->budget &&
           total->iterations < settings->max_iterations) {
        int left = settings->max_iterations - total->iterations;
        double next = fmax(first, *floor / LEVEL_FACTOR);
        keep(s, kept, false);
        pinch_force_set_floor(s, next);
        if (!pinch_force_newton(arena, s, settings, LATER_LIMIT < left ? LATER_LIMIT : left, &part)) return false;
        total->iterations += part.iterations;
        total->newton_steps += part.newton_steps;
        if (part.status != PINCH_SOLVE_CONVERGED) {
            keep(s, kept, true);
            pinch_force_set_floor(s, *floor);
            (void)pinch_force_evaluate(s);
            return true;
        }
        total->residual = part.residual;
        *floor = next;
    }
    return true;
}

/*
 * First the floor of the last step is tried from the warm start, then the same from Gauss-Seidel sweeps, then floor
 * level by floor level, and back down from where one is found; a small island also from a floor of an earlier step.
 * *try counts them. Returns false when memory ran out.
 */
static bool continue_in_compliance(pinch_arena *arena, pinch_force_system *s, const pinch_problem *problem,
                                   const pinch_solver_settings *settings, double *floor, int *try,
                                   pinch_solver_result *total)
{
    int tries = may_soften(problem) ? LEVELS : 2;
    double first = *floor;
    answer kept = {0};
    if (tries > 2 && !make_room(arena, s, &kept)) return false;
    pinch_solver_result part;
    memset(total, 0, sizeof *total);
    total->status = PINCH_SOLVE_MAX_ITERATIONS;
    for (*try = 0; *try < tries && (*try < 2 || *floor < SOFTEST); ++*try) {
        if (*try > 1) *floor *= LEVEL_FACTOR;
        pinch_force_warm_start(s, problem);
        pinch_force_set_floor(s, *floor);
        if (*try >= 1) pinch_force_sweeps(s, SWEEPS);
        s->work += *try >= 1 ? (double)SWEEPS * s->element_count : 0;
        int limit = *try == 0 ? FIRST_LIMIT : LATER_LIMIT, left = settings->max_iterations - total->iterations;
        if (!pinch_force_newton(arena, s, settings, limit < left ? limit : left, &part)) return false;
        total->status = part.status;
        total->iterations += part.iterations;
        total->newton_steps += part.newton_steps;
        total->residual = part.residual;
        if (part.status == PINCH_SOLVE_CONVERGED || s->work > s->budget) break;
    }
    if (tries == 2 || total->status != PINCH_SOLVE_CONVERGED) return true;
    bool raised = *try > 1, small = s->mobility->unknowns + s->multiplier_count <= SMALL;
    if (!raised && !small) return true;
    return stiffen(arena, s, settings, &kept, small ? FIRST_FLOOR : first, floor, total);
}

/*
 * Leads the forces near a solution along a path, first at the floor of the last step and then at softer ones. *total
 * says how the solve had ended before; where no path arrives, it stays so. Returns false when memory ran out.
 */
static bool continue_along_path(pinch_arena *arena, pinch_force_system *s, const pinch_problem *problem,
                                const pinch_solver_settings *settings, double *floor, int *try,
                                pinch_solver_result *total)
{
    enum { MOST_UNKNOWNS = 120, MOST_STEPS = 4000, PATHS = 3 };
    static const double SOFTER = 25;
    pinch_solver_result part;
    *try = 0;
    if (s->mobility->unknowns + s->multiplier_count > MOST_UNKNOWNS) return true;
    int tries = may_soften(problem) ? PATHS : 1;
    double each = pow((s->mobility->unknowns + s->multiplier_count + 1) / 6.0, 3) / 3 + s->element_count;
    for (; *try < tries && total->status != PINCH_SOLVE_CONVERGED; ++*try) {
        int steps = settings->max_iterations - total->iterations;
        bool arrived;
        if (*try > 0) *floor = fmin(SOFTER * *floor, SOFTEST);
        if (steps > MOST_STEPS) steps = MOST_STEPS;
        if (steps > (s->budget - s->work) / each) steps = (int)((s->budget - s->work) / each);
        pinch_force_warm_start(s, problem);
        pinch_force_set_floor(s, *floor);
        if (!pinch_force_follow_path(arena, s, &steps, &arrived)) return false;
        total->iterations += steps;
        s->work += each * steps;
        if (!arrived) continue;
        if (!pinch_force_newton(arena, s, settings, LATER_LIMIT, &part)) return false;
        total->by_flow = true;
        total->status = part.status;
        total->iterations += part.iterations;
        total->newton_steps += part.newton_steps;
        total->residual = part.residual;
    }
    return true;
}

bool pinch_force_solve(pinch_arena *arena, pinch_problem *problem, const pinch_mobility *mobility,
                       const pinch_solver_settings *settings, pinch_force_way way, pinch_force_system *s,
                       pinch_step_result *result)
{
    int hold, try;
    double share, floor = last_floor(problem, &hold), before = floor;
    if (!pinch_force_system_build(arena, problem, mobility, s)) return false;
    s->budget = settings->budget > 0 ? settings->budget : INFINITY;
    if (!(way == PINCH_FORCE_BY_PATH
              ? continue_along_path(arena, s, problem, settings, &floor, &try, &result->solve)
              : continue_in_compliance(arena, s, problem, settings, &floor, &try, &result->solve)))
        return false;
    result->unknowns = mobility->unknowns + s->multiplier_count;
    result->over_budget = s->work > s->budget;
    if (result->solve.status != PINCH_SOLVE_CONVERGED) return true;
    result->floor_level = (int)fmax(0, ceil(log(floor / FIRST_FLOOR) / log(LEVEL_FACTOR) - 1e-6));
    if (!pinch_force_read_back(arena, problem, s, result, &share)) return false;
    if (floor > before)
        hold = QUIET_STEPS;
    else if (hold > 0)
        hold--;
    else if (share > SUNK_SHARE)
        floor = fmax(LOWEST_FLOOR, LOWERED * floor);
    remember_floor(problem, floor, hold);
    return true;
}
