/*
 * Islands at rest.
 *
 * What a step computes for a held object that does not move is rounding: depths are rounded to eps |x|, and the object
 * answers with motions of that size, in every step, for ever. An island whose motions before a step and after it are no
 * larger is at rest: its velocities are zero, its elastic states stay, and its bodies get exactly the forces that
 * cancel their weight in ODE's arithmetic. Those differ from the contacts' forces by m v / h of that rounding. So poses
 * keep their bits.
 *
 * In the next step the same contacts come from the same poses, and the island's problem is, to the bit, the one whose
 * answer has been found and verified: that answer is this step's, too. Where anything differs (a force, a pose, a
 * velocity, a mass, a contact, a surface, the step, gravity), the island is solved anew.
 */
#include "islands/island_life.h"

#include "joints/island_joints.h"
#include "util/checksum.h"

#include "support/extremes.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Motions up to these count as none. */
typedef struct rounding {
    double length, angle; /* m, rad in a step */
} rounding;

/* Computes the rounding from the last place of the coordinates that the island's depths are computed from. */
static rounding rounding_of(const pinch_problem *problem)
{
    static const double PLACES = 8;
    double largest = 0, smallest = INFINITY;
    for (int b = 0; b < problem->body_count; b++) {
        smallest = pinch_smaller(smallest, problem->bodies[b].radius);
        for (int i = 0; i < 3; i++) largest = pinch_larger(largest, fabs(problem->bodies[b].position[i]));
    }
    for (int k = 0; k < problem->contact_count; k++)
        for (int i = 0; i < 3; i++) largest = pinch_larger(largest, fabs(problem->contacts[k].position[i]));
    double length = PLACES * DBL_EPSILON * largest;
    return (rounding){length, length / smallest};
}

static bool no_larger(const double *values, int count, double limit)
{
    bool all = true;
    for (int i = 0; i < count; i++) all &= fabs(values[i]) <= limit;
    return all;
}

static bool body_rests(const pinch_step_body *b, const pinch_body *solved, double h, const rounding *r)
{
    const double *v = dBodyGetLinearVel(b->body), *w = dBodyGetAngularVel(b->body);
    if (b->drive >= 0 && (!no_larger(v, 3, 0) || !no_larger(w, 3, 0))) return false; /* as its owner prescribes */
    return no_larger(v, 3, r->length / h) && no_larger(w, 3, r->angle / h) &&
           no_larger(solved->velocity_end, 3, r->length / h) && no_larger(solved->velocity_end + 3, 3, r->angle / h);
}

/* Without friction, whether it slips is only read out. So it is where there is no kinetic coefficient besides. */
static bool has_friction(const pinch_contact *c)
{
    return c->model != PINCH_CONTACT_FRICTIONLESS && c->friction[0] + c->friction[1] + c->friction_limit[0] > 0;
}

/* A compliance floor is a part of h W, which rounding of the lever arms changes with them. */
static bool differ_by_rounding(const double *a, const double *b, int count, double part)
{
    bool all = true;
    for (int i = 0; i < count; i++) all &= fabs(a[i] - b[i]) <= part * fabs(a[i]);
    return all;
}

/* Tells whether the contact will be in the next step as it is in this one. */
static bool contact_rests(const pinch_pair *pair, const pinch_manifold_point *point, const pinch_contact *c, double h,
                          const rounding *r)
{
    double sheared[2], turned[3] = {c->elastic_end[2] - c->elastic[2], 0, 0};
    for (int i = 0; i < 2; i++) {
        sheared[i] = c->elastic_end[i] - c->elastic[i];
        if (c->model == PINCH_CONTACT_ROLLING) turned[1 + i] = c->rolling_elastic_end[i] - c->rolling_elastic[i];
    }
    if (!no_larger(sheared, 2, r->length) || !no_larger(turned, 3, r->angle) ||
        !no_larger(c->relative_velocity, 1, r->length / h))
        return false;
    bool slips = c->state == PINCH_CONTACT_SLIP, presses = c->force[0] > 0;
    bool slips_on = pair->has_material && has_friction(c) && slips != point->slipping;
    if (slips_on || presses != (point->normal_force > 0)) return false;
    const pinch_own_law *own = point->own;
    return pair->has_material ||
           (own->floor == c->floor && differ_by_rounding(own->compliance, c->compliance, 3, 4 * r->angle));
}

bool pinch_island_at_rest(const pinch_step_context *context, const pinch_contact_store *contacts,
                          const pinch_step_bodies *bodies, const pinch_island *island, const pinch_problem *problem)
{
    rounding r = rounding_of(problem);
    for (int k = 0; k < island->bodies.count; k++)
        if (!body_rests(pinch_island_body(bodies, island->bodies, k), &problem->bodies[k], context->h, &r))
            return false;
    for (int i = 0; i < island->pairs.count; i++) {
        const pinch_pair *pair = pinch_island_pair(contacts, island->pairs, i);
        for (int k = 0; k < pair->manifold.count; k++)
            if (!contact_rests(pair, &pair->manifold.point[k], &problem->contacts[pair->first_in_island + k],
                               context->h, &r))
                return false;
    }
    return true;
}

