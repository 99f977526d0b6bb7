/*
 * The energy that hard contacts put in as they push bodies out of each other.
 *
 * A hard contact takes an overlap back as joints take errors of position back: it asks for a velocity apart. By itself
 * that costs next to nothing. But where joints all but lock what overlaps, or where overlaps contradict each other, a
 * small motion apart is a large one of everything else, and bodies that are deep in each other are thrown about. How
 * deep they are depends on how soft they were before: a floor of compliance that falls leaves them deep in stiff
 * contacts.
 *
 * So it is bounded what contacts may put in. Where they would put more in, bodies come apart more slowly.
 *
 *  - Contacts put in what the kinetic energy gains but for the work of weight, of motors and springs of joints, and
 *    of surfaces that move. Weight and surfaces work along the mean of the velocities before and after the step, v
 *    and v+, as the kinetic energy changes by just what all forces do along it. So a finger that its owner stops
 *    still lifts what it carries in that step, at half of its last velocity. With v+ instead, an elastic rebound
 *    would seem to gain h m g v+, and a box that a belt takes uphill more than the belt gives. One by one they cannot
 *    be judged: in a jam, some give what others take. Where joints put in what contacts do not, that is for the
 *    account of joints to judge (energy_account.c).
 *  - What the motors of a mechanism take that drive with all their force and are pushed back, where an overlap pushes
 *    any of its bodies, does not count, about as fast as overlaps push them, and partners that drive bodies on: fingers
 *    that squeeze a light body have to come out of it against their motors, and out of what that body is pressed into.
 *    Of other motors and brakes it counts, as contacts might pump against them. What goes into springs of joints does
 *    not count in the same way: a spring gives no more back than once, and bodies that it drives into each other again
 *    lose that in contacts.
 *  - They keep a balance, as joints do: they may put in what bodies have lost in contacts not long before (time-domain
 *    passivity), about twice the energy that overlaps ask for by themselves, once, and a part of a step's fall, with
 *    which all overlaps go in the end. Joints may hang all bodies of an island on one that is pushed. With more in each
 *    step, a chain of bodies that was held in a wall and dragged along was spun up for as long as it was in there.
 *  - What surfaces lose by friction has never been the bodies'. So no more than the kinetic energy lost comes to the
 *    balance, and surfaces give no more than brings all bodies of the island to their speed in a step and lifts them at
 *    it. In a jam they would give any work otherwise, and other contacts take it.
 *  - Contacts that push no more at all and still put too much in do so by friction: a jam has wound its springs up, or
 *    presses bodies onto a surface that moves with a force that has nothing to do with them. They let go: friction
 *    starts from rest then, on a surface at rest, and can only take.
 *  - What comes up out of an overlap has to be lifted, with all that lies on it, and that takes as much at any pace. So
 *    contacts may put in besides, along the way by which the bodies of a pair really come apart, the work of the
 *    pair's own weight, or of the force that they carry where they carry it without being thrown. What they come in
 *    again counts back, so that all of it is bounded by the depths that were there. Where bodies rise by the speed that
 *    contacts gave them before, it makes up for what these put in then. Sweeps, which are no answer, lift nothing.
 *
 * A bounce gives back a part of what it takes. But where a body is jammed, or normals contradict each other, what
 * bounces off one contact is driven into the next, and a bounce gives many times what has come in. So bounces have no
 * allowance of their own: they count among what contacts put in, and are slowed with the rest.
 *
 * Contacts that are soft by their own parameters are springs, and may give what they hold. Fingertips of a material are
 * none of these contacts.
 *
 * Contacts whose partner drives them on are not judged: a bat gives a ball what it likes. But nothing is as strong as a
 * body that is moved whatever it meets. Where it presses others against a wall, they may have no way out but at many
 * times its speed, or none at all, and are shot out. So where hard contacts have let go, and bodies would still get
 * more energy than if a long lever moved them all, or with joints a gear, these partners are held back to that: they go
 * into the bodies instead.
 *
 * Islands part and merge, bodies stay. So the balance is kept by body, in equal parts. It may be negative, down to what
 * overlaps have asked for.
 */
