/*
 * Checkpoints: all that the rest of a run depends on, and all that it has measured so far. The plugin's snapshot has
 * the state of ODE's world and of the contacts; what is here besides is the run's own.
 */
#define _POSIX_C_SOURCE 200809L

#include "simulation_state.h"
#include "world_hand.h"

#include "common/input_file.h"

#include <stdlib.h>
#include <string.h>

static const char FORMAT[16] = "pinch-run/5";

/* ---- The tape ---- */

/* Plain values, written one behind the other and read back in the same order by the same function. What is written
 * grows in memory. After the first failure nothing more is written, and what is read is 0. */
typedef struct tape {
    bool reading;
    unsigned char *bytes; /* owned where it is written */
    size_t size, at;      /* of the bytes there are; read so far */
    size_t room;
    bool no_memory, damaged;
} tape;

static tape tape_write(void)
{
    return (tape){.reading = false};
}

static tape tape_read(const void *bytes, size_t size)
{
    return (tape){.reading = true, .bytes = (unsigned char *)bytes, .size = size}; /* it is not written to */
}

static void tape_free(tape *t)
{
    if (!t->reading) free(t->bytes);
    t->bytes = NULL;
}

static bool make_room(tape *t, size_t size)
{
    if (t->no_memory) return false;
    if (size <= t->room - t->size) return true;
    size_t room = 2 * t->room + size + 4096;
    unsigned char *more = realloc(t->bytes, room);
    t->no_memory = !more;
    if (!more) return false;
    t->bytes = more;
    t->room = room;
    return true;
}

static void tape_bytes(tape *t, void *value, size_t size)
{
    if (size == 0) return;
    if (!t->reading) {
        if (!make_room(t, size)) return;
        memcpy(t->bytes + t->size, value, size);
        t->size += size;
        return;
    }
    t->damaged = t->damaged || size > t->size - t->at;
    if (t->damaged) {
        memset(value, 0, size);
        return;
    }
    memcpy(value, t->bytes + t->at, size);
    t->at += size;
}

#define TAPE(t, value) tape_bytes((t), &(value), sizeof(value))

static void tape_flag(tape *t, bool *value)
{
    unsigned char byte = t->reading ? 0 : *value;
    TAPE(t, byte);
    *value = byte == 1;
    t->damaged = t->damaged || byte > 1;
}

/* A number that both sides know: anything else is damage. */
static void tape_expect(tape *t, int64_t value)
{
    int64_t found = value;
    TAPE(t, found);
    t->damaged = t->damaged || found != value;
}

/* FNV-1a, to go on with; 0 to begin. */
static uint64_t tape_hash(uint64_t hash, const void *bytes, size_t size)
{
    if (hash == 0) hash = 0xcbf29ce484222325u;
    for (size_t i = 0; i < size; i++) hash = (hash ^ ((const unsigned char *)bytes)[i]) * 0x100000001b3u;
    return hash;
}

/* ---- What belongs to the scene ---- */

static uint64_t hash_solver(uint64_t hash, const world_settings *settings)
{
    const pinch_solver_settings *s = &settings->solver;
    int kinds[] = {settings->contact_solver, settings->faces, settings->points, settings->cold_start, s->solver,
                   s->max_iterations,        s->newton_finish};
    hash = tape_hash(hash, kinds, sizeof kinds);
    hash = tape_hash(hash, &s->tolerance, sizeof s->tolerance);
    hash = tape_hash(hash, &s->goal, sizeof s->goal);
    return tape_hash(hash, &s->seed, sizeof s->seed);
}

/* A body is known by its mass and inertia. */
static uint64_t hash_body(uint64_t hash, dBodyID body)
{
    dMass mass;
    dBodyGetMass(body, &mass);
    hash = tape_hash(hash, &mass.mass, sizeof mass.mass);
    for (int row = 0; row < 3; row++) hash = tape_hash(hash, mass.I + 4 * row, 3 * sizeof(double));
    return hash;
}

