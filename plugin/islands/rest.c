/*
 * Islands at rest.
 *
 * What a step computes for a held object that does not move is rounding: depths are rounded to eps |x|, and the object
 * answers with motions of that size, in every step, for ever. An island whose motions before a step and after it are no
 * larger is at rest: its velocities are zero, its elastic states stay, and its bodies get the very forces of which ODE
 * makes no motion. Those differ from the contacts' by m v / h of that rounding. So poses keep their bits.
 *
 * In the next step the same contacts come from the same poses, and the island's problem is, to the bit, the one whose
 * answer has been found and verified: it is this step's, too. Where anything differs (a force, a pose, a velocity, a
 * mass, a contact, a surface, the step, gravity), the island is solved anew.
 */
#include "util/checksum.h"
#include "plugin.h"

#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* What counts as none. */
typedef struct rounding {
    double length, angle; /* m, rad in a step */
} rounding;

/* In units of the last place of the coordinates that the island's depths are computed from. */
static rounding rounding_of(const pinch_problem *problem)
{
    static const double PLACES = 8;
    double largest = 0, smallest = INFINITY;
    for (int b = 0; b < problem->body_count; b++) {
        smallest = fmin(smallest, problem->bodies[b].radius);
        for (int i = 0; i < 3; i++) largest = fmax(largest, fabs(problem->bodies[b].position[i]));
    }
    for (int k = 0; k < problem->contact_count; k++)
        for (int i = 0; i < 3; i++) largest = fmax(largest, fabs(problem->contacts[k].position[i]));
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

/* Does the contact find itself in the next step as it did in this one? */
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
    if (slips != point->slipping || presses != (point->normal_force > 0)) return false;
    const pinch_own_law *own = point->own;
    return pair->has_material || (own->floor == c->floor && own->hold == c->hold &&
                                  memcmp(own->compliance, c->compliance, sizeof own->compliance) == 0);
}

static const pinch_pair *pair_of(const pinch_ode *p, const pinch_island *island, int k)
{
    return &p->pairs.items[p->pair_of.items[island->first_pair + k]];
}

bool pinch_island_rests(const pinch_ode *p, const pinch_island *island, double h, const pinch_problem *problem)
{
    rounding r = rounding_of(problem);
    for (int k = 0; k < island->body_count; k++)
        if (!body_rests(pinch_island_body(p, island, k), &problem->bodies[k], h, &r)) return false;
    for (int i = 0; i < island->pair_count; i++) {
        const pinch_pair *pair = pair_of(p, island, i);
        for (int k = 0; k < pair->manifold.count; k++)
            if (!contact_rests(pair, &pair->manifold.point[k], &problem->contacts[pair->first_core + k], h, &r))
                return false;
    }
    return true;
}

void pinch_bring_to_rest(pinch_problem *problem)
{
    for (int b = 0; b < problem->body_count; b++)
        memset(problem->bodies[b].velocity_end, 0, sizeof problem->bodies[b].velocity_end);
    for (int k = 0; k < problem->contact_count; k++) {
        pinch_contact *c = &problem->contacts[k];
        memcpy(c->elastic_end, c->elastic, sizeof c->elastic);
        memcpy(c->rolling_elastic_end, c->rolling_elastic, sizeof c->rolling_elastic);
    }
}

/* As ODE computes it; that of a body under force control does not count. At rest the mass counts by nothing else. */
static void weight_of(const pinch_ode *p, const pinch_step_body *b, double weight[3])
{
    dMass mass;
    bool falls = b->drive < 0 && dBodyGetGravityMode(b->body);
    dBodyGetMass(b->body, &mass);
    for (int i = 0; i < 3; i++) weight[i] = falls ? mass.mass * p->world_values[i] : 0;
}

/* ODE adds the weight to the forces before it makes a velocity of them. */
static void balance_weight(const pinch_step_body *b, const double weight[3])
{
    dBodySetForce(b->body, -weight[0], -weight[1], -weight[2]);
    dBodySetTorque(b->body, 0, 0, 0);
}

static uint64_t rest_bits(const double quaternion[4], const double weight[3])
{
    return pinch_checksum(pinch_checksum(pinch_checksum_start(7), quaternion, 4), weight, 3);
}

void pinch_hold_still(pinch_ode *p, const pinch_island *island)
{
    for (int k = 0; k < island->body_count; k++) {
        pinch_step_body *b = pinch_island_body(p, island, k);
        double weight[3];
        weight_of(p, b, weight);
        b->rest_bits = rest_bits(dBodyGetQuaternion(b->body), weight);
        if (b->drive < 0) balance_weight(b, weight);
    }
}

