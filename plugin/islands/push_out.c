/*
 * The energy that hard contacts put in as they push bodies out of each other.
 *
 * A hard contact takes an overlap back as joints take errors of position back: it asks for a velocity apart. By itself
 * that costs next to nothing. But where joints all but lock what overlaps, a small motion apart is a large one of
 * everything else, and bodies that begin deep in each other throw a mechanism about.
 *
 * The contact force F changes the kinetic energy by h F (w+ + w-)/2, with the normal velocity w before and after the
 * step. What of this velocity is no more than the overlap asks for is its push. It may put in as many times the energy
 * that the overlaps ask for as joints may of their errors (energy_account.c), and a part of the energy in motion; where
 * it would put more in, bodies come apart more slowly. Contacts that are soft by their own parameters are springs, and
 * may give what they hold. Fingertips of a material are none of these contacts.
 */
#include "islands/island_life.h"

#include "joints/island_joints.h"

#include "support/vec3.h"

#include <math.h>

static const double TIMES_ASKED_FOR = 100, PART_OF_MOTION = 0.1;
/* Softer ones than this part of what the bodies' inertia gives a contact in a step are springs, as in surface.c. */
static const double STIFF = 0.01;

/* Returns the velocity (m/s) that a contact asks for because its bodies overlap. One whose partner drives it on is not
 * judged. */
static double push_of(const pinch_contact *c, double h)
{
    if (!c->may_soften || !(c->depth > 0) || c->surface_velocity[0] < 0) return 0;
    double push = c->stiffness[0] * c->depth / (h * c->stiffness[0] + c->damping[0]);
    return fmax(push - c->surface_velocity[0], 0);
}

static double inverse_masses(const pinch_problem *problem, const pinch_contact *c)
{
    double sum = 0;
    if (c->body1 >= 0) sum += 1 / problem->bodies[c->body1].mass;
    if (c->body2 >= 0) sum += 1 / problem->bodies[c->body2].mass;
    return sum;
}

double pinch_push_out_limit(const pinch_problem *problem)
{
    double h = problem->step, limit = PART_OF_MOTION * pinch_energy_in_motion(problem);
    for (int k = 0; k < problem->contact_count; k++) {
        const pinch_contact *c = &problem->contacts[k];
        double push = push_of(c, h), mobility = inverse_masses(problem, c);
        if (!(push > 0)) continue;
        limit += TIMES_ASKED_FOR * 0.5 * push * push / mobility;
        if (STIFF * h * mobility * (h * c->stiffness[0] + c->damping[0]) <= 1)
            limit += 0.5 * c->stiffness[0] * c->depth * c->depth;
    }
    return limit;
}

/* Returns the normal velocity (m/s) of body 1 relative to body 2 at a contact, before its force acts. */
static double approach(const pinch_problem *problem, const pinch_contact *c)
{
    double sum = 0;
    for (int side = 0; side < 2; side++) {
        int body = side ? c->body2 : c->body1;
        double arm[3], turned[3];
        if (body < 0) continue;
        const pinch_body *b = &problem->bodies[body];
        pinch_v3_sub(c->position, b->position, arm);
        pinch_v3_cross(b->velocity + 3, arm, turned);
        sum += (side ? -1 : 1) * (pinch_v3_dot(b->velocity, c->normal) + pinch_v3_dot(turned, c->normal));
    }
    return sum;
}

double pinch_push_out_work(const pinch_problem *problem)
{
    double work = 0;
    for (int k = 0; k < problem->contact_count; k++) {
        const pinch_contact *c = &problem->contacts[k];
        double push = push_of(c, problem->step);
        if (!(push > 0)) continue;
        double mean = 0.5 * (c->relative_velocity[0] - c->surface_velocity[0] + approach(problem, c));
        work += problem->step * c->force[0] * fmin(fmax(mean, 0), push);
    }
    return work;
}

void pinch_set_push_out(pinch_problem *problem, double from, double to)
{
    for (int k = 0; k < problem->contact_count; k++) {
        pinch_contact *c = &problem->contacts[k];
        double push = from > 0 ? push_of(c, problem->step) / from : 0;
        c->surface_velocity[0] += (from - to) * push;
    }
}