#include "islands/island_life.h"

#include "joints/island_joints.h"

#include "support/extremes.h"
#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* Of a step's fall, which is allowed in any case, as for joints; of the balance, what is left of it after a step:
 * overlaps are gone after some tens of steps. */
static const double OF_FALL = 0.2, LEFT = 0.98;
/* Of the energy that overlaps ask for. A body lifts what lies on it. */
static const double TIMES_ASKED_FOR = 2;
/* Softer ones than this part of what the bodies' inertia gives a contact in a step are springs, as in surface.c. */
static const double STIFF = 0.01;

/* Where joints press contacts into each other they do so for long, and each try costs. There the next step begins at
 * the pace of the last, faster by this factor where it put in less than this part of what it might, and at this pace at
 * least. */
static const double FASTER = 2, EASY = 0.25, LEAST = 0.1;

/* Goes through an island's contacts in the order in which its problem has them. */
typedef struct walk {
    const pinch_contact_store *contacts;
    const pinch_island *island;
    int pair, point;      /* of the next contact */
    const pinch_pair *at; /* that pair, from its second point on */
} walk;

/* Returns the next contact's own law; NULL for one of a fingertip, which has none of its own. */
static inline pinch_own_law *next_own(walk *w)
{
    if (w->point == 0) {
        w->at = pinch_island_pair(w->contacts, w->island->pairs, w->pair);
        pinch_prefetch_island_pairs(w->contacts, w->island->pairs, w->pair, PINCH_READS_OWN_LAWS);
    }
    pinch_own_law *own = w->at->has_material ? NULL : w->at->manifold.point[w->point].own;
    if (++w->point == w->at->manifold.count) {
        w->point = 0;
        w->pair++;
    }
    return own;
}

static const pinch_own_law *next_law(walk *w)
{
    static const pinch_own_law OF_A_FINGERTIP = {.surface = -1};
    const pinch_own_law *own = next_own(w);
    return own ? own : &OF_A_FINGERTIP;
}

/* Returns how fast (m/s) the surface moves by itself along the normal, into body 1. */
static double speed_into(const pinch_contact *c, const pinch_own_law *own)
{
    return pinch_larger(-(c->surface_velocity[0] + own->rebound), own->pose_speed);
}

/* Tells whether a partner drives the contact on. One of a fingertip is none of these. */
static bool is_pushed_by_partner(const pinch_contact *c, const pinch_own_law *own)
{
    return c->may_soften && speed_into(c, own) > 0;
}

/* Tells whether a contact is judged: it is none of a fingertip, and no partner drives it on. */
static bool is_hard(const pinch_contact *c, const pinch_own_law *own)
{
    return c->may_soften && !is_pushed_by_partner(c, own);
}

/* Returns the velocity (m/s) at which the overlap of a contact is to be taken back. */
static double closing_of(const pinch_contact *c, double h)
{
    return c->depth > 0 ? c->stiffness[0] * c->depth / (h * c->stiffness[0] + c->damping[0]) : 0;
}

/* Returns the velocity (m/s) that a contact asks for because its bodies overlap. */
static double push_of(const pinch_contact *c, const pinch_own_law *own, double h)
{
    if (!is_hard(c, own) || !(c->depth > 0)) return 0;
    return pinch_larger(closing_of(c, h) - (c->surface_velocity[0] + own->rebound), 0);
}

static double inverse_masses(const pinch_problem *problem, const pinch_contact *c)
{
    double sum = 0;
    if (c->body1 >= 0) sum += 1 / problem->bodies[c->body1].mass;
    if (c->body2 >= 0) sum += 1 / problem->bodies[c->body2].mass;
    return sum;
}