/* The scene names files, of meshes and hands, whose contents may change. One that has gone since counts as empty. */
static bool hash_file(void *context, const char *path)
{
    uint64_t *hash = context;
    unsigned char buffer[65536];
    char fault[128];
    FILE *stream = input_open_regular(path, fault);
    for (size_t got; stream && (got = fread(buffer, 1, sizeof buffer, stream)) > 0;)
        *hash = tape_hash(*hash, buffer, got);
    if (stream) (void)fclose(stream);
    return true;
}

/* Returns a hash of scene, files, settings and bodies; 0 when memory runs out. */
static uint64_t fingerprint(const world *w)
{
    char *text = NULL;
    size_t size = 0;
    FILE *stream = open_memstream(&text, &size);
    if (!stream) return 0;
    bool printed = scene_print(w->scene, stream) == SCENE_OK;
    printed = fclose(stream) == 0 && printed;
    uint64_t hash = printed ? tape_hash(0, text, size) : 0;
    free(text);
    if (!printed) return 0;
    (void)scene_each_file(w->scene, hash_file, &hash);
    hash = hash_solver(hash, &w->settings);
    for (int i = 0; i < w->body_count; i++) hash = hash_body(hash, w->bodies[i]);
    return hash ? hash : 1;
}

bool simulation_know_origin(simulation *s)
{
    if (s->fingerprint == 0) s->fingerprint = fingerprint(s->w);
    return s->fingerprint != 0;
}

/* ---- The parts of ODE's world ---- */

typedef struct part_lists {
    pinch_ode_parts parts;
    dGeomID *geoms;
    dJointID *joints;
} part_lists;

static void free_parts(part_lists *lists)
{
    free(lists->geoms);
    free(lists->joints);
}

static void list_hand_joints(const world_hand *h, part_lists *lists)
{
    for (int i = 0; i < h->joint_count; i++)
        if (h->joints[i].joint) lists->joints[lists->parts.joint_count++] = h->joints[i].joint;
    for (int i = 0; i < h->loop_count; i++)
        if (h->loops[i].ball) lists->joints[lists->parts.joint_count++] = h->loops[i].ball;
}

/* The lists are those of one build of the world, whose order depends on the scene alone. */
static bool list_parts(const world *w, part_lists *lists)
{
    size_t joints = 1 + (size_t)w->finger_count;
    for (int k = 0; k < w->hand_count; k++) joints += (size_t)(w->hands[k].joint_count + w->hands[k].loop_count);
    *lists = (part_lists){.parts = {.bodies = w->bodies, .body_count = w->body_count}};
    lists->geoms = calloc((size_t)(w->geom_count + w->object_count), sizeof *lists->geoms);
    lists->joints = calloc(joints, sizeof *lists->joints);
    if (!lists->geoms || !lists->joints) {
        free_parts(lists);
        return false;
    }
    for (int i = 0; i < w->geom_count; i++) lists->geoms[lists->parts.geom_count++] = w->geoms[i];
    for (int i = 0; i < w->object_count; i++) lists->geoms[lists->parts.geom_count++] = w->objects[i].geom;
    if (w->plane) lists->joints[lists->parts.joint_count++] = w->plane;
    for (int i = 0; i < w->finger_count; i++)
        if (w->fingers[i].slider) lists->joints[lists->parts.joint_count++] = w->fingers[i].slider;
    for (int k = 0; k < w->hand_count; k++) list_hand_joints(&w->hands[k], lists);
    lists->parts.geoms = lists->geoms;
    lists->parts.joints = lists->joints;
    return true;
}

/* ---- The world's own state ---- */

static void tape_finger(tape *t, world_finger *finger)
{
    world_finger_state *s = &finger->state;
    TAPE(t, finger->energy.kinetic_start);
    TAPE(t, finger->force);
    TAPE(t, finger->push);
    TAPE(t, s->points);
    TAPE(t, s->state);
    TAPE(t, s->normal_force);
    TAPE(t, s->force);
    TAPE(t, s->tangential_force);
    TAPE(t, s->torsional_moment);
    TAPE(t, s->moment);
    TAPE(t, s->point);
    TAPE(t, s->elastic);
    TAPE(t, s->slip);
    TAPE(t, s->slip_total);
    TAPE(t, s->least_margin);
    TAPE(t, s->stiffness);
    TAPE(t, s->peak_normal_force);
}

