#include "stiff/stiff_ladder.h"

#include "problem/wrenches.h"
#include "stiff/stiff_newton.h"

#include <math.h>
#include <string.h>

enum { RUNGS = 7, SWEEP_RUNG = 2, SWEEPS = 30, FIRST_LIMIT = 15, LATER_LIMIT = 25, QUIET_STEPS = 16 };
static const double FIRST_FLOOR = 1e-4, RUNG_FACTOR = 5;

/* Below this compliance, as a part of what its own inertia gives a contact in a step, Newton's method in the velocities
 * begins to fail. */
static const double STIFF = 1e-3;
/* Above this number of unknowns a sparse factorization is worth its lists. */
enum { LARGE = 60 };

bool pinch_stiff_needed(const pinch_problem *problem)
{
    for (int k = 0; k < problem->contact_count; k++) {
        const pinch_contact *c = &problem->contacts[k];
        if (c->may_soften || c->model == PINCH_CONTACT_ROLLING) return true;
        for (int i = 0; i < 5; i++)
            if (c->friction_limit[i] != 0) return true;
        if (c->viscous[0] != 0 || c->viscous[1] != 0) return true;
    }
    return false;
}

bool pinch_stiff_wanted(const pinch_problem *problem, const pinch_mobility *mobility)
{
    double h = problem->step;
    for (int b = 0; b < problem->body_count; b++)
        if (problem->bodies[b].mass == 0) return false; /* massless drives have no part here */
    if (mobility->unknowns > LARGE || pinch_stiff_needed(problem)) return true;
    for (int k = 0; k < problem->contact_count; k++) {
        const pinch_contact *c = &problem->contacts[k];
        double inertia = 0;
        if (c->body1 >= 0) inertia += 1 / problem->bodies[c->body1].mass;
        if (c->body2 >= 0) inertia += 1 / problem->bodies[c->body2].mass;
        if (1 < STIFF * h * inertia * (h * c->stiffness[0] + c->damping[0])) return true;
    }
    return false;
}

static int first_rung(const pinch_problem *problem)
{
    int hardship = 0;
    for (int k = 0; k < problem->contact_count; k++)
        if (problem->contacts[k].hardship > hardship) hardship = problem->contacts[k].hardship;
    int rung = hardship / QUIET_STEPS;
    return rung < RUNGS ? rung : RUNGS - 1;
}

static void remember(pinch_problem *problem, int first, int rung)
{
    int hardship = 0;
    for (int k = 0; k < problem->contact_count; k++)
        if (problem->contacts[k].hardship > hardship) hardship = problem->contacts[k].hardship;
    hardship = rung > first ? QUIET_STEPS * rung + QUIET_STEPS - 1 : hardship > 0 ? hardship - 1 : 0;
    for (int k = 0; k < problem->contact_count; k++) problem->contacts[k].hardship = hardship;
}

/* e+ = (c e/h - r)/(k + c/h), the spring and damper whose force r is; a damper alone keeps no displacement. */
static void end_of_row(double h, double stiffness, double damping, double elastic, double force, double w, bool sticks,
                       double *elastic_end, double *slip)
{
    *elastic_end = stiffness == 0 ? 0 : (damping * elastic / h - force) / (stiffness + damping / h);
    *slip = sticks && stiffness > 0 ? 0 : elastic + h * w - *elastic_end;
}

