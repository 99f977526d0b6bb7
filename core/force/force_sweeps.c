/*
 * Projected Gauss-Seidel: one contact after the other gets the force that its law asks for beside those of the others,
 * equation (24) of core/README.md.
 *
 * Within Newton's method a few sweeps put contacts onto the right pieces of their laws. By themselves they approximate
 * a step of a heap of free bodies: an error dies out in proportion to the distance that it has to travel, and what one
 * step leaves the next one takes up from its forces. So contacts come in the order of their distance from what does not
 * move, and each sweep takes what bears the heap to its top.
 */
#include "force/force_rows.h"
#include "force/force_system.h"
#include "support/await.h"
#include "support/extremes.h"
#include "support/lanes.h"
#include "support/loop.h"

#include <limits.h>
#include <math.h>
#include <string.h>

static void visit_element(pinch_force_system *s, const pinch_force_element *e)
{
    double z[PINCH_CONTACT_ROWS_MAX], p[PINCH_CONTACT_ROWS_MAX], change[PINCH_CONTACT_ROWS_MAX];
    double *r = pinch_force_values(e, PINCH_FORCE_R);
    pinch_force_trial(e, s->q, z);
    (void)pinch_contact_law_project(e->law, pinch_force_values(e, PINCH_FORCE_RHO), z, p, NULL);
    for (int i = 0; i < e->rows; i++) {
        change[i] = p[i] - r[i];
        r[i] = p[i];
    }
    pinch_force_add_impulse(e, s->step, change, s->q);
}

void pinch_force_sweeps(pinch_force_system *s, int count)
{
    (void)pinch_force_evaluate(s);
    for (int sweep = 0; sweep < count; sweep++) {
        for (int k = 0; k < s->element_count; k++) visit_element(s, &s->elements[k]);
        for (int i = 0; i < s->multiplier_count; i++) {
            pinch_force_multiplier *m = &s->multipliers[i];
            double w = 0;
            for (int b = 0; b < m->blocks; b++)
                for (int k = 0; k < m->block[b].size; k++) w += m->block[b].g[k] * s->q[m->block[b].first + k];
            double y = m->y - (w - m->unit.target) - m->unit.compliance * m->y;
            y = (y + m->kappa * m->anchor) / (1 + m->kappa);
            y = fmin(fmax(y, m->unit.low), m->unit.high);
            double change = y - m->y;
            m->y = y;
            for (int b = 0; b < m->blocks; b++)
                for (int k = 0; k < m->block[b].size; k++) s->q[m->block[b].first + k] += change * m->block[b].g[k];
        }
    }
}

/* ---- sweeps alone ---- */

/* A contact of free bodies, as sweeps go through them. All that a visit to one with the usual friction reads lies
 * together. */
typedef struct swept_contact {
    pinch_force_element *element;
    bool usual;                                          /* its friction has a disc for its cross section */
    double low, high, friction, limit;                   /* of its law */
    double *q[2];                                        /* a body's; a partner that does not move has one of its own */
    double g[2][PINCH_FORCE_CONTACT * PINCH_FORCE_BODY]; /* zero for such a partner */
    double still[PINCH_FORCE_CONTACT];                   /* w_0 - b */
    double rho[PINCH_FORCE_CONTACT], keep[PINCH_FORCE_CONTACT]; /* 1 - rho C */
    double *r; /* its forces, which lie apart from what threads only read */
} swept_contact;

/* Contacts that follow each other and are those of the same two bodies, -1: what does not move. */
typedef struct meeting {
    int cluster[2], first, count;
} meeting;

static int find_meetings(const pinch_force_system *s, meeting *meetings)
{
    int count = 0;
    for (int k = 0; k < s->contact_count; k++) {
        const int *c = s->clusters ? s->clusters + 2 * k : s->elements[k].cluster;
        meeting *last = count > 0 ? &meetings[count - 1] : NULL;
        if (last && last->cluster[0] == c[0] && last->cluster[1] == c[1])
            last->count++;
        else
            meetings[count++] = (meeting){{c[0], c[1]}, k, 1};
    }
    return count;
}

