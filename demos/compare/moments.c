#include "moments.h"

#include "common/vector.h"

#include <stdlib.h>
#include <string.h>

const char *moment_reason_text(moment_reason reason)
{
    static const char *const texts[] = {"even", "state change", "load change"};
    return texts[reason];
}

bool moments_start(moment_watch *m, const world *w, long steps)
{
    size_t n = (size_t)steps + 1, fingers = (size_t)w->finger_count;
    memset(m, 0, sizeof *m);
    m->w = w;
    m->steps = steps;
    m->change = calloc(n, sizeof *m->change);
    m->turned = calloc(n, sizeof *m->turned);
    m->last = calloc(3 * fingers, sizeof *m->last);
    m->state = calloc(fingers, sizeof *m->state);
    return m->change && m->turned && m->last && m->state;
}

void moments_free(moment_watch *m)
{
    free(m->change);
    free(m->turned);
    free(m->last);
    free(m->state);
}

void moments_after_step(moment_watch *m)
{
    long step = m->w->steps;
    for (int f = 0; f < m->w->finger_count; f++) {
        const world_finger_state *s = &m->w->fingers[f].state;
        double change[3];
        scene_subtract(s->force, m->last + 3 * f, change);
        m->change[step - 1] += scene_norm(change);
        if (step > 1 && s->state != m->state[f]) m->turned[step - 1] = true;
        scene_copy(s->force, m->last + 3 * f);
        m->state[f] = s->state;
    }
}

static bool near_one(const moment *chosen, int count, long step, long gap)
{
    for (int i = 0; i < count; i++)
        if (labs(chosen[i].step - step) <= gap) return true;
    return false;
}

static int by_step(const void *a, const void *b)
{
    long x = ((const moment *)a)->step, y = ((const moment *)b)->step;
    return (x > y) - (x < y);
}

int moments_choose(const moment_watch *m, int most, moment *chosen)
{
    int count = 0, even = (most + 1) / 2, turns = even + (most - even) / 2;
    long gap = m->steps / (8L * most + 1);
    for (int i = 1; i <= even; i++) { /* the last is the run's last step */
        long step = (m->steps * i + even - 1) / even;
        if (step >= 1 && !near_one(chosen, count, step, 0)) chosen[count++] = (moment){step, MOMENT_EVEN};
    }
    for (long step = 1; step <= m->steps && count < turns; step++)
        if (m->turned[step - 1] && !near_one(chosen, count, step, gap)) chosen[count++] = (moment){step, MOMENT_STATE};
    while (count < most) {
        long best = 0;
        for (long step = 1; step <= m->steps; step++)
            if (m->change[step - 1] > (best ? m->change[best - 1] : 0) && !near_one(chosen, count, step, gap))
                best = step;
        if (!best) break;
        chosen[count++] = (moment){best, MOMENT_LOAD};
    }
    qsort(chosen, (size_t)count, sizeof *chosen, by_step);
    return count;
}