static double mass_of(const pinch_problem *problem)
{
    double mass = 0;
    for (int b = 0; b < problem->body_count; b++) mass += problem->bodies[b].mass;
    return mass;
}

/* Returns the energy (J) that a contact's own spring gives back at most, with all bodies on it: its damper takes most
 * of what k d^2/2 holds where c^2 > k m. One that bounces comes out at the speed of its bounce instead. */
static double energy_of_spring(const pinch_contact *c, const pinch_own_law *own, double h, double mobility, double mass)
{
    double k = c->stiffness[0], damping = c->damping[0];
    if (own->rebound > 0 || !(k > 0) || STIFF * h * mobility * (h * k + damping) > 1) return 0;
    return 0.5 * k * c->depth * c->depth / (1 + damping * damping / (k * mass));
}

/* Returns the energy (J) that the overlaps ask for: of each pair's bodies, where they move apart as its contacts ask in
 * the mean, and of springs. */
static double energy_asked_for(const pinch_contact_store *contacts, const pinch_island *island,
                               const pinch_problem *problem)
{
    double h = problem->step, mass = mass_of(problem), sum = 0;
    walk at = {contacts, island, 0, 0, NULL};
    for (int first = 0, k; first < problem->contact_count; first = k) {
        const pinch_contact *pair = &problem->contacts[first];
        double of_pair = 0, mobility = inverse_masses(problem, pair);
        for (k = first; k < problem->contact_count; k++) {
            const pinch_contact *c = &problem->contacts[k];
            if (c->body1 != pair->body1 || c->body2 != pair->body2) break;
            const pinch_own_law *own = next_law(&at);
            double push = push_of(c, own, h);
            of_pair += 0.5 * push * push / mobility;
            if (push > 0) sum += energy_of_spring(c, own, h, mobility, mass);
        }
        sum += of_pair / (k - first);
    }
    return sum;
}

/* Returns the energy (J) that a step's fall gives to the island's bodies, the part of it that counts. */
static double part_of_fall(const pinch_step_context *context, const pinch_problem *problem)
{
    double fall = pinch_fall_in_step(context);
    return OF_FALL * 0.5 * mass_of(problem) * fall * fall;
}

/* Does a surface move by itself along the contact, or about its normal? */
static bool moves_along(const pinch_contact *c)
{
    return c->surface_velocity[1] != 0 || c->surface_velocity[2] != 0 || c->surface_velocity[3] != 0;
}

/* Returns the most energy (J) that surfaces may give in a step: they bring all bodies to the speed of the fastest, and
 * lift them at it. */
static double most_of_surfaces(const pinch_step_context *context, const pinch_contact_store *contacts,
                               const pinch_island *island, const pinch_problem *problem)
{
    double fastest = 0;
    walk at = {contacts, island, 0, 0, NULL};
    for (int k = 0; k < problem->contact_count; k++) {
        const pinch_contact *c = &problem->contacts[k];
        const pinch_own_law *own = next_law(&at);
        double into = speed_into(c, own), along = 0;
        if (moves_along(c)) along = hypot(c->surface_velocity[1], c->surface_velocity[2]);
        along = pinch_larger(along, own->carried_at);
        if (into > 0) along = hypot(along, into);
        fastest = pinch_larger(along, fastest);
    }
    return fastest > 0 ? mass_of(problem) * fastest * (0.5 * fastest + pinch_fall_in_step(context)) : 0;
}

/* Returns the energy (J) that the fastest push asks for beside joints, which may hang all bodies on one. */
static double energy_of_all(const pinch_contact_store *contacts, const pinch_island *island,
                            const pinch_problem *problem)
{
    double fastest = 0;
    walk at = {contacts, island, 0, 0, NULL};
    for (int k = 0; k < problem->contact_count; k++)
        fastest = fmax(fastest, push_of(&problem->contacts[k], next_law(&at), problem->step));
    return 0.5 * mass_of(problem) * fastest * fastest;
}

