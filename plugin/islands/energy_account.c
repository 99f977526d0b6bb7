/*
 * The account of the energy that joints have taken out of bodies, and may put in again.
 *
 * By themselves joints only take energy out. Whatever they put in when they take errors of position back
 * (joints/joint_energy.c) must have been taken out before: the account of an island grows by what its joints take out
 * in a step, falls by what they put in, and may not become negative (time-domain passivity; Hannaford and Ryu,
 * "Time-domain passivity control of haptic interfaces", 2002). So a mechanism can never have more energy than it began
 * with and what gravity, motors, springs and contacts gave it, but for these parts:
 *
 *  - In each step the account gets the part OF_FALL of the energy that a fall of that length gives to bodies at rest.
 *    With it errors go away that were there before the bodies moved, and nobody sees it: it is h |g|^2 / 10 W/kg.
 *  - Where joints close no loops, an error costs what it asks for by itself, and what a motion tears apart takes more
 *    energy out than the way back puts in. There joints do what ODE's exact step does, but where that takes a hundred
 *    times the energy that errors ask for. This ends where bodies turn so far in a step that rows mean little: joints
 *    are torn then, and when the bodies calm down, the way back would cost many times the energy that is left. It
 *    ends, too, where hard contacts had to give way: joints are jammed against them, in loops. It begins again when
 *    errors are small.
 *  - What comes back has to be lifted, and that takes as much at any pace. So joints may put in besides, along the way
 *    by which errors really become smaller, the work of the forces in their rows, up to the weight of all bodies; in
 *    loops, where errors may contradict each other, only as long as the bodies of a joint are carried without being
 *    thrown, and in trees not faster than by some falls of a step. All of it is bounded by the errors that were there.
 *
 * Beside the account stand savings. Where bodies turn far in a step, a motion along rows as they were leads away from
 * where they should be, and a heavy body at the end of a chain tears it apart: rows take much energy out in each step,
 * and closing takes as much, against the tension. An account that forgets this has the chain torn further and further
 * by its weight. So the savings are all that joints have taken out less all that they have put in, the parts above
 * included, and joints may put a part of what is saved in, if that is more than the account allows and lifting asks
 * for: all of it at once would be a kick. No more is saved than twice what it takes to close the errors that there are,
 * and nothing where rows contradict each other. What joints take out beside contacts may be an impact, and is not
 * saved. Debts stay. Turning by much in a step puts energy in, too, which joints take out and save: with 162 kg at the
 * end of five links of 1 kg, a chain that swings at steps of 17 ms has come to two and a half times the energy that it
 * began with.
 *
 * Where an island goes to ODE (backoff.c) its joints keep their pace, if they close loops or are torn: ODE is given
 * that part of their ERP (joints/joint_pace.c). It goes down where the island gains energy in ODE's step, and up
 * otherwise.
 *
 * The account holds no more than the part MOST of the energy in motion beside that of the centre of mass, and the
 * energy of STEPS_OF_FALL steps' fall, so that what stops and impacts have taken out does not come back as a kick.
 *
 * Islands part and merge, bodies stay. So the account is kept by body, in equal parts, and savings by mass.
 */
#include "islands/island_life.h"

#include "joints/island_joints.h"

#include "support/vec3.h"

#include <math.h>
#include <stdlib.h>

static const double OF_FALL = 0.2, MOST = 0.1, OVERDRAFT = 0.2, TIMES_ASKED_FOR = 100;
enum { STEPS_OF_FALL = 50 }; /* held in any case */

/* Of the savings, joints may put this part in in a step. It is the part of an error that ODE takes back in a step, by
 * the ERP that its worlds begin with. */
static const double OF_SAVED = 0.2;
/* As many times the work of closing in a step are saved at most. Five times throw what is left of a chain at 30 m/s
 * when a heavy load is let go; with one time a torn chain stays as it is. */
static const double MOST_SAVED = 2;

/* Where a step needed less than this part of what it had, the next goes by this factor faster. */
static const double EASY = 0.25, FASTER = 1.5;
/* Where errors could not be taken back at all, this is tried next: what was in the way may be gone. */
static const double LEAST = 0.01;

void pinch_accounts_free(pinch_joint_accounts *a)
{
    free(a->items);
    pinch_item_index_free(&a->index);
}

