/*
 * How fast bodies come up that lie on each other in overlaps.
 *
 * Each overlap asks for a velocity apart, and in a stack these add up from the ground to the top. What is fast there
 * flies on as soon as the overlaps are gone, and a tower whose boxes fell onto each other one by one would hop by as
 * much as it is high. An account of energy (push_out.c) does not see that, as long as other bodies come down and more
 * is lost in their impacts.
 *
 * So a body comes up no faster than gravity stops it over the way that is left. Where it goes at v, what ODE adds to
 * its velocity and then to its position has it fly on by
 *
 *     h v + h (v - g h) + h (v - 2 g h) + ... = v^2 / 2g + h v / 2
 *
 * which is to be no more than the depth D of all overlaps below it. Contacts along the way to it ask for a part of
 * their velocities where these add up to more, the smallest part that any body on top of them has to have. What lies on
 * top is not held back to less than one contact on its way asks for, so that a single pair parts as in ODE.
 *
 * What lies below another body is its neighbour that is nearer to the ground: bodies are gone through by height, and
 * of those below it the one counts that comes up fastest.
 */
#include "islands/island_life.h"

#include "support/extremes.h"
#include "support/vec3.h"

#include <math.h>
#include <stdlib.h>

static int by_height(const void *a, const void *b)
{
    const pinch_height *x = a, *y = b;
    if (x->height != y->height) return x->height < y->height ? -1 : 1;
    return x->body < y->body ? -1 : 1;
}

/* Returns the acceleration (m/s^2) that presses the bodies down, and finds the direction against it: gravity, or where
 * the world has none, what acts on all of them. 0: nothing does. */
static double find_up(const pinch_step_context *context, const pinch_problem *problem, double up[3])
{
    double mass = 0, acting[3] = {0, 0, 0};
    for (int b = 0; b < problem->body_count; b++) {
        mass += problem->bodies[b].mass;
        pinch_v3_add_scaled(acting, 1, problem->bodies[b].external);
    }
    bool falls = pinch_v3_norm(context->gravity) > 0;
    for (int i = 0; i < 3; i++) up[i] = -(falls ? context->gravity[i] : acting[i] / mass);
    double g = pinch_v3_norm(up);
    for (int i = 0; i < 3 && g > 0; i++) up[i] /= g;
    return g;
}

/* May the pushes of any contacts on each other add up to more than gravity stops? Where no push is faster than s times
 * its depth, those that add up to v come from a depth D >= v/s, and v^2 + g h v <= 2 g D holds if s (v + g h) <= 2 g.
 */
static bool may_throw(const pinch_problem *problem, const pinch_rise *rise, double g)
{
    double sum = 0, steepest = 0;
    for (int k = 0; k < problem->contact_count; k++) {
        double push = rise->contacts.items[k].push;
        if (!(push > 0)) continue;
        sum += push;
        steepest = pinch_larger(push / problem->contacts[k].depth, steepest);
    }
    return steepest * (sum + g * problem->step) > 2 * g;
}

/* Sorts the bodies by height, and gives each contact to the upper one of its bodies. */
static void sort(const pinch_problem *problem, const double up[3], pinch_rise *rise)
{
    pinch_rising_body *bodies = rise->bodies.items;
    pinch_height *order = rise->order.items;
    for (int b = 0; b < problem->body_count; b++)
        order[b] = (pinch_height){pinch_v3_dot(problem->bodies[b].position, up), b};
    qsort(order, (size_t)problem->body_count, sizeof *order, by_height);
    for (int i = 0; i < problem->body_count; i++)
        bodies[order[i].body] = (pinch_rising_body){.place = i, .first = -1, .pace = 1};
    for (int k = 0; k < problem->contact_count; k++) {
        const pinch_contact *c = &problem->contacts[k];
        pinch_rising_contact *r = &rise->contacts.items[k];
        bool first_is_upper = c->body2 < 0 || (c->body1 >= 0 && bodies[c->body1].place > bodies[c->body2].place);
        int upper = first_is_upper ? c->body1 : c->body2;
        r->below = first_is_upper ? c->body2 : c->body1;
        r->lifts = pinch_v3_dot(c->normal, up) * (first_is_upper ? 1 : -1);
        r->next = bodies[upper].first;
        bodies[upper].first = k;
    }
}

/* Finds how fast a body comes up, and the way that it has to go, from those of the bodies below it; and the part of
 * that velocity that it may have. */
static void find_pace(const pinch_problem *problem, pinch_rise *rise, double g, pinch_rising_body *b)
{
    static const pinch_rising_body GROUND = {.pace = 1};
    for (int k = b->first; k >= 0; k = rise->contacts.items[k].next) {
        const pinch_rising_contact *r = &rise->contacts.items[k];
        const pinch_rising_body *below = r->below < 0 ? &GROUND : &rise->bodies.items[r->below];
        double push = r->push * r->lifts, speed = below->speed + push;
        if (!(push > 0) || speed <= b->speed) continue;
        b->speed = speed;
        b->way = below->way + problem->contacts[k].depth * r->lifts;
        b->fastest = fmax(below->fastest, push);
    }
    double fall = 0.5 * g * problem->step, most = fmax(sqrt(fall * fall + 2 * g * b->way) - fall, b->fastest);
    b->pace = b->speed > most ? most / b->speed : 1;
}

/* From the top down, each contact gets the pace of what lies on it. */
static void set_paces(const pinch_problem *problem, pinch_rise *rise)
{
    for (int i = problem->body_count - 1; i >= 0; i--) {
        const pinch_rising_body *b = &rise->bodies.items[rise->order.items[i].body];
        rise->slows = rise->slows || b->pace < 1;
        for (int k = b->first; k >= 0; k = rise->contacts.items[k].next) {
            pinch_rising_contact *r = &rise->contacts.items[k];
            bool lifts = r->push * r->lifts > 0;
            r->pace = lifts ? b->pace : 1;
            if (lifts && r->below >= 0)
                rise->bodies.items[r->below].pace = fmin(rise->bodies.items[r->below].pace, b->pace);
        }
    }
}

void pinch_limit_rise(const pinch_step_context *context, const pinch_contact_store *contacts,
                      const pinch_island *island, const pinch_problem *problem, pinch_rise *rise)
{
    double up[3], g = find_up(context, problem, up);
    rise->slows = false;
    if (!(g > 0) || !pinch_reserve_rise(rise, problem->body_count, problem->contact_count)) return;
    pinch_find_pushes(contacts, island, problem, rise->contacts.items);
    if (!may_throw(problem, rise, g)) return;
    sort(problem, up, rise);
    for (int i = 0; i < problem->body_count; i++)
        find_pace(problem, rise, g, &rise->bodies.items[rise->order.items[i].body]);
    set_paces(problem, rise);
}