/* What contacts ask for and what surfaces may give: two sums over all contacts, which two threads may do at a time. */
typedef struct push_sums {
    const pinch_step_context *context;
    const pinch_contact_store *contacts;
    const pinch_island *island;
    const pinch_problem *problem;
    double asked, of_surfaces; /* J */
} push_sums;

static void sum_up(void *argument, int first, int end)
{
    push_sums *s = argument;
    for (int k = first; k < end; k++) {
        if (k == 0)
            s->asked = energy_asked_for(s->contacts, s->island, s->problem);
        else
            s->of_surfaces = most_of_surfaces(s->context, s->contacts, s->island, s->problem);
    }
}

bool pinch_open_push(const pinch_step_context *context, const pinch_contact_store *contacts,
                     const pinch_island_graph *graph, const pinch_problem *problem, pinch_island *island)
{
    island->pushes = false;
    for (int k = 0; k < problem->contact_count && !island->pushes; k++)
        island->pushes = problem->contacts[k].may_soften;
    if (!island->pushes) return false;
    push_sums sums = {context, contacts, island, problem, 0, 0};
    if (problem->crew)
        problem->crew->parallel_for(problem->crew->context, 2, 1, sum_up, &sums);
    else
        sum_up(&sums, 0, 2);
    double asked = sums.asked;
    if (island->joints.joint_rows > 0) asked = fmax(asked, energy_of_all(contacts, island, problem));
    pinch_read_push(context, graph, island);
    double fall = part_of_fall(context, problem);
    island->push_limit = fall + fmax(TIMES_ASKED_FOR * asked + island->push_balance, 0);
    island->surface_limit = sums.of_surfaces;
    return true;
}

/* An answer, and the bodies that have not moved yet. */
typedef struct answer {
    const pinch_step_bodies *bodies;
    pinch_range range;
    const pinch_problem *problem;
} answer;

/* Finds the velocity (m/s) of body 1 relative to body 2 at a contact, before the step. (That of the problem's bodies
 * has weight in it.) */
static void find_velocity_before(const answer *a, const pinch_contact *c, double *velocity)
{
    memset(velocity, 0, 3 * sizeof *velocity);
    for (int side = 0; side < 2; side++) {
        int number = side ? c->body2 : c->body1;
        double arm[3], turned[3];
        if (number < 0) continue;
        dBodyID body = pinch_island_body(a->bodies, a->range, number)->body;
        pinch_v3_sub(c->position, a->problem->bodies[number].position, arm);
        pinch_v3_cross(dBodyGetAngularVel(body), arm, turned);
        pinch_v3_add_scaled(velocity, side ? -1 : 1, dBodyGetLinearVel(body));
        pinch_v3_add_scaled(velocity, side ? -1 : 1, turned);
    }
}

/* Returns the mean normal velocity (m/s) of a contact in the step: times h and its force, the energy that it gives. */
static double mean_velocity(const answer *a, const pinch_contact *c)
{
    double before[3];
    find_velocity_before(a, c, before);
    return 0.5 * (c->relative_velocity[0] - c->surface_velocity[0] + pinch_v3_dot(before, c->normal));
}

/* Returns the power (W) of friction in the same sense, but for what a surface that moves by itself does. */
static double mean_power_of_friction(const answer *a, const pinch_contact *c)
{
    double before[3], t2[3];
    find_velocity_before(a, c, before);
    pinch_v3_cross(c->normal, c->tangent1, t2);
    double along1 = c->relative_velocity[1] + c->surface_velocity[1] + pinch_v3_dot(before, c->tangent1);
    double along2 = c->relative_velocity[2] + c->surface_velocity[2] + pinch_v3_dot(before, t2);
    return 0.5 * (c->force[1] * along1 + c->force[2] * along2);
}