size_t pinch_accounts_bytes(const pinch_joint_accounts *a)
{
    return PINCH_LIST_BYTES(*a) + pinch_item_index_bytes(&a->index);
}

static pinch_item_keys keys_of(const pinch_joint_accounts *a)
{
    return PINCH_ITEM_KEYS(*a, pinch_joint_account, body);
}

/* *next: where it may be, as accounts of an island are made one after the other; then the place after it. */
static pinch_joint_account *find(const pinch_joint_accounts *a, dBodyID body, int *next)
{
    int place = pinch_item_index_find(&a->index, keys_of(a), &body, next);
    if (place < 0) return NULL;
    *next = place + 1;
    return &a->items[place];
}

void pinch_accounts_forget(pinch_joint_accounts *a, dBodyID body)
{
    int place = pinch_item_index_get(&a->index, keys_of(a), &body);
    if (place < 0) return;
    pinch_item_index_remove(&a->index, keys_of(a), place, a->count - 1);
    a->items[place] = a->items[--a->count]; /* their order says nothing */
}

/* Returns the energy (J) that a fall of one step gives to the island's bodies. */
static double energy_of_fall(const pinch_step_context *context, const pinch_problem *problem)
{
    double fall = pinch_fall_in_step(context), mass = 0;
    for (int b = 0; b < problem->body_count; b++) mass += problem->bodies[b].mass;
    return 0.5 * mass * fall * fall;
}

/* Tells whether a body turns so far in a step that rows, which are linear, mean little at its end. */
static bool turns_far(const pinch_problem *problem)
{
    static const double FAR = 0.25; /* rad */
    for (int b = 0; b < problem->body_count; b++)
        if (!(problem->step * pinch_v3_norm(problem->bodies[b].velocity + 3) <= FAR)) return true;
    return false;
}

bool pinch_errors_are_small(const pinch_step_context *context, const pinch_joint_store *joints,
                            const pinch_island *island, const pinch_problem *problem)
{
    static const double SMALL = 0.01; /* of the energy in motion: bodies turn by a tenth of a radian in a step */
    double most = SMALL * pinch_energy_in_motion(problem) + OF_FALL * energy_of_fall(context, problem);
    return pinch_energy_of_errors(joints, &island->joints, problem) <= most;
}

/* Sums up what the bodies' accounts hold. The pace is that of the slowest, and one torn joint counts for all. */
static void read_accounts(const pinch_island_graph *graph, pinch_island *island)
{
    pinch_island_joints *j = &island->joints;
    j->pace = 1;
    j->energy = j->saved = 0;
    j->torn = false;
    int next = 0;
    for (int k = 0; k < island->bodies.count; k++) {
        const pinch_joint_account *a =
            find(&graph->accounts, pinch_island_body(&graph->bodies, island->bodies, k)->body, &next);
        if (!a) continue;
        j->energy += a->energy;
        j->saved += a->saved;
        j->torn = j->torn || a->torn;
        if (a->pace < j->pace) j->pace = a->pace;
    }
}

void pinch_read_push(const pinch_step_context *context, const pinch_island_graph *graph, pinch_island *island)
{
    int next = 0;
    island->push_balance = 0;
    island->push_pace = 1;
    for (int k = 0; k < island->bodies.count && graph->accounts.count > 0; k++) {
        const pinch_joint_account *a =
            find(&graph->accounts, pinch_island_body(&graph->bodies, island->bodies, k)->body, &next);
        if (!a) continue;
        /* what has been free, or at rest, is in no overlap any more that has been paid for */
        if (a->push > 0 || a->seen >= context->number - 1) island->push_balance += a->push;
        if (a->push_slowed_step == context->number - 1) island->push_pace = fmin(island->push_pace, a->push_pace);
    }
}

void pinch_open_account(const pinch_step_context *context, const pinch_island_graph *graph,
                        const pinch_joint_store *joints, const pinch_problem *problem, pinch_island *island)
{
    pinch_island_joints *j = &island->joints;
    double motion = pinch_energy_in_motion(problem), fall = OF_FALL * energy_of_fall(context, problem);
    double most = MOST * motion + STEPS_OF_FALL * fall;
    read_accounts(graph, island);
    j->torn = turns_far(problem) || (j->torn && !pinch_errors_are_small(context, joints, island, problem));
    bool as_ode = !j->torn && !pinch_joints_close_loops(joints, &graph->bodies, island->bodies, j);
    double errors = as_ode ? pinch_energy_of_errors(joints, j, problem) : 0;
    j->overdraft = as_ode ? OVERDRAFT * motion + TIMES_ASKED_FOR * errors : 0;
    j->energy = fmin(j->energy, most) + fall + j->overdraft;
}

