/* Builds the system of a problem: rows in reduced coordinates, and laws. */
#include "force/force_system.h"

#include <math.h>
#include <string.h>

/* The block has one row. */
static double block_norm2(const pinch_row_block *block)
{
    double sum = 0;
    for (int k = 0; k < block->size; k++) sum += block->g[k] * block->g[k];
    return sum;
}

/* The values of an element, and what may come behind them, are aligned for lanes. */
static int value_room(int rows)
{
    return (pinch_force_value_count(rows) + 1) / 2 * 2;
}

/* Gives an element its law, and room for the values of its rows. Returns false when memory runs out. */
static bool make_room(pinch_arena *arena, const pinch_contact_law *law, pinch_force_element *e)
{
    e->law = law;
    e->rows = law->rows;
    e->values = PINCH_ARENA_ARRAY(arena, double, value_room(law->rows));
    return e->values != NULL;
}

static void clear_values(const pinch_force_element *e)
{
    memset(e->values, 0, (size_t)pinch_force_value_count(e->rows) * sizeof *e->values);
}

/* Each law of an island is kept once; where there are many, contacts look for theirs among the last few. */
enum { LAST_LAWS = 4 };
typedef struct laws {
    const pinch_contact_law *last[LAST_LAWS];
    int next;
} laws;

/* Returns NULL when memory runs out. */
static const pinch_contact_law *law_of(pinch_arena *arena, const pinch_contact *contact, laws *known)
{
    pinch_contact_law law;
    pinch_contact_law_of(contact, 0, &law);
    for (int i = 0; i < LAST_LAWS; i++)
        if (known->last[i] && memcmp(known->last[i], &law, sizeof law) == 0) return known->last[i];
    pinch_contact_law *kept = PINCH_ARENA_ARRAY(arena, pinch_contact_law, 1);
    if (!kept) return NULL;
    *kept = law;
    known->last[known->next++ % LAST_LAWS] = kept;
    return kept;
}

static void begin_element(pinch_contact *contact, pinch_force_element *e)
{
    memset(e, 0, sizeof *e);
    e->contact = contact;
    e->sinks_at_most = INFINITY;
}

/* Returns w0 as the rows are added to. */
static double *begin_rows(const pinch_force_element *e)
{
    double *w0 = pinch_force_values(e, PINCH_FORCE_W0);
    clear_values(e);
    memcpy(w0, e->contact->surface_velocity, sizeof *w0 * (size_t)e->rows);
    return w0;
}

static bool add_contact(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility, laws *known,
                        pinch_force_element *e)
{
    const pinch_contact_law *law = law_of(arena, e->contact, known);
    return law && make_room(arena, law, e) &&
           pinch_contact_rows(arena, mobility, problem->bodies, e->contact, e->block, e->cluster, begin_rows(e));
}

/* ---- contacts between single bodies, by all threads ---- */

typedef struct contact_task {
    const pinch_problem *problem;
    const pinch_force_system *system;
    const pinch_contact_law **law; /* per contact, where it is not that of the one before */
    bool *as_before;               /* per contact: it is, within a chunk */
    size_t *room;                  /* per chunk: doubles; later how many the chunks before have */
    double *all;
} contact_task;

static void look_at_contacts(void *argument, int first, int end)
{
    const contact_task *task = argument;
    pinch_contact_law law[2];
    size_t room = 0;
    for (int k = first; k < end; k++) {
        const pinch_contact *c = &task->problem->contacts[k];
        pinch_contact_law_of(c, 0, &law[k % 2]);
        task->as_before[k] = k > first && memcmp(&law[0], &law[1], sizeof law[0]) == 0;
        room += (size_t)(value_room(law[k % 2].rows) + pinch_contact_rows_room(task->system->mobility, c));
    }
    task->room[first / PINCH_CHUNK] = room;
}

static void place_contacts(void *argument, int first, int end)
{
    const contact_task *task = argument;
    const pinch_mobility *mobility = task->system->mobility;
    double *room = task->all + task->room[first / PINCH_CHUNK];
    const pinch_contact_law *law = NULL;
    for (int k = first; k < end; k++) {
        pinch_force_element *e = &task->system->elements[k];
        begin_element(&task->problem->contacts[k], e);
        e->law = law = task->as_before[k] ? law : task->law[k];
        e->rows = law->rows;
        e->values = room;
        room += value_room(law->rows);
        pinch_contact_rows_place(mobility, e->contact, room, e->block, e->cluster);
        room += pinch_contact_rows_room(mobility, e->contact);
        pinch_contact_rows_fill(mobility, task->problem->bodies, e->contact, e->block, begin_rows(e));
    }
}