void pinch_brake(pinch_ode *p, const pinch_island *island)
{
    for (int k = 0; k < island->body_count; k++) {
        dBodyID body = pinch_island_body(p, island, k)->body;
        dBodySetLinearVel(body, 0, 0, 0);
        dBodySetAngularVel(body, 0, 0, 0);
    }
}

/* Will ODE, which makes a quaternion a unit one in every step, leave it as it is? */
static bool stays_unit(const double *q)
{
    double norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    return 1 / sqrt(norm2) == 1;
}

/* A quaternion whose length is 1 only nearly goes to and fro between two neighbours for ever. One a bit or two away is
 * of length 1 as ODE computes it. */
static void settle_turn(const pinch_ode *p, const pinch_step_body *b)
{
    double q[4], weight[3];
    memcpy(q, dBodyGetQuaternion(b->body), sizeof q);
    weight_of(p, b, weight);
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

void pinch_settle_poses(const pinch_ode *p, const pinch_island *island)
{
    for (int k = 0; k < island->body_count; k++) settle_turn(p, pinch_island_body(p, island, k));
}

/* Where it was, without velocity, under the forces and the weight it had. */
static bool body_same(const pinch_ode *p, const pinch_step_body *b)
{
    dBodyID body = b->body;
    double weight[3];
    if (memcmp(dBodyGetPosition(body), b->position, sizeof b->position) != 0 || !pinch_body_stands(body)) return false;
    weight_of(p, b, weight);
    if (rest_bits(dBodyGetQuaternion(body), weight) != b->rest_bits) return false;
    return b->drive >= 0 || (memcmp(dBodyGetForce(body), b->wrench, 3 * sizeof(double)) == 0 &&
                             memcmp(dBodyGetTorque(body), b->wrench + 3, 3 * sizeof(double)) == 0);
}

/* The rows of its joints from the poses and parameters of this step; the bodies they are for are not looked at. */
static bool joints_same(pinch_ode *p, int worker, pinch_island *island, double h)
{
    pinch_desk *desk = &p->desk[worker];
    if (island->joint_count == 0) return true;
    if (!p->at_once || !pinch_desk_reserve(desk, island->body_count, 0, PINCH_JOINT_MAX_ROWS * island->joint_count + 1))
        return false;
    memset(desk->bodies.items, 0, (size_t)island->body_count * sizeof *desk->bodies.items);
    pinch_problem problem = {.bodies = desk->bodies.items, .rows = desk->rows.items};
    pinch_fill_joints(p, island, h, &problem);
    return pinch_joint_bits(island, problem.rows, problem.row_count) == island->joint_bits;
}

bool pinch_island_same(pinch_ode *p, int worker, pinch_island *island, double h)
{
    if (!island->rests || !p->same_world || p->settings.cold_start || p->settings.solve_at_rest) return false;
    for (int k = 0; k < island->body_count; k++)
        if (!body_same(p, pinch_island_body(p, island, k))) return false;
    for (int i = 0; i < island->pair_count && !p->unchanged; i++)
        if (!pair_of(p, island, i)->same) return false;
    return joints_same(p, worker, island, h);
}

/* Without forces and velocity ODE's step leaves a body as it is; it leaves a disabled one sooner. No joint that is
 * enabled ties it to others: the layout is as it was, and the island's own joints are switched off. */
static void leave_out(const pinch_step_body *b)
{
    static const double NONE[6] = {0};
    if (memcmp(b->wrench, NONE, sizeof NONE) != 0) {
        dBodySetForce(b->body, 0, 0, 0);
        dBodySetTorque(b->body, 0, 0, 0);
    }
    dBodyDisable(b->body);
}

void pinch_rest_on(pinch_ode *p, pinch_island *island)
{
    island->again = true;
    island->left_out = p->at_once; /* otherwise forces may still be added */
    island->mismatch[0] = island->mismatch[1] = 0;
    for (int k = 0; k < island->body_count; k++) {
        const pinch_step_body *b = pinch_island_body(p, island, k);
        double weight[3];
        if (b->drive >= 0) continue;
        if (island->left_out) {
            leave_out(b);
            continue;
        }
        weight_of(p, b, weight);
        balance_weight(b, weight);
    }
    pinch_take_joints_again(p, island);
}

void pinch_take_in(const pinch_ode *p, pinch_island *island)
{
    for (int k = 0; k < island->body_count && island->left_out; k++) {
        const pinch_step_body *b = pinch_island_body(p, island, k);
        if (b->drive < 0) dBodyEnable(b->body);
    }
    island->left_out = false;
}

bool pinch_stayed(const pinch_ode *p, const pinch_island *island)
{
    for (int k = 0; k < island->body_count; k++)
        if (!pinch_body_stands(pinch_island_body(p, island, k)->body)) return false;
    return true;
}
