#include "pair_forces.h"

#include "common/vector.h"
#include "exact/exact.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int number_of(const bench_world *w, dGeomID geom)
{
    for (int i = 0; i < w->geom_count; i++)
        if (w->geoms[i] == geom) return i;
    return -1;
}

static pair_force *find(const pair_forces *forces, const int geom[2])
{
    for (int i = 0; i < forces->count; i++)
        if (memcmp(forces->items[i].geom, geom, sizeof forces->items[i].geom) == 0) return &forces->items[i];
    return NULL;
}

/* Adds a force on the body of the first geom. */
static void add(const bench_world *w, dGeomID geom1, dGeomID geom2, const double force[3], pair_forces *forces)
{
    int a = number_of(w, geom1), b = number_of(w, geom2);
    const int geom[2] = {a < b ? a : b, a < b ? b : a};
    pair_force *of = find(forces, geom);
    if (!of && forces->count == forces->room) {
        int room = 2 * forces->room + 16;
        pair_force *more = realloc(forces->items, (size_t)room * sizeof *more);
        forces->complete = forces->complete && more;
        if (!more) return;
        forces->items = more;
        forces->room = room;
    }
    if (!of) {
        of = &forces->items[forces->count++];
        *of = (pair_force){{geom[0], geom[1]}, {0, 0, 0}};
    }
    for (int i = 0; i < 3; i++) of->force[i] += a < b ? force[i] : -force[i];
}

static void read_pinch(const bench_world *w, pair_forces *forces)
{
    const pinch_ode_contact *list;
    int count = 0;
    forces->complete = pinch_ode_contacts(w->pinch, &list, &count) == PINCH_OK;
    for (int i = 0; i < count; i++) add(w, list[i].geom1, list[i].geom2, list[i].force, forces);
}

void pair_forces_read(const bench_world *w, pair_forces *forces)
{
    forces->count = 0;
    forces->complete = true;
    if (w->pinch) {
        read_pinch(w, forces);
        return;
    }
    for (int i = 0; i < w->contact_count; i++) {
        const bench_contact *c = &w->contacts[i];
        double force[3], sign = c->body[0] ? 1 : -1; /* attached as (0, body), ODE writes the body's force first */
        for (int k = 0; k < 3; k++) force[k] = sign * c->feedback.f1[k];
        add(w, c->contact.geom.g1, c->contact.geom.g2, force, forces);
    }
}

static void add_exact(const bench_world *w, const pinch_problem *problem, const int *places, const double *exact,
                      pair_forces *forces)
{
    const pinch_ode_contact *list;
    int count;
    pinch_ode_contacts(w->pinch, &list, &count);
    for (int i = 0; i < problem->contact_count; i++) {
        const pinch_contact *c = &problem->contacts[i];
        double t2[3], force[3];
        scene_cross(c->normal, c->tangent1, t2);
        for (int k = 0; k < 3; k++)
            force[k] = exact[4 * i] * c->normal[k] + exact[4 * i + 1] * c->tangent1[k] + exact[4 * i + 2] * t2[k];
        add(w, list[places[i]].geom1, list[places[i]].geom2, force, forces);
    }
}

void pair_forces_solve(const bench_world *w, pair_forces *forces)
{
    const pinch_ode_contact *list;
    int count = 0;
    pinch_ode_contacts(w->pinch, &list, &count);
    int *places = calloc((size_t)count + 1, sizeof *places);
    forces->count = 0;
    forces->complete = places != NULL;
    for (int k = 0; k < pinch_ode_island_count(w->pinch) && forces->complete; k++) {
        pinch_problem problem;
        exact_answer answer;
        forces->complete = pinch_ode_read_island(w->pinch, k, &problem, places) == PINCH_OK &&
                           exact_solve(&problem, &answer) == EXACT_OK;
        if (!forces->complete) break;
        add_exact(w, &problem, places, answer.force, forces);
        exact_free(&answer);
    }
    free(places);
}

void pair_forces_free(pair_forces *forces)
{
    free(forces->items);
    memset(forces, 0, sizeof *forces);
}

double pair_forces_largest(const pair_forces *forces)
{
    double largest = 0;
    for (int i = 0; i < forces->count; i++) largest = fmax(largest, scene_norm(forces->items[i].force));
    return largest;
}

/* Of the pairs of `a`; with `alone`, of those that `b` does not have. */
static double difference(const pair_forces *a, const pair_forces *b, bool alone)
{
    double largest = 0;
    for (int i = 0; i < a->count; i++) {
        const pair_force *other = find(b, a->items[i].geom);
        double off[3];
        scene_copy(a->items[i].force, off);
        if (other && alone) continue;
        for (int k = 0; k < 3 && other; k++) off[k] -= other->force[k];
        largest = fmax(largest, scene_norm(off));
    }
    return largest;
}

double pair_forces_difference(const pair_forces *a, const pair_forces *b)
{
    if (!a->complete || !b->complete) return NAN;
    return fmax(difference(a, b, false), difference(b, a, true));
}