/* Returns false when memory runs out. */
static bool share_contacts(pinch_arena *arena, const pinch_problem *problem, const pinch_force_system *s)
{
    int count = problem->contact_count, chunks = pinch_chunk_count(count);
    laws known = {.next = 0};
    contact_task task = {problem,
                         s,
                         PINCH_ARENA_ARRAY(arena, const pinch_contact_law *, count + 1),
                         PINCH_ARENA_ARRAY(arena, bool, count + 1),
                         PINCH_ARENA_ARRAY(arena, size_t, chunks + 1),
                         NULL};
    size_t all = 0;
    if (arena->failed) return false;
    pinch_loop(s->crew, count, look_at_contacts, &task);
    for (int k = 0; k < chunks; k++) {
        size_t room = task.room[k];
        task.room[k] = all;
        all += room;
    }
    for (int k = 0; k < count; k++)
        if (!task.as_before[k] && !(task.law[k] = law_of(arena, &problem->contacts[k], &known))) return false;
    task.all = PINCH_ARENA_ARRAY(arena, double, all + 1);
    if (!task.all) return false;
    pinch_loop(s->crew, count, place_contacts, &task);
    return true;
}

/* Adds the contacts. Returns false when memory runs out. */
static bool add_contacts(pinch_arena *arena, const pinch_problem *problem, pinch_force_system *s)
{
    laws known = {.next = 0};
    s->element_count = problem->contact_count;
    if (s->crew && pinch_all_clusters_single(s->mobility)) return share_contacts(arena, problem, s);
    for (int k = 0; k < problem->contact_count; k++) {
        begin_element(&problem->contacts[k], &s->elements[k]);
        if (!add_contact(arena, problem, s->mobility, &known, &s->elements[k])) return false;
    }
    return true;
}

/* The block where the row acts most comes first. */
static void home_first(pinch_row_block block[2], int cluster[2])
{
    if (cluster[1] < 0 || !(block_norm2(&block[1]) > block_norm2(&block[0]))) return;
    pinch_row_block swapped = block[0];
    int other = cluster[0];
    block[0] = block[1];
    cluster[0] = cluster[1];
    block[1] = swapped;
    cluster[1] = other;
}

static bool add_compliant_row(pinch_arena *arena, const pinch_mobility *mobility, const pinch_joint_row *row,
                              pinch_force_element *e)
{
    double w0 = 0;
    memset(e, 0, sizeof *e);
    if (!pinch_joint_row_reduce(arena, mobility, row, e->block, e->cluster, &w0)) return false;
    home_first(e->block, e->cluster);
    pinch_contact_law *law = PINCH_ARENA_ARRAY(arena, pinch_contact_law, 1);
    if (!law) return false;
    memset(law, 0, sizeof *law);
    law->rows = 1;
    law->low = row->low;
    law->high = row->high;
    if (!make_room(arena, law, e)) return false;
    clear_values(e);
    *pinch_force_values(e, PINCH_FORCE_W0) = w0;
    *pinch_force_values(e, PINCH_FORCE_B) = row->rhs;
    *pinch_force_values(e, PINCH_FORCE_COMPLIANCE) = row->cfm;
    return true;
}

static bool add_multiplier(pinch_arena *arena, double step, const pinch_mobility *mobility, const pinch_joint_row *row,
                           int parts, pinch_force_multiplier *m)
{
    double w0 = 0;
    memset(m, 0, sizeof *m);
    m->block = PINCH_ARENA_ARRAY(arena, pinch_row_block, 2 * parts);
    m->cluster = PINCH_ARENA_ARRAY(arena, int, 2 * parts);
    if (arena->failed) return false;
    if (parts > 1) {
        m->blocks = pinch_coupling_reduce(arena, mobility, row, parts, m->block, m->cluster, &w0);
        if (m->blocks < 0) return false;
    } else {
        if (!pinch_joint_row_reduce(arena, mobility, row, m->block, m->cluster, &w0)) return false;
        m->blocks = m->cluster[1] >= 0 ? 2 : m->cluster[0] >= 0 ? 1 : 0;
    }
    /* with length 0 its target, bounds and y stay 0 */
    (void)pinch_unit_row_make(row, step, w0, m->block, m->blocks, &m->unit);
    return true;
}

/* Returns the trace of a body's inverse inertia, an upper bound of what a moment along any axis turns, which does not
 * change as the body turns. */
static double most_turned(const pinch_body *b)
{
    const double *I = b->inertia;
    double minors[3] = {I[4] * I[8] - I[5] * I[7], I[0] * I[8] - I[2] * I[6], I[0] * I[4] - I[1] * I[3]};
    double determinant = I[0] * minors[0] - I[1] * (I[3] * I[8] - I[5] * I[6]) + I[2] * (I[3] * I[7] - I[4] * I[6]);
    return (minors[0] + minors[1] + minors[2]) / determinant;
}

static double most_turned_of_all(const pinch_problem *problem)
{
    double most = 0;
    for (int b = 0; b < problem->body_count; b++)
        if (problem->bodies[b].mass > 0) most = fmax(most, most_turned(&problem->bodies[b]));
    return most;
}

/* Returns the power of ten by which all yields are multiplied. The factors of the matrix need some of them; where the
 * proportions or the whole changed as the bodies turn, a mechanism would get energy from it. */
static double common_factor(const pinch_problem *problem)
{
    static const double LEAST = 2e-14; /* of kappa */
    double turned = most_turned_of_all(problem), least = INFINITY, factor = 1;
    for (int j = 0; j < problem->row_count; j++)
        if (problem->rows[j].yield > 0) least = fmin(least, problem->rows[j].yield / problem->step);
    while (factor * least < 2 * turned * LEAST && isfinite(turned)) factor *= 10;
    return factor;
}