double pinch_joints_may_put_in(const pinch_island_joints *joints)
{
    return fmax(joints->energy + joints->lifting, fmin(OF_SAVED * joints->saved, joints->closing_work));
}

void pinch_close_overdraft(pinch_island_joints *joints)
{
    joints->torn = true;
    joints->energy -= joints->overdraft;
    joints->overdraft = 0;
}

/* Drops bodies that have been nowhere near a joint for long. They may be gone. */
static void drop_stale(pinch_joint_accounts *a, long now)
{
    enum { LONG = 1000 };
    int kept = 0;
    for (int k = 0; k < a->count; k++)
        if (now - a->items[k].seen <= LONG) a->items[kept++] = a->items[k];
    a->count = kept;
    (void)pinch_item_index_rebuild(&a->index, keys_of(a), kept); /* it has held as many before */
}

static pinch_joint_account *find_or_add(pinch_joint_accounts *a, dBodyID body, long now, int *next)
{
    pinch_joint_account *known = find(a, body, next);
    if (known) return known;
    if (a->count == a->room) drop_stale(a, now);
    if (!PINCH_RESERVE(*a, a->count + 1)) return NULL; /* without memory it is new again in the next step */
    if (!pinch_item_index_add(&a->index, keys_of(a), &body, a->count)) return NULL;
    a->items[a->count] = (pinch_joint_account){.body = body, .pace = 1, .push_pace = 1};
    return &a->items[a->count++];
}

static double mass_of(dBodyID body)
{
    dMass mass;
    dBodyGetMass(body, &mass);
    return mass.mass;
}

/* Keeps what the island has left (J) in equal parts by body, what it has saved by their mass, and its next pace. A
 * heavy body that is let go takes along what its weight has made. */
static void write_accounts(const pinch_step_context *context, pinch_island_graph *graph, const pinch_island *island,
                           double left, double saved, double pace)
{
    int next = 0;
    double mass = 0;
    for (int k = 0; k < island->bodies.count && saved != 0; k++)
        mass += mass_of(pinch_island_body(&graph->bodies, island->bodies, k)->body);
    for (int k = 0; k < island->bodies.count; k++) {
        dBodyID body = pinch_island_body(&graph->bodies, island->bodies, k)->body;
        pinch_joint_account *a = find_or_add(&graph->accounts, body, context->number, &next);
        if (!a) continue;
        a->energy = left / island->bodies.count;
        a->saved = saved != 0 ? saved * mass_of(body) / mass : 0;
        a->pace = pace;
        a->torn = island->joints.torn;
        a->seen = context->number;
    }
}

/* ---- islands that go to ODE ---- */

/* Returns the kinetic energy (J) of the island's bodies, and the work that their weight has done if they have moved at
 * their velocity for a step. */
static double kinetic_energy(const pinch_step_context *context, const pinch_step_bodies *bodies, pinch_range range,
                             double *weight, double *mass)
{
    double kinetic = 0;
    *weight = *mass = 0;
    for (int k = 0; k < range.count; k++) {
        dBodyID body = pinch_island_body(bodies, range, k)->body;
        const double *v = dBodyGetLinearVel(body), *w = dBodyGetAngularVel(body);
        dVector3 spin;
        dMass m;
        dBodyGetMass(body, &m);
        dBodyVectorFromWorld(body, w[0], w[1], w[2], spin);
        kinetic += 0.5 * m.mass * pinch_v3_dot(v, v);
        for (int i = 0; i < 3; i++) kinetic += 0.5 * spin[i] * pinch_v3_dot(m.I + 4 * i, spin);
        if (dBodyGetGravityMode(body)) *weight += context->h * m.mass * pinch_v3_dot(context->gravity, v);
        *mass += m.mass;
    }
    return kinetic;
}