/* Returns the work (J) that surfaces do on bodies as they move by themselves. In a jam some give what others take, so
 * that their sum counts; where it is negative, they have only taken. */
static double work_of_surfaces(const pinch_contact_store *contacts, const pinch_step_bodies *bodies,
                               const pinch_problem *problem, const pinch_island *island)
{
    answer found = {bodies, island->bodies, problem};
    double power = 0;
    walk at = {contacts, island, 0, 0, NULL};
    for (int k = 0; k < problem->contact_count && island->surface_limit > 0; k++) {
        const pinch_contact *c = &problem->contacts[k];
        const pinch_own_law *own = next_law(&at);
        double into = speed_into(c, own);
        if (moves_along(c) || own->carried_at > 0) power += mean_power_of_friction(&found, c);
        for (int i = 1; i < 4; i++) power -= c->force[i] * c->surface_velocity[i];
        if (into > 0) power += c->force[0] * mean_velocity(&found, c);
    }
    return fmin(fmax(problem->step * power, 0), island->surface_limit);
}

/* Returns the force (N) that presses the pair of a contact together from outside. */
static double pressed_by(const pinch_problem *problem, const pinch_contact *c)
{
    double sum = 0;
    if (c->body1 >= 0) sum += fmax(-pinch_v3_dot(problem->bodies[c->body1].external, c->normal), 0);
    if (c->body2 >= 0) sum += fmax(pinch_v3_dot(problem->bodies[c->body2].external, c->normal), 0);
    return sum;
}

/* Tells whether a body of a contact's pair is thrown. */
static bool is_thrown(const answer *a, const pinch_contact *c, double fall)
{
    for (int side = 0; side < 2; side++) {
        int number = side ? c->body2 : c->body1;
        if (number < 0) continue;
        dBodyID body = pinch_island_body(a->bodies, a->range, number)->body;
        if (pinch_body_is_thrown(body, &a->problem->bodies[number], fall)) return true;
    }
    return false;
}

/* Finds how far (m) a pair, whose contacts begin at *next, comes out of its overlaps, in their mean, and the force (N)
 * that these bear. Returns how many overlaps there are. *next: where the next pair begins. */
static int way_out(const answer *a, walk *at, int *next, double *way, double *force)
{
    const pinch_contact *pair = &a->problem->contacts[*next];
    double step = a->problem->step;
    int overlaps = 0;
    *way = *force = 0;
    for (; *next < a->problem->contact_count; ++*next) {
        const pinch_contact *c = &a->problem->contacts[*next];
        if (c->body1 != pair->body1 || c->body2 != pair->body2) break;
        double push = push_of(c, next_law(at), step);
        if (!(push > 0)) continue;
        *way += step * pinch_smaller(mean_velocity(a, c), push);
        *force += c->force[0];
        overlaps++;
    }
    if (overlaps > 0) *way /= overlaps;
    return overlaps;
}

/* Returns the work (J) of lifting where hard pairs come out of their overlaps: of each with what lies on it; where
 * joints may hang all bodies on them, of all bodies by the mean of their ways. */
static double work_of_lifting(const pinch_step_context *context, const pinch_contact_store *contacts,
                              const pinch_step_bodies *bodies, const pinch_problem *problem, const pinch_island *island)
{
    answer found = {bodies, island->bodies, problem};
    double of_pairs = 0, ways = 0, all = pinch_weight_of_all(problem), fall = pinch_fall_in_step(context);
    int pairs = 0;
    walk at = {contacts, island, 0, 0, NULL};
    for (int next = 0; next < problem->contact_count;) {
        const pinch_contact *pair = &problem->contacts[next];
        double way, force, weight = pressed_by(problem, pair);
        if (way_out(&found, &at, &next, &way, &force) == 0) continue;
        if (force > weight && !is_thrown(&found, pair, fall)) weight = fmin(force, all);
        of_pairs += way * weight;
        ways += way;
        pairs++;
    }
    bool hang_on_it = island->joints.joint_rows > 0 && pairs > 0;
    return hang_on_it ? fmax(of_pairs, ways / pairs * all) : of_pairs;
}