enum { FAR = INT_MAX / 4 };

/* Finds out for each body over how many contacts it hangs together with what does not move. */
static void find_distances(const meeting *meetings, int count, int bodies, int *distance)
{
    for (int c = 0; c < bodies; c++) distance[c] = FAR;
    bool nearer = true, back = false;
    for (; nearer; back = !back) { /* to and fro, as most contacts are in order */
        nearer = false;
        for (int i = 0; i < count; i++) {
            const int *c = meetings[back ? count - 1 - i : i].cluster;
            for (int side = 0; side < 2; side++) {
                int by_other = c[1 - side] >= 0 ? distance[c[1 - side]] + 1 : 1;
                if (c[side] < 0 || by_other >= distance[c[side]]) continue;
                distance[c[side]] = by_other;
                nearer = true;
            }
        }
    }
}

/* Returns the largest distance of a body that hangs together with what does not move. */
static int farthest_of(const int *distance, int bodies)
{
    int farthest = 0;
    for (int c = 0; c < bodies; c++)
        if (distance[c] < FAR && distance[c] > farthest) farthest = distance[c];
    return farthest;
}

int pinch_force_height(pinch_arena *arena, const pinch_force_system *s)
{
    int bodies = s->mobility->cluster_count, *distance = PINCH_ARENA_ARRAY(arena, int, bodies + 1);
    meeting *found = PINCH_ARENA_ARRAY(arena, meeting, s->contact_count + 1);
    if (arena->failed) return 0;
    find_distances(found, find_meetings(s, found), bodies, distance);
    return farthest_of(distance, bodies);
}

/* Puts meetings in the order of both bodies' distances, those with the same in their own. Returns NULL when memory ran
 * out. */
static meeting *put_in_order(pinch_arena *arena, const meeting *meetings, int count, int bodies)
{
    int *distance = PINCH_ARENA_ARRAY(arena, int, bodies + 1);
    int *first = PINCH_ARENA_ARRAY(arena, int, 2 * bodies + 4);
    meeting *ordered = PINCH_ARENA_ARRAY(arena, meeting, count + 1);
    if (arena->failed) return NULL;
    find_distances(meetings, count, bodies, distance);
    int farthest = farthest_of(distance, bodies);
    for (int c = 0; c < bodies; c++)
        if (distance[c] == FAR) distance[c] = farthest + 1; /* they hang together with nothing */
    memset(first, 0, sizeof *first * (size_t)(2 * bodies + 4));
    for (int pass = 0; pass < 2; pass++) {
        for (int k = 0; k < count; k++) {
            const int *c = meetings[k].cluster;
            int sum = (c[0] >= 0 ? distance[c[0]] : 0) + (c[1] >= 0 ? distance[c[1]] : 0);
            if (pass == 0)
                first[sum + 1]++;
            else
                ordered[first[sum]++] = meetings[k];
        }
        for (int d = 0; d < 2 * bodies + 3 && pass == 0; d++) first[d + 1] += first[d];
    }
    return ordered;
}

/* Gathers what sweeps read of a contact. `none` is q of what does not move; r: where its forces are to be. */
static void gather(const pinch_force_system *s, pinch_force_element *e, double *none, double *r, swept_contact *c)
{
    const double *w0 = pinch_force_values(e, PINCH_FORCE_W0), *b = pinch_force_values(e, PINCH_FORCE_B);
    const double *rho = pinch_force_values(e, PINCH_FORCE_RHO);
    const double *compliance = pinch_force_values(e, PINCH_FORCE_COMPLIANCE);
    c->element = e;
    c->usual = pinch_force_has_disc(e) && e->law->friction[0] < INFINITY;
    if (!c->usual) return;
    c->r = r;
    memcpy(r, pinch_force_values(e, PINCH_FORCE_R), sizeof *r * PINCH_FORCE_CONTACT);
    c->low = e->law->low, c->high = e->law->high;
    c->friction = e->law->friction[0], c->limit = e->law->limit[0];
    for (int side = 0; side < 2; side++) {
        bool moves = e->block[side].size > 0;
        c->q[side] = moves ? s->q + e->block[side].first : none;
        if (moves)
            memcpy(c->g[side], e->block[side].g, sizeof c->g[side]);
        else
            memset(c->g[side], 0, sizeof c->g[side]);
    }
    for (int i = 0; i < PINCH_FORCE_CONTACT; i++) {
        c->still[i] = w0[i] - b[i];
        c->rho[i] = rho[i];
        c->keep[i] = 1 - rho[i] * compliance[i];
    }
}

