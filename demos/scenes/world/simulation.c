#include "simulation_state.h"
#include "world_hand.h"

#include "common/vector.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* An object that was held has been dropped when it has fallen freely for this long and this far. Its own speed at the
 * start of the fall does not count: an object without weight drifts from finger to finger, and nothing drops it. */
static const double DROP_TIME = 0.05;     /* s */
static const double DROP_DISTANCE = 0.01; /* of its bounding radius */
/* At the end of a run an object has been dropped, too, that nothing touches this far from where it was last touched. */
static const double LOST_DISTANCE = 2; /* bounding radii: its own size */

const char *simulation_event_name(simulation_event_type type)
{
    static const char *const names[] = {"crush", "slip", "dropped", "limit"};
    return names[type];
}

static world_pose pose_of(const world *w, int object)
{
    world_pose p;
    memcpy(p.position, dBodyGetPosition(w->objects[object].body), sizeof p.position);
    memcpy(p.orientation, dBodyGetQuaternion(w->objects[object].body), sizeof p.orientation);
    return p;
}

/* The object as the hand sees it, which the schedule has moved and turned about the world's origin. */
static world_pose pose_in_hand(const world *w, int object)
{
    world_pose in_world = pose_of(w, object), p;
    double turn[4], from_hand[3];
    scene_loads loads;
    scene_schedule_at(w->scene, w->time, &loads);
    scene_quaternion_from_rotation(loads.v[SCENE_HAND_ROTATION], turn);
    scene_subtract(in_world.position, loads.v[SCENE_HAND_TRANSLATION], from_hand);
    scene_rotate_back(turn, from_hand, p.position);
    dQMultiply1(p.orientation, turn, in_world.orientation);
    return p;
}

static double distance(const world_pose *a, const world_pose *b)
{
    double d2 = 0;
    for (int i = 0; i < 3; i++) d2 += (a->position[i] - b->position[i]) * (a->position[i] - b->position[i]);
    return sqrt(d2);
}

/* The angle between two orientations, from the vector part of a^-1 b, which is accurate for small angles. */
static double angle(const world_pose *a, const world_pose *b)
{
    dQuaternion turn;
    dQMultiply1(turn, a->orientation, b->orientation);
    double sine = sqrt(turn[1] * turn[1] + turn[2] * turn[2] + turn[3] * turn[3]);
    return 2 * atan2(sine, fabs(turn[0]));
}

static world_status add_event(simulation *s, simulation_event event)
{
    simulation_result *r = &s->result;
    if (r->event_count == s->event_room) {
        int room = 2 * s->event_room + 8;
        simulation_event *more = realloc(r->events, (size_t)room * sizeof *more);
        if (!more) return WORLD_NO_MEMORY;
        r->events = more;
        s->event_room = room;
    }
    r->events[r->event_count++] = event;
    return WORLD_OK;
}

static simulation_event finger_event(double time, int finger, simulation_event_type type, double value, double limit)
{
    return (simulation_event){
        .time = time, .finger = finger, .hand = -1, .joint = -1, .type = type, .value = value, .limit = limit};
}

static world_status watch_fingers(simulation *s)
{
    const world *w = s->w;
    world_status status = WORLD_OK;
    for (int i = 0; i < w->finger_count && status == WORLD_OK; i++) {
        const world_finger_state *state = &w->fingers[i].state;
        const scene_finger *f = w->fingers[i].finger;
        if (!s->crushed[i] && state->normal_force > f->damage_max_force) {
            s->crushed[i] = true;
            status = add_event(s, finger_event(w->time, i, EVENT_CRUSH, state->normal_force, f->damage_max_force));
        }
        if (!s->slipped[i] && state->slip_total > f->damage_max_slip && status == WORLD_OK) {
            s->slipped[i] = true;
            status = add_event(s, finger_event(w->time, i, EVENT_SLIP, state->slip_total, f->damage_max_slip));
        }
    }
    return status;
}

