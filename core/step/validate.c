#include "step/stages.h"

#include "support/lanes.h"
#include "support/loop.h"
#include "support/vec3.h"

#include <math.h>
#include <stdatomic.h>

/* One sum is finite only if all its terms are (or infinities cancel into NaN, which is not finite either): what is to
 * be finite adds zero to it. Several sums keep additions from waiting for each other. */
typedef struct zeros {
    pinch_lanes even, odd;
    double rest;
} zeros;

static inline void add_finite(const double *values, int count, zeros *z)
{
    int i = 0;
    for (; i + 3 < count; i += 4) {
        z->even += pinch_lanes_at(values + i) * 0.0;
        z->odd += pinch_lanes_at(values + i + 2) * 0.0;
    }
    if (i + 1 < count) {
        z->even += pinch_lanes_at(values + i) * 0.0;
        i += 2;
    }
    if (i < count) z->rest += values[i] * 0.0;
}

static inline bool all_zero(const zeros *z)
{
    pinch_lanes both = z->even + z->odd;
    return both[0] + both[1] + z->rest == 0;
}

static bool all_finite(const double *values, int count)
{
    zeros z = {{0, 0}, {0, 0}, 0};
    add_finite(values, count, &z);
    return all_zero(&z);
}

static bool body_index_valid(const pinch_problem *problem, int body)
{
    return body >= PINCH_STATIC_BODY && body < problem->body_count;
}

/* Unit vectors, right angles and symmetries need not be exact: whoever made them has rounded. */
static const double ROUNDING = 1e-6;

static bool is_symmetric(const double *inertia)
{
    double skew = fabs(inertia[1] - inertia[3]) + fabs(inertia[2] - inertia[6]) + fabs(inertia[5] - inertia[7]);
    return skew <= ROUNDING * (inertia[0] + inertia[4] + inertia[8]);
}

static bool drive_valid(const pinch_body *b)
{
    return fabs(pinch_v3_norm(b->drive_axis) - 1) <= ROUNDING && isfinite(b->drive_force);
}

static bool body_valid(const pinch_body *b)
{
    zeros z = {{0, 0}, {0, 0}, b->mass * 0.0};
    add_finite(b->inertia, 9, &z);
    add_finite(b->position, 3, &z);
    add_finite(b->velocity, 6, &z);
    add_finite(b->external, 6, &z);
    return all_zero(&z) && b->mass >= 0 && b->radius > 0 && (b->mass > 0 ? is_symmetric(b->inertia) : drive_valid(b));
}

static bool frame_valid(const pinch_contact *c)
{
    double n2 = 0, t2 = 0, nt = 0;
    for (int i = 0; i < 3; i++) {
        n2 += c->normal[i] * c->normal[i];
        t2 += c->tangent1[i] * c->tangent1[i];
        nt += c->normal[i] * c->tangent1[i];
    }
    return fabs(n2 - 1) <= ROUNDING && fabs(t2 - 1) <= ROUNDING && fabs(nt) <= ROUNDING;
}

/* A row needs a spring, or where its contact may soften at least a damper. */
static bool resists(const pinch_contact *c, int i)
{
    double k = c->stiffness[i], d = c->damping[i];
    return d >= 0 && (k > 0 || (c->may_soften && k == 0 && d > 0));
}

static bool contact_valid(const pinch_problem *problem, const pinch_contact *c)
{
    bool rolling = c->model == PINCH_CONTACT_ROLLING;
    bool soft = c->model == PINCH_CONTACT_SOFT || rolling, friction = c->model != PINCH_CONTACT_FRICTIONLESS;
    if (!body_index_valid(problem, c->body1) || !body_index_valid(problem, c->body2)) return false;
    if (c->body1 == c->body2) return false; /* a body does not touch itself, and the world not the world */
    if (friction && !soft && c->model != PINCH_CONTACT_HARD) return false;
    if (!frame_valid(c)) return false;
    zeros z = {{0, 0}, {0, 0}, c->depth * 0.0}; /* the frame is finite: its lengths are */
    add_finite(c->position, 3, &z);
    add_finite(c->surface_velocity, 6, &z);
    add_finite(c->stiffness, 3, &z);
    add_finite(c->damping, 3, &z);
    add_finite(c->elastic, 3, &z);
    add_finite(c->force, 4, &z);
    add_finite(c->viscous, 2, &z);
    bool laws = resists(c, 0) && c->max_force > 0 &&
                (!friction || (resists(c, 1) && c->friction[0] >= 0 && c->friction[1] >= 0)) &&
                (!soft || (resists(c, 2) && c->torsional_friction >= 0));
    for (int i = 0; i < 5; i++) laws = laws && c->friction_limit[i] >= 0;
    laws = laws && c->viscous[0] >= 0 && c->viscous[1] >= 0;
    if (rolling)
        laws = laws && c->rolling_friction[0] >= 0 && c->rolling_friction[1] >= 0 &&
               all_finite(c->rolling_elastic, 2) && all_finite(c->rolling_moment, 2);
    return laws && all_zero(&z);
}

static bool row_valid(const pinch_problem *problem, const pinch_joint_row *row)
{
    if (!body_index_valid(problem, row->body1) || !body_index_valid(problem, row->body2)) return false;
    if (row->body1 < 0 && row->body2 < 0) return false;
    const double others[4] = {row->rhs, row->force, row->cfm, row->yield};
    zeros z = {{0, 0}, {0, 0}, 0};
    for (int i = 0; i < 6; i += 2) {
        z.even += pinch_lanes_at(row->j1 + i) * 0.0;
        z.odd += pinch_lanes_at(row->j2 + i) * 0.0;
    }
    add_finite(others, 4, &z);
    return all_zero(&z) && row->cfm >= 0 && row->yield >= 0 && row->low <= row->high;
}

typedef struct validation {
    const pinch_problem *problem;
    atomic_bool wrong;
} validation;

static void validate_bodies(void *argument, int first, int end)
{
    validation *v = argument;
    for (int b = first; b < end; b++)
        if (!body_valid(&v->problem->bodies[b])) atomic_store(&v->wrong, true);
}

static void validate_contacts(void *argument, int first, int end)
{
    validation *v = argument;
    for (int k = first; k < end; k++)
        if (!contact_valid(v->problem, &v->problem->contacts[k])) atomic_store(&v->wrong, true);
}

bool pinch_problem_valid(const pinch_problem *problem)
{
    if (!(problem->step > 0) || !isfinite(problem->step)) return false;
    if (problem->body_count < 1 || problem->contact_count < 0 || problem->row_count < 0) return false;
    if (problem->faces != 0 && (problem->faces < 2 || problem->faces > 4096)) return false;
    validation v = {.problem = problem};
    pinch_each(problem->crew, problem->body_count, validate_bodies, &v);
    pinch_each(problem->crew, problem->contact_count, validate_contacts, &v);
    if (atomic_load(&v.wrong)) return false;
    for (int k = 0; k < problem->row_count; k++)
        if (!row_valid(problem, &problem->rows[k])) return false;
    return problem->row_count < 1 || !problem->rows[0].continues;
}
