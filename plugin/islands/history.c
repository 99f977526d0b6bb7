/* What bodies and contacts carry from one step into the next, after ODE has moved the bodies. */
#include "islands/island_life.h"

#include "support/loop.h"
#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* A body that ODE put to sleep at the start of its step has kept its contact forces for when it wakes. They must not
 * act twice. */
static void quiet_sleeper(const pinch_drives *drives, const pinch_step_body *b)
{
    if (b->drive < 0 && !dBodyIsEnabled(b->body)) pinch_take_back_contact_forces(drives, b);
}

/* Returns what the body's limit of the angular speed has taken from the spin solved for, rad/s. */
static double taken_by_limit(dBodyID body, const double *solved)
{
    double most = dBodyGetMaxAngularSpeed(body), speed2 = pinch_v3_dot(solved, solved);
    return speed2 > most * most ? sqrt(speed2) - most : 0;
}

/*
 * Computes what ODE arrived at less what was solved for. With damping, ODE scales a velocity after it has moved the
 * body with it: what goes beyond the damping is known, but not which way the body went. A limit of the angular speed is
 * none of a contact's: what it takes in a step the contact slips, without a force. A spring that took it up would be
 * stretched far beyond what friction holds, and pull the body below its limit.
 */
static void measure_mismatch(pinch_step_body *b, double largest[2])
{
    double *difference = b->velocity, damping[2] = {dBodyGetLinearDamping(b->body), dBodyGetAngularDamping(b->body)};
    if (b->drive >= 0 || !dBodyIsEnabled(b->body)) {
        memset(difference, 0, sizeof b->velocity);
        return;
    }
    const double *now[2] = {dBodyGetLinearVel(b->body), dBodyGetAngularVel(b->body)};
    const double limited[2] = {0, taken_by_limit(b->body, difference + 3)};
    for (int part = 0; part < 2; part++) {
        double taken = limited[part] + damping[part] * pinch_v3_norm(difference + 3 * part);
        pinch_v3_sub(now[part], difference + 3 * part, difference + 3 * part);
        double excess = pinch_v3_norm(difference + 3 * part) - taken;
        if (!(largest[part] > excess)) largest[part] = excess;
    }
    if (limited[1] > 0) memset(difference + 3, 0, 3 * sizeof *difference);
    if (damping[0] != 0 || damping[1] != 0) memset(difference, 0, sizeof b->velocity);
}

/* Adds sign * (v + w x arm) and sign * w of one body's mismatch. */
static void add_mismatch(const pinch_step_bodies *bodies, int step_body, const double *point, double sign,
                         double *linear, double *angular)
{
    if (step_body < 0) return;
    const pinch_step_body *b = &bodies->items[step_body];
    double arm[3], turned[3];
    pinch_v3_sub(point, b->position, arm);
    pinch_v3_cross(b->velocity + 3, arm, turned);
    pinch_v3_add_scaled(linear, sign, b->velocity);
    pinch_v3_add_scaled(linear, sign, turned);
    pinch_v3_add_scaled(angular, sign, b->velocity + 3);
}

/* How far the two bodies of a pair moved (m) and turned (rad) in the step: their velocities times h. */
typedef struct pair_motion {
    bool turns[2]; /* false: it has no spin */
    double start[2][3], turn[2][3];
    double mean[3], differs[3]; /* of the turns */
    double slide[3];            /* of the bodies' centres against each other */
    double second[3];           /* what add_motion adds wherever a point is */
} pair_motion;

/*
 * Finds the apparent shear of bodies that turn together.
 *
 * Two bodies that turn together, as a hand does with what it holds, do not move against each other. The step sees their
 * centres go along chords of that turn and the contact go along tangents, and would shear it by the difference of
 * arc = (exp(h W) - 1) d and tangent = h W x d, with the common spin W and the distance d of the centres, in every
 * step. Bodies that roll on each other have no common spin: one stands still or turns the other way. Returns false for
 * these.
 */
static inline bool find_common_turn(const pair_motion *m, double *arc, double *tangent)
{
    double angle2 = pinch_v3_dot(m->mean, m->mean), common = angle2 - pinch_v3_dot(m->differs, m->differs);
    if (!(common > 0)) return false;
    pinch_v3_set(arc, 0, 0, 0);
    pinch_v3_set(tangent, 0, 0, 0);
    double angle = sqrt(angle2), half = sin(0.5 * angle), part = common / angle2, apart[3], once[3], twice[3];
    pinch_v3_sub(m->start[0], m->start[1], apart);
    pinch_v3_cross(m->mean, apart, once);
    pinch_v3_cross(m->mean, once, twice);
    pinch_v3_add_scaled(tangent, part, once);
    pinch_v3_add_scaled(arc, part * (angle > 0 ? sin(angle) / angle : 1), once);
    pinch_v3_add_scaled(arc, part * 2 * half * half / angle2, twice);
    return true;
}

