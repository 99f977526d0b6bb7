/*
 * Sleep: bodies that are to be disabled once they have been slow for long enough (dBodySetAutoDisableFlag).
 *
 * ODE decides on each body by itself, at the beginning of its step: it sets a body's velocities to zero as soon as they
 * have been below their thresholds for the steps and the time asked for, and again in each later step, as long as
 * something in the body's island moves. Forces that have been solved for the velocities before that are wrong behind
 * it: what they were to stop is thrown the other way. Nor does a grasp hold for the right reason where what it carries
 * slowly is stopped in each step.
 *
 * So Pinch decides, by the same thresholds, and on whole islands: they go to sleep once all of their bodies are due,
 * and until then no body is stopped. While ODE steps, the thresholds of bodies in islands that are awake are zero: ODE
 * may still disable what stands exactly still, which changes nothing for it. As in ODE, what moves or may move without
 * going to sleep keeps awake what touches it or is tied to it.
 *
 * Means over several samples (dBodySetAutoDisableAverageSamplesCount) are taken over as many steps, one run of them
 * after the other, where ODE takes them over the last steps anew in each step.
 *
 * A program that enables a body has ODE begin its count anew, which cannot be seen. What can be seen is what it does
 * with the body then. Where it pushes it otherwise than in the step before, the count begins anew here, too. Where it
 * enables it in each step to keep it awake, the body is found enabled in the step after the one that put it to sleep:
 * it waits twice as long from then on, until it has moved, or has slept on. The push of the step that it has slept
 * through is dropped; with that of the next step it would be twice as hard.
 */
#include "islands/island_graph.h"

#include "joints/joint_store.h"

#include "support/vec3.h"

#include <stdlib.h>
#include <string.h>

void pinch_sleep_free(pinch_sleep *s)
{
    free(s->items);
    free(s->held.items);
    pinch_item_index_free(&s->index);
}

size_t pinch_sleep_bytes(const pinch_sleep *s)
{
    return PINCH_LIST_BYTES(*s) + PINCH_LIST_BYTES(s->held) + pinch_item_index_bytes(&s->index);
}

static pinch_item_keys keys_of(const pinch_sleep *s)
{
    return PINCH_ITEM_KEYS(*s, pinch_idle_body, body);
}

/* *next: where it may be, as bodies come in the same order in most steps; then its place. */
static pinch_idle_body *find(const pinch_sleep *s, dBodyID body, int *next)
{
    int place = pinch_item_index_find(&s->index, keys_of(s), &body, next);
    return place < 0 ? NULL : &s->items[place];
}

void pinch_sleep_forget(pinch_sleep *s, dBodyID body)
{
    int place = pinch_item_index_get(&s->index, keys_of(s), &body);
    if (place < 0) return;
    pinch_item_index_remove(&s->index, keys_of(s), place, s->count - 1);
    s->items[place] = s->items[--s->count]; /* their order says nothing */
}

static void drop_unseen(pinch_sleep *s, long now)
{
    int kept = 0;
    for (int k = 0; k < s->count; k++)
        if (now - s->items[k].seen <= 1) s->items[kept++] = s->items[k];
    s->count = kept;
    (void)pinch_item_index_rebuild(&s->index, keys_of(s), kept); /* it has held as many before */
}

/* Returns NULL when memory runs out: the body does not sleep yet. */
static pinch_idle_body *find_or_add(pinch_sleep *s, dBodyID body, long now, int *next)
{
    pinch_idle_body *known = find(s, body, next);
    if (!known) {
        if (s->count == s->room) drop_unseen(s, now);
        if (!PINCH_RESERVE(*s, s->count + 1) || !pinch_item_index_add(&s->index, keys_of(s), &body, s->count))
            return NULL;
        known = &s->items[s->count++];
        *known = (pinch_idle_body){.body = body, .patience = 1, .seen = now - 1};
    }
    if (known->seen < now - 1) *known = (pinch_idle_body){.body = body, .patience = 1};
    return known;
}

static void begin_samples(pinch_idle_body *b)
{
    pinch_v3_set(b->linear, 0, 0, 0);
    pinch_v3_set(b->angular, 0, 0, 0);
    b->samples = 0;
}

static void begin_anew(pinch_idle_body *b)
{
    b->steps = 0;
    b->time = 0;
    b->has_mean = false;
    begin_samples(b);
}

