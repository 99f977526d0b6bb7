/* What an answer says of contacts is read out, and added up to the wrenches on bodies. */
#include "islands/island_life.h"

#include "support/await.h"
#include "support/extremes.h"
#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* Adds a contact force to what its body will get. */
static void add_wrench(pinch_step_body *body, const double *point, const double *force, double sign)
{
    double arm[3], torque[3];
    pinch_v3_sub(point, body->position, arm);
    pinch_v3_cross(arm, force, torque);
    pinch_v3_add_scaled(body->wrench, sign, force);
    pinch_v3_add_scaled(body->wrench + 3, sign, torque);
}

/* An infinite coefficient gives nothing where there is no normal force. */
static double limit_at(double limit, double coefficient, double normal_force)
{
    return normal_force > 0 ? limit + coefficient * normal_force : limit;
}

static double smaller_limit(const pinch_contact *c)
{
    double limit[2];
    for (int i = 0; i < 2; i++) limit[i] = limit_at(c->friction_limit[i], c->friction[i], c->force[0]);
    return limit[0] < limit[1] ? limit[0] : limit[1];
}

/* The solve has no rows for the tangential motion of a contact without friction: nothing depends on it there. Such a
 * contact slides with all of that motion while it presses. */
static void read_out_sliding(const pinch_problem *problem, const pinch_contact *c, pinch_ode_contact *out)
{
    double t2[3], moved[3] = {0, 0, 0}, arm[3], turned[3];
    const int body[2] = {c->body1, c->body2};
    for (int side = 0; side < 2; side++) {
        if (body[side] < 0) continue;
        const pinch_body *b = &problem->bodies[body[side]];
        pinch_v3_sub(c->position, b->position, arm);
        pinch_v3_cross(b->velocity_end + 3, arm, turned);
        pinch_v3_add_scaled(moved, side ? -1 : 1, b->velocity_end);
        pinch_v3_add_scaled(moved, side ? -1 : 1, turned);
    }
    pinch_v3_cross(c->normal, c->tangent1, t2);
    pinch_v3_add_scaled(moved, c->surface_velocity[1], c->tangent1);
    pinch_v3_add_scaled(moved, c->surface_velocity[2], t2);
    pinch_v3_make_perpendicular(moved, c->normal);
    pinch_v3_add_scaled(out->relative_velocity, 1, moved);
    if (!(c->force[0] > 0)) return;
    if (out->state == PINCH_CONTACT_STICK) out->state = PINCH_CONTACT_SLIP;
    pinch_v3_add_scaled(out->slip, problem->step, moved);
}

static double torsion_limit(const pinch_contact *c)
{
    return c->model < PINCH_CONTACT_SOFT ? 0 : limit_at(c->friction_limit[2], c->torsional_friction, c->force[0]);
}

/* Computes the vector that has these components along two tangents. */
static void in_plane(const double *t1, const double *t2, const double component[2], double *vector)
{
    double a = component[0], b = component[1];
    for (int i = 0; i < 3; i++) vector[i] = t1[i] * a + t2[i] * b;
}

/* Copies the solution of one contact into the read-out. */
static void read_out(const pinch_contact *c, pinch_ode_contact *out)
{
    double t1[3], t2[3];
    pinch_v3_copy(t1, c->tangent1);
    pinch_v3_cross(c->normal, t1, t2);
    pinch_v3_copy(out->position, c->position);
    pinch_v3_copy(out->normal, c->normal);
    pinch_v3_copy(out->stiffness, c->stiffness);
    out->depth = c->depth;
    out->normal_force = c->force[0];
    out->torsion = c->force[3];
    out->twist = c->elastic_end[2];
    out->slip_twist = c->slip[2];
    out->spin = c->relative_velocity[3];
    out->friction_limit = c->model == PINCH_CONTACT_FRICTIONLESS ? 0 : smaller_limit(c);
    out->torsion_limit = torsion_limit(c);
    out->state = c->state;
    in_plane(t1, t2, c->force + 1, out->tangential);
    in_plane(t1, t2, c->elastic_end, out->elastic);
    if (c->slip[0] == 0 && c->slip[1] == 0) /* exactly: it sticks, or does not touch */
        pinch_v3_set(out->slip, 0, 0, 0);
    else
        in_plane(t1, t2, c->slip, out->slip);
    for (int i = 0; i < 3; i++) {
        out->force[i] = c->normal[i] * c->force[0] + out->tangential[i];
        out->relative_velocity[i] =
            c->normal[i] * c->relative_velocity[0] + t1[i] * c->relative_velocity[1] + t2[i] * c->relative_velocity[2];
    }
    pinch_v3_set(out->rolling_moment, 0, 0, 0);
    if (c->model == PINCH_CONTACT_ROLLING) in_plane(t1, t2, c->rolling_moment, out->rolling_moment);
}

