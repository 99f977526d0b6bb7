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
 * overlaps have asked for, until the body has been free for a step: that was for overlaps which are gone then.
 */
#include "islands/island_life.h"

#include "joints/island_joints.h"
#include "support/loop.h"

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

/* Tells whether the contact is between the same bodies as the one before it. */
static bool goes_on(const pinch_problem *problem, int contact)
{
    if (contact <= 0 || contact >= problem->contact_count) return false;
    const pinch_contact *c = &problem->contacts[contact], *before = c - 1;
    return c->body1 == before->body1 && c->body2 == before->body2;
}

/* Contacts between the same bodies that follow each other are a group, of one pair of geoms or of several. Goes through
 * those that begin among some pairs of an island. */
typedef struct groups {
    walk at;
    int next, end; /* contacts */
} groups;

static int first_contact(const pinch_contact_store *contacts, const pinch_island *island, int pair)
{
    return pair < island->pairs.count ? pinch_island_pair(contacts, island->pairs, pair)->first_in_island
                                      : island->contacts.count;
}

static groups groups_among(const pinch_contact_store *contacts, const pinch_island *island,
                           const pinch_problem *problem, int first, int end)
{
    groups g = {{contacts, island, first, 0, NULL},
                first_contact(contacts, island, first),
                first_contact(contacts, island, end)};
    for (; g.next < g.end && goes_on(problem, g.next); g.next++) (void)next_own(&g.at);
    return g;
}

/* Returns how fast (m/s) the surface moves by itself along the normal, into body 1. That a deep contact parts more
 * slowly than at its ERP stands in the same velocity, and does not make a partner that comes in one that stays. */