static void tape_object(tape *t, world_object *object)
{
    TAPE(t, object->energy.kinetic_start);
    tape_flag(t, &object->touched);
    TAPE(t, object->force);
    TAPE(t, object->moment);
}

static void tape_joint(tape *t, world_joint *j)
{
    tape_flag(t, &j->moved);
    TAPE(t, j->energy.kinetic_start);
    TAPE(t, j->storage);
    TAPE(t, j->storage_start);
    TAPE(t, j->position);
    TAPE(t, j->velocity);
    TAPE(t, j->start_position);
    TAPE(t, j->target);
    TAPE(t, j->own_torque);
    TAPE(t, j->torque);
    tape_flag(t, &j->at_limit);
    tape_flag(t, &j->saturated);
}

static void tape_hand(tape *t, world_hand *h)
{
    for (int i = 0; i < h->joint_count; i++) tape_joint(t, &h->joints[i]);
    for (int i = 0; i < h->tie_count; i++) {
        TAPE(t, h->ties[i].position);
        TAPE(t, h->ties[i].force);
    }
}

static void tape_world(tape *t, world *w)
{
    TAPE(t, w->steps);
    TAPE(t, w->time);
    TAPE(t, w->loads);
    TAPE(t, w->elastic_initial);
    TAPE(t, w->elastic_before);
    TAPE(t, w->ledger);
    TAPE(t, w->depth_max);
    for (int i = 0; i < w->finger_count; i++) tape_finger(t, &w->fingers[i]);
    for (int i = 0; i < w->object_count; i++) tape_object(t, &w->objects[i]);
    for (int i = 0; i < w->hand_count; i++) tape_hand(t, &w->hands[i]);
}

/* ---- What was measured ---- */

static void tape_track(tape *t, track *k)
{
    TAPE(t, k->start);
    TAPE(t, k->middle);
    TAPE(t, k->touched);
    TAPE(t, k->start_in_hand);
    TAPE(t, k->middle_in_hand);
    tape_flag(t, &k->held);
    TAPE(t, k->fall_position);
    TAPE(t, k->fall_velocity);
    TAPE(t, k->fall_time);
}

static void tape_event(tape *t, simulation_event *event)
{
    TAPE(t, event->time);
    TAPE(t, event->finger);
    TAPE(t, event->object);
    TAPE(t, event->hand);
    TAPE(t, event->joint);
    TAPE(t, event->type);
    TAPE(t, event->value);
    TAPE(t, event->limit);
}

static void tape_events(tape *t, simulation *s)
{
    enum { EVENT_BYTES = 32 }; /* at least */
    int count = s->result.event_count;
    TAPE(t, count);
    if (t->reading) {
        t->damaged = t->damaged || count < 0 || (size_t)count > (t->size - t->at) / EVENT_BYTES;
        if (t->damaged) return;
        simulation_event *events = calloc((size_t)count + 1, sizeof *events);
        t->no_memory = !events;
        if (t->no_memory) return;
        free(s->result.events); /* those of what the run did before */
        s->result.events = events;
        s->event_room = count + 1;
        s->result.event_count = count;
    }
    for (int i = 0; i < count; i++) tape_event(t, &s->result.events[i]);
}

/* A text of which the run has its own, or NULL. */
static void tape_text(tape *t, char **text)
{
    int64_t size = *text ? (int64_t)strlen(*text) + 1 : 0;
    TAPE(t, size);
    if (t->reading) {
        t->damaged = t->damaged || size < 0 || (size_t)size > t->size - t->at;
        free(*text);
        *text = t->damaged || size == 0 ? NULL : malloc((size_t)size);
        t->no_memory = t->no_memory || (!t->damaged && size > 0 && !*text);
    }
    if (!*text) return;
    tape_bytes(t, *text, (size_t)size);
    if (t->reading) (*text)[size - 1] = '\0';
}