/* Finds how one body moved. Returns whether it turned. */
static inline bool find_way(dBodyID body, double h, double *way, double *turn, double *start)
{
    static const double NONE[3] = {0, 0, 0};
    const double *v = body ? dBodyGetLinearVel(body) : NONE, *w = body ? dBodyGetAngularVel(body) : NONE;
    for (int i = 0; i < 3; i++) {
        way[i] = h * v[i];
        turn[i] = h * w[i];
    }
    pinch_v3_sub(body ? dBodyGetPosition(body) : NONE, way, start);
    return turn[0] != 0 || turn[1] != 0 || turn[2] != 0;
}

static inline void find_motion(const pinch_pair *pair, double h, pair_motion *m)
{
    double way[2][3], ways[3], apart[3], bend[3], drift[3], arc[3], tangent[3];
    m->turns[0] = find_way(pair->body[0], h, way[0], m->turn[0], m->start[0]);
    m->turns[1] = find_way(pair->body[1], h, way[1], m->turn[1], m->start[1]);
    for (int i = 0; i < 3; i++) {
        m->mean[i] = 0.5 * (m->turn[0][i] + m->turn[1][i]);
        m->differs[i] = m->turn[0][i] - m->turn[1][i];
        ways[i] = way[0][i] + way[1][i];
        m->slide[i] = apart[i] = way[0][i] - way[1][i];
        m->second[i] = 0;
    }
    if (m->turns[0] && m->turns[1] && find_common_turn(m, arc, tangent)) {
        pinch_v3_sub(apart, arc, apart);
        pinch_v3_sub(tangent, arc, m->second);
        pinch_v3_add_scaled(m->slide, 1, m->second);
    }
    pinch_v3_cross(m->differs, ways, bend);
    pinch_v3_cross(m->mean, apart, drift);
    pinch_v3_add_scaled(m->second, -0.25, bend);
    pinch_v3_add_scaled(m->second, -0.5, drift);
}

/*
 * Adds what the shear of the step lacks of what the bodies did: less the common turn, and of the second order what the
 * mean of both ends of the step, (w + w') / 2, has of the bodies' motion. The contact's own is added when it is found
 * anew, see add_rolling in contacts/manifold_point.c.
 *
 * With the mean turn W, the difference D of the turns, the bodies' ways s1 and s2, u = s1 - s2 less the arc of the
 * common turn, and the shear w that the contact had, all of them times h, a place that stays where it is has
 *
 *     w' - w = -D x (s1 + s2) / 2 - W x u.
 *
 * The whole shear of the step is turned about the normal n by W afterwards. The end's half has turned already, so that
 * it loses W . n n x w.
 */
static void add_motion(const pair_motion *m, const double *point, const double *normal, double *shear)
{
    double w[3], part[3];
    pinch_v3_copy(w, m->slide);
    pinch_v3_add_scaled(shear, 1, m->second);
    for (int side = 0; side < 2; side++) {
        double arm[3];
        if (!m->turns[side]) continue;
        pinch_v3_sub(point, m->start[side], arm);
        pinch_v3_cross(m->turn[side], arm, part);
        pinch_v3_add_scaled(w, side ? -1 : 1, part);
    }
    pinch_v3_cross(normal, w, part);
    pinch_v3_add_scaled(shear, -0.5 * pinch_v3_dot(m->mean, normal), part);
}

/* The slip of a step, summed up over what presses, each point by its force. */
typedef struct pair_slip {
    double pressed, slip[3], twist;
} pair_slip;

static void add_slip(const pinch_ode_contact *out, pair_slip *sum)
{
    sum->pressed += out->normal_force;
    sum->twist += out->normal_force * out->slip_twist;
    pinch_v3_add_scaled(sum->slip, out->normal_force, out->slip);
}

/* Adds the step's mean slip to the pair's path. What does not press starts anew. */
static void lengthen_path(const pair_slip *sum, pinch_pair *pair)
{
    const double *slip = sum->slip;
    if (!(sum->pressed > 0)) {
        pair->slip_total = pair->twist_total = 0;
    } else if (sum->twist != 0 || slip[0] != 0 || slip[1] != 0 || slip[2] != 0) {
        pair->slip_total += pinch_v3_norm(slip) / sum->pressed;
        pair->twist_total += fabs(sum->twist) / sum->pressed;
    }
}

