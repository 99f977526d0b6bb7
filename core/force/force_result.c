#include "force/force_system.h"

#include "kinematics/wrenches.h"
#include "support/extremes.h"

#include <math.h>
#include <string.h>

/* An answer changes these; they are kept to be restored where it is refused. */
typedef struct pinch_force_before {
    double elastic[3], rolling_elastic[2];
    double stiffness[3], damping[3], viscous[2];
    double compliance[3];
} pinch_force_before;

static void keep(const pinch_contact *c, pinch_force_before *before)
{
    memcpy(before->elastic, c->elastic, sizeof c->elastic);
    memcpy(before->rolling_elastic, c->rolling_elastic, sizeof c->rolling_elastic);
    memcpy(before->stiffness, c->stiffness, sizeof c->stiffness);
    memcpy(before->damping, c->damping, sizeof c->damping);
    memcpy(before->viscous, c->viscous, sizeof c->viscous);
    memcpy(before->compliance, c->compliance, sizeof c->compliance);
}

static void restore(const pinch_force_before *before, pinch_contact *c)
{
    memcpy(c->elastic, before->elastic, sizeof c->elastic);
    memcpy(c->rolling_elastic, before->rolling_elastic, sizeof c->rolling_elastic);
    memcpy(c->stiffness, before->stiffness, sizeof c->stiffness);
    memcpy(c->damping, before->damping, sizeof c->damping);
    memcpy(c->viscous, before->viscous, sizeof c->viscous);
    memcpy(c->compliance, before->compliance, sizeof c->compliance);
}

void pinch_force_undo(const pinch_force_system *s)
{
    for (int k = 0; k < s->contact_count && s->before; k++) restore(&s->before[k], s->elements[k].contact);
}

/* A floor that lets a contact sink by more than this is reported; part of the smaller body's size. */
static const double MOST_SUNK = 1e-2;

/* Of a thin body, what it has along the normal is what counts: it may sink by this many times that part of it. */
static const double OF_THICKNESS = 3;

/* Returns the size of a body along a direction (m) by the second moment of its mass: of a ball its diameter, of a plate
 * 1.3 times its thickness. */
static double size_along(const pinch_body *b, const double *direction)
{
    const double *I = b->inertia, *n = direction;
    double turned = 0;
    for (int i = 0; i < 3; i++) turned += n[i] * (I[3 * i] * n[0] + I[3 * i + 1] * n[1] + I[3 * i + 2] * n[2]);
    double moment = 0.5 * (I[0] + I[4] + I[8]) - turned;
    return sqrt(20 * pinch_larger(moment, 0) / b->mass);
}

/* Returns a body's size as far as a contact along the normal may sink by a part of it. */
static double size_for(const pinch_body *b, const double *normal)
{
    return b->mass > 0 ? pinch_smaller(2 * b->radius, OF_THICKNESS * size_along(b, normal)) : 2 * b->radius;
}

/* Returns by how much a floor lets a contact sink, as a part of the smaller body's size. */
static double sunk_share(const pinch_problem *problem, const pinch_contact *c, double depth)
{
    double size = INFINITY;
    if (!(depth > 0)) return 0;
    if (c->body1 >= 0) size = pinch_smaller(size, size_for(&problem->bodies[c->body1], c->normal));
    if (c->body2 >= 0) size = pinch_smaller(size, size_for(&problem->bodies[c->body2], c->normal));
    return depth / size;
}

/* Returns how far (m) the floor lets a contact, as it came, sink beyond what was prescribed. */
static double sinks_by(double h, const pinch_force_element *e, const pinch_contact *c)
{
    double factor = pinch_force_prescribed(c, h, 0) / *pinch_force_values(e, PINCH_FORCE_COMPLIANCE);
    if (!(factor < 1) || !(c->stiffness[0] > 0)) return 0;
    double force = *pinch_force_values(e, PINCH_FORCE_R);
    double lasting = force * (1 / (factor * c->stiffness[0]) - 1 / c->stiffness[0]);
    return pinch_smaller(pinch_smaller(lasting, e->sinks_at_most), pinch_larger(c->depth, 0));
}