/* Sets kappa of equation (54), from the row's own yield where it has one. Where rows do not depend on each other, kappa
 * keeps the matrix regular and is no part of the law. */
static void set_proximal_terms(pinch_force_system *s, const pinch_problem *problem)
{
    static const double PROXIMAL = 1e-7, NEARLY_NONE = 1e-10;
    double factor = s->dependent_rows ? common_factor(problem) / problem->step : 0;
    for (int j = 0; j < problem->row_count; j++) {
        if (s->element_of_row[j] > -2) continue;
        pinch_force_multiplier *m = &s->multipliers[-2 - s->element_of_row[j]];
        double sigma2 = m->unit.sigma * m->unit.sigma, yield = problem->rows[j].yield;
        bool own = s->dependent_rows && yield > 0 && sigma2 > 0;
        if (m->unit.compliance > NEARLY_NONE) continue; /* its own keeps the matrix regular: kappa is 0 */
        bool bounded = m->unit.low > -INFINITY || m->unit.high < INFINITY; /* others are independent, if none depends */
        m->kappa = own ? factor * yield / sigma2 : s->dependent_rows ? PROXIMAL : bounded ? NEARLY_NONE : 0;
    }
}

static void copy_clusters(void *argument, int first, int end)
{
    const pinch_force_system *s = argument;
    for (int k = first; k < end; k++)
        for (int side = 0; side < 2; side++) s->clusters[2 * k + side] = s->elements[k].cluster[side];
}

/* Lists the elements of each cluster. Returns false when memory ran out. */
static bool find_meetings(pinch_arena *arena, pinch_force_system *s)
{
    int clusters = s->mobility->cluster_count, count = 2 * s->element_count;
    s->meet_first = PINCH_ARENA_ARRAY(arena, int, clusters + 2);
    s->meets = PINCH_ARENA_ARRAY(arena, int, count + 1);
    s->clusters = PINCH_ARENA_ARRAY(arena, int, count + 1);
    if (arena->failed) return false;
    pinch_each(s->crew, s->element_count, copy_clusters, s);
    memset(s->meet_first, 0, sizeof(int) * (size_t)(clusters + 2));
    int *next = s->meet_first + 1; /* where the next one goes; in the end, where those of the next cluster begin */
    for (int i = 0; i < count; i++)
        if (s->clusters[i] >= 0) next[s->clusters[i] + 1]++;
    for (int c = 0; c < clusters; c++) next[c + 1] += next[c];
    for (int i = 0; i < count; i++)
        if (s->clusters[i] >= 0) s->meets[next[s->clusters[i]]++] = i;
    return true;
}

bool pinch_force_system_build(pinch_arena *arena, pinch_problem *problem, const pinch_mobility *mobility,
                              pinch_force_system *s)
{
    *s = (pinch_force_system){.step = problem->step, .orders = s->orders};
    s->bodies = problem->bodies;
    s->mobility = mobility;
    s->dependent_rows = mobility->dependent_count > 0;
    s->kept_rows = mobility->kept_count > 0;
    s->contact_count = problem->contact_count;
    s->elements = PINCH_ARENA_ARRAY(arena, pinch_force_element, problem->contact_count + problem->row_count + 1);
    s->multipliers = PINCH_ARENA_ARRAY(arena, pinch_force_multiplier, problem->row_count + 1);
    s->element_of_row = PINCH_ARENA_ARRAY(arena, int, problem->row_count + 1);
    s->q = PINCH_ARENA_ARRAY(arena, double, mobility->unknowns + 1);
    if (s->dependent_rows) {
        s->base_q = PINCH_ARENA_ARRAY(arena, double, mobility->unknowns + 1);
        s->exact_q = PINCH_ARENA_ARRAY(arena, pinch_double_double, mobility->unknowns + 1);
    }
    s->crew = problem->crew;
    s->partials = PINCH_ARENA_ARRAY(arena, pinch_force_partial,
                                    pinch_chunk_count(problem->contact_count + problem->row_count) + 1);
    if (arena->failed) return false;
    if (!add_contacts(arena, problem, s)) return false;
    for (int j = 0; j < problem->row_count; j++) {
        const pinch_joint_row *row = &problem->rows[j];
        s->element_of_row[j] = -1;
        if (mobility->eliminated[j] || row->continues) continue;
        int parts = pinch_row_parts(problem, j);
        bool compliant = row->cfm > 0 && parts == 1;
        s->element_of_row[j] = compliant ? s->element_count : -2 - s->multiplier_count;
        if (compliant ? !add_compliant_row(arena, mobility, row, &s->elements[s->element_count++])
                      : !add_multiplier(arena, s->step, mobility, row, parts, &s->multipliers[s->multiplier_count++]))
            return false;
    }
    set_proximal_terms(s, problem);
    if (s->crew && !find_meetings(arena, s)) return false;
    s->built = pinch_arena_here(arena);
    return true;
}