static double speed_into(const pinch_contact *c, const pinch_own_law *own)
{
    return pinch_larger(own->eased - (c->surface_velocity[0] + own->rebound), own->pose_speed);
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

/* Returns the velocity (m/s) that a contact asks for because its bodies overlap, also beside that of a partner that
 * drives it on. */
static double parting_of(const pinch_contact *c, const pinch_own_law *own, double h)
{
    if (!is_pushed_by_partner(c, own)) return push_of(c, own, h);
    return own->eased > 0 ? pinch_larger(closing_of(c, h) - own->eased, 0) : 0;
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

/* Tells whether a contact is soft by its own parameters: a step that is shorter than others of late makes none of what
 * was hard in these. mobility: 1/kg, of its bodies. */
static bool is_spring(const pinch_contact *c, const pinch_own_law *own, double h, double mobility)
{
    return !(STIFF * own->paced_step * mobility * (h * c->stiffness[0] + c->damping[0]) > 1);
}

/* Returns the energy (J) that a contact's own spring gives back at most, with all bodies on it: its damper takes most
 * of what k d^2/2 holds where c^2 > k m. One that bounces comes out at the speed of its bounce instead. */
static double energy_of_spring(const pinch_contact *c, const pinch_own_law *own, double h, double mobility, double mass)
{
    double k = c->stiffness[0], damping = c->damping[0];
    if (own->rebound > 0 || !(k > 0) || !is_spring(c, own, h, mobility)) return 0;
    return 0.5 * k * c->depth * c->depth / (1 + damping * damping / (k * mass));
}

/* Does a surface move by itself along the contact, or about its normal? */
static bool moves_along(const pinch_contact *c)
{
    return c->surface_velocity[1] != 0 || c->surface_velocity[2] != 0 || c->surface_velocity[3] != 0;
}

/* Returns how fast (m/s) a surface moves by itself. */
static double speed_of_surface(const pinch_contact *c, const pinch_own_law *own)
{
    double into = speed_into(c, own), along = 0;
    if (moves_along(c)) along = hypot(c->surface_velocity[1], c->surface_velocity[2]);
    along = pinch_larger(along, own->carried_at);
    return into > 0 ? hypot(along, into) : along;
}

static double height_of(const pinch_problem *problem, const pinch_rise *rise, int body)
{
    return pinch_v3_dot(problem->bodies[body].position, rise->up);
}

/* Tells whether body 1 of a contact is the upper one. */
static bool first_is_upper(const pinch_problem *problem, const pinch_rise *rise, const pinch_contact *c)
{
    if (c->body1 < 0 || c->body2 < 0) return c->body1 >= 0;
    double one = height_of(problem, rise, c->body1), other = height_of(problem, rise, c->body2);
    return one != other ? one > other : c->body1 > c->body2;
}

/* Returns the upward part of a contact's normal, seen from its upper body. */
static double upward_part(const pinch_rise *rise, const pinch_contact *c, bool first_is_upper)
{
    return pinch_v3_dot(c->normal, rise->up) * (first_is_upper ? 1 : -1);
}

/* The loop over an island's pairs before its solve. */
typedef struct opening {
    const pinch_contact_store *contacts;
    const pinch_island *island;
    const pinch_problem *problem;
    pinch_rise *rise;
    double mass; /* kg of all bodies */
} opening;

/* Finds what a group of contacts asks for: energy, where its bodies move apart as its contacts ask in the mean, and
 * springs; and how fast its pairs push the upper body up. */
static void open_group(const opening *o, groups *g, pinch_push_part *part)
{
    const pinch_problem *problem = o->problem;
    const pinch_contact *first = &problem->contacts[g->next];
    bool upper = first_is_upper(problem, o->rise, first);
    double of_pair = 0, mobility = inverse_masses(problem, first);
    pinch_rising_pair *pair = NULL;
    do {
        const pinch_contact *c = &problem->contacts[g->next];
        if (g->at.point == 0) {
            pair = &o->rise->pairs.items[g->at.pair];
            pair->upper = upper ? c->body1 : c->body2;
            pair->lower = upper ? c->body2 : c->body1;
            pair->speed = pair->way = 0;
        }
        const pinch_own_law *own = next_law(&g->at);
        part->surfaces = pinch_larger(speed_of_surface(c, own), part->surfaces);
        double push = parting_of(c, own, problem->step);
        if (!(push > 0)) continue;
        of_pair += 0.5 * push * push / mobility;
        part->asked += energy_of_spring(c, own, problem->step, mobility, o->mass);
        part->fastest = fmax(part->fastest, push);
        if (is_spring(c, own, problem->step, mobility)) continue; /* under a load it is deep, and parts at no speed */
        double lifts = upward_part(o->rise, c, upper);
        pair->speed = fmax(push * lifts, pair->speed);
        pair->way = fmax(c->depth * lifts, pair->way); /* of pushes at ODE's largest velocity, the deepest one's */
        part->sum += push;
        part->steepest = pinch_larger(push / c->depth, part->steepest);
    } while (goes_on(problem, ++g->next));
    part->asked += of_pair / (double)(&problem->contacts[g->next] - first);
}

static void open_some(void *argument, int first, int end)
{
    const opening *o = argument;
    pinch_push_part part = {0};
    for (groups g = groups_among(o->contacts, o->island, o->problem, first, end); g.next < g.end;)
        open_group(o, &g, &part);
    o->rise->parts.items[first / PINCH_CHUNK] = part;
}

/* Returns the energy (J) that a step's fall gives to the island's bodies, the part of it that counts. */
static double part_of_fall(const pinch_step_context *context, double mass)
{
    double fall = pinch_fall_in_step(context);
    return OF_FALL * 0.5 * mass * fall * fall;
}

bool pinch_open_push(const pinch_step_context *context, const pinch_contact_store *contacts,
                     const pinch_island_graph *graph, const pinch_problem *problem, pinch_rise *rise,
                     pinch_island *island)
{
    island->pushes = false;
    for (int k = 0; k < problem->contact_count && !island->pushes; k++)
        island->pushes = problem->contacts[k].may_soften;
    if (!island->pushes) return false;
    int pairs = island->pairs.count, parts = pinch_chunk_count(pairs);
    if (!pinch_reserve_rise(rise, problem->body_count, pairs, parts)) {
        island->status = PINCH_OUT_OF_MEMORY;
        return false;
    }
    opening o = {contacts, island, problem, rise, mass_of(problem)};
    pinch_find_up(context, problem, rise);
    pinch_loop(problem->crew, pairs, open_some, &o);
    pinch_push_part all = {0};
    for (int k = 0; k < parts; k++) {
        const pinch_push_part *part = &rise->parts.items[k];
        all.asked += part->asked;
        all.sum += part->sum;
        all.fastest = fmax(all.fastest, part->fastest);
        all.steepest = pinch_larger(part->steepest, all.steepest);
        all.surfaces = pinch_larger(part->surfaces, all.surfaces);
    }
    rise->sum = all.sum;
    rise->steepest = all.steepest;
    /* joints may hang all bodies on the fastest push */
    if (island->joints.joint_rows > 0) all.asked = fmax(all.asked, 0.5 * o.mass * all.fastest * all.fastest);
    pinch_read_push(context, graph, island);
    island->push_limit = part_of_fall(context, o.mass) + fmax(TIMES_ASKED_FOR * all.asked + island->push_balance, 0);
    /* surfaces bring all bodies to the speed of the fastest of them, and lift them at it */
    island->surface_limit = o.mass * all.surfaces * (0.5 * all.surfaces + pinch_fall_in_step(context));
    return true;
}

/* Returns the force (N) that presses the pair of a contact together from outside. */
static double pressed_by(const pinch_problem *problem, const pinch_contact *c)
{
    double sum = 0;
    if (c->body1 >= 0) sum += fmax(-pinch_v3_dot(problem->bodies[c->body1].external, c->normal), 0);
    if (c->body2 >= 0) sum += fmax(pinch_v3_dot(problem->bodies[c->body2].external, c->normal), 0);
    return sum;
}

/* The loop over an island's pairs after its solve, before its bodies move. */
typedef struct answer {
    const pinch_contact_store *contacts;
    const pinch_step_bodies *bodies;
    const pinch_island *island;
    const pinch_problem *problem;
    pinch_rise *rise;
    double fall, weight; /* m/s by gravity in the step; N, of all bodies */
} answer;

/* A body of a pair, as it moves before the step. (The velocity of the problem's body has weight in it.) */
typedef struct mover {
    dBodyID body; /* NULL: none */
    const pinch_body *solved;
    const double *velocity, *spin;
} mover;

static mover mover_of(const answer *a, int number)
{
    if (number < 0) return (mover){NULL, NULL, NULL, NULL};
    dBodyID body = pinch_island_body(a->bodies, a->island->bodies, number)->body;
    return (mover){body, &a->problem->bodies[number], dBodyGetLinearVel(body), dBodyGetAngularVel(body)};
}

/* Finds the velocity (m/s) of body 1 relative to body 2 at a contact, before the step. */
static void find_velocity_before(const mover of[2], const pinch_contact *c, double *velocity)
{
    memset(velocity, 0, 3 * sizeof *velocity);
    for (int side = 0; side < 2; side++) {
        double arm[3], turned[3];
        if (!of[side].body) continue;
        pinch_v3_sub(c->position, of[side].solved->position, arm);
        pinch_v3_cross(of[side].spin, arm, turned);
        pinch_v3_add_scaled(velocity, side ? -1 : 1, of[side].velocity);
        pinch_v3_add_scaled(velocity, side ? -1 : 1, turned);
    }
}

/* Returns the mean normal velocity (m/s) of a contact in the step: times h and its force, the energy that it gives.
 * before: its velocity before the step. */
static double mean_velocity(const pinch_contact *c, const double *before)
{
    return 0.5 * (c->relative_velocity[0] - c->surface_velocity[0] + pinch_v3_dot(before, c->normal));
}

/* Returns the power (W) of friction in the same sense, but for what a surface that moves by itself does. */
static double mean_power_of_friction(const pinch_contact *c, const double *before)
{
    double t2[3];
    pinch_v3_cross(c->normal, c->tangent1, t2);
    double along1 = c->relative_velocity[1] + c->surface_velocity[1] + pinch_v3_dot(before, c->tangent1);
    double along2 = c->relative_velocity[2] + c->surface_velocity[2] + pinch_v3_dot(before, t2);
    return 0.5 * (c->force[1] * along1 + c->force[2] * along2);
}

/* Adds the power (W) that a surface gives to bodies as it moves by itself. */
static void add_power_of_surface(const pinch_contact *c, const pinch_own_law *own, const double *before, double *power)
{
    double into = speed_into(c, own);
    if (moves_along(c) || own->carried_at > 0) *power += mean_power_of_friction(c, before);
    for (int i = 1; i < 4; i++) *power -= c->force[i] * c->surface_velocity[i];
    if (into > 0) *power += c->force[0] * mean_velocity(c, before);
}

/* Tells whether a body of a pair is thrown. */
static bool is_thrown(const mover of[2], double fall)
{
    for (int side = 0; side < 2; side++)
        if (of[side].body && pinch_body_is_thrown(of[side].body, of[side].solved, fall)) return true;
    return false;
}

/* Finds the power of the surfaces of a group, how far its bodies come out of their overlaps, in the mean, and the work
 * of lifting them with what lies on them. */
static void judge_group(const answer *a, groups *g, pinch_push_part *part)
{
    const pinch_problem *problem = a->problem;
    const pinch_contact *pair = &problem->contacts[g->next];
    const mover of[2] = {mover_of(a, pair->body1), mover_of(a, pair->body2)};
    double step = problem->step, way = 0, force = 0;
    int overlaps = 0;
    do {
        const pinch_contact *c = &problem->contacts[g->next];
        const pinch_own_law *own = next_law(&g->at);
        double push = parting_of(c, own, step), before[3];
        if (!(push > 0) && !(a->island->surface_limit > 0)) continue;
        find_velocity_before(of, c, before);
        if (a->island->surface_limit > 0) add_power_of_surface(c, own, before, &part->power_of_surfaces);
        if (!(push > 0)) continue;
        way += step * pinch_smaller(mean_velocity(c, before), push);
        force += c->force[0];
        overlaps++;
    } while (goes_on(problem, ++g->next));
    if (overlaps == 0) return;
    way /= overlaps;
    double weight = pressed_by(problem, pair);
    if (force > weight && !is_thrown(of, a->fall)) weight = fmin(force, a->weight);
    part->lifting += way * weight;
    part->ways += way;
    part->leaving++;
}

static void judge_some(void *argument, int first, int end)
{
    const answer *a = argument;
    pinch_push_part part = {0};
    for (groups g = groups_among(a->contacts, a->island, a->problem, first, end); g.next < g.end;)
        judge_group(a, &g, &part);
    a->rise->parts.items[first / PINCH_CHUNK] = part;
}

/* Finds two works (J). That of surfaces on bodies as they move by themselves: in a jam some give what others take, so
 * that their sum counts; where it is negative, they have only taken. That of lifting where hard pairs come out of their
 * overlaps: of each with what lies on it; where joints may hang all bodies on them, of all bodies by the mean of their
 * ways. */
static void judge_all(answer *a, double *of_surfaces, double *lifting)
{
    const pinch_island *island = a->island;
    pinch_push_part all = {0};
    pinch_loop(a->problem->crew, island->pairs.count, judge_some, a);
    for (int k = 0; k < pinch_chunk_count(island->pairs.count); k++) {
        const pinch_push_part *part = &a->rise->parts.items[k];
        all.power_of_surfaces += part->power_of_surfaces;
        all.lifting += part->lifting;
        all.ways += part->ways;
        all.leaving += part->leaving;
    }
    *of_surfaces = fmin(fmax(a->problem->step * all.power_of_surfaces, 0), island->surface_limit);
    bool hang_on_it = island->joints.joint_rows > 0 && all.leaving > 0;
    *lifting = hang_on_it ? fmax(all.lifting, all.ways / all.leaving * a->weight) : all.lifting;
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
                      pinch_rise *rise, pinch_island *island)
{
    answer a = {contacts, bodies, island, problem, rise, pinch_fall_in_step(context), pinch_weight_of_all(problem)};
    double lag, gain = pinch_kinetic_gain(bodies, island->bodies, problem, &lag) + lag, put_in = gain;
    double by_contacts = INFINITY, of_surfaces, lifting;
    judge_all(&a, &of_surfaces, &lifting);
    if (island->joints.joint_rows > 0) {
        by_contacts = pinch_contact_work(problem);
        put_in = island->joints.work + by_contacts + lag; /* without what motors and springs of joints do */
        if (put_in > 0) put_in = fmax(put_in + taken_by_drives(contacts, joints, bodies, problem, island, put_in), 0);
    }
    if (island->result.swept) lifting = 0;
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
    double fall = part_of_fall(context, mass_of(problem)), balance = island->push_balance - island->push_change;
    if (balance < 0) balance = fmin(balance + island->push_spare, 0);
    island->push_balance = balance > 0 ? LEFT * balance : fmin(balance + fall, 0);
    if (fabs(island->push_balance) < fall) island->push_balance = 0;
    bool easy = island->push_work <= EASY * island->push_limit, jointed = island->joints.joint_rows > 0;
    island->push_pace = jointed ? fmin(fmax(easy ? FASTER * pace : pace, LEAST), 1) : pace;
}

/* Slowing down what contacts ask for, in a loop over an island's pairs. */
typedef struct slowing {
    const pinch_contact_store *contacts;
    const pinch_island *island;
    const pinch_rise *rise;
    double pace, bounce;
    pinch_problem *problem;
} slowing;

/* Returns the part of a push that is not too fast. What a spring bears is no speed. */
static double pace_of(const slowing *s, const pinch_contact *c, const pinch_own_law *own)
{
    if (!s->rise->slows || is_spring(c, own, s->problem->step, inverse_masses(s->problem, c))) return 1;
    bool upper = first_is_upper(s->problem, s->rise, c);
    return upward_part(s->rise, c, upper) > 0 ? s->rise->bodies.items[upper ? c->body1 : c->body2].pace : 1;
}

static void slow_some(void *argument, int first, int end)
{
    const slowing *s = argument;
    walk at = {s->contacts, s->island, first, 0, NULL};
    int last = first_contact(s->contacts, s->island, end);
    for (int k = first_contact(s->contacts, s->island, first); k < last; k++) {
        pinch_contact *c = &s->problem->contacts[k];
        const pinch_own_law *own = next_law(&at);
        if (!is_hard(c, own)) continue;
        double push = push_of(c, own, s->problem->step), part = push > 0 ? s->pace * pace_of(s, c, own) : s->pace;
        c->surface_velocity[0] += (1 - part) * push + (1 - s->bounce) * own->rebound;
    }
}

void pinch_slow_push_out(const pinch_contact_store *contacts, const pinch_island *island, const pinch_rise *rise,
                         double pace, double bounce, pinch_problem *problem)
{
    slowing s = {contacts, island, rise, pace, bounce, problem};
    pinch_loop(problem->crew, island->pairs.count, slow_some, &s);
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
