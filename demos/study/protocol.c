/* What is done to hand and object once the scene's own schedule has ended. */
#include "trial.h"

#include "common/output.h"
#include "common/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int protocol_runs(const study_protocol *p, int dimension)
{
    return p->type == STUDY_SIX_FORCES ? 2 * dimension : 1;
}

const char *protocol_direction(const study_protocol *p, int run)
{
    static const char *const names[] = {"+x", "-x", "+y", "-y", "+z", "-z"};
    return p->type == STUDY_SIX_FORCES ? names[run] : "";
}

static double path_end(const scene_drive *drive)
{
    bool moves = drive->type == SCENE_DRIVE_PATH && drive->u.path.count > 0;
    return moves ? drive->u.path.points[drive->u.path.count - 1].time : 0.0;
}

double protocol_schedule_end(const scene *s)
{
    double end = s->schedule[s->entry_count - 1].time;
    for (size_t i = 0; i < s->finger_count; i++)
        end = fmax(end, fmax(s->fingers[i].ramp, path_end(&s->fingers[i].drive)));
    for (size_t i = 0; i < s->hand_count; i++) {
        const scene_hand *h = &s->hands[i];
        end = fmax(end, path_end(&h->drive));
        for (size_t k = 0; k < h->control_count; k++)
            if (h->controls[k].target_count > 0)
                end = fmax(end, h->controls[k].target[h->controls[k].target_count - 1].time);
    }
    return end;
}

/* The schedule as it is extended. */
typedef struct tail {
    scene *s;
    bool failed;
} tail;

/* One more entry, which goes on as the one before. */
static scene_entry *add_entry(tail *t, double time)
{
    scene *s = t->s;
    scene_entry *more = t->failed ? NULL : realloc(s->schedule, (s->entry_count + 1) * sizeof *more);
    if (!more) {
        t->failed = true;
        return NULL;
    }
    s->schedule = more;
    more[s->entry_count] = more[s->entry_count - 1];
    more[s->entry_count].time = time;
    return &more[s->entry_count++];
}

static void add_constant(tail *t, double time, scene_channel channel, const double value[3])
{
    scene_entry *entry = add_entry(t, time);
    if (!entry) return;
    entry->channels[channel] = (scene_signal){.type = SCENE_CONSTANT, .start = time};
    scene_copy(value, entry->channels[channel].value);
}

static double lift(const study_protocol *p, tail *t, double begin, const scene_loads *before)
{
    /* The hand follows 3 x^2 - 2 x^3, whose greatest slope is 3/2, in straight pieces. */
    enum { PIECES = 40 };
    double time = 1.5 * p->distance / p->speed;
    for (int k = 0; k <= PIECES; k++) {
        double value[3], at = (double)k / PIECES;
        scene_copy(before->v[SCENE_HAND_TRANSLATION], value);
        scene_add_scaled(value, p->distance * scene_ramp(at, 1.0), p->axis);
        add_constant(t, begin + at * time, SCENE_HAND_TRANSLATION, value);
    }
    return begin + time + p->hold;
}

/* Seen from a shaken hand the object is accelerated against the hand's motion. */
static double shake(const study_protocol *p, tail *t, double begin, const scene_loads *before)
{
    double omega = 2.0 * SCENE_PI * p->frequency;
    for (int axis = 0; axis < 3; axis++) {
        if (!p->axes[axis]) continue;
        scene_entry *entry = add_entry(t, begin);
        if (!entry) return begin;
        entry->channels[SCENE_BASE_ACCELERATION] = (scene_signal){
            .type = SCENE_SINE, .frequency = p->frequency, .fade = fmin(0.5, 0.25 * p->time), .start = begin};
        entry->channels[SCENE_BASE_ACCELERATION].value[axis] = p->amplitude * omega * omega;
        begin += p->time;
        add_constant(t, begin, SCENE_BASE_ACCELERATION, before->v[SCENE_BASE_ACCELERATION]);
    }
    return begin + p->settle;
}

static double push(const study_protocol *p, tail *t, int run, double begin, const scene_loads *before)
{
    double force[3];
    scene_copy(before->v[SCENE_FORCE], force);
    force[run / 2] += (run % 2 ? -1.0 : 1.0) * p->force_per_mass * t->s->objects[0].mass;
    add_constant(t, begin, SCENE_FORCE, force);
    return begin + p->hold;
}

bool protocol_apply(const study_protocol *p, int run, scene *s, double *begin)
{
    *begin = 0.0;
    if (p->type == STUDY_NO_PROTOCOL) return true;
    tail t = {s, false};
    scene_loads before;
    *begin = protocol_schedule_end(s) + p->settle;
    scene_schedule_at(s, *begin, &before);
    add_entry(&t, *begin);
    if (p->type == STUDY_LIFT)
        s->duration = lift(p, &t, *begin, &before);
    else if (p->type == STUDY_SHAKE)
        s->duration = shake(p, &t, *begin, &before);
    else
        s->duration = push(p, &t, run, *begin, &before);
    return !t.failed;
}

json_t *protocol_document(const study_protocol *p)
{
    json_t *axes = json_array();
    for (int i = 0; i < 3; i++) {
        char name[2] = {(char)('x' + i), '\0'};
        if (p->axes[i]) (void)json_array_append_new(axes, json_string(name));
    }
    json_t *document = NULL;
    if (p->type == STUDY_NO_PROTOCOL) document = json_pack("{s:s}", "name", "none");
    if (p->type == STUDY_LIFT)
        document = json_pack("{s:s, s:f, s:f, s:f, s:o, s:f}", "name", "lift", "settle", p->settle, "distance",
                             p->distance, "speed", p->speed, "axis", json_numbers(p->axis, 3), "hold", p->hold);
    if (p->type == STUDY_SHAKE)
        document = json_pack("{s:s, s:f, s:f, s:f, s:O, s:f}", "name", "shake", "settle", p->settle, "amplitude",
                             p->amplitude, "frequency", p->frequency, "axes", axes, "time", p->time);
    if (p->type == STUDY_SIX_FORCES)
        document = json_pack("{s:s, s:f, s:f, s:f}", "name", "six-forces", "settle", p->settle, "force_per_mass",
                             p->force_per_mass, "hold", p->hold);
    json_decref(axes);
    return document;
}