/* The steps for which a floor is still to stay do not pass while nothing moves. */
static void hold_floors(const pinch_contact_store *contacts, const pinch_island *island, pinch_problem *problem)
{
    for (int i = 0; i < island->pairs.count; i++) {
        const pinch_pair *pair = pinch_island_pair(contacts, island->pairs, i);
        for (int k = 0; k < pair->manifold.count && !pair->has_material; k++)
            problem->contacts[pair->first_in_island + k].hold = pair->manifold.point[k].own->hold;
    }
}

void pinch_make_steady(const pinch_contact_store *contacts, const pinch_island *island, pinch_problem *problem)
{
    hold_floors(contacts, island, problem);
    for (int b = 0; b < problem->body_count; b++)
        memset(problem->bodies[b].velocity_end, 0, sizeof problem->bodies[b].velocity_end);
    for (int k = 0; k < problem->contact_count; k++) {
        pinch_contact *c = &problem->contacts[k];
        memcpy(c->elastic_end, c->elastic, sizeof c->elastic);
        memcpy(c->rolling_elastic_end, c->rolling_elastic, sizeof c->rolling_elastic);
    }
}

/* Computes a body's weight as ODE does; that of a body under force control does not count. The mass
 * of a body at rest enters by its weight alone. */
static void weight_of(const pinch_step_context *context, const pinch_step_body *b, double weight[3])
{
    dMass mass;
    bool falls = b->drive < 0 && dBodyGetGravityMode(b->body);
    dBodyGetMass(b->body, &mass);
    for (int i = 0; i < 3; i++) weight[i] = falls ? mass.mass * context->gravity[i] : 0;
}

/* Sets the force that leaves no velocity: ODE adds the weight to it. */
static void balance_weight(const pinch_step_body *b, const double weight[3])
{
    dBodySetForce(b->body, -weight[0], -weight[1], -weight[2]);
    dBodySetTorque(b->body, 0, 0, 0);
}

static uint64_t rest_bits(const double quaternion[4], const double weight[3])
{
    return pinch_checksum(pinch_checksum(pinch_checksum_start(7), quaternion, 4), weight, 3);
}

void pinch_balance_gravity(const pinch_step_context *context, const pinch_step_bodies *bodies,
                           const pinch_island *island)
{
    for (int k = 0; k < island->bodies.count; k++) {
        pinch_step_body *b = pinch_island_body(bodies, island->bodies, k);
        double weight[3];
        weight_of(context, b, weight);
        b->rest_bits = rest_bits(dBodyGetQuaternion(b->body), weight);
        if (b->drive < 0) balance_weight(b, weight);
    }
}

void pinch_stop_bodies(const pinch_step_bodies *bodies, const pinch_island *island)
{
    for (int k = 0; k < island->bodies.count; k++) {
        dBodyID body = pinch_island_body(bodies, island->bodies, k)->body;
        dBodySetLinearVel(body, 0, 0, 0);
        dBodySetAngularVel(body, 0, 0, 0);
    }
}

/* Tells whether ODE, which normalizes a quaternion in every step, leaves this one as it is. */
static bool stays_unit(const double *q)
{
    double norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    return 1 / sqrt(norm2) == 1;
}

/* A quaternion whose length is only nearly 1 alternates between two neighbours for ever. One a bit or two away has
 * length 1 as ODE computes it. */
static void steady_orientation(const pinch_step_context *context, const pinch_step_body *b)
{
    double q[4], weight[3];
    memcpy(q, dBodyGetQuaternion(b->body), sizeof q);
    weight_of(context, b, weight);
    if (rest_bits(q, weight) == b->rest_bits) return;
    for (int i = 0; i < 4; i++) {
        double was = q[i], up = was, down = was;
        for (int places = 0; places < 4; places++) {
            q[i] = up = nextafter(up, 2);
            if (stays_unit(q)) break;
            q[i] = down = nextafter(down, -2);
            if (stays_unit(q)) break;
        }
        if (stays_unit(q)) break;
        q[i] = was;
    }
    if (stays_unit(q)) dBodySetQuaternion(b->body, q);
}

void pinch_steady_orientations(const pinch_step_context *context, const pinch_step_bodies *bodies,
                               const pinch_island *island)
{
    for (int k = 0; k < island->bodies.count; k++)
        steady_orientation(context, pinch_island_body(bodies, island->bodies, k));
}

