/*
 * Memory that solves need for themselves: the threads' desks and solvers.
 *
 * A step may need far more of it than those that follow: the first of a heap, whose linear systems are not known yet,
 * or the last before everything rests. What a span of steps has not needed is given back. Where it was missed after
 * that, the next span is twice as long, so that a scene that goes to and fro soon asks for nothing any more; and little
 * is not worth it.
 */
#include "plugin.h"

#include <stdlib.h>

enum { FIRST_SPAN = 8, LONGEST_SPAN = 1 << 20, LITTLE = 1 << 16 /* bytes of a thread's solver, and of each list */ };

static bool reserve(void **items, int *room, int *most, int count, size_t item_size)
{
    if (count > *most) *most = count;
    return pinch_list_reserve(items, room, count, item_size);
}

bool pinch_desk_reserve(pinch_desk *desk, int bodies, int contacts, int rows)
{
    return reserve((void **)&desk->bodies.items, &desk->bodies.room, &desk->bodies.count, bodies, sizeof(pinch_body)) &&
           reserve((void **)&desk->contacts.items, &desk->contacts.room, &desk->contacts.count, contacts,
                   sizeof(pinch_contact)) &&
           reserve((void **)&desk->rows.items, &desk->rows.room, &desk->rows.count, rows, sizeof(pinch_joint_row));
}

/* To the most that was needed, where that is much less; its content is not needed. */
static void trim(void **items, int *room, int *most, size_t item_size)
{
    int needed = *most, least = (int)(LITTLE / item_size);
    *most = 0;
    if (needed < least) needed = least;
    if (needed >= *room - *room / 4) return;
    free(*items);
    *items = NULL;
    *room = 0;
    (void)pinch_list_reserve(items, room, needed, item_size); /* or when it is needed */
}

static size_t bytes_held(const pinch_ode *p)
{
    size_t sum = 0;
    for (int k = 0; k < p->threads; k++)
        sum += pinch_step_solver_memory(p->solver[k], NULL) + pinch_desk_bytes(&p->desk[k]);
    return sum;
}

void pinch_scratch_review(pinch_ode *p)
{
    if (p->scratch_span == 0) p->scratch_span = FIRST_SPAN;
    if (p->step < p->scratch_looked_at + p->scratch_span) return;
    size_t before = bytes_held(p);
    if (p->scratch_missed > 0 && before > p->scratch_missed) {
        if (p->scratch_span < LONGEST_SPAN) p->scratch_span *= 2;
        p->scratch_missed = 0;
    }
    for (int k = 0; k < p->threads; k++) {
        pinch_desk *desk = &p->desk[k];
        pinch_step_solver_trim(p->solver[k], LITTLE);
        trim((void **)&desk->bodies.items, &desk->bodies.room, &desk->bodies.count, sizeof(pinch_body));
        trim((void **)&desk->contacts.items, &desk->contacts.room, &desk->contacts.count, sizeof(pinch_contact));
        trim((void **)&desk->rows.items, &desk->rows.room, &desk->rows.count, sizeof(pinch_joint_row));
    }
    size_t after = bytes_held(p);
    if (after < before) p->scratch_missed = after + (before - after) / 2;
    p->scratch_looked_at = p->step;
}