/* The contact becomes what was solved, its elastic state and compliance included. */
static void soften(double h, const pinch_force_element *e, pinch_contact *c)
{
    const double *compliance = pinch_force_values(e, PINCH_FORCE_COMPLIANCE);
    double elastic[5], prescribed[PINCH_CONTACT_ROWS_MAX];
    bool used[3] = {false};
    pinch_force_elastic(e, elastic);
    memcpy(c->elastic, elastic, sizeof c->elastic);
    memcpy(c->rolling_elastic, elastic + 3, sizeof c->rolling_elastic);
    for (int i = 0; i < e->rows; i++) prescribed[i] = pinch_force_prescribed(c, h, i);
    for (int i = 0; i < e->rows; i++) {
        int kind = i == 0 ? 0 : i < 3 ? 1 : 2;
        if (kind == 1 && c->viscous[i - 1] > 0) {
            c->viscous[i - 1] = compliance[i];
            continue;
        }
        c->compliance[kind] = compliance[i];
        if (used[kind]) continue; /* one factor for a kind */
        used[kind] = true;
        double factor = prescribed[i] / compliance[i];
        c->stiffness[kind] *= factor;
        c->damping[kind] *= factor;
    }
}

/* Returns by how much a contact's normal force misses the law that was prescribed, in the measure of (53), N: equation
 * (60). */
static double missed_force(double h, const pinch_force_element *e, const pinch_contact *c)
{
    double used = *pinch_force_values(e, PINCH_FORCE_COMPLIANCE), prescribed = pinch_force_prescribed(c, h, 0);
    if (!(used > prescribed)) return 0;
    return *pinch_force_values(e, PINCH_FORCE_R) * (used - prescribed) /
           (prescribed + h * pinch_blocks_norm2(e->block, 0));
}

/* Two bodies that press each other, and the least that a contact of theirs sinks. What does not move has the number
 * behind all bodies. */
typedef struct touch {
    int body[2];
    double sinks;
} touch;

/* Finding touches takes all contacts, of which those of the same two bodies mostly follow each other. */
typedef struct touch_task {
    const pinch_problem *problem;
    const pinch_force_system *system;
    const double *sinks;
    touch *touches;
    int *count; /* per chunk, whose touches begin where its contacts do */
} touch_task;

static void find_touches(void *argument, int first, int end)
{
    const touch_task *task = argument;
    int nowhere = task->problem->body_count;
    touch *touches = task->touches + first;
    int count = 0;
    for (int k = first; k < end; k++) {
        const pinch_contact *c = &task->problem->contacts[k];
        if (!(*pinch_force_values(&task->system->elements[k], PINCH_FORCE_R) > 0)) continue;
        touch t = {{c->body1 >= 0 ? c->body1 : nowhere, c->body2 >= 0 ? c->body2 : nowhere}, task->sinks[k]};
        touch *last = count > 0 ? &touches[count - 1] : NULL;
        if (last && last->body[0] == t.body[0] && last->body[1] == t.body[1])
            last->sinks = pinch_smaller(last->sinks, t.sinks);
        else
            touches[count++] = t;
    }
    task->count[first / PINCH_CHUNK] = count;
}

/* Returns all touches, *count of them. NULL: memory ran out. */
static touch *list_touches(pinch_arena *arena, const pinch_problem *problem, const pinch_force_system *s,
                           const double *sinks, int *count)
{
    int chunks = pinch_chunk_count(problem->contact_count);
    touch_task task = {problem, s, sinks, PINCH_ARENA_ARRAY(arena, touch, problem->contact_count + 1),
                       PINCH_ARENA_ARRAY(arena, int, chunks + 1)};
    *count = 0;
    if (arena->failed) return NULL;
    pinch_loop(s->crew, problem->contact_count, find_touches, &task);
    for (int k = 0; k < chunks; k++) {
        memmove(task.touches + *count, task.touches + k * PINCH_CHUNK, sizeof(touch) * (size_t)task.count[k]);
        *count += task.count[k];
    }
    return task.touches;
}

/*
 * Tells whether floors let a body sink by more than MOST_SUNK of its size though no contact does by itself: in a stack,
 * each course sinks with all below it. A body sinks at least by the least sum of what contacts sink on a way from it to
 * what does not move, because it lies on one of its neighbours at least. Bodies without such a way fall. sinks: of each
 * contact, m. Returns false also when memory ran out, which the arena notes.
 */