static void begin_fall(simulation *s, int object)
{
    dBodyID body = s->w->objects[object].body;
    track *k = &s->track[object];
    scene_copy(dBodyGetPosition(body), k->fall_position);
    scene_copy(dBodyGetLinearVel(body), k->fall_velocity);
    k->fall_time = s->w->time;
}

/* Does a force act on the object that nobody who touches it exerts, its weight for one? */
static bool has_weight(const world *w, int object)
{
    double force[3], moment[3];
    world_external_wrench(w, object, force, moment);
    return force[0] != 0 || force[1] != 0 || force[2] != 0;
}

/* How far the object is from where its speed alone would have brought it since its fall began. */
static double fallen(const simulation *s, int object)
{
    const track *k = &s->track[object];
    double way[3];
    scene_subtract(dBodyGetPosition(s->w->objects[object].body), k->fall_position, way);
    scene_add_scaled(way, k->fall_time - s->w->time, k->fall_velocity);
    return scene_norm(way);
}

static world_status watch_drop(simulation *s, int object)
{
    const world *w = s->w;
    track *k = &s->track[object];
    bool fingers = false;
    for (int i = 0; i < w->finger_count; i++)
        fingers = fingers || (w->fingers[i].object == object && w->fingers[i].state.points > 0);
    if (fingers) k->held = true;
    if (fingers || w->objects[object].touched) {
        k->touched = pose_of(w, object);
        begin_fall(s, object);
        return WORLD_OK;
    }
    if (!has_weight(w, object)) begin_fall(s, object);
    world_pose now = pose_of(w, object);
    double way = distance(&now, &k->touched), radius = w->scene->objects[object].shape.bounding_radius;
    bool fell = w->time - k->fall_time >= DROP_TIME && fallen(s, object) >= DROP_DISTANCE * radius;
    bool lost = w->steps == s->steps && way > LOST_DISTANCE * radius;
    if (!k->held || !(fell || lost)) return WORLD_OK;
    k->held = false;
    simulation_event event = finger_event(w->time, -1, EVENT_DROPPED, way, 0);
    event.object = object;
    return add_event(s, event);
}

/* A joint that starts at its limit and stays there has not come to it. */
static world_status watch_joints(simulation *s, int k)
{
    const world *w = s->w;
    world_status status = WORLD_OK;
    for (int i = 0; i < w->hands[k].joint_count && status == WORLD_OK; i++) {
        const world_joint *j = &w->hands[k].joints[i];
        if (!j->at_limit) s->away[k][i] = true;
        if (!j->at_limit || !s->away[k][i] || s->limited[k][i]) continue;
        s->limited[k][i] = true;
        bool low = fabs(j->position - j->of->lower) < fabs(j->position - j->of->upper);
        simulation_event event = finger_event(w->time, -1, EVENT_LIMIT, j->position, low ? j->of->lower : j->of->upper);
        event.hand = k;
        event.joint = i;
        status = add_event(s, event);
    }
    return status;
}