/* Tells whether something pushes the body otherwise than in the step before. */
static bool is_pushed_anew(pinch_idle_body *b)
{
    double now[6];
    pinch_v3_copy(now, dBodyGetForce(b->body));
    pinch_v3_copy(now + 3, dBodyGetTorque(b->body));
    bool anew = memcmp(now, b->push, sizeof now) != 0;
    memcpy(b->push, now, sizeof now);
    return anew;
}

/* A mean counts as too fast as soon as the sum of the samples that there are is: what hits a body is seen at once,
 * though later samples may cancel it. */
static bool too_fast(const double *sum, int samples, double threshold)
{
    double limit = samples * threshold;
    return pinch_v3_dot(sum, sum) > limit * limit;
}

/* Takes the body's velocity into account at the beginning of a step of h (s). */
static void watch(pinch_idle_body *b, double h)
{
    int samples = dBodyGetAutoDisableAverageSamplesCount(b->body);
    pinch_v3_add_scaled(b->linear, 1, dBodyGetLinearVel(b->body));
    pinch_v3_add_scaled(b->angular, 1, dBodyGetAngularVel(b->body));
    if (is_pushed_anew(b)) begin_anew(b);
    if (samples == 0 || too_fast(b->linear, samples, dBodyGetAutoDisableLinearThreshold(b->body)) ||
        too_fast(b->angular, samples, dBodyGetAutoDisableAngularThreshold(b->body))) {
        begin_anew(b);
        b->patience = 1;
        return;
    }
    if (++b->samples >= samples) {
        b->has_mean = true;
        begin_samples(b);
    }
    if (!b->has_mean) return;
    b->steps += b->steps < PINCH_MOST_IDLE_STEPS;
    b->time += h;
}

static bool is_due(const pinch_idle_body *b)
{
    return b->steps > 0 && b->steps >= (double)b->patience * dBodyGetAutoDisableSteps(b->body) &&
           b->time >= b->patience * dBodyGetAutoDisableTime(b->body);
}

/* Looks at a body at the beginning of a step. */
static void look_at(pinch_sleep *s, dBodyID body, const pinch_step_context *context, int *next)
{
    pinch_idle_body *b = find_or_add(s, body, context->number, next);
    if (!b || b->seen == context->number) return; /* a step that is tried once more */
    b->seen = context->number;
    bool enabled = dBodyIsEnabled(body);
    if (enabled && b->was_put_to_sleep && b->patience < PINCH_MOST_PATIENCE) b->patience *= 2;
    if (!enabled) b->patience = 1;
    b->was_put_to_sleep = false;
    if (enabled)
        watch(b, context->h);
    else
        begin_anew(b);
}

static void keep_awake(pinch_island_graph *graph, int body)
{
    pinch_island *island = &graph->items[graph->bodies.items[body].parent];
    island->phase = PINCH_ISLAND_AWAKE;
    island->kept_awake = true;
}

/* An enabled body that is not of the island wakes what joints tie to it: a kinematic one, or another one by a joint
 * that Pinch does not know. */
static void wake_tied(pinch_island_graph *graph, const pinch_joint_store *joints, int body)
{
    const pinch_step_body *b = &graph->bodies.items[body];
    for (int k = 0; k < b->joint_count; k++) {
        dJointID joint = joints->attached.items[b->first_joint + k].joint;
        dBodyID first = dJointGetBody(joint, 0), other = first == b->body ? dJointGetBody(joint, 1) : first;
        if (!other || !dBodyIsEnabled(other)) continue;
        int known = pinch_step_body_of(&graph->bodies, other);
        if (known < 0 || graph->bodies.items[known].parent != b->parent) keep_awake(graph, body);
    }
}

/* As in ODE, an enabled kinematic body wakes what it touches. */
static void wake_touched(pinch_island_graph *graph, const pinch_pair *pair)
{
    for (int side = 0; side < 2 && pair->manifold.count > 0; side++) {
        dBodyID body = pair->body[side];
        int touched = pair->step_body[!side];
        if (body && touched >= 0 && dBodyIsKinematic(body) && dBodyIsEnabled(body)) keep_awake(graph, touched);
    }
}