/* Tells whether a body is where it was, without velocity, under the forces and the weight it had. */
static bool body_unchanged(const pinch_step_context *context, const pinch_drives *drives, const pinch_step_body *b)
{
    dBodyID body = b->body;
    double weight[3];
    if (memcmp(dBodyGetPosition(body), b->position, sizeof b->position) != 0 || !pinch_body_stands(body)) return false;
    weight_of(context, b, weight);
    if (rest_bits(dBodyGetQuaternion(body), weight) != b->rest_bits) return false;
    if (b->drive >= 0) return drives->items[b->drive].force == b->wrench[0];
    return memcmp(dBodyGetForce(body), b->wrench, 3 * sizeof(double)) == 0 &&
           memcmp(dBodyGetTorque(body), b->wrench + 3, 3 * sizeof(double)) == 0;
}

/* Compares what the rows of the island's joints depend on, and the rows themselves where that has changed or cannot be
 * told. The bodies that they are for do not count. */
static bool joints_unchanged(const pinch_step_context *context, const pinch_step_bodies *bodies,
                             pinch_joint_store *joints, pinch_problem_buffers *buffers, pinch_island *island)
{
    if (island->joints.range.count == 0) return true;
    if (!context->solve_and_advance) return false;
    uint64_t inputs;
    pinch_island_joints *j = &island->joints;
    if (j->inputs_known && pinch_joint_inputs(joints, j, &inputs) && inputs == j->rest_inputs) return true;
    if (!pinch_reserve_problem(buffers, island->bodies.count, 0, j->room.count)) return false;
    memset(buffers->bodies.items, 0, (size_t)island->bodies.count * sizeof *buffers->bodies.items);
    pinch_problem problem = {.bodies = buffers->bodies.items, .rows = buffers->rows.items};
    pinch_fill_joints(joints, context, bodies, j, &problem);
    pinch_remember_joint_inputs(joints, j);
    return pinch_joint_bits(j, &problem) == j->rest_bits;
}

bool pinch_island_unchanged(const pinch_step_context *context, const pinch_contact_store *contacts,
                            const pinch_step_bodies *bodies, pinch_joint_store *joints, pinch_problem_buffers *buffers,
                            pinch_island *island)
{
    bool rested = island->phase >= PINCH_ISLAND_RESTING;
    if (!rested || !context->same_world || context->settings.cold_start || context->settings.solve_at_rest)
        return false;
    for (int k = 0; k < island->bodies.count; k++)
        if (!body_unchanged(context, &bodies->drives, pinch_island_body(bodies, island->bodies, k))) return false;
    for (int i = 0; i < island->pairs.count && !contacts->unchanged; i++)
        if (!pinch_island_pair(contacts, island->pairs, i)->unchanged) return false;
    return joints_unchanged(context, bodies, joints, buffers, island);
}

/* Without forces and velocity ODE's step leaves a body as it is, and it leaves a disabled one sooner. No enabled joint
 * ties it to others: the islands are those of the last step, and the island's own joints are disabled. */
static void skip_body(const pinch_step_body *b)
{
    static const double NONE[6] = {0};
    if (memcmp(b->wrench, NONE, sizeof NONE) != 0) {
        dBodySetForce(b->body, 0, 0, 0);
        dBodySetTorque(b->body, 0, 0, 0);
    }
    dBodyDisable(b->body);
}

void pinch_reuse_answer(const pinch_step_context *context, const pinch_step_bodies *bodies,
                        const pinch_joint_store *joints, pinch_island *island)
{
    island->phase = PINCH_ISLAND_REUSED;
    island->skipped_by_ode = context->solve_and_advance; /* otherwise forces may still be added */
    island->mismatch[0] = island->mismatch[1] = 0;
    for (int k = 0; k < island->bodies.count; k++) {
        const pinch_step_body *b = pinch_island_body(bodies, island->bodies, k);
        double weight[3];
        if (b->drive >= 0) continue;
        if (island->skipped_by_ode) {
            skip_body(b);
            continue;
        }
        weight_of(context, b, weight);
        balance_weight(b, weight);
    }
    pinch_reuse_joints(joints, &island->joints, island->skipped_by_ode);
}

void pinch_reenable_bodies(const pinch_step_bodies *bodies, pinch_island *island)
{
    for (int k = 0; k < island->bodies.count && island->skipped_by_ode; k++) {
        const pinch_step_body *b = pinch_island_body(bodies, island->bodies, k);
        if (b->drive < 0) dBodyEnable(b->body);
    }
    island->skipped_by_ode = false;
}

bool pinch_island_stands(const pinch_step_bodies *bodies, const pinch_island *island)
{
    for (int k = 0; k < island->bodies.count; k++)
        if (!pinch_body_stands(pinch_island_body(bodies, island->bodies, k)->body)) return false;
    return true;
}