static bool bodies_sink(pinch_arena *arena, const pinch_problem *problem, const pinch_force_system *s,
                        const double *sinks)
{
    double sum = 0, smallest = INFINITY;
    for (int k = 0; k < problem->contact_count; k++) sum += sinks[k];
    for (int b = 0; b < problem->body_count; b++) smallest = pinch_smaller(smallest, 2 * problem->bodies[b].radius);
    if (!(sum > MOST_SUNK * smallest)) return false;
    int count;
    double *way = PINCH_ARENA_ARRAY(arena, double, problem->body_count + 1);
    const touch *touches = list_touches(arena, problem, s, sinks, &count);
    if (arena->failed) return false;
    for (int b = 0; b < problem->body_count; b++) way[b] = INFINITY;
    way[problem->body_count] = 0; /* what does not move */
    /* Bellman and Ford's method, to and fro, as contacts of bodies built one after the other mostly are in order */
    bool shorter = true, back = false;
    for (; shorter; back = !back) {
        shorter = false;
        for (int i = 0; i < count; i++) {
            const touch *t = &touches[back ? count - 1 - i : i];
            double to1 = way[t->body[0]], to2 = way[t->body[1]];
            shorter = shorter || to1 > to2 + t->sinks || to2 > to1 + t->sinks;
            if (to1 > to2 + t->sinks) way[t->body[0]] = to2 + t->sinks;
            if (to2 > to1 + t->sinks) way[t->body[1]] = to1 + t->sinks;
        }
    }
    for (int b = 0; b < problem->body_count; b++)
        if (isfinite(way[b]) && way[b] > MOST_SUNK * 2 * problem->bodies[b].radius) return true;
    return false;
}

typedef struct sink_task {
    const pinch_problem *problem;
    const pinch_force_system *system;
    double *sinks;
} sink_task;

static void find_sinks(void *argument, int first, int end)
{
    const sink_task *task = argument;
    for (int k = first; k < end; k++)
        task->sinks[k] = sinks_by(task->problem->step, &task->system->elements[k], &task->problem->contacts[k]);
}

void pinch_force_sinks(const pinch_problem *problem, const pinch_force_system *s, double *sinks)
{
    sink_task task = {problem, s, sinks};
    pinch_loop(s->crew, s->contact_count, find_sinks, &task);
}

bool pinch_force_sinks_far(pinch_arena *arena, const pinch_problem *problem, const pinch_force_system *s,
                           const double *sinks)
{
    for (int k = 0; k < s->contact_count; k++)
        if (sunk_share(problem, &problem->contacts[k], sinks[k]) > MOST_SUNK) return true;
    pinch_arena_mark here = pinch_arena_here(arena);
    bool far = bodies_sink(arena, problem, s, sinks);
    if (!arena->failed) pinch_arena_rewind(arena, &here);
    return far;
}

static void finish_contact(const pinch_force_element *e, double step, const double *q, pinch_contact *c)
{
    const double *z = pinch_force_values(e, PINCH_FORCE_Z), *r = pinch_force_values(e, PINCH_FORCE_R);
    double p[PINCH_CONTACT_ROWS_MAX], w[PINCH_CONTACT_ROWS_MAX];
    pinch_force_element_velocity(e, q, w);
    pinch_contact_state state = pinch_contact_law_project(e->law, pinch_force_values(e, PINCH_FORCE_RHO), z, p, NULL);
    pinch_contact_end end = {.rows = e->rows, .state = state, .force = r, .velocity = w};
    for (int i = 1; i < e->rows; i++) {
        bool sticks = state == PINCH_CONTACT_STICK;
        if (e->rows == 6 && i == 3) sticks = e->inside || fabs(z[i]) <= fabs(r[i]);      /* torsion sticks by itself */
        if (e->rows == 6 && i > 3) sticks = e->inside || (z[4] == p[4] && z[5] == p[5]); /* and so does rolling */
        end.sticking |= (unsigned)sticks << i;
    }
    pinch_contact_law_finish(&end, step, c);
}

/* What reading contacts back takes, and what a chunk of them has found. */
typedef struct read_back_task {
    const pinch_problem *problem;
    pinch_force_system *system;
    double *sinks;
    struct read_back_found {
        double floor_residual, floor_depth, largest, share;
    } * found; /* per chunk */
} read_back_task;

