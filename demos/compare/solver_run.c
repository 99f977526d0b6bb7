#include "solver_run.h"

#include "common/measure.h"
#include "common/vector.h"

#include <stdlib.h>
#include <string.h>

/* ---- What is recorded while a run goes on. ---- */

static void pose_of(const world *w, double pose[7])
{
    memcpy(pose, dBodyGetPosition(w->object), 3 * sizeof *pose);
    memcpy(pose + 3, dBodyGetQuaternion(w->object), 4 * sizeof *pose);
}

/* The angle of the rotation from orientation a to b. */
static double angle_between(const double a[4], const double b[4])
{
    const double back[4] = {a[0], -a[1], -a[2], -a[3]};
    double turn[4];
    scene_quaternion_product(b, back, turn);
    return 2 * atan2(scene_norm(turn + 1), fabs(turn[0]));
}

bool observer_start(observer *r, const world *w, long steps)
{
    size_t fingers = (size_t)w->finger_count;
    memset(r, 0, sizeof *r);
    r->w = w;
    r->steps = steps;
    r->stride = steps / OBSERVER_POINTS + 1;
    r->columns = OBSERVER_FINGERS + OBSERVER_PER_FINGER * w->finger_count;
    for (int i = 0; i < METRIC_THRESHOLDS; i++) r->passed[i] = NAN;
    r->history = calloc(6 * fingers, sizeof *r->history);
    r->noise = calloc(fingers, sizeof *r->noise);
    r->curve = calloc((size_t)(OBSERVER_POINTS + 2) * (size_t)r->columns, sizeof *r->curve);
    r->poses = calloc((size_t)steps + 1, sizeof *r->poses);
    pose_of(w, r->start);
    return r->history && r->noise && r->curve && r->poses;
}

void observer_free(observer *r)
{
    free(r->history);
    free(r->noise);
    free(r->curve);
    free(r->poses);
}

void observer_before_step(observer *r)
{
    memcpy(r->before, dBodyGetLinearVel(r->w->object), 3 * sizeof *r->before);
    memcpy(r->before + 3, dBodyGetAngularVel(r->w->object), 3 * sizeof *r->before);
    memcpy(r->centre, dBodyGetPosition(r->w->object), sizeof r->centre);
    body_world_inertia(r->w->object, r->inertia);
}

/* The inertia matrix is symmetric but for rounding. It is read by columns here and in `gyroscopic`. */
static void times(const double matrix[9], const double v[3], double out[3])
{
    for (int i = 0; i < 3; i++) out[i] = matrix[i] * v[0] + matrix[3 + i] * v[1] + matrix[6 + i] * v[2];
}

/*
 * h times ODE's gyroscopic torque: I y - L with (I - h [L]x) y = L, L = I w. Solved by the fixed point
 * I y = L + h L x y, whose change falls by h |w| a round.
 */
static void gyroscopic(const double inertia[9], const double w[3], double h, double impulse[3])
{
    double L[3], y[3], Iy[3], a[3], b[3], c[3], t[3];
    times(inertia, w, L);
    memcpy(y, w, sizeof y);
    for (int i = 0; i < 3; i++) a[i] = inertia[3 * i], b[i] = inertia[3 * i + 1], c[i] = inertia[3 * i + 2];
    scene_cross(b, c, t);
    double determinant = scene_dot(a, t);
    for (int round = 0; round < 60; round++) {
        double turned[3], rhs[3], next[3], change = 0;
        scene_cross(L, y, turned);
        for (int i = 0; i < 3; i++) rhs[i] = L[i] + h * turned[i];
        next[0] = scene_dot(rhs, t) / determinant;
        scene_cross(c, a, Iy);
        next[1] = scene_dot(rhs, Iy) / determinant;
        scene_cross(a, b, Iy);
        next[2] = scene_dot(rhs, Iy) / determinant;
        for (int i = 0; i < 3; i++) change = fmax(change, fabs(next[i] - y[i]));
        memcpy(y, next, sizeof y);
        if (change == 0) break;
    }
    times(inertia, y, Iy);
    for (int i = 0; i < 3; i++) impulse[i] = Iy[i] - L[i];
}

