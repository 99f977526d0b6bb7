/* The scene over time: ramps, the schedule's signals, and where the kinematic bases are. */

#include "common/vector.h"
#include "scene.h"

#include <string.h>

double scene_ramp(double t, double ramp)
{
    if (t >= ramp) return 1.0;
    if (t <= 0.0) return 0.0;
    double s = t / ramp;
    return s * s * (3.0 - 2.0 * s);
}

static void signal_at(const scene_signal *signal, double t, double out[3])
{
    /* before its start a signal is held */
    double s = fmax(t - signal->start, 0.0);
    double angle = 2.0 * SCENE_PI * signal->frequency * s;
    switch (signal->type) {
    case SCENE_CONSTANT:
        scene_copy(signal->value, out);
        return;
    case SCENE_SINE: {
        double factor = sin(angle + signal->phase) * scene_ramp(s, signal->fade);
        for (int i = 0; i < 3; i++) out[i] = factor * signal->value[i];
        return;
    }
    case SCENE_TURN: {
        double q[4] = {cos(0.5 * angle)};
        for (int i = 0; i < 3; i++) q[i + 1] = sin(0.5 * angle) * signal->axis[i];
        scene_rotate(q, signal->value, out);
        return;
    }
    }
}

void scene_first_loads(const scene *s, scene_loads *loads)
{
    const scene_entry *first = &s->schedule[0];
    for (int c = 0; c < SCENE_CHANNEL_COUNT; c++) signal_at(&first->channels[c], first->time, loads->v[c]);
}

size_t scene_latest(const double *times, size_t stride, size_t count, double t)
{
    size_t low = 0, high = count; /* what is wanted is in [low, high) */
    while (low + 1 < high) {
        size_t middle = low + (high - low) / 2;
        const double *time = (const double *)((const char *)times + middle * stride);
        *(*time <= t ? &low : &high) = middle;
    }
    return low;
}

void scene_schedule_at(const scene *s, double t, scene_loads *loads)
{
    size_t i = scene_latest(&s->schedule->time, sizeof *s->schedule, s->entry_count, t);
    const scene_entry *now = &s->schedule[i];
    const scene_entry *next = i + 1 < s->entry_count && t > now->time ? now + 1 : NULL;
    for (int c = 0; c < SCENE_CHANNEL_COUNT; c++) {
        double *v = loads->v[c];
        signal_at(&now->channels[c], fmax(t, now->time), v);
        if (!next || now->channels[c].type != SCENE_CONSTANT) continue;
        double target[3];
        signal_at(&next->channels[c], next->time, target);
        double fraction = (t - now->time) / (next->time - now->time);
        for (int k = 0; k < 3; k++) v[k] += fraction * (target[k] - v[k]);
    }
}

void scene_path_at(const scene_drive *drive, double t, double translation[3], double rotation[3])
{
    for (int k = 0; k < 3; k++) translation[k] = rotation[k] = 0.0;
    if (drive->type != SCENE_DRIVE_PATH) return;
    const scene_path_point *points = drive->u.path.points;
    size_t count = drive->u.path.count, i = scene_latest(&points->time, sizeof *points, count, t), next = i;
    double fraction = 0.0;
    if (i + 1 < count && t > points[i].time) {
        next = i + 1;
        fraction = (t - points[i].time) / (points[next].time - points[i].time);
    }
    for (int k = 0; k < 3; k++) {
        translation[k] = points[i].translation[k] + fraction * (points[next].translation[k] - points[i].translation[k]);
        rotation[k] = points[i].rotation[k] + fraction * (points[next].rotation[k] - points[i].rotation[k]);
    }
}

bool scene_finger_force(const scene_finger *finger, double *force)
{
    if (finger->drive.type == SCENE_DRIVE_SLIDER) {
        *force = finger->drive.u.slider.force;
        return true;
    }
    *force = finger->normal_force;
    return finger->has_normal_force;
}

/* Moves a pose by the path drive, about its own origin, and then by the schedule's hand. */
static void carry(const scene *s, const scene_drive *drive, double t, double position[3], double orientation[4])
{
    double translation[3], rotation[3], turn[4], moved[3], turned[4];
    scene_path_at(drive, t, translation, rotation);
    scene_copy(position, moved);
    scene_add_scaled(moved, 1.0, translation);
    scene_quaternion_from_rotation(rotation, turn);
    scene_quaternion_product(turn, orientation, turned);

    scene_loads loads;
    scene_schedule_at(s, t, &loads);
    scene_quaternion_from_rotation(loads.v[SCENE_HAND_ROTATION], turn);
    scene_rotate(turn, moved, position);
    scene_add_scaled(position, 1.0, loads.v[SCENE_HAND_TRANSLATION]);
    scene_quaternion_product(turn, turned, orientation);
}

void scene_base_pose(const scene *s, const scene_finger *finger, double t, double position[3], double orientation[4])
{
    scene_copy(finger->tip_position, position);
    scene_add_scaled(position, finger->closing * scene_ramp(t, finger->ramp), finger->normal);
    memcpy(orientation, finger->tip_orientation, 4 * sizeof *orientation);
    carry(s, &finger->drive, t, position, orientation);
}

void scene_hand_pose(const scene *s, const scene_hand *hand, double t, double position[3], double orientation[4])
{
    scene_copy(hand->position, position);
    memcpy(orientation, hand->orientation, 4 * sizeof *orientation);
    carry(s, &hand->drive, t, position, orientation);
}
