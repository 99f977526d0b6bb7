/* Snapshots: the state of plugin and world as bytes, and back. */
#include "ode_state.h"

#include "snapshot/archive.h"
#include "snapshot/snapshot.h"
#include "util/checksum.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

/* At the start of a snapshot. Whoever reads it with other types than it was written with finds another `types`. */
typedef struct snapshot_head {
    char format[16];
    uint32_t order; /* of bytes */
    uint32_t types;
    uint64_t size; /* of the whole snapshot, its checksum at the end included */
} snapshot_head;

static snapshot_head head_of(size_t size)
{
    snapshot_head head = {.format = "pinch-ode/16", .order = 0x01020304, .size = size};
    head.types = sizeof(long) << 24 | sizeof(dReal) << 16 | sizeof(pinch_contact_model) << 8 | sizeof(dJointType);
    return head;
}

/* The checksum of the bytes before it, a word at a time; what is missing in the last word counts as 0. */
static uint64_t sum_of(const unsigned char *bytes, size_t size)
{
    uint64_t sum = pinch_checksum_start(1);
    for (size_t at = 0; at < size; at += sizeof(double)) {
        double word = 0;
        memcpy(&word, bytes + at, size - at < sizeof word ? size - at : sizeof word);
        sum = pinch_checksum(sum, &word, 1);
    }
    return sum;
}

/* What is read before anything is replaced. */
typedef struct restored {
    pinch_ode state; /* stores and numbers */
    pinch_joint_poses poses;
    pinch_world_state *world;
} restored;

static void archive_numbers(pinch_archive *a, pinch_ode *p)
{
    PINCH_ARCHIVE(a, p->context.number);
    if (p->context.number < 0 || p->context.number > LONG_MAX / 2) pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
    PINCH_ARCHIVE(a, p->last_h);
    PINCH_ARCHIVE(a, p->context.noise);
    PINCH_ARCHIVE(a, p->world_values);
    PINCH_ARCHIVE(a, p->stats);
    pinch_archive_flag(a, &p->recount_at_rest);
}

/* Nothing is known of the last step where something was changed by hand, or where it had things that are gone. */
static bool last_step_can_be_written(const pinch_archive *a, pinch_ode *p)
{
    pinch_archive trial = *a;
    trial.bytes = NULL;
    if (!p->contacts.same_bodies) return false;
    pinch_archive_last_step(&trial, &p->contacts, &p->graph, &p->joints, &p->pool.kept);
    return trial.status == PINCH_OK;
}

static void archive_last_step(pinch_archive *a, pinch_ode *p)
{
    bool known = !a->reading && a->status == PINCH_OK && last_step_can_be_written(a, p);
    pinch_archive_flag(a, &known);
    if (known) pinch_archive_last_step(a, &p->contacts, &p->graph, &p->joints, &p->pool.kept);
    if (!known) pinch_archive_row_forces(a, &p->joints);
    if (!known && !a->reading && a->bytes) pinch_invalidate_step_cache(&p->contacts); /* as where this is restored */
}

static void archive_all(pinch_archive *a, size_t size, pinch_ode *p, pinch_joint_poses *poses,
                        pinch_world_state **world)
{
    snapshot_head head = head_of(size), wanted = head;
    PINCH_ARCHIVE(a, head);
    if (memcmp(&head, &wanted, sizeof head) != 0) pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
    archive_numbers(a, p);
    pinch_archive_contacts(a, &p->contacts, p->context.number);
    pinch_archive_joints(a, &p->joints, poses);
    pinch_archive_islands(a, &p->graph);
    pinch_archive_near(a, &p->detection.near);
    archive_last_step(a, p);
    pinch_archive_world(a, world);
}

static bool between_steps(const pinch_ode *p)
{
    return !p->solved && !p->detecting && p->contacts.buffer.count == 0 && p->contacts.contact_joints.count == 0 &&
           p->graph.handed.count == 0;
}

/* Writes `size` bytes without the checksum; or, with `bytes` NULL, counts them. */
static pinch_status write_all(pinch_ode *p, const pinch_ode_parts *parts, unsigned char *bytes, size_t *size)
{
    pinch_archive a = pinch_archive_write(parts, bytes, *size);
    archive_all(&a, *size + sizeof(uint64_t), p, p->joints.poses, NULL);
    *size = a.at;
    pinch_archive_end(&a);
    return a.status;
}