static void tape_measures(tape *t, simulation *s)
{
    const world *w = s->w;
    for (int i = 0; i < w->object_count; i++) {
        tape_track(t, &s->track[i]);
        TAPE(t, s->result.objects[i].speed_max);
    }
    for (int i = 0; i < w->finger_count; i++) {
        tape_flag(t, &s->crushed[i]);
        tape_flag(t, &s->slipped[i]);
    }
    for (int k = 0; k < w->hand_count; k++)
        for (int i = 0; i < w->hands[k].joint_count; i++) {
            tape_flag(t, &s->away[k][i]);
            tape_flag(t, &s->limited[k][i]);
        }
    tape_text(t, &s->result.overlap);
    tape_events(t, s);
}

/* ---- The whole ---- */

static void tape_counts(tape *t, const world *w)
{
    tape_expect(t, w->body_count);
    tape_expect(t, w->geom_count);
    tape_expect(t, w->object_count);
    tape_expect(t, w->finger_count);
    tape_expect(t, w->hand_count);
}

/* Writes the snapshot of plugin and world behind its size. */
static bool write_snapshot(tape *t, world *w, const part_lists *lists)
{
    size_t size = 0;
    if (pinch_ode_save(w->plugin, &lists->parts, NULL, &size) != PINCH_OK) return false;
    unsigned char *bytes = malloc(size);
    bool saved = bytes && pinch_ode_save(w->plugin, &lists->parts, bytes, &size) == PINCH_OK;
    if (saved) {
        uint64_t count = size;
        TAPE(t, count);
        tape_bytes(t, bytes, size);
    }
    free(bytes);
    return saved;
}

bool simulation_checkpoint(simulation *s, unsigned char **bytes, size_t *size)
{
    part_lists lists;
    char format[sizeof FORMAT];
    tape t = tape_write();
    if (!simulation_know_origin(s)) return false;
    uint64_t of = s->fingerprint;
    if (!list_parts(s->w, &lists)) return false;
    memcpy(format, FORMAT, sizeof format);
    TAPE(&t, format);
    TAPE(&t, of);
    tape_counts(&t, s->w);
    tape_world(&t, s->w);
    tape_measures(&t, s);
    bool written = write_snapshot(&t, s->w, &lists) && !t.no_memory;
    uint64_t sum = written ? tape_hash(0, t.bytes, t.size) : 0;
    TAPE(&t, sum);
    free_parts(&lists);
    if (!written || t.no_memory) {
        tape_free(&t);
        return false;
    }
    *bytes = t.bytes;
    *size = t.size;
    return true;
}

static checkpoint_status read_snapshot(tape *t, world *w)
{
    part_lists lists;
    uint64_t size;
    TAPE(t, size);
    if (t->no_memory || !list_parts(w, &lists)) return CHECKPOINT_NO_MEMORY;
    pinch_status status = t->damaged || size != t->size - t->at
                              ? PINCH_INVALID_ARGUMENT
                              : pinch_ode_restore(w->plugin, &lists.parts, t->bytes + t->at, (size_t)size);
    free_parts(&lists);
    if (status == PINCH_OUT_OF_MEMORY) return CHECKPOINT_NO_MEMORY;
    return status == PINCH_OK ? CHECKPOINT_FINE : CHECKPOINT_DAMAGED;
}

checkpoint_status simulation_resume(simulation *s, const unsigned char *bytes, size_t size)
{
    uint64_t sum, of;
    char format[sizeof FORMAT];
    if (size < sizeof format + 2 * sizeof sum) return CHECKPOINT_DAMAGED;
    memcpy(&sum, bytes + size - sizeof sum, sizeof sum);
    tape t = tape_read(bytes, size - sizeof sum);
    TAPE(&t, format);
    if (memcmp(format, FORMAT, sizeof format) != 0 || tape_hash(0, bytes, size - sizeof sum) != sum)
        return CHECKPOINT_DAMAGED;
    TAPE(&t, of);
    if (!simulation_know_origin(s)) return CHECKPOINT_NO_MEMORY;
    if (of != s->fingerprint) return CHECKPOINT_FOREIGN;
    tape_counts(&t, s->w);
    if (t.damaged) return CHECKPOINT_DAMAGED;
    tape_world(&t, s->w);
    tape_measures(&t, s);
    return read_snapshot(&t, s->w);
}