static inline pinch_lanes row_times(const double *g, const double *q)
{
    return pinch_lanes_at(g) * pinch_lanes_at(q) + pinch_lanes_at(g + 2) * pinch_lanes_at(q + 2) +
           pinch_lanes_at(g + 4) * pinch_lanes_at(q + 4);
}

static inline void visit(swept_contact *restrict c, double h)
{
    double z[PINCH_FORCE_CONTACT], p[PINCH_FORCE_CONTACT], impulse[PINCH_FORCE_CONTACT];
    for (int i = 0; i < PINCH_FORCE_CONTACT; i++) {
        pinch_lanes w =
            row_times(c->g[0] + i * PINCH_FORCE_BODY, c->q[0]) + row_times(c->g[1] + i * PINCH_FORCE_BODY, c->q[1]);
        z[i] = c->keep[i] * c->r[i] - c->rho[i] * (c->still[i] + (w[0] + w[1]));
    }
    p[0] = pinch_within(z[0], c->low, c->high);
    pinch_friction_rows f = {PINCH_FORCE_CONTACT, z, p, NULL, 0};
    (void)pinch_friction_disc_project(f, c->limit + c->friction * p[0], c->friction, 1);
    for (int i = 0; i < PINCH_FORCE_CONTACT; i++) {
        impulse[i] = h * (p[i] - c->r[i]);
        c->r[i] = p[i];
    }
    for (int side = 0; side < 2; side++)
        for (int k = 0; k < PINCH_FORCE_BODY; k += 2) {
            const double *g = c->g[side] + k;
            double *q = c->q[side] + k;
            pinch_lanes_put(pinch_lanes_at(q) + impulse[0] * pinch_lanes_at(g) +
                                impulse[1] * pinch_lanes_at(g + PINCH_FORCE_BODY) +
                                impulse[2] * pinch_lanes_at(g + 2 * PINCH_FORCE_BODY),
                            q);
        }
}

/* Sweeps over contacts in one order. */
typedef struct sweeping {
    pinch_force_system *system;
    swept_contact *contacts; /* in it, */
    double *forces;          /* theirs, */
    int *order, count;       /* and their numbers in the system */
    double *none;            /* q of what does not move; with a crew, one of each contact */
    const meeting *meetings; /* in it */
    int meeting_count, sweeps;
    /* with a crew */
    int *awaited;         /* per stretch: how many contacts the sweep before has to have visited */
    atomic_int *progress; /* per sweep and one before the first: the contacts that it has visited */
    atomic_int next;      /* sweep */
} sweeping;

static void sweep_over(sweeping *w, int first, int end)
{
    for (int i = first; i < end; i++) {
        if (w->contacts[i].usual)
            visit(&w->contacts[i], w->system->step);
        else
            visit_element(w->system, w->contacts[i].element);
    }
}

enum { STRETCH = 32 }; /* contacts that follow each other */

/*
 * Several threads sweep behind each other. A sweep comes to a contact when the one before has visited all contacts of
 * its bodies, which are near in an order by distance: there are layers of the heap between the two, and each body is
 * pushed in the same order as by sweeps one after the other, to the same bits.
 */
static void sweep_behind(void *argument, int first, int end)
{
    sweeping *w = argument;
    (void)first, (void)end;
    for (int sweep; (sweep = atomic_fetch_add(&w->next, 1)) < w->sweeps;)
        for (int i = 0; i < w->count; i += STRETCH) {
            int after = i + STRETCH < w->count ? i + STRETCH : w->count;
            pinch_await(&w->progress[sweep], w->awaited[i / STRETCH]);
            sweep_over(w, i, after);
            pinch_say(&w->progress[sweep + 1], after);
        }
}