static double speed(const world *w, int object)
{
    const double *v = dBodyGetLinearVel(w->objects[object].body);
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static simulation_motion motion_between(const simulation *s, const world_pose *start, const world_pose *middle,
                                        const world_pose *end)
{
    simulation_motion m = {.creep = NAN, .creep_angular = NAN};
    double half = s->w->time / 2;
    for (int i = 0; i < 3; i++) m.displacement[i] = end->position[i] - start->position[i];
    if (s->w->steps < s->steps) return m;
    m.creep = half > 0 ? distance(end, middle) / half : 0;
    m.creep_angular = half > 0 ? angle(end, middle) / half : 0;
    return m;
}

/* What position control should give at the end of the step, and how far what it gave is from that. */
static double joint_error(const world *w)
{
    double most = NAN;
    for (int k = 0; k < w->hand_count; k++) {
        for (int i = 0; i < w->hands[k].joint_count; i++) {
            const world_joint *j = &w->hands[k].joints[i];
            const scene_control *c = j->control;
            if (c->type != SCENE_POSITION_CONTROL) continue;
            double force = c->kp * (j->target - j->position) - c->kd * j->velocity;
            force = fmin(fmax(force, c->least_force), c->most_force);
            most = fmax(most, fabs(force - j->own_torque));
        }
    }
    return most;
}

/* Contacts push apart what begins in each other, with forces that nobody has meant. Between fingers a little of it
 * tells: what they push each other with is missing where they press. */
static world_status watch_overlap(simulation *s)
{
    static const double LARGE = 0.05, BETWEEN_FINGERS = 1e-3; /* of the object's bounding radius */
    static const char format[] = "%s and %s begin %.3g m in each other, and are pushed apart";
    const world *w = s->w;
    world_overlap o;
    if (w->steps != 1 || !world_deepest_overlap(w, &o)) return WORLD_OK;
    if (o.depth < (o.fingers ? BETWEEN_FINGERS : LARGE) * w->scene->objects[0].shape.bounding_radius) return WORLD_OK;
    size_t size = sizeof format + strlen(o.first) + strlen(o.second) + 32;
    s->result.overlap = malloc(size);
    if (!s->result.overlap) return WORLD_NO_MEMORY;
    snprintf(s->result.overlap, size, format, o.first, o.second, o.depth);
    return WORLD_OK;
}

bool simulation_energy_remark(const world *w, char text[SIMULATION_REMARK])
{
    static const double MUCH = 0.05; /* of all work */
    const energy_ledger *l = &w->ledger;
    if (!(l->integrator < -MUCH * l->work_size)) return false;
    snprintf(text, SIMULATION_REMARK,
             "steps of %g s have put %.3g J in, as bodies meet contacts too deep; shorter ones put in less",
             w->scene->step, -l->integrator);
    return true;
}

bool simulation_duration_remark(const scene *s, char text[SIMULATION_REMARK])
{
    static const double ROUNDING = 1e-6; /* of a step */
    double count = s->duration / s->step;
    if (fabs(count - round(count)) <= fmax(ROUNDING, 4 * DBL_EPSILON * count)) return false;
    snprintf(text, SIMULATION_REMARK, "a duration of %.9g s is %.9g steps of %.9g s; the run ends after %.9g s",
             s->duration, count, s->step, round(count) * s->step);
    return true;
}

void simulation_remarks(const world *w, const simulation_result *result,
                        void (*report)(void *context, const char *text), void *context)
{
    char text[SIMULATION_REMARK];
    if (simulation_duration_remark(w->scene, text)) report(context, text);
    if (result->overlap) report(context, result->overlap);
    if (simulation_energy_remark(w, text)) report(context, text);
}

static void measure_object(simulation *s, int object)
{
    const world *w = s->w;
    simulation_result *r = &s->result;
    simulation_object *o = &r->objects[object];
    const track *k = &s->track[object];
    world_pose end = pose_of(w, object), end_in_hand = pose_in_hand(w, object);
    double force[3], moment[3], contact[3], turning[3];
    o->motion = motion_between(s, &k->start, &k->middle, &end);
    o->motion_in_hand = motion_between(s, &k->start_in_hand, &k->middle_in_hand, &end_in_hand);
    world_external_wrench(w, object, force, moment);
    world_contact_wrench(w, object, contact, turning);
    for (int i = 0; i < 3; i++) {
        force[i] += contact[i];
        moment[i] += turning[i];
    }
    r->force_error = fmax(r->force_error, scene_norm(force));
    r->torque_error = fmax(r->torque_error, scene_norm(moment));
}

static void measure_end(simulation *s)
{
    const world *w = s->w;
    simulation_result *r = &s->result;
    r->force_error = r->torque_error = 0;
    for (int k = 0; k < r->object_count; k++) measure_object(s, k);
    r->motion = r->objects[0].motion;
    r->motion_in_hand = r->objects[0].motion_in_hand;
    r->speed_max = r->objects[0].speed_max;
    r->joint_error = joint_error(w);
    r->loop_gap = NAN;
    for (int k = 0; k < w->hand_count; k++)
        if (w->hands[k].loop_count > 0) r->loop_gap = fmax(r->loop_gap, world_loop_gap(&w->hands[k]));
    r->steps = w->steps;
    r->time = w->time;
    r->max_penetration = w->depth_max;
}

static bool make_room(simulation *s)
{
    const world *w = s->w;
    size_t fingers = (size_t)w->finger_count, objects = (size_t)w->object_count, joints = 1;
    for (int k = 0; k < w->hand_count; k++) joints += (size_t)w->hands[k].joint_count;
    s->crushed = calloc(2 * fingers + 2 * joints, sizeof *s->crushed);
    s->away = calloc(2 * (size_t)w->hand_count + 1, sizeof *s->away);
    s->track = calloc(objects, sizeof *s->track);
    s->result.objects = calloc(objects, sizeof *s->result.objects);
    if (!s->crushed || !s->away || !s->track || !s->result.objects) return false;
    s->slipped = s->crushed + fingers;
    s->limited = s->away + w->hand_count;
    bool *next = s->slipped + fingers;
    for (int k = 0; k < w->hand_count; k++) {
        s->away[k] = next;
        s->limited[k] = next + joints;
        next += w->hands[k].joint_count;
    }
    return true;
}

static void free_room(simulation *s)
{
    free(s->crushed);
    free(s->away);
    free(s->track);
    free(s);
}

simulation *simulation_start(world *w)
{
    simulation *s = calloc(1, sizeof *s);
    if (!s) return NULL;
    s->w = w;
    if (!make_room(s)) {
        free(s->result.objects);
        free_room(s);
        return NULL;
    }
    s->result.object_count = w->object_count;
    for (int k = 0; k < w->object_count; k++) {
        track *t = &s->track[k];
        t->start = t->middle = t->touched = pose_of(w, k);
        t->start_in_hand = t->middle_in_hand = pose_in_hand(w, k);
        t->held = k == 0 && w->hand_count == 0; /* every tip touches at the start */
        begin_fall(s, k);
    }
    s->steps = lround(w->scene->duration / w->scene->step);
    return s;
}

const simulation_result *simulation_so_far(const simulation *s)
{
    return &s->result;
}

long simulation_steps(const simulation *s)
{
    return s->steps;
}

world_status simulation_step(simulation *s)
{
    world *w = s->w;
    world_status status = world_advance(w);
    if (status == WORLD_OK) status = watch_overlap(s);
    if (status == WORLD_OK) status = watch_fingers(s);
    for (int k = 0; k < w->hand_count && status == WORLD_OK; k++) status = watch_joints(s, k);
    for (int k = 0; k < w->object_count && status == WORLD_OK; k++) {
        simulation_object *o = &s->result.objects[k];
        status = watch_drop(s, k);
        if (w->steps == (s->steps + 1) / 2) {
            s->track[k].middle = pose_of(w, k);
            s->track[k].middle_in_hand = pose_in_hand(w, k);
        }
        if (2 * w->steps > s->steps) o->speed_max = fmax(o->speed_max, speed(w, k));
    }
    return status;
}

void simulation_finish(simulation *s, simulation_result *result)
{
    measure_end(s);
    s->result.touched = false;
    for (int i = 0; i < s->w->finger_count; i++)
        if (s->w->fingers[i].object >= 0 && s->w->fingers[i].state.points > 0) s->result.touched = true;
    *result = s->result;
    free_room(s);
}

void simulation_free(simulation_result *r)
{
    free(r->events);
    free(r->objects);
    free(r->overlap);
    r->objects = NULL;
    r->overlap = NULL;
    r->events = NULL;
    r->event_count = 0;
}