static void name_result(const pinch_pair *pair, pinch_ode_contact *out)
{
    out->geom1 = pair->id[0];
    out->geom2 = pair->id[1];
    out->body1 = pair->body[0];
    out->body2 = pair->body[1];
}

/* Keeps the shear that locks as a contact becomes stiffer by its parameters, unless it has let go. What slips, or moves
 * without a force, forgets as much of it. */
static void lock_shear(double step, const pinch_contact *c, pinch_manifold_point *point)
{
    pinch_own_law *own = point->own;
    double now = c->compliance[1], before = own->stiffens_from;
    if (point->locks) pinch_v3_scale(own->locked, 1 - own->unlocks);
    if (own->yields < own->yielded && now < before && (c->elastic[0] != 0 || c->elastic[1] != 0)) {
        pinch_v3_add_scaled(own->locked, 1 - now / before, point->elastic);
        own->locked_from = pinch_larger(own->yielded, own->locked_from);
        point->locks = true;
    }
    if (!point->locks) return;
    const double *w = c->relative_velocity + 1;
    double way = c->force[0] > 0 ? hypot(c->slip[0], c->slip[1]) : step * hypot(w[0], w[1]);
    double length = pinch_v3_norm(own->locked);
    point->locks = length > way;
    if (point->locks)
        pinch_v3_scale(own->locked, 1 - way / length);
    else
        own->locked[0] = own->locked[1] = own->locked[2] = own->locked_from = own->unlocks = 0;
}

/* Keeps what only a point with surface parameters of its own has. */
static void keep_own_law(double step, const pinch_contact *c, const double *rolling_moment, pinch_manifold_point *point)
{
    pinch_own_law *own = point->own;
    pinch_rolling *rolling = pinch_rolling_of(point);
    double t2[3];
    pinch_v3_cross(c->normal, c->tangent1, t2);
    if (rolling) in_plane(c->tangent1, t2, c->rolling_elastic_end, rolling->rolled);
    if (rolling) pinch_v3_copy(rolling->moment, rolling_moment);
    lock_shear(step, c, point);
    own->yielded = own->yields;
    pinch_v3_copy(own->compliance, c->compliance);
    own->step = step;
    own->floor = c->floor;
    own->hold = c->hold;
    own->hold_span = c->hold_span;
    own->carried_at = own->carries_at;
    own->closed_at = own->closes_at;
}

/* Adds a result's force and torques to what the bodies will get. */
static void add_wrenches(const pinch_step_bodies *bodies, const pinch_pair *pair, const pinch_ode_contact *out)
{
    for (int side = 0; side < 2; side++) {
        if (pair->step_body[side] < 0) continue;
        double sign = side ? -1 : 1;
        pinch_step_body *body = &bodies->items[pair->step_body[side]];
        add_wrench(body, out->position, out->force, sign);
        if (out->torsion != 0) pinch_v3_add_scaled(body->wrench + 3, sign * out->torsion, out->normal);
        pinch_v3_add_scaled(body->wrench + 3, sign, out->rolling_moment);
    }
}

typedef struct read_task {
    const pinch_contact_store *contacts;
    const pinch_step_bodies *bodies;
    pinch_island *island;
    const pinch_problem *problem;
    bool reads, adds; /* results are read out; bodies get their forces, in the order of contacts */
} read_task;

