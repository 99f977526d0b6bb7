/*
 * The fallback for joints that ODE solves after the contacts, by quickstep's few sweeps.
 *
 * The forces of the contacts are right where joints hold. Sweeps that end early leave joints far from that, stiff
 * contacts answer in the next step, and a program that lay still shakes. The mismatch tells, what ODE arrived at less
 * what was solved for: where it is more than a part of what gravity does in a step and of the motion there is, an
 * island with such joints is left to ODE, contacts and all, as it was without Pinch. Later Pinch tries it again
 * (backoff.c).
 *
 * The same is done where joints would put in more energy than they may (energy_account.c), and Pinch cannot have them
 * close more slowly because it does not know all of them. And joints that ODE solves never keep contact forces that
 * were found with rows that depend on each other: ODE shares out what these carry in another way.
 */
#include "islands/island_life.h"

#include "support/vec3.h"

#include <math.h>

static const double PART_OF_FALL = 0.1, PART_OF_SPEED = 0.05;
static const double LEAST_PULL = 1; /* m/s^2 */

/* Tells whether contacts push a body so much more than it moves that what the joints leave would be all there is. */
static bool pushed_hard(const pinch_step_body *b, double h, double fall)
{
    static const double MOST = 100;
    double force[3], torque[3];
    dMass mass;
    dBodyGetMass(b->body, &mass);
    pinch_v3_sub(dBodyGetForce(b->body), b->wrench, force);
    pinch_v3_sub(dBodyGetTorque(b->body), b->wrench + 3, torque);
    double inertia = (mass.I[0] + mass.I[5] + mass.I[10]) / 3, size = sqrt(inertia / mass.mass);
    double speed = pinch_v3_norm(dBodyGetLinearVel(b->body)) + pinch_v3_norm(b->velocity) + fall;
    double spin = pinch_v3_norm(dBodyGetAngularVel(b->body)) + pinch_v3_norm(b->velocity + 3) + fall / size;
    return !(h * pinch_v3_norm(force) <= MOST * mass.mass * speed &&
             h * pinch_v3_norm(torque) <= MOST * inertia * spin);
}

static double speed_of(const pinch_step_bodies *bodies, const pinch_island *island)
{
    double largest = 0;
    for (int k = 0; k < island->bodies.count; k++)
        largest = fmax(largest, pinch_v3_norm(dBodyGetLinearVel(pinch_island_body(bodies, island->bodies, k)->body)));
    return largest;
}

/* Where rows depend on each other and ask for different things, what is solved for is no motion at all. */
static bool runs_away(const pinch_step_bodies *bodies, const pinch_island *island, double fall)
{
    static const double MOST = 1000;
    double before = speed_of(bodies, island), after = 0;
    for (int k = 0; k < island->bodies.count; k++)
        after = fmax(after, pinch_v3_norm(pinch_island_body(bodies, island->bodies, k)->velocity));
    return !(after <= MOST * (before + fall));
}

static bool joints_bear_all(const pinch_step_bodies *bodies, const pinch_island *island, double h, double fall)
{
    for (int k = 0; k < island->bodies.count; k++) {
        const pinch_step_body *b = pinch_island_body(bodies, island->bodies, k);
        if (b->drive < 0 && pushed_hard(b, h, fall)) return true;
    }
    return false;
}

double pinch_fall_in_step(const pinch_step_context *context)
{
    return context->h * fmax(pinch_v3_norm(context->gravity), LEAST_PULL);
}

bool pinch_joint_fallback_needed(const pinch_step_context *context, const pinch_step_bodies *bodies,
                                 const pinch_island *island)
{
    if (!context->solve_and_advance || island->joints.range.count == 0) return false;
    bool quickstep = context->settings.stepper == PINCH_ODE_QUICKSTEP;
    if (island->joints.put_energy_in && (quickstep || island->joints.by_pinch)) return true;
    if (island->joints.by_pinch) return false;
    if (island->result.dependent_rows > 0 && !context->settings.joints_by_ode) return true;
    double fall = pinch_fall_in_step(context);
    if (!island->joints.rows_hold && runs_away(bodies, island, fall)) return true;
    return quickstep && joints_bear_all(bodies, island, context->h, fall);
}

bool pinch_joints_went_wrong(const pinch_step_context *context, const pinch_step_bodies *bodies,
                             const pinch_island *island)
{
    bool quickstep = context->settings.stepper == PINCH_ODE_QUICKSTEP;
    if (island->phase == PINCH_ISLAND_ASLEEP || island->joints.range.count == 0) return false;
    bool given_up = quickstep || island->phase == PINCH_ISLAND_FALLBACK;
    if (given_up && island->joints.put_energy_in) return true;
    if (island->joints.by_pinch) return false;
    if (island->phase == PINCH_ISLAND_FALLBACK) /* its solve had an answer, then, that was given up for its joints */
        return island->tried && island->result.dependent_rows > 0 &&
               island->result.solve.status == PINCH_SOLVE_CONVERGED;
    double fall = pinch_fall_in_step(context);
    return quickstep && island->mismatch[0] > PART_OF_FALL * fall &&
           island->mismatch[0] > PART_OF_FALL * fall + PART_OF_SPEED * speed_of(bodies, island);
}