/* The part of the object's change of momentum that the reported forces do not account for. In dimension 2 only what
 * moves in the plane counts. */
static void balance(observer *r)
{
    const world *w = r->w;
    double force[3], moment[3], moved[3], shifted[3], left[3], turning[3], change[3], turned[3], impulse[3];
    double h = w->scene->step;
    double contact[3], about[3];
    world_external_wrench(w, 0, force, moment);
    world_contact_wrench(w, 0, contact, about);
    /* The moments were taken about the centre at the end of the step. */
    scene_subtract(dBodyGetPosition(w->object), r->centre, moved);
    scene_cross(moved, contact, shifted);
    gyroscopic(r->inertia, r->before + 3, h, impulse);
    for (int i = 0; i < 3; i++) change[i] = dBodyGetAngularVel(w->object)[i] - r->before[3 + i];
    times(r->inertia, change, turned);
    for (int i = 0; i < 3; i++) {
        double gained = w->scene->objects[0].mass * (dBodyGetLinearVel(w->object)[i] - r->before[i]) / h;
        left[i] = gained - force[i] - contact[i];
        turning[i] = (turned[i] - impulse[i]) / h - moment[i] - about[i] - shifted[i];
    }
    if (w->scene->dimension == 2)
        left[2] = turning[0] = turning[1] = 0; /* nobody reports the forces that hold it in the plane */
    r->balance = scene_norm(left);
    r->momentum = fmax(r->momentum, r->balance);
    r->angular_momentum = fmax(r->angular_momentum, scene_norm(turning));
}

/* Measures how far a tip on a slider is from its rail, along which it may move. */
static void watch_rails(observer *r)
{
    const world *w = r->w;
    for (int i = 0; i < w->finger_count; i++) {
        const world_finger *finger = &w->fingers[i];
        if (!finger->slider) continue;
        double position[3], orientation[4], off[3], along[3], axis[3];
        scene_base_pose(w->scene, finger->finger, w->time, position, orientation);
        scene_rotate_back(finger->finger->tip_orientation, finger->finger->normal, along);
        scene_rotate(orientation, along, axis);
        scene_subtract(dBodyGetPosition(finger->body), position, off);
        scene_add_scaled(off, -scene_dot(off, axis), axis);
        r->constraint = fmax(r->constraint, scene_norm(off));
        r->constraint_angular =
            fmax(r->constraint_angular, angle_between(orientation, dBodyGetQuaternion(finger->body)));
    }
}

/* White noise of deviation s on every step gives second differences of deviation s sqrt(1 + 4 + 1). */
static void watch_forces(observer *r)
{
    const world *w = r->w;
    bool counts = 2 * w->steps > r->steps && w->steps > 2;
    r->noisy += counts;
    for (int f = 0; f < w->finger_count; f++) {
        const double *now = w->fingers[f].state.force;
        double *last = r->history + 6 * f, *before = last + 3;
        for (int i = 0; i < 3; i++) {
            double bend = now[i] - 2 * last[i] + before[i];
            if (counts) r->noise[f] += bend * bend / 6;
            before[i] = last[i];
            last[i] = now[i];
        }
        r->points += w->fingers[f].state.points;
    }
}

/* Keeps the pose, and measures how far it is from the peer's after the same step. */
static void watch_divergence(observer *r, const observer *peer)
{
    double *mine = r->poses[r->w->steps - 1], apart[3];
    pose_of(r->w, mine);
    if (!peer) return;
    const double *other = peer->poses[r->w->steps - 1];
    scene_subtract(mine, other, apart);
    r->divergence =
        hypot(scene_norm(apart), r->w->scene->objects[0].shape.bounding_radius * angle_between(mine + 3, other + 3));
    r->divergence_max = fmax(r->divergence_max, r->divergence);
    for (int i = 0; i < METRIC_THRESHOLDS; i++)
        if (isnan(r->passed[i]) && r->divergence >= metric_thresholds[i]) r->passed[i] = r->w->time;
}