void pinch_open_fallback_account(const pinch_step_context *context, const pinch_island_graph *graph,
                                 const pinch_joint_store *joints, pinch_island *island)
{
    pinch_island_joints *j = &island->joints;
    double pace = j->pace, weight, mass;
    bool torn = island->tried && j->torn;
    j->slowed = false;
    if (j->range.count == 0 || context->settings.joints_by_ode || context->settings.ode_solves) return;
    read_accounts(graph, island);
    if (island->tried) j->pace = pace;
    j->torn = j->torn || torn;
    for (int k = 0; k < j->range.count; k++)
        if (!pinch_island_joint(joints, j, k)->exact) return;
    j->slowed = j->torn || pinch_joints_close_loops(joints, &graph->bodies, island->bodies, j);
    j->kinetic = kinetic_energy(context, &graph->bodies, island->bodies, &weight, &mass);
}

/* Judges by all energy that the island has gained: what motors and contacts gave it cannot be told. */
static void keep_fallback_account(const pinch_step_context *context, pinch_island_graph *graph,
                                  const pinch_island *island)
{
    static const double GAIN = 0.01, SLOWER = 0.25;
    const pinch_island_joints *j = &island->joints;
    double weight, mass, fall = pinch_fall_in_step(context);
    double kinetic = kinetic_energy(context, &graph->bodies, island->bodies, &weight, &mass);
    double gained = kinetic - j->kinetic - weight;
    bool much = !(gained <= GAIN * j->kinetic + 0.5 * mass * fall * fall);
    double pace = much ? SLOWER * j->pace : fmin(fmax(FASTER * j->pace, LEAST), 1);
    gained = fmax(gained, 0);
    write_accounts(context, graph, island, fmax(j->energy - gained, 0), j->saved - gained, pace);
}

/* Keeps what hard contacts may put in. Bodies that have none, and had none before, need no account. */
static void keep_push(const pinch_step_context *context, pinch_island_graph *graph, const pinch_island *island)
{
    double each = island->push_balance / island->bodies.count;
    bool keeps = each != 0 || island->push_pace < 1;
    int next = 0;
    for (int k = 0; k < island->bodies.count; k++) {
        dBodyID body = pinch_island_body(&graph->bodies, island->bodies, k)->body;
        pinch_joint_account *a =
            keeps ? find_or_add(&graph->accounts, body, context->number, &next) : find(&graph->accounts, body, &next);
        if (!a) continue;
        a->push = each;
        a->push_pace = island->push_pace;
        if (island->push_pace < 1) a->push_slowed_step = context->number;
        if (keeps) a->seen = context->number;
    }
}

/* Bodies that ODE moves for a step are still in their overlaps. */
static void keep_debts(const pinch_step_context *context, pinch_island_graph *graph, const pinch_island *island)
{
    int next = 0;
    for (int k = 0; k < island->bodies.count && graph->accounts.count > 0; k++) {
        pinch_joint_account *a =
            find(&graph->accounts, pinch_island_body(&graph->bodies, island->bodies, k)->body, &next);
        if (a && a->push < 0) a->seen = context->number;
    }
}

void pinch_keep_account(const pinch_step_context *context, pinch_island_graph *graph, const pinch_island *island)
{
    const pinch_island_joints *j = &island->joints;
    if (island->phase == PINCH_ISLAND_SOLVED && island->pushes) keep_push(context, graph, island);
    if (island->phase == PINCH_ISLAND_FALLBACK && island->contacts.count > 0) keep_debts(context, graph, island);
    if (j->range.count == 0) return;
    if (island->phase == PINCH_ISLAND_FALLBACK && j->slowed) keep_fallback_account(context, graph, island);
    if (island->phase != PINCH_ISLAND_SOLVED || j->joint_rows == 0) return; /* none was opened without rows */
    double drawn = fmin(j->work, fmax(j->work - j->lifting, 0));            /* negative: paid in */
    double left = fmax(j->energy - j->overdraft - drawn, 0);
    double spent = island->contacts.count > 0 ? fmax(j->work, 0) : j->work; /* negative: saved */
    double saved = fmin(j->saved - spent, MOST_SAVED * j->closing_work);
    bool easy = j->work <= EASY * pinch_joints_may_put_in(j);
    write_accounts(context, graph, island, left, saved, easy ? fmin(fmax(FASTER * j->pace, LEAST), 1) : j->pace);
}