pinch_status pinch_ode_save(pinch_ode *p, const pinch_ode_parts *parts, void *data, size_t *size)
{
    if (!p || !parts || !size || !between_steps(p)) return PINCH_INVALID_ARGUMENT;
    size_t room = *size, written = 0;
    pinch_drop_forgotten(p);
    pinch_status status = write_all(p, parts, NULL, &written);
    if (status != PINCH_OK) return status;
    *size = written + sizeof(uint64_t);
    if (!data) return PINCH_OK;
    if (room < *size) return PINCH_INVALID_ARGUMENT;
    status = write_all(p, parts, data, &written);
    if (status != PINCH_OK) return status;
    uint64_t sum = sum_of(data, written);
    memcpy((unsigned char *)data + written, &sum, sizeof sum);
    pinch_clean_spaces(parts); /* as they will be where this is restored */
    return PINCH_OK;
}

static void free_restored(restored *r)
{
    pinch_contact_store_free(&r->state.contacts);
    pinch_joint_store_free(&r->state.joints);
    pinch_island_graph_free(&r->state.graph);
    pinch_near_pairs_free(&r->state.detection.near);
    pinch_problem_buffers_free(&r->state.pool.kept);
    pinch_joint_poses_free(&r->poses);
    pinch_world_state_free(r->world);
}

/* Hands what was read over to the plugin. Nothing can fail any more. */
static void take_over(pinch_ode *p, restored *r)
{
    pinch_joint_poses *poses = p->joints.poses;
    bool own = poses == &p->joints.own_poses;
    pinch_contact_store_take(&p->contacts, &r->state.contacts);
    pinch_joint_store_free(&p->joints);
    p->joints = r->state.joints;
    p->joints.poses = own ? &p->joints.own_poses : poses;
    if (!own) pinch_joint_poses_free(poses);
    *p->joints.poses = r->poses;
    pinch_island_graph_free(&p->graph);
    p->graph = r->state.graph;
    pinch_near_pairs_free(&p->detection.near);
    p->detection.near = r->state.detection.near;
    pinch_problem_buffers_free(&p->pool.kept);
    p->pool.kept = r->state.pool.kept;
    p->context.number = r->state.context.number;
    p->last_h = r->state.last_h;
    memcpy(p->context.noise, r->state.context.noise, sizeof p->context.noise);
    memcpy(p->world_values, r->state.world_values, sizeof p->world_values);
    p->stats = r->state.stats;
    p->recount_at_rest = r->state.recount_at_rest;
}

static pinch_status read_all(const pinch_ode_parts *parts, const unsigned char *bytes, size_t size, restored *r)
{
    pinch_archive a = pinch_archive_read(parts, bytes, size - sizeof(uint64_t));
    pinch_contact_store_init(&r->state.contacts);
    archive_all(&a, size, &r->state, &r->poses, &r->world);
    if (a.at != a.size) pinch_archive_fail(&a, PINCH_INVALID_ARGUMENT);
    pinch_archive_end(&a);
    return a.status;
}

pinch_status pinch_ode_restore(pinch_ode *p, const pinch_ode_parts *parts, const void *data, size_t size)
{
    uint64_t sum;
    if (!p || !parts || !data || !between_steps(p)) return PINCH_INVALID_ARGUMENT;
    if (size < sizeof(snapshot_head) + sizeof sum) return PINCH_INVALID_ARGUMENT;
    memcpy(&sum, (const unsigned char *)data + size - sizeof sum, sizeof sum);
    if (sum_of(data, size - sizeof sum) != sum) return PINCH_INVALID_ARGUMENT;
    restored *r = calloc(1, sizeof *r);
    if (!r) return PINCH_OUT_OF_MEMORY;
    pinch_status status = read_all(parts, data, size, r);
    if (status == PINCH_OK) {
        r->state.contacts.laws_follow_poses = p->contacts.laws_follow_poses; /* a setting */
        take_over(p, r);
        pinch_restore_world(parts, r->world);
        pinch_world_state_free(r->world);
    } else {
        free_restored(r);
    }
    free(r);
    return status;
}
