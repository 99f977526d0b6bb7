/*
 * Joints that ODE solves, after the contacts, by quickstep's few sweeps.
 *
 * The forces of the contacts are right where joints hold. Sweeps that end early leave joints far from that, stiff
 * contacts answer in the next step, and a program that lay still shakes. What ODE arrived at, less what was solved for,
 * tells: where that is more than a part of what gravity does in a step and of the motion there is, islands with such
 * joints are left to ODE, contacts and all, as they were without Pinch. Later they are tried again: soon at first, and
 * after twice as many steps each time that it goes wrong again.
 */
#include "plugin.h"

#include "support/vec3.h"

#include <math.h>

enum { FIRST_SPAN = 8, LONGEST_SPAN = 1 << 24 };
static const double PART_OF_FALL = 0.1, PART_OF_SPEED = 0.05;
static const double LEAST_PULL = 1; /* m/s^2, where gravity is less */

/* Do contacts push a body so much more than it moves that what the joints leave would be all there is? */
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

static double speed_of(const pinch_ode *p, const pinch_island *island)
{
    double largest = 0;
    for (int k = 0; k < island->body_count; k++)
        largest = fmax(largest, pinch_v3_norm(dBodyGetLinearVel(pinch_island_body(p, island, k)->body)));
    return largest;
}

/* Rows that depend on each other and ask for different things: what is solved for is no motion at all. */
static bool runs_away(const pinch_ode *p, const pinch_island *island, double fall)
{
    static const double MOST = 1000;
    double before = speed_of(p, island), after = 0;
    for (int k = 0; k < island->body_count; k++)
        after = fmax(after, pinch_v3_norm(pinch_island_body(p, island, k)->velocity));
    return !(after <= MOST * (before + fall));
}

static bool joints_bear_all(const pinch_ode *p, const pinch_island *island, double h, double fall)
{
    for (int k = 0; k < island->body_count; k++) {
        const pinch_step_body *b = pinch_island_body(p, island, k);
        if (b->drive < 0 && pushed_hard(b, h, fall)) return true;
    }
    return false;
}

static double fall_of(const pinch_ode *p, double h)
{
    return h * fmax(pinch_v3_norm(p->world_values), LEAST_PULL);
}

bool pinch_joints_left_anyway(const pinch_ode *p, const pinch_island *island)
{
    bool distrusted = p->settings.stepper == PINCH_ODE_QUICKSTEP && p->at_once && p->step < p->distrusted_until;
    for (int k = 0; k < island->joint_count && distrusted; k++)
        if (!pinch_island_joint(p, island, k)->exact) return true;
    return false;
}

bool pinch_joints_distrusted(const pinch_ode *p, const pinch_island *island, double h)
{
    if (!p->at_once || island->joint_count == 0 || island->takes_joints) return false;
    if (!island->rows_hold && runs_away(p, island, fall_of(p, h))) return true;
    return p->settings.stepper == PINCH_ODE_QUICKSTEP &&
           (p->step < p->distrusted_until || joints_bear_all(p, island, h, fall_of(p, h)));
}

void pinch_judge_joints(pinch_ode *p, const pinch_island *island, double h)
{
    if (p->settings.stepper != PINCH_ODE_QUICKSTEP || !island->solved || island->joint_count == 0 ||
        island->takes_joints || p->step < p->distrusted_until)
        return;
    double fall = fall_of(p, h);
    if (island->mismatch[0] <= PART_OF_FALL * fall) return;
    if (island->mismatch[0] <= PART_OF_FALL * fall + PART_OF_SPEED * speed_of(p, island)) return;
    bool soon = p->step - p->distrusted_until <= p->distrust_span;
    p->distrust_span = soon && p->distrust_span > 0 ? p->distrust_span * 2 : FIRST_SPAN;
    if (p->distrust_span > LONGEST_SPAN) p->distrust_span = LONGEST_SPAN;
    p->distrusted_until = p->step + 1 + p->distrust_span;
}