static void record_point(observer *r)
{
    const world *w = r->w;
    double *row = r->curve + (size_t)r->rows * (size_t)r->columns, now[7];
    if (r->rows >= OBSERVER_POINTS + 2) return;
    pose_of(w, now);
    row[OBSERVER_TIME] = w->time;
    scene_subtract(now, r->start, row + OBSERVER_POSITION);
    row[OBSERVER_ROTATION] = angle_between(r->start + 3, now + 3);
    row[OBSERVER_DIVERGENCE] = r->divergence;
    row[OBSERVER_BALANCE] = r->balance;
    for (int f = 0; f < w->finger_count; f++) {
        const world_finger_state *s = &w->fingers[f].state;
        double *part = row + OBSERVER_FINGERS + OBSERVER_PER_FINGER * f;
        part[OBSERVER_NORMAL] = s->normal_force;
        part[OBSERVER_TANGENTIAL] = scene_norm(s->tangential_force);
        part[OBSERVER_SLIP] = s->slip_total;
    }
    r->rows++;
}

void observer_after_step(observer *r, const observer *peer)
{
    balance(r);
    watch_rails(r);
    watch_forces(r);
    watch_divergence(r, peer);
    if (r->w->steps == 1 || r->w->steps % r->stride == 0 || r->w->steps == r->steps) record_point(r);
}

static double smallest_margin(const world *w)
{
    double smallest = NAN;
    for (int f = 0; f < w->finger_count; f++) smallest = fmin(smallest, world_least_margin(w, &w->fingers[f]));
    return smallest;
}

void observer_metrics(const observer *r, double m[METRIC_COUNT])
{
    const world *w = r->w;
    double now[7], moved[3], noise = 0, slip = 0, grip = 0;
    bool rails = false;
    pose_of(w, now);
    scene_subtract(now, r->start, moved);
    for (int f = 0; f < w->finger_count; f++) {
        noise = fmax(noise, r->noise[f]);
        slip = fmax(slip, w->fingers[f].state.slip_total);
        grip += w->fingers[f].state.normal_force;
        rails = rails || w->fingers[f].slider;
    }
    m[METRIC_FORCE_JITTER] = r->noisy > 0 ? sqrt(noise / (double)r->noisy) : NAN;
    m[METRIC_DISPLACEMENT] = scene_norm(moved);
    m[METRIC_ROTATION] = angle_between(r->start + 3, now + 3);
    m[METRIC_GRIP_FORCE] = grip;
    m[METRIC_SLIP] = slip;
    m[METRIC_SLIP_MARGIN] = smallest_margin(w);
    m[METRIC_PENETRATION] = w->depth_max;
    m[METRIC_POINTS] = w->steps > 0 ? r->points / (double)w->steps : NAN;
    m[METRIC_MOMENTUM_ERROR] = r->momentum;
    m[METRIC_ANGULAR_MOMENTUM_ERROR] = r->angular_momentum;
    m[METRIC_CONSTRAINT_ERROR] = rails ? r->constraint : NAN;
    m[METRIC_CONSTRAINT_ERROR_ANGULAR] = rails ? r->constraint_angular : NAN;
    m[METRIC_DIVERGENCE_MAX] = r->divergence_max;
    m[METRIC_DIVERGENCE_END] = r->divergence;
    for (int i = 0; i < METRIC_THRESHOLDS; i++) m[METRIC_DIVERGES_1UM + i] = r->passed[i];
}

/* ---- A run with its observer. ---- */

world_status solver_run_start(solver_run *c, const scene *s)
{
    char error[256];
    world_status status = world_create(s, &c->settings, &c->w, error);
    if (status != WORLD_OK) return status;
    c->simulation = simulation_start(c->w);
    if (!c->simulation) return WORLD_NO_MEMORY;
    long steps = simulation_steps(c->simulation);
    c->step_s = calloc((size_t)steps + 1, sizeof *c->step_s);
    if (c->film_rate > 0) c->pictures = film_start(c->w, c->film_rate);
    if (c->film_rate > 0 && !c->pictures) return WORLD_NO_MEMORY;
    return c->step_s && observer_start(&c->observer, c->w, steps) ? WORLD_OK : WORLD_NO_MEMORY;
}

