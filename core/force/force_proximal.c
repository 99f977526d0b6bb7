/*
 * Leads the forces of a heap to an answer where Newton's method fails: the proximal point method, equation (75) of
 * core/README.md (Rockafellar, "Monotone operators and the proximal point algorithm", 1976). Each contact gets a
 * further compliance about the force that it has so far. With a large one few contacts change between touching,
 * sticking and slipping, and Newton's method converges in some steps. The forces that it finds are closer to their
 * laws, and with a smaller one it converges from there, until there is none left.
 *
 * At a higher floor Newton's method converges as well, but all that lies on contacts sinks. Here they are as stiff in
 * the end as they are asked to be.
 */
#include "force/force_rows.h"
#include "force/force_system.h"

#include <math.h>

bool pinch_force_may_approach(const pinch_force_system *s)
{
    /* contacts: with few, steps with given limits of friction or a higher floor lead to an answer; with more than MANY,
     * sweeps alone take a twentieth of the time */
    enum { FEW = 100, MANY = 2000 };
    bool may = s->multiplier_count == 0 && s->contact_count > FEW && s->contact_count <= MANY &&
               s->contact_count == s->element_count;
    for (int c = 0; c < s->mobility->cluster_count && may; c++)
        may = s->mobility->clusters[c].freedoms == PINCH_FORCE_BODY;
    return may;
}

/* Gives each contact the part `ease` of 1/rho as a further compliance, about the force that it has. */
static void ease_contacts(pinch_force_system *s, double ease)
{
    for (int k = 0; k < s->contact_count; k++) {
        pinch_force_element *e = &s->elements[k];
        const double *r = pinch_force_values(e, PINCH_FORCE_R);
        double *compliance = pinch_force_values(e, PINCH_FORCE_COMPLIANCE), *b = pinch_force_values(e, PINCH_FORCE_B);
        double *rho = pinch_force_values(e, PINCH_FORCE_RHO);
        for (int i = 0; i < e->rows; i++) {
            double further = ease / rho[i];
            compliance[i] += further;
            b[i] += further * r[i];
            rho[i] /= 1 + ease;
        }
    }
}

/* *merit: the root afterwards. Returns false when memory ran out. */
static bool sweep(pinch_arena *arena, pinch_force_system *s, int count, double *merit)
{
    static const double VISIT = 0.25; /* in products of blocks: they read a contact from one place */
    pinch_arena_mark here = pinch_arena_here(arena);
    bool swept = pinch_force_sweep_alone(arena, s, count, merit);
    pinch_arena_rewind(arena, &here);
    s->work += VISIT * count * s->contact_count;
    return swept;
}

/* Runs Newton's method for contacts that are eased; where it fails, once more after sweeps, which are fast at finding
 * out which contacts touch where these are soft. Returns false when memory ran out. */
static bool solve_eased(pinch_arena *arena, pinch_force_system *s, const pinch_solver_settings *settings,
                        pinch_force_answer *center, pinch_solver_result *total, pinch_solver_result *part)
{
    enum { LIMIT = 8, SWEEPS = 200 };
    static const double CLOSE = 1e-7;
    double merit;
    pinch_solver_settings rough = *settings;
    rough.tolerance = rough.goal = CLOSE;
    if (!pinch_force_newton_within(arena, s, &rough, LIMIT, total, part)) return false;
    if (part->status == PINCH_SOLVE_CONVERGED || s->work > s->budget) return true;
    pinch_force_keep(s, center, true);
    return sweep(arena, s, SWEEPS, &merit) && pinch_force_newton_within(arena, s, &rough, LIMIT, total, part);
}

/*
 * After each answer the further compliance falls, more slowly where it has once been too small. Where it would be less
 * than the floor there is none: Newton's method is as likely to converge without it.
 */
bool pinch_force_approach(pinch_arena *arena, pinch_force_system *s, const pinch_solver_settings *settings,
                          pinch_force_proximal way, pinch_solver_result *total, pinch_solver_result *part)
{
    enum { LIMIT = 8, MOST_FAILURES = 5 };
    static const double FALLS_TO = 0.4, LATER_TO = 0.6, BACK = 2;
    double ease = way.ease, merit;
    part->status = PINCH_SOLVE_MAX_ITERATIONS;
    if (way.sweeps > 0 && !sweep(arena, s, way.sweeps, &merit)) return false;
    pinch_force_keep(s, way.center, false);
    for (int failures = 0; failures <= MOST_FAILURES && !(s->work > s->budget);) {
        bool eased = ease > way.floor;
        pinch_force_set_floor(s, way.floor);
        if (eased) ease_contacts(s, ease);
        bool ran = eased ? solve_eased(arena, s, settings, way.center, total, part)
                         : pinch_force_newton_within(arena, s, settings, LIMIT, total, part);
        if (!ran) return false;
        bool converged = part->status == PINCH_SOLVE_CONVERGED;
        /* once more: forces with which a solve begins have to be closer to their laws than those with which it ends */
        if (converged && !eased) return pinch_force_newton_within(arena, s, settings, LIMIT, total, part);
        pinch_force_keep(s, way.center, !converged);
        if (converged)
            ease *= failures > 0 ? LATER_TO : FALLS_TO;
        else {
            ease = BACK * (eased ? ease : way.floor);
            failures++;
        }
    }
    if (part->status == PINCH_SOLVE_CONVERGED) part->status = PINCH_SOLVE_MAX_ITERATIONS;
    pinch_force_set_floor(s, way.floor);
    part->residual = pinch_force_evaluate(s);
    return true;
}

static bool has_forces(const pinch_force_system *s)
{
    bool any = false;
    for (int k = 0; k < s->contact_count && !any; k++) any = *pinch_force_values(&s->elements[k], PINCH_FORCE_R) != 0;
    return any;
}

bool pinch_force_begin_heap(pinch_arena *arena, pinch_force_system *s, const pinch_solver_settings *settings,
                            pinch_force_proximal *way, int limit, pinch_solver_result *total, pinch_solver_result *part)
{
    enum { SWEEPS = 60, MORE = 240 };
    static const double FAR = 1e-2, NEAR = 3e-4;
    double merit = pinch_force_evaluate(s);
    bool far = merit > FAR && has_forces(s);
    if (far && !sweep(arena, s, SWEEPS, &merit)) return false;
    if (!far || merit <= NEAR) return pinch_force_newton_within(arena, s, settings, limit, total, part);
    way->floor = fmin(way->floor, PINCH_FORCE_FLOOR_OF_HEAPS);
    way->sweeps = MORE;
    pinch_force_set_floor(s, way->floor);
    return pinch_force_approach(arena, s, settings, *way, total, part);
}