/* Finds how far the sweep before has to be. Returns false when memory ran out. */
static bool find_awaited(pinch_arena *arena, sweeping *w)
{
    int *until = PINCH_ARENA_ARRAY(arena, int, w->system->mobility->cluster_count + 1);
    w->awaited = PINCH_ARENA_ARRAY(arena, int, w->count / STRETCH + 1);
    w->progress = PINCH_ARENA_ARRAY(arena, atomic_int, w->sweeps + 1);
    if (arena->failed) return false;
    memset(w->awaited, 0, sizeof *w->awaited * (size_t)(w->count / STRETCH + 1));
    for (int pass = 0; pass < 2; pass++)
        for (int k = 0, first = 0; k < w->meeting_count; first += w->meetings[k++].count)
            for (int side = 0; side < 2; side++) {
                int c = w->meetings[k].cluster[side], end = first + w->meetings[k].count;
                if (c >= 0 && pass == 0) until[c] = end;
                for (int i = first / STRETCH; c >= 0 && pass == 1 && i * STRETCH < end; i++)
                    if (until[c] > w->awaited[i]) w->awaited[i] = until[c];
            }
    for (int k = 0; k <= w->sweeps; k++) atomic_init(&w->progress[k], k == 0 ? w->count : 0);
    return true;
}

static void gather_contacts(void *argument, int first, int end)
{
    const sweeping *w = argument;
    for (int i = first; i < end; i++)
        gather(w->system, &w->system->elements[w->order[i]], w->none, w->forces + PINCH_FORCE_CONTACT * i,
               &w->contacts[i]);
}

static void put_forces_back(void *argument, int first, int end)
{
    const sweeping *w = argument;
    for (int i = first; i < end; i++)
        if (w->contacts[i].usual)
            memcpy(pinch_force_values(w->contacts[i].element, PINCH_FORCE_R), w->contacts[i].r,
                   sizeof *w->forces * PINCH_FORCE_CONTACT);
}

/* Finds an order that suits heaps. Returns false when memory ran out. */
static bool arrange(pinch_arena *arena, sweeping *w)
{
    const pinch_force_system *s = w->system;
    meeting *found = PINCH_ARENA_ARRAY(arena, meeting, w->count + 1);
    if (arena->failed) return false;
    w->meeting_count = find_meetings(s, found);
    w->meetings = put_in_order(arena, found, w->meeting_count, s->mobility->cluster_count);
    if (!w->meetings) return false;
    for (int k = 0, at = 0; k < w->meeting_count; k++)
        for (int i = 0; i < w->meetings[k].count; i++) w->order[at++] = w->meetings[k].first + i;
    return !s->crew || find_awaited(arena, w);
}

bool pinch_force_sweep_alone(pinch_arena *arena, pinch_force_system *s, int count, double *merit)
{
    int nones = PINCH_FORCE_BODY * (s->crew ? s->contact_count : 1);
    sweeping w = {.system = s,
                  .contacts = PINCH_ARENA_ARRAY(arena, swept_contact, s->contact_count + 1),
                  .forces = PINCH_ARENA_ARRAY(arena, double, PINCH_FORCE_CONTACT * s->contact_count + 1),
                  .order = PINCH_ARENA_ARRAY(arena, int, s->contact_count + 1),
                  .count = s->contact_count,
                  .none = PINCH_ARENA_ARRAY(arena, double, nones),
                  .sweeps = count};
    if (arena->failed || !arrange(arena, &w)) return false;
    memset(w.none, 0, sizeof *w.none * (size_t)nones);
    pinch_force_move(s);
    pinch_loop(s->crew, w.count, gather_contacts, &w);
    if (s->crew)
        pinch_all_at_once(s->crew, sweep_behind, &w);
    else
        for (int sweep = 0; sweep < count; sweep++) sweep_over(&w, 0, w.count);
    pinch_loop(s->crew, w.count, put_forces_back, &w);
    *merit = pinch_force_evaluate(s);
    return true;
}