world_status solver_run_step(solver_run *c, const solver_run *peer)
{
    double before = c->w->step_s;
    observer_before_step(&c->observer);
    dRandSetSeed(c->random);
    world_status status = simulation_step(c->simulation);
    c->random = dRandGetSeed();
    if (status != WORLD_OK) return status;
    c->step_s[c->w->steps - 1] = c->w->step_s - before;
    observer_after_step(&c->observer, peer ? &peer->observer : NULL);
    return !c->pictures || film_step(c->pictures, c->w) ? WORLD_OK : WORLD_NO_MEMORY;
}

static bool dropped(const simulation_result *r)
{
    for (int i = 0; i < r->event_count; i++)
        if (r->events[i].type == EVENT_DROPPED) return true;
    return false;
}

static void pinch_metrics(const solver_run *c, double *m)
{
    pinch_ode_stats stats = pinch_ode_statistics(c->w->plugin);
    const energy_ledger *ledger = &c->w->ledger;
    m[METRIC_VERIFIED] = !c->w->diverged && stats.fallback_islands == 0;
    m[METRIC_UNCONVERGED_STEPS] = (double)stats.unconverged_steps;
    m[METRIC_ITERATIONS_MEAN] = stats.islands > 0 ? (double)stats.iterations / (double)stats.islands : NAN;
    m[METRIC_ITERATIONS_MAX] = stats.iterations_max;
    m[METRIC_ENERGY_CLOSURE] = ledger->closure;
    m[METRIC_ENERGY_CLOSURE_RELATIVE] = ledger->work_size > 0 ? ledger->closure / ledger->work_size : NAN;
    m[METRIC_DIVERGENCE_MAX] = m[METRIC_DIVERGENCE_END] = NAN; /* Pinch is what the others are measured against */
}

void solver_run_finish(solver_run *c)
{
    double *m = c->metrics;
    for (int i = 0; i < METRIC_COUNT; i++) m[i] = NAN;
    simulation_finish(c->simulation, &c->result);
    c->simulation = NULL;
    c->hash = world_hash(c->w);
    observer_metrics(&c->observer, m);
    m[METRIC_CREEP] = c->result.motion.creep;
    m[METRIC_CREEP_ANGULAR] = c->result.motion.creep_angular;
    m[METRIC_CREEP_IN_HAND] = c->result.motion_in_hand.creep;
    m[METRIC_CREEP_IN_HAND_ANGULAR] = c->result.motion_in_hand.creep_angular;
    m[METRIC_DROPPED] = dropped(&c->result);
    if (c->settings.contact_solver == WORLD_PINCH) pinch_metrics(c, m);
    if (c->settings.contact_solver == WORLD_QUICKSTEP)
        m[METRIC_ITERATIONS_MEAN] = m[METRIC_ITERATIONS_MAX] = c->settings.quickstep_iterations;
    if (c->w->steps == 0) return;
    m[METRIC_COST] = 1e6 * median(c->step_s, (int)c->w->steps);
}

void solver_run_free(solver_run *c)
{
    if (c->simulation) simulation_finish(c->simulation, &c->result);
    simulation_free(&c->result);
    observer_free(&c->observer);
    free(c->step_s);
    film_free(c->pictures);
    world_free(c->w);
    memset(c, 0, sizeof *c);
}

world_status solver_run_hash(const solver_run *c, const scene *s, job_share *share, uint64_t *hash)
{
    char error[256];
    world *w;
    world_status status = world_create(s, &c->settings, &w, error);
    if (status != WORLD_OK) return status;
    dRandSetSeed(0);
    for (long k = lround(s->duration / s->step); k > 0 && status == WORLD_OK; k--) {
        status = world_advance(w);
        job_share_step(share);
    }
    *hash = world_hash(w);
    world_free(w);
    return status == WORLD_DIVERGED ? WORLD_OK : status;
}
