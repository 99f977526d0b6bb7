#include "simulation.h"

#include "common/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An object that was held has been dropped when it has not been touched for this long and has gone this far. */
static const double DROP_TIME = 0.05;     /* s */
static const double DROP_DISTANCE = 0.01; /* of its bounding radius, since it was last touched */

const char *simulation_event_name(simulation_event_type type)
{
    static const char *const names[] = {"crush", "slip", "dropped"};
    return names[type];
}

typedef struct pose {
    double position[3], orientation[4];
} pose;

struct simulation {
    world *w;
    long steps;                  /* of the whole run */
    pose start, middle, touched; /* at the start, half way, when last touched */
    pose start_in_hand, middle_in_hand;
    bool *crushed, *slipped; /* per finger: has the event been reported? */
    bool held;               /* has a finger carried load since the last drop? */
    double last_touch;       /* s */
    int event_room;
    simulation_result result;
};

static pose pose_of(const world *w)
{
    pose p;
    memcpy(p.position, dBodyGetPosition(w->object), sizeof p.position);
    memcpy(p.orientation, dBodyGetQuaternion(w->object), sizeof p.orientation);
    return p;
}

/* The object as the hand sees it, which the schedule has moved and turned about the world's origin. */
static pose pose_in_hand(const world *w)
{
    pose in_world = pose_of(w), p;
    double turn[4], from_hand[3];
    scene_loads loads;
    scene_schedule_at(w->scene, w->time, &loads);
    scene_quaternion_from_rotation(loads.v[SCENE_HAND_ROTATION], turn);
    scene_subtract(in_world.position, loads.v[SCENE_HAND_TRANSLATION], from_hand);
    scene_rotate_back(turn, from_hand, p.position);
    dQMultiply1(p.orientation, turn, in_world.orientation);
    return p;
}

static double distance(const pose *a, const pose *b)
{
    double d2 = 0;
    for (int i = 0; i < 3; i++) d2 += (a->position[i] - b->position[i]) * (a->position[i] - b->position[i]);
    return sqrt(d2);
}

/* The angle between two orientations, from the vector part of a^-1 b, which is accurate for small angles. */
static double angle(const pose *a, const pose *b)
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

static world_status watch_fingers(simulation *s)
{
    const world *w = s->w;
    world_status status = WORLD_OK;
    for (int i = 0; i < w->finger_count && status == WORLD_OK; i++) {
        const world_finger_state *state = &w->fingers[i].state;
        const scene_finger *f = w->fingers[i].finger;
        if (!s->crushed[i] && state->normal_force > f->damage_max_force) {
            s->crushed[i] = true;
            status =
                add_event(s, (simulation_event){w->time, i, EVENT_CRUSH, state->normal_force, f->damage_max_force});
        }
        if (!s->slipped[i] && state->slip_total > f->damage_max_slip && status == WORLD_OK) {
            s->slipped[i] = true;
            status = add_event(s, (simulation_event){w->time, i, EVENT_SLIP, state->slip_total, f->damage_max_slip});
        }
    }
    return status;
}

static world_status watch_drop(simulation *s)
{
    const world *w = s->w;
    bool fingers = false;
    for (int i = 0; i < w->finger_count; i++) fingers = fingers || w->fingers[i].state.points > 0;
    if (fingers) s->held = true;
    if (fingers || w->environment_touched) {
        s->last_touch = w->time;
        s->touched = pose_of(w);
        return WORLD_OK;
    }
    if (!s->held || w->time - s->last_touch < DROP_TIME) return WORLD_OK;
    pose now = pose_of(w);
    if (distance(&now, &s->touched) < DROP_DISTANCE * w->scene->objects[0].shape.bounding_radius) return WORLD_OK;
    s->held = false;
    return add_event(s, (simulation_event){w->time, -1, EVENT_DROPPED, distance(&now, &s->touched), 0});
}

static double speed(const world *w)
{
    const double *v = dBodyGetLinearVel(w->object);
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static simulation_motion motion_between(const simulation *s, const pose *start, const pose *middle, const pose *end)
{
    simulation_motion m = {.creep = NAN, .creep_angular = NAN};
    double half = s->w->time / 2;
    for (int i = 0; i < 3; i++) m.displacement[i] = end->position[i] - start->position[i];
    if (s->w->steps < s->steps) return m;
    m.creep = half > 0 ? distance(end, middle) / half : 0;
    m.creep_angular = half > 0 ? angle(end, middle) / half : 0;
    return m;
}

static void measure_end(simulation *s)
{
    const world *w = s->w;
    simulation_result *r = &s->result;
    pose end = pose_of(w), end_in_hand = pose_in_hand(w);
    double force[3], moment[3];
    r->motion = motion_between(s, &s->start, &s->middle, &end);
    r->motion_in_hand = motion_between(s, &s->start_in_hand, &s->middle_in_hand, &end_in_hand);
    world_external_wrench(w, force, moment);
    for (int i = 0; i < 3; i++) {
        force[i] += w->environment_force[i];
        moment[i] += w->environment_moment[i];
    }
    for (int f = 0; f < w->finger_count; f++) {
        for (int i = 0; i < 3; i++) {
            force[i] += w->fingers[f].state.force[i];
            moment[i] += w->fingers[f].state.moment[i];
        }
    }
    r->force_error = sqrt(force[0] * force[0] + force[1] * force[1] + force[2] * force[2]);
    r->torque_error = sqrt(moment[0] * moment[0] + moment[1] * moment[1] + moment[2] * moment[2]);
    r->steps = w->steps;
    r->time = w->time;
    r->max_penetration = w->depth_max;
}

simulation *simulation_start(world *w)
{
    size_t fingers = (size_t)w->finger_count;
    simulation *s = calloc(1, sizeof *s);
    if (!s) return NULL;
    s->crushed = calloc(2 * fingers, sizeof *s->crushed);
    if (!s->crushed) {
        free(s);
        return NULL;
    }
    s->w = w;
    s->slipped = s->crushed + fingers;
    s->start = s->middle = s->touched = pose_of(w);
    s->start_in_hand = s->middle_in_hand = pose_in_hand(w);
    s->held = true; /* every tip touches at the start */
    s->steps = lround(w->scene->duration / w->scene->step);
    return s;
}

long simulation_steps(const simulation *s)
{
    return s->steps;
}

world_status simulation_step(simulation *s)
{
    world *w = s->w;
    world_status status = world_advance(w);
    if (status == WORLD_OK) status = watch_fingers(s);
    if (status == WORLD_OK) status = watch_drop(s);
    if (w->steps == (s->steps + 1) / 2) {
        s->middle = pose_of(w);
        s->middle_in_hand = pose_in_hand(w);
    }
    if (2 * w->steps > s->steps) s->result.speed_max = fmax(s->result.speed_max, speed(w));
    return status;
}

void simulation_finish(simulation *s, simulation_result *result)
{
    measure_end(s);
    *result = s->result;
    free(s->crushed);
    free(s);
}

void simulation_free(simulation_result *r)
{
    free(r->events);
    r->events = NULL;
    r->event_count = 0;
}
