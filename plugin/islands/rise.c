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
 * What lies below another body is its neighbour that is nearer to the ground, so that bodies can be gone through in an
 * order in which each comes after those below it. Of these the one counts that comes up fastest.
 */
#include "islands/island_life.h"

#include "support/vec3.h"

#include <math.h>
#include <stdlib.h>

void pinch_find_up(const pinch_step_context *context, const pinch_problem *problem, pinch_rise *rise)
{
    double mass = 0, acting[3] = {0, 0, 0}, *up = rise->up;
    bool falls = pinch_v3_norm(context->gravity) > 0;
    for (int b = 0; b < problem->body_count && !falls; b++) {
        mass += problem->bodies[b].mass;
        pinch_v3_add_scaled(acting, 1, problem->bodies[b].external);
    }
    for (int i = 0; i < 3; i++) up[i] = -(falls ? context->gravity[i] : acting[i] / mass);
    rise->acceleration = pinch_v3_norm(up);
    for (int i = 0; i < 3 && rise->acceleration > 0; i++) up[i] /= rise->acceleration;
}

/* May the pushes of any contacts on each other add up to more than gravity stops? Where no push is faster than s times
 * its depth, those that add up to v come from a depth D >= v/s, and v^2 + g h v <= 2 g D holds if s (v + g h) <= 2 g.
 */
static bool may_throw(const pinch_problem *problem, const pinch_rise *rise)
{
    double g = rise->acceleration;
    return g > 0 && rise->steepest * (rise->sum + g * problem->step) > 2 * g;
}

/* Links each body to the pairs in which it is pushed up, and to those in which it pushes another one. */
static void link_bodies(const pinch_problem *problem, pinch_rise *rise, int pairs)
{
    pinch_rising_body *bodies = rise->bodies.items;
    for (int b = 0; b < problem->body_count; b++) bodies[b] = (pinch_rising_body){.below = -1, .above = -1, .pace = 1};
    for (int k = 0; k < pairs; k++) {
        pinch_rising_pair *pair = &rise->pairs.items[k];
        if (!(pair->speed > 0)) continue;
        pair->next_of_upper = bodies[pair->upper].below;
        bodies[pair->upper].below = k;
        if (pair->lower < 0) continue;
        pair->next_of_lower = bodies[pair->lower].above;
        bodies[pair->lower].above = k;
        bodies[pair->upper].awaited++;
    }
}

/* Finds how fast a body comes up, and the way that it has to go, from those of the bodies below it; and the part of
 * that velocity that it may have. */
static void find_pace(double step, const pinch_rise *rise, pinch_rising_body *b)
{
    static const pinch_rising_body GROUND = {.pace = 1};
    for (int k = b->below; k >= 0; k = rise->pairs.items[k].next_of_upper) {
        const pinch_rising_pair *pair = &rise->pairs.items[k];
        const pinch_rising_body *below = pair->lower < 0 ? &GROUND : &rise->bodies.items[pair->lower];
        double speed = below->speed + pair->speed;
        if (speed <= b->speed) continue;
        b->speed = speed;
        b->way = below->way + pair->way;
        b->fastest = fmax(below->fastest, pair->speed);
    }
    double g = rise->acceleration, fall = 0.5 * g * step;
    double most = fmax(sqrt(fall * fall + 2 * g * b->way) - fall, b->fastest);
    b->pace = b->speed > most ? most / b->speed : 1;
}

/* From the ground up, finds the pace of each body. */
static void find_paces(const pinch_problem *problem, pinch_rise *rise)
{
    pinch_rising_body *bodies = rise->bodies.items;
    int *order = rise->order.items, known = 0;
    for (int b = 0; b < problem->body_count; b++)
        if (bodies[b].awaited == 0) order[known++] = b;
    for (int i = 0; i < known; i++) {
        pinch_rising_body *b = &bodies[order[i]];
        find_pace(problem->step, rise, b);
        for (int k = b->above; k >= 0; k = rise->pairs.items[k].next_of_lower) {
            int upper = rise->pairs.items[k].upper;
            if (--bodies[upper].awaited == 0) order[known++] = upper;
        }
    }
}

/* From the top down, each body gets the pace of what lies on it. */
static void lower_paces(const pinch_problem *problem, pinch_rise *rise)
{
    pinch_rising_body *bodies = rise->bodies.items;
    for (int i = problem->body_count - 1; i >= 0; i--) {
        const pinch_rising_body *b = &bodies[rise->order.items[i]];
        rise->slows = rise->slows || b->pace < 1;
        for (int k = b->below; k >= 0; k = rise->pairs.items[k].next_of_upper) {
            int lower = rise->pairs.items[k].lower;
            if (lower >= 0) bodies[lower].pace = fmin(bodies[lower].pace, b->pace);
        }
    }
}

void pinch_limit_rise(const pinch_problem *problem, int pairs, pinch_rise *rise)
{
    rise->slows = false;
    if (!may_throw(problem, rise)) return;
    link_bodies(problem, rise, pairs);
    find_paces(problem, rise);
    lower_paces(problem, rise);
}