static void read_out_pairs(const read_task *task, int first, int end)
{
    const pinch_problem *problem = task->problem;
    const pinch_contact_store *contacts = task->contacts;
    const pinch_range pairs = task->island->pairs;
    const bool reads = task->reads, adds = task->adds;
    for (int i = first; i < end; i++) {
        const pinch_pair *pair = pinch_island_pair(contacts, pairs, i);
        pinch_prefetch_island_pairs(contacts, pairs, i,
                                    reads ? PINCH_READS_RESULTS | PINCH_READS_OWN_LAWS : PINCH_READS_RESULTS);
        for (int k = 0; k < pair->manifold.count; k++) {
            const pinch_contact *c = &problem->contacts[pair->first_in_island + k];
            pinch_ode_contact *out = &contacts->results.items[pair->first_result + k];
            if (reads) {
                name_result(pair, out);
                read_out(c, out);
                if (c->model == PINCH_CONTACT_FRICTIONLESS) read_out_sliding(problem, c, out);
                if (!pair->has_material) keep_own_law(problem->step, c, out->rolling_moment, &pair->manifold.point[k]);
            }
            if (!adds) continue;
            add_wrenches(task->bodies, pair, out);
            if (out->depth > task->island->depth_max) task->island->depth_max = out->depth;
        }
    }
}

/* Pairs that threads share, in runs that follow each other. */
enum { RUNS = 64 };
typedef struct shared_answer {
    read_task reads, adds;
    int count;
    atomic_int next;       /* run that nobody has begun to read */
    atomic_int come;       /* threads: the first one adds */
    atomic_int done[RUNS]; /* per run */
} shared_answer;

static void do_run(const shared_answer *s, int run, const read_task *task)
{
    long long count = s->count;
    read_out_pairs(task, (int)(count * run / RUNS), (int)(count * (run + 1) / RUNS));
}

/* Reads the next run. Returns false where there is none. */
static bool read_next(shared_answer *s)
{
    int run = atomic_fetch_add(&s->next, 1);
    if (run >= RUNS) return false;
    do_run(s, run, &s->reads);
    pinch_say(&s->done[run], 1);
    return true;
}

/* Bodies get the forces of a run as soon as it has been read out, and those before it, from one thread. It reads runs
 * itself while the next one is not done. */
static void share_answer(void *argument, int first, int end)
{
    shared_answer *s = argument;
    (void)first, (void)end;
    bool adds = atomic_fetch_add(&s->come, 1) == 0, left = true;
    for (int run = 0; adds && run < RUNS; run++) {
        while (left && atomic_load(&s->done[run]) == 0) left = read_next(s);
        pinch_await(&s->done[run], 1);
        do_run(s, run, &s->adds);
    }
    while (left) left = read_next(s);
}

void pinch_read_out_contacts(const pinch_contact_store *contacts, const pinch_step_bodies *bodies, pinch_island *island,
                             const pinch_problem *problem)
{
    read_task task = {contacts, bodies, island, problem, true, !problem->crew};
    if (!problem->crew) {
        read_out_pairs(&task, 0, island->pairs.count);
        return;
    }
    shared_answer s = {.reads = task, .adds = {contacts, bodies, island, problem, false, true}};
    s.count = island->pairs.count;
    pinch_all_at_once(problem->crew, share_answer, &s);
}

void pinch_leave_unsolved(pinch_contact_store *contacts, pinch_island *island)
{
    if (island->phase != PINCH_ISLAND_ASLEEP) island->phase = PINCH_ISLAND_FALLBACK;
    for (int i = 0; i < island->pairs.count; i++) {
        const pinch_pair *pair = pinch_island_pair(contacts, island->pairs, i);
        for (int k = 0; k < pair->manifold.count; k++) {
            pinch_ode_contact *out = &contacts->results.items[pair->first_result + k];
            memset(out, 0, sizeof *out);
            name_result(pair, out);
        }
    }
}