void pinch_find_sleepers(pinch_island_graph *graph, const pinch_contact_store *contacts,
                         const pinch_joint_store *joints, const pinch_step_context *context)
{
    int next = 0;
    graph->sleepers = false;
    graph->sleep.by_ode = context->settings.ode_solves;
    for (int i = 0; i < graph->bodies.count; i++) {
        const pinch_step_body *b = &graph->bodies.items[i];
        pinch_island *island = &graph->items[b->parent];
        bool enabled = b->drive >= 0 || dBodyIsEnabled(b->body), due_by_itself = dBodyGetAutoDisableFlag(b->body);
        bool may_sleep = b->drive < 0 && (!enabled || due_by_itself);
        if (enabled) island->phase = PINCH_ISLAND_AWAKE;
        if (b->drive >= 0 || (enabled && !due_by_itself)) island->kept_awake = true;
        if (b->drive < 0 && due_by_itself && !graph->sleep.by_ode) look_at(&graph->sleep, b->body, context, &next);
        island->may_sleep = island->may_sleep || may_sleep;
        graph->sleepers = graph->sleepers || may_sleep;
    }
    for (int i = 0; i < contacts->pairs.count; i++) wake_touched(graph, &contacts->pairs.items[i]);
    for (int i = 0; i < graph->bodies.count && graph->sleepers; i++) wake_tied(graph, joints, i);
}

/* A body that was disabled before the step has nothing to wait for. As in ODE, nothing stops in mid-air. */
static bool may_go_to_sleep(const pinch_island_graph *graph, const pinch_island *island)
{
    int next = 0;
    bool all = island->phase == PINCH_ISLAND_AWAKE && !island->kept_awake &&
               island->contacts.count + island->joints.range.count > 0;
    for (int k = 0; k < island->bodies.count && all; k++) {
        dBodyID body = pinch_island_body(&graph->bodies, island->bodies, k)->body;
        const pinch_idle_body *b = find(&graph->sleep, body, &next);
        all = !dBodyIsEnabled(body) || (b && is_due(b));
    }
    return all;
}

void pinch_choose_sleepers(pinch_island_graph *graph)
{
    for (int i = 0; i < graph->count && graph->sleepers && !graph->sleep.by_ode; i++) {
        pinch_island *island = &graph->items[i];
        island->falls_asleep = may_go_to_sleep(graph, island);
        if (island->falls_asleep) island->phase = PINCH_ISLAND_ASLEEP;
    }
}

void pinch_put_to_sleep(pinch_island_graph *graph)
{
    int next = 0;
    for (int i = 0; i < graph->count && graph->sleepers; i++) {
        const pinch_island *island = &graph->items[i];
        for (int k = 0; k < island->bodies.count && island->falls_asleep; k++) {
            dBodyID body = pinch_island_body(&graph->bodies, island->bodies, k)->body;
            pinch_idle_body *b = find(&graph->sleep, body, &next);
            if (!dBodyIsEnabled(body)) continue;
            if (b) b->was_put_to_sleep = true;
            dBodySetLinearVel(body, 0, 0, 0);
            dBodySetAngularVel(body, 0, 0, 0);
            dBodySetForce(body, 0, 0, 0);
            dBodySetTorque(body, 0, 0, 0);
            dBodyDisable(body);
        }
    }
}

void pinch_hold_sleep_of_ode(pinch_island_graph *graph)
{
    pinch_sleep *s = &graph->sleep;
    s->held.count = 0;
    if (!graph->sleepers || s->by_ode || !PINCH_RESERVE(s->held, graph->bodies.count)) return;
    for (int i = 0; i < graph->bodies.count; i++) {
        const pinch_step_body *b = &graph->bodies.items[i];
        if (graph->items[b->parent].phase == PINCH_ISLAND_ASLEEP || !dBodyGetAutoDisableFlag(b->body)) continue;
        s->held.items[s->held.count++] = (pinch_sleep_thresholds){b->body, dBodyGetAutoDisableLinearThreshold(b->body),
                                                                  dBodyGetAutoDisableAngularThreshold(b->body)};
        dBodySetAutoDisableLinearThreshold(b->body, 0);
        dBodySetAutoDisableAngularThreshold(b->body, 0);
    }
}

void pinch_release_sleep_of_ode(pinch_island_graph *graph)
{
    pinch_sleep *s = &graph->sleep;
    for (int k = 0; k < s->held.count; k++) {
        dBodySetAutoDisableLinearThreshold(s->held.items[k].body, s->held.items[k].linear);
        dBodySetAutoDisableAngularThreshold(s->held.items[k].body, s->held.items[k].angular);
    }
    s->held.count = 0;
}