static void end_of_contact(double h, const pinch_stiff_element *e, pinch_contact *c, pinch_step_result *result)
{
    int rows = e->law.rows;
    bool used[3] = {false};
    double r[PINCH_STIFF_ROWS] = {0}, w[PINCH_STIFF_ROWS] = {0}, p[PINCH_STIFF_ROWS], end[5] = {0}, slip[5] = {0};
    memcpy(r, e->r, sizeof *r * (size_t)rows);
    memcpy(w, e->w, sizeof *w * (size_t)rows);
    c->state = pinch_stiff_project(&e->law, e->rho, e->z, p, NULL);
    for (int i = 0; i < rows; i++) {
        int kind = i == 0 ? 0 : i < 3 ? 1 : 2;
        if (kind == 1 && c->viscous[i - 1] > 0) {
            c->viscous[i - 1] = e->compliance[i];
            continue;
        }
        if (used[kind]) continue; /* one factor for a kind */
        used[kind] = true;
        double factor = e->prescribed[i] / e->compliance[i];
        if (i == 0 && factor < 1 && c->stiffness[0] > 0) {
            double sinks = r[0] * (1 / (factor * c->stiffness[0]) - 1 / c->stiffness[0]);
            result->floor_depth = fmax(result->floor_depth, sinks);
        }
        c->stiffness[kind] *= factor;
        c->damping[kind] *= factor;
    }
    for (int i = 1; i < rows && c->state != PINCH_CONTACT_OPEN; i++) {
        int kind = i < 3 ? 1 : 2;
        double before = i < 4 ? c->elastic[i - 1] : c->rolling_elastic[i - 4];
        bool flows = i < 3 && c->viscous[i - 1] > 0;
        bool own = rows == 6 && i > 2; /* sticks or slips by itself */
        bool sticks = own ? fabs(e->z[i]) <= fabs(r[i]) : c->state == PINCH_CONTACT_STICK;
        end_of_row(h, flows ? 0 : c->stiffness[kind], c->damping[kind], before, r[i], w[i], sticks, &end[i - 1],
                   &slip[i - 1]);
    }
    memcpy(c->force, r, sizeof c->force);
    memcpy(c->rolling_moment, r + 4, sizeof c->rolling_moment);
    memcpy(c->relative_velocity, w, sizeof c->relative_velocity);
    memcpy(c->elastic_end, end, sizeof c->elastic_end);
    memcpy(c->rolling_elastic_end, end + 3, sizeof c->rolling_elastic_end);
    memcpy(c->slip, slip, sizeof c->slip);
    if (r[0] >= c->max_force) c->state = PINCH_CONTACT_YIELD;
}

static void read_back(pinch_problem *problem, const pinch_stiff_system *s, double *scratch, pinch_step_result *result)
{
    for (int b = 0; b < problem->body_count; b++)
        pinch_mobility_velocity(s->mobility, b, s->q, problem->bodies[b].velocity_end);
    for (int k = 0; k < problem->contact_count; k++)
        end_of_contact(problem->step, &s->elements[k], &problem->contacts[k], result);
    bool eliminated = false;
    for (int j = 0; j < problem->row_count; j++) {
        int e = s->element_of_row[j];
        eliminated = eliminated || e == -1;
        if (e >= 0) problem->rows[j].force = s->elements[e].r[0];
        if (e > -2) continue;
        const pinch_stiff_multiplier *m = &s->multipliers[-2 - e];
        problem->rows[j].force = m->sigma > 0 ? m->y / (problem->step * m->sigma) : 0;
    }
    if (eliminated) pinch_joint_forces(problem, s->mobility, s->element_of_row, scratch);
}

bool pinch_stiff_solve(pinch_arena *arena, pinch_problem *problem, pinch_mobility *mobility,
                       const pinch_solver_settings *settings, double *scratch, pinch_step_result *result)
{
    pinch_stiff_system s;
    pinch_solver_result part, total = {.status = PINCH_SOLVE_MAX_ITERATIONS};
    if (!pinch_stiff_system_build(arena, problem, mobility, &s)) return false;
    bool softens = false;
    for (int k = 0; k < problem->contact_count; k++) softens = softens || problem->contacts[k].may_soften;
    int first = first_rung(problem), last = softens ? RUNGS : first + 1, rung = first;
    double floor = FIRST_FLOOR * pow(RUNG_FACTOR, first);
    for (; rung < last && total.status != PINCH_SOLVE_CONVERGED; rung++, floor *= RUNG_FACTOR) {
        pinch_stiff_warm_start(&s, problem);
        pinch_stiff_set_floor(&s, floor);
        if (rung >= first + SWEEP_RUNG) pinch_stiff_sweeps(&s, SWEEPS);
        int limit = rung == first ? FIRST_LIMIT : LATER_LIMIT, left = settings->max_iterations - total.iterations;
        if (!pinch_stiff_newton(arena, &s, settings, limit < left ? limit : left, &part)) return false;
        total.status = part.status;
        total.iterations += part.iterations;
        total.newton_steps += part.newton_steps;
        total.residual = part.residual;
    }
    result->solve = total;
    result->unknowns = mobility->unknowns + s.multiplier_count;
    result->rung = rung - 1;
    if (total.status != PINCH_SOLVE_CONVERGED) return true;
    read_back(problem, &s, scratch, result);
    remember(problem, first, rung - 1);
    return true;
}