static void read_back_contacts(void *argument, int first, int end)
{
    const read_back_task *task = argument;
    const pinch_problem *problem = task->problem;
    pinch_force_system *s = task->system;
    struct read_back_found found = {0};
    for (int k = first; k < end; k++) {
        pinch_contact *c = &problem->contacts[k];
        keep(c, &s->before[k]);
        found.floor_residual = pinch_larger(missed_force(problem->step, &s->elements[k], c), found.floor_residual);
        found.largest = pinch_larger(found.largest, *pinch_force_values(&s->elements[k], PINCH_FORCE_R));
        task->sinks[k] = sinks_by(problem->step, &s->elements[k], c);
        soften(problem->step, &s->elements[k], c);
        found.floor_depth = pinch_larger(task->sinks[k], found.floor_depth);
        found.share = pinch_larger(sunk_share(problem, c, task->sinks[k]), found.share);
        finish_contact(&s->elements[k], problem->step, s->q, c);
    }
    task->found[first / PINCH_CHUNK] = found;
}

static void read_back_bodies(void *argument, int first, int end)
{
    const read_back_task *task = argument;
    for (int b = first; b < end; b++)
        pinch_mobility_velocity(task->system->mobility, b, task->system->q, task->problem->bodies[b].velocity_end);
}

/* The scale, or what was put aside, has rounded the bounds of the multiplier. */
static void hold_at_bounds(const pinch_force_multiplier *m, pinch_joint_row *row)
{
    if (m->y <= m->unit.low) row->force = row->low;
    if (m->y >= m->unit.high) row->force = row->high;
    row->force = pinch_within(row->force, row->low, row->high);
}

bool pinch_force_read_back(pinch_arena *arena, pinch_problem *problem, pinch_force_system *s, pinch_step_result *result,
                           double *share)
{
    double largest = 0;
    *share = 0;
    s->joints_kept = pinch_force_may_hold_rows(s);
    if (!s->joints_kept) pinch_arena_rewind(arena, &s->built);
    s->before = PINCH_ARENA_ARRAY(arena, pinch_force_before, s->contact_count + 1);
    s->body_scratch = PINCH_ARENA_ARRAY(arena, double, 12 * problem->body_count);
    int chunks = pinch_chunk_count(problem->contact_count);
    read_back_task task = {problem, s, PINCH_ARENA_ARRAY(arena, double, problem->contact_count + 1),
                           PINCH_ARENA_ARRAY(arena, struct read_back_found, chunks + 1)};
    if (arena->failed) return false;
    pinch_each(s->crew, problem->body_count, read_back_bodies, &task);
    pinch_loop(s->crew, problem->contact_count, read_back_contacts, &task);
    for (int k = 0; k < chunks; k++) {
        result->floor_residual = fmax(result->floor_residual, task.found[k].floor_residual);
        result->floor_depth = fmax(result->floor_depth, task.found[k].floor_depth);
        largest = pinch_larger(largest, task.found[k].largest);
        *share = fmax(*share, task.found[k].share);
    }
    result->too_soft = *share > MOST_SUNK || result->floor_residual > PINCH_FORCE_MOST_MISSED * largest ||
                       (!s->answer_counts && bodies_sink(arena, problem, s, task.sinks));
    if (arena->failed) return false;
    for (int j = 0; j < problem->row_count; j++) {
        int e = s->element_of_row[j];
        if (e != -1) problem->rows[j].force = pinch_force_of_row(s, j);
        if (problem->rows[j].continues) {
            problem->rows[j].force = problem->rows[j - 1].force;
            problem->rows[j].pivot = 1;
        }
        if (e > -2) continue;
        const pinch_force_multiplier *m = &s->multipliers[-2 - e];
        if (m->base != 0 || pinch_row_parts(problem, j) > 1) hold_at_bounds(m, &problem->rows[j]);
        problem->rows[j].pivot = 1;
        if (s->dependent_rows) problem->rows[j].violation = m->unit.sigma * pinch_force_given_way(m);
    }
    pinch_joint_forces(problem, s->mobility, s->body_scratch);
    return true;
}