/* Tells whether a body of the contact is one of the mechanism. */
static bool touches_mechanism(const pinch_step_bodies *bodies, pinch_range range, const pinch_contact *c, int mechanism)
{
    return (c->body1 >= 0 && pinch_mechanism_of(bodies, range, c->body1) == mechanism) ||
           (c->body2 >= 0 && pinch_mechanism_of(bodies, range, c->body2) == mechanism);
}

/* Returns the lever (m) by which a contact turns a row of a body at least: a part of its distance, as links further on
 * may turn against the row, and of the body's size. */
static double lever_of(const pinch_body *body, const pinch_contact *c)
{
    static const double PART = 1.0 / 3;
    double arm[3];
    pinch_v3_sub(c->position, body->position, arm);
    return PART * fmax(pinch_v3_norm(arm), body->radius);
}

/* Returns how fast (m/s) the next contact pushes its bodies apart as it presses them, by an overlap or by a partner
 * that drives them on; 0 where it does not. An overlap that is handed over again as it was, while its bodies move, is
 * not known any more: programs keep contacts for some steps, and would be pushed out too far. */
static double press_of(const pinch_contact_store *contacts, const pinch_problem *problem, const pinch_island *island,
                       walk *at, const pinch_contact *c)
{
    bool known = !pinch_island_pair(contacts, island->pairs, at->pair)->unchanged;
    const pinch_own_law *own = next_law(at);
    if (!(c->force[0] > 0)) return 0;
    if (is_pushed_by_partner(c, own)) return speed_into(c, own);
    return known ? push_of(c, own, problem->step) : 0;
}

/*
 * Returns the speed (m/s or rad/s) along a row at which all overlaps come apart at once. What lies between a mechanism
 * and something that does not give way pushes it by the sum of their speeds: of each pair by the mean, as far as it
 * bears the force of the row. per_push: how far the row goes for each metre that bodies of the mechanism are pushed.
 */
static double pushed_by_all(const pinch_contact_store *contacts, const pinch_problem *problem,
                            const pinch_island *island, const pinch_joint_row *row, double per_push)
{
    double power = 0, most = fabs(row->force) * per_push;
    walk at = {contacts, island, 0, 0, NULL};
    for (int k = 0; k < problem->contact_count;) {
        const pinch_contact *pair = &problem->contacts[k];
        double force = 0, of_pair = 0;
        for (; k < problem->contact_count; k++) {
            const pinch_contact *c = &problem->contacts[k];
            if (c->body1 != pair->body1 || c->body2 != pair->body2) break;
            double push = press_of(contacts, problem, island, &at, c);
            if (!(push > 0)) continue;
            force += c->force[0];
            of_pair += c->force[0] * push;
        }
        power += force > most ? of_pair * (most / force) : of_pair;
    }
    return power / fabs(row->force);
}

/* Returns the speed (m/s or rad/s) at which overlaps push a mechanism along a row of it, at most: they ask for it where
 * they press its bodies, and a row that turns goes round at that speed over the lever. */
static double pushed_along(const pinch_contact_store *contacts, const pinch_step_bodies *bodies,
                           const pinch_problem *problem, const pinch_island *island, const pinch_joint_row *row)
{
    int number = row->body1 >= 0 ? row->body1 : row->body2;
    if (number < 0) return 0;
    int mechanism = pinch_mechanism_of(bodies, island->bodies, number);
    double fastest = 0, per_push = INFINITY, moves = pinch_v3_norm(row->body1 >= 0 ? row->j1 : row->j2);
    walk at = {contacts, island, 0, 0, NULL};
    for (int k = 0; k < problem->contact_count; k++) {
        const pinch_contact *c = &problem->contacts[k];
        double push = press_of(contacts, problem, island, &at, c);
        if (!(push > 0) || !touches_mechanism(bodies, island->bodies, c, mechanism)) continue;
        double goes = moves > 0 ? moves : 1 / lever_of(&problem->bodies[number], c);
        fastest = fmax(fastest, goes * push);
        per_push = fmin(per_push, goes);
    }
    return fastest > 0 ? fmax(fastest, pushed_by_all(contacts, problem, island, row, per_push)) : 0;
}

