#include "problem/legal.h"

#include <math.h>

/* One sum is finite only if all its terms are (or infinities cancel into NaN, which is not finite either). */
static bool all_finite(const double *values, int count)
{
    double sum = 0, other = 0; /* two chains of additions: neither waits for the other */
    int i = 0;
    for (; i + 1 < count; i += 2) {
        sum += values[i] * 0.0;
        other += values[i + 1] * 0.0;
    }
    if (i < count) sum += values[i] * 0.0;
    return sum + other == 0;
}

static bool body_index_legal(const pinch_problem *problem, int body)
{
    return body >= PINCH_STATIC_BODY && body < problem->body_count;
}

static bool body_legal(const pinch_body *b)
{
    bool finite = all_finite(b->inertia, 9) && all_finite(b->position, 3) && all_finite(b->velocity, 6) &&
                  all_finite(b->external, 6) && isfinite(b->mass);
    return finite && b->mass >= 0 && b->radius > 0 &&
           (b->mass > 0 || (all_finite(b->drive_axis, 3) && isfinite(b->drive_force)));
}

/* The frame need not be unit and square to the last bit: whoever made it has rounded. */
static bool frame_legal(const pinch_contact *c)
{
    static const double FRAME_TOLERANCE = 1e-6;
    double n2 = 0, t2 = 0, nt = 0;
    for (int i = 0; i < 3; i++) {
        n2 += c->normal[i] * c->normal[i];
        t2 += c->tangent1[i] * c->tangent1[i];
        nt += c->normal[i] * c->tangent1[i];
    }
    return fabs(n2 - 1) <= FRAME_TOLERANCE && fabs(t2 - 1) <= FRAME_TOLERANCE && fabs(nt) <= FRAME_TOLERANCE;
}

/* A spring, or where a contact may soften at least a damper. */
static bool resists(const pinch_contact *c, int i)
{
    double k = c->stiffness[i], d = c->damping[i];
    return d >= 0 && (k > 0 || (c->may_soften && k == 0 && d > 0));
}

static bool contact_legal(const pinch_problem *problem, const pinch_contact *c)
{
    bool rolling = c->model == PINCH_CONTACT_ROLLING;
    bool soft = c->model == PINCH_CONTACT_SOFT || rolling, friction = c->model != PINCH_CONTACT_FRICTIONLESS;
    if (!body_index_legal(problem, c->body1) || !body_index_legal(problem, c->body2)) return false;
    if (c->body1 < 0 && c->body2 < 0) return false;
    if (friction && !soft && c->model != PINCH_CONTACT_HARD) return false;
    if (!frame_legal(c)) return false;
    bool finite = all_finite(c->position, 3) && all_finite(c->normal, 3) && all_finite(c->tangent1, 3) &&
                  all_finite(c->surface_velocity, 6) && isfinite(c->depth) && all_finite(c->stiffness, 3) &&
                  all_finite(c->damping, 3) && all_finite(c->elastic, 3) && all_finite(c->force, 4);
    bool laws = resists(c, 0) && c->max_force > 0 &&
                (!friction || (resists(c, 1) && c->friction[0] >= 0 && c->friction[1] >= 0)) &&
                (!soft || (resists(c, 2) && c->torsional_friction >= 0));
    for (int i = 0; i < 5; i++) laws = laws && c->friction_limit[i] >= 0;
    laws = laws && all_finite(c->viscous, 2) && c->viscous[0] >= 0 && c->viscous[1] >= 0;
    if (rolling)
        laws = laws && c->rolling_friction[0] >= 0 && c->rolling_friction[1] >= 0 &&
               all_finite(c->rolling_elastic, 2) && all_finite(c->rolling_moment, 2);
    return finite && laws;
}

static bool row_legal(const pinch_problem *problem, const pinch_joint_row *row)
{
    if (!body_index_legal(problem, row->body1) || !body_index_legal(problem, row->body2)) return false;
    if (row->body1 < 0 && row->body2 < 0) return false;
    return all_finite(row->j1, 6) && all_finite(row->j2, 6) && isfinite(row->rhs) && row->cfm >= 0 &&
           isfinite(row->cfm) && row->low <= row->high && isfinite(row->force);
}

bool pinch_problem_legal(const pinch_problem *problem)
{
    if (!(problem->step > 0) || !isfinite(problem->step) || problem->body_count < 1) return false;
    if (problem->faces != 0 && (problem->faces < 2 || problem->faces > 4096)) return false;
    for (int b = 0; b < problem->body_count; b++)
        if (!body_legal(&problem->bodies[b])) return false;
    for (int k = 0; k < problem->contact_count; k++)
        if (!contact_legal(problem, &problem->contacts[k])) return false;
    for (int k = 0; k < problem->row_count; k++)
        if (!row_legal(problem, &problem->rows[k])) return false;
    return true;
}