/* Writes the solved end state into a point of the manifold. */
static void keep_solution(const pinch_ode_contact *out, pinch_manifold_point *point)
{
    pinch_v3_copy(point->elastic, out->elastic);
    pinch_v3_copy(point->friction, out->tangential);
    point->twist = out->twist;
    point->normal_force = out->normal_force;
    point->torsion = out->torsion;
    point->slipping = out->state == PINCH_CONTACT_SLIP;
}

/* Turns an elastic displacement about the unit normal. */
static void turn_about(double *elastic, const double *normal, double angle)
{
    double turned[3], small = 1e-8; /* below it cosine and sine are 1 and the angle, to rounding */
    pinch_v3_cross(normal, elastic, turned);
    if (fabs(angle) >= small) pinch_v3_scale(elastic, cos(angle));
    pinch_v3_add_scaled(elastic, fabs(angle) >= small ? sin(angle) : angle, turned);
}

/*
 * The elastic state goes on from what the bodies really did: the solved end state, plus the motion of the mismatch,
 * turned with the pair's mean spin about the normal.
 */
static void carry_point(const pinch_step_bodies *bodies, const pinch_pair *pair, const pair_motion *motion, double h,
                        const double *position, pinch_manifold_point *point)
{
    double linear[3] = {0, 0, 0}, angular[3] = {0, 0, 0};
    for (int side = 0; side < 2; side++)
        add_mismatch(bodies, pair->step_body[side], position, side ? -1 : 1, linear, angular);
    pinch_v3_scale(linear, h);
    add_motion(motion, position, point->normal, linear);
    pinch_v3_make_perpendicular(linear, point->normal);
    pinch_v3_add_scaled(point->elastic, 1, linear);
    point->twist += h * pinch_v3_dot(angular, point->normal);
    double turned = pinch_v3_dot(motion->mean, point->normal);
    turn_about(point->elastic, point->normal, turned);
    if (point->locks) turn_about(point->own->locked, point->normal, turned);
}

static void carry_pair(const pinch_contact_store *contacts, const pinch_step_bodies *bodies, pinch_pair *pair, double h)
{
    pair_motion motion;
    pair_slip slip = {0, {0, 0, 0}, 0};
    find_motion(pair, h, &motion);
    if (!pair->has_material) pair->posed.apart = pinch_pair_apart(pair);
    pinch_v3_copy(pair->turned, motion.differs);
    for (int k = 0; k < pair->manifold.count; k++) {
        pinch_manifold_point *point = &pair->manifold.point[k];
        const pinch_ode_contact *out = &contacts->results.items[pair->first_result + k];
        keep_solution(out, point);
        if (!(out->normal_force > 0)) continue;
        add_slip(out, &slip);
        if (out->friction_limit > 0 || out->torsion != 0) carry_point(bodies, pair, &motion, h, out->position, point);
    }
    lengthen_path(&slip, pair);
}

void pinch_stop_drives(const pinch_step_bodies *bodies, const pinch_island *island)
{
    for (int k = 0; k < island->bodies.count && bodies->drives.count > 0 && pinch_island_is_solved(island); k++) {
        const pinch_step_body *b = pinch_island_body(bodies, island->bodies, k);
        if (b->drive >= 0) pinch_drive_stop(&bodies->drives.items[b->drive]);
    }
}

typedef struct carry_task {
    const pinch_contact_store *contacts;
    const pinch_step_bodies *bodies;
    const pinch_island *island;
    double h;
} carry_task;

static void carry_pairs(void *argument, int first, int end)
{
    const carry_task *task = argument;
    const pinch_contact_store *contacts = task->contacts;
    const pinch_step_bodies *bodies = task->bodies;
    const pinch_range pairs = task->island->pairs;
    const double h = task->h;
    for (int k = first; k < end; k++) {
        pinch_prefetch_island_pairs(contacts, pairs, k, PINCH_READS_RESULTS);
        carry_pair(contacts, bodies, pinch_island_pair(contacts, pairs, k), h);
    }
}

void pinch_carry_history(const pinch_step_context *context, pinch_contact_store *contacts,
                         const pinch_step_bodies *bodies, pinch_island *island, const pinch_crew *crew)
{
    bool stays =
        island->phase == PINCH_ISLAND_REUSED && (island->skipped_by_ode || pinch_island_stands(bodies, island));
    pinch_reenable_bodies(bodies, island);
    if (stays) return;
    for (int k = 0; k < island->bodies.count && pinch_island_is_solved(island); k++) {
        pinch_step_body *b = pinch_island_body(bodies, island->bodies, k);
        quiet_sleeper(&bodies->drives, b);
        measure_mismatch(b, island->mismatch);
    }
    carry_task task = {contacts, bodies, island, context->h};
    if (island->phase != PINCH_ISLAND_ASLEEP) pinch_each(crew, island->pairs.count, carry_pairs, &task);
}