/* Returns the work (J, <= 0) of motors and springs that press bodies into overlaps and are pushed back: those of the
 * fingers that are pushed, however far from the contact, as fast as they are pushed. What else drives them back, as a
 * flywheel does, counts. put_in: what is to be made up for (J). */
static double taken_by_drives(const pinch_contact_store *contacts, const pinch_joint_store *joints,
                              const pinch_step_bodies *bodies, const pinch_problem *problem, const pinch_island *island,
                              double put_in)
{
    double work = 0;
    bool found = false;
    for (int k = 0; k < problem->row_count && work > -put_in; k++) {
        const pinch_joint_row *row = &problem->rows[k];
        double taken = pinch_work_taken_by_drive(problem, row);
        if (!(taken < 0)) continue;
        if (!found) pinch_find_mechanisms(joints, bodies, island->bodies, &island->joints);
        found = true;
        double most = problem->step * fabs(row->force) * pushed_along(contacts, bodies, problem, island, row);
        work += fmax(taken, -most);
    }
    return work;
}

void pinch_judge_push(const pinch_step_context *context, const pinch_contact_store *contacts,
                      const pinch_joint_store *joints, const pinch_step_bodies *bodies, const pinch_problem *problem,
                      pinch_island *island)
{
    double lag, gain = pinch_kinetic_gain(bodies, island->bodies, problem, &lag) + lag, put_in = gain;
    double by_contacts = INFINITY;
    double of_surfaces = work_of_surfaces(contacts, bodies, problem, island);
    if (island->joints.joint_rows > 0) {
        by_contacts = pinch_contact_work(problem);
        put_in = island->joints.work + by_contacts + lag; /* without what motors and springs of joints do */
        if (put_in > 0) put_in = fmax(put_in + taken_by_drives(contacts, joints, bodies, problem, island, put_in), 0);
    }
    double lifting = !island->result.swept ? work_of_lifting(context, contacts, bodies, problem, island) : 0;
    put_in -= of_surfaces;
    island->push_spare = fmax(lifting - fmax(put_in, 0), 0);
    put_in -= lifting;
    by_contacts -= of_surfaces + lifting;
    island->push_work = put_in <= by_contacts ? put_in : by_contacts;
    island->push_change = put_in <= 0 ? fmax(put_in, fmin(gain, 0)) : put_in;
}

void pinch_close_push(const pinch_step_context *context, const pinch_problem *problem, double pace,
                      pinch_island *island)
{
    double fall = part_of_fall(context, problem), balance = island->push_balance - island->push_change;
    if (balance < 0) balance = fmin(balance + island->push_spare, 0);
    island->push_balance = balance > 0 ? LEFT * balance : fmin(balance + fall, 0);
    if (fabs(island->push_balance) < fall) island->push_balance = 0;
    bool easy = island->push_work <= EASY * island->push_limit, jointed = island->joints.joint_rows > 0;
    island->push_pace = jointed ? fmin(fmax(easy ? FASTER * pace : pace, LEAST), 1) : pace;
}

void pinch_find_pushes(const pinch_contact_store *contacts, const pinch_island *island, const pinch_problem *problem,
                       pinch_rising_contact *of)
{
    walk at = {contacts, island, 0, 0, NULL};
    for (int k = 0; k < problem->contact_count; k++)
        of[k].push = push_of(&problem->contacts[k], next_law(&at), problem->step);
}

void pinch_slow_push_out(const pinch_contact_store *contacts, const pinch_island *island, const pinch_rise *rise,
                         double pace, double bounce, pinch_problem *problem)
{
    walk at = {contacts, island, 0, 0, NULL};
    for (int k = 0; k < problem->contact_count; k++) {
        pinch_contact *c = &problem->contacts[k];
        const pinch_own_law *own = next_law(&at);
        if (!is_hard(c, own)) continue;
        double part = rise->slows ? pace * rise->contacts.items[k].pace : pace;
        c->surface_velocity[0] += (1 - part) * push_of(c, own, problem->step) + (1 - bounce) * own->rebound;
    }
}

bool pinch_bounces_fall_short(const pinch_contact_store *contacts, const pinch_island *island,
                              const pinch_problem *problem)
{
    walk at = {contacts, island, 0, 0, NULL};
    bool any = false;
    for (int k = 0; k < problem->contact_count && contacts->any_bounces; k++) {
        const pinch_contact *c = &problem->contacts[k];
        pinch_own_law *own = next_own(&at);
        if (!own) continue;
        own->impact = own->rebound > 0 && c->may_soften ? c->force[0] : 0;
        own->gave_way = c->compliance[0] * own->impact;
        any = any || own->impact > 0;
    }
    return any;
}

/* A bounce falls short by no more than this part of it. What presses on a contact besides, as the weight of what comes
 * to rest in ever smaller bounces, is no part of it. */
static const double SHORT_BY = 0.1;

bool pinch_bounce_in_full(const pinch_contact_store *contacts, const pinch_island *island, pinch_problem *problem)
{
    walk at = {contacts, island, 0, 0, NULL};
    bool any = false;
    for (int k = 0; k < problem->contact_count; k++) {
        pinch_contact *c = &problem->contacts[k];
        pinch_own_law *own = next_own(&at);
        if (!own || !(own->impact > 0)) continue;
        double prescribed = own->impact / (problem->step * c->stiffness[0] + c->damping[0]);
        double more = fmin(fmax(own->gave_way - prescribed, 0), SHORT_BY * own->rebound);
        c->surface_velocity[0] -= more;
        own->rebound += more;
        any = any || more > 0;
    }
    return any;
}

double pinch_most_of_partners(const pinch_island *island)
{
    static const double MOST_OF_A_LEVER = 10, MOST_OF_A_GEAR = 50;
    double most = island->joints.joint_rows > 0 ? MOST_OF_A_GEAR : MOST_OF_A_LEVER;
    return island->surface_limit > 0 ? island->push_limit + most * most * island->surface_limit : INFINITY;
}

void pinch_slow_partners(const pinch_contact_store *contacts, const pinch_island *island, double pace,
                         pinch_problem *problem)
{
    walk at = {contacts, island, 0, 0, NULL};
    for (int k = 0; k < problem->contact_count; k++) {
        pinch_contact *c = &problem->contacts[k];
        if (!is_pushed_by_partner(c, next_law(&at))) continue;
        c->surface_velocity[0] += (1 - pace) * (closing_of(c, problem->step) - c->surface_velocity[0]);
        for (int i = 1; i < 4; i++) c->surface_velocity[i] *= pace;
        memset(c->elastic, 0, sizeof c->elastic);
        memset(c->rolling_elastic, 0, sizeof c->rolling_elastic);
    }
}

void pinch_let_go(const pinch_contact_store *contacts, const pinch_island *island, pinch_problem *problem)
{
    walk at = {contacts, island, 0, 0, NULL};
    for (int k = 0; k < problem->contact_count; k++) {
        pinch_contact *c = &problem->contacts[k];
        if (!is_hard(c, next_law(&at))) continue;
        memset(c->surface_velocity + 1, 0, 3 * sizeof *c->surface_velocity);
        memset(c->elastic, 0, sizeof c->elastic);
        memset(c->rolling_elastic, 0, sizeof c->rolling_elastic);
    }
}
