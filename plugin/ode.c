/* Life and read-outs of the plugin. */
#include "plugin.h"

#include <stdlib.h>
#include <string.h>

pinch_ode_settings pinch_ode_default_settings(void)
{
    pinch_ode_settings settings = {
        .solver = pinch_default_solver_settings(),
        .stepper = PINCH_ODE_WORLDSTEP,
        .scope = PINCH_ODE_ALL_CONTACTS,
        .tangential_ratio = 2.0 / 3,
        .merge_distance = 0.05,
        .stale_tilt = 0.05,
        .threads = 1,
        .manifold_points = PINCH_MANIFOLD_POINTS,
    };
    return settings;
}

/* A solver for each thread, and the threads beside the caller's. */
static bool create_threads(pinch_ode *p, int threads)
{
    mtx_init(&p->blocks, mtx_plain);
    p->solver = calloc((size_t)threads, sizeof *p->solver);
    p->desk = calloc((size_t)threads, sizeof *p->desk);
    if (!p->solver || !p->desk) return false;
    for (; p->threads < threads; p->threads++)
        if (pinch_step_solver_create(&p->solver[p->threads]) != PINCH_OK) return false;
    if (threads > 1) p->workers = pinch_workers_create(threads);
    return threads == 1 || p->workers;
}

static void free_desk(pinch_desk *desk)
{
    free(desk->bodies.items);
    free(desk->contacts.items);
    free(desk->rows.items);
}

static void destroy_threads(pinch_ode *p)
{
    pinch_workers_destroy(p->workers);
    for (int k = 0; k < p->threads; k++) {
        pinch_step_solver_destroy(p->solver[k]);
        free_desk(&p->desk[k]);
    }
    free(p->solver);
    free(p->desk);
    free_desk(&p->kept);
    mtx_destroy(&p->blocks);
}

pinch_status pinch_ode_create(dWorldID world, const pinch_ode_settings *settings, pinch_ode **plugin)
{
    if (!world || !plugin) return PINCH_INVALID_ARGUMENT;
    pinch_status legal = pinch_check_settings(settings);
    if (legal != PINCH_OK) return legal;

    pinch_ode *p = calloc(1, sizeof *p);
    if (!p) return PINCH_OUT_OF_MEMORY;
    if (!create_threads(p, settings->threads)) {
        destroy_threads(p);
        free(p);
        return PINCH_OUT_OF_MEMORY;
    }
    p->world = world;
    p->joint_poses = &p->own_poses;
    p->settings = *settings;
    p->poses_count = settings->faces > 0; /* facets turn with their geom */
    p->left = dJointGroupCreate(0);
    p->points.item_size = sizeof(pinch_manifold_point);
    p->own_laws.item_size = sizeof(pinch_own_law);
    p->last_surface = -1;
    *plugin = p;
    return PINCH_OK;
}

void pinch_ode_destroy(pinch_ode *p)
{
    if (!p) return;
    dJointGroupDestroy(p->left);
    destroy_threads(p);
    pinch_item_index_free(&p->geom_index);
    pinch_item_index_free(&p->pair_index);
    pinch_item_index_free(&p->drive_index);
    pinch_joint_poses_free(&p->own_poses);
    pinch_item_index_free(&p->body_index);
    pinch_item_index_free(&p->joint_index);
    pinch_item_index_free(&p->reference_index);
    free(p->geoms.items);
    free(p->materials.items);
    free(p->poses.items);
    free(p->pairs.items);
    pinch_block_pool_free(&p->points);
    pinch_block_pool_free(&p->own_laws);
    free(p->taken.items);
    free(p->surfaces.items);
    free(p->directions.items);
    pinch_key_map_free(&p->surface_index);
    free(p->handed.items);
    free(p->drives.items);
    free(p->references.items);
    free(p->bodies.items);
    free(p->joints.items);
    free(p->attached.items);
    free(p->islands.items);
    free(p->pair_of.items);
    free(p->body_of.items);
    free(p->joint_of.items);
    free(p->contacts.items);
    free(p->left_contacts.items);
    free(p->order.items);
    for (int i = 0; i < p->memories.count; i++) pinch_step_memory_destroy(p->memories.items[i]);
    free(p->memories.items);
    free(p);
}

pinch_status pinch_ode_add_contact(pinch_ode *p, const dContact *contact, dBodyID body1, dBodyID body2)
{
    bool taken;
    if (!p || !contact || p->solved) return PINCH_INVALID_ARGUMENT;
    return pinch_take_contact(p, contact, body1, body2, -1, &taken);
}

pinch_status pinch_ode_add_joint(pinch_ode *p, dJointID joint, const dContact *contact)
{
    if (!p || !joint || !contact || p->solved) return PINCH_INVALID_ARGUMENT;
    int index = p->handed.count;
    bool taken;
    if (!PINCH_RESERVE(p->handed, index + 1)) return PINCH_OUT_OF_MEMORY;
    pinch_handed_joint *handed = &p->handed.items[index];
    handed->joint = joint;
    handed->body[0] = dJointGetBody(joint, 0);
    handed->body[1] = dJointGetBody(joint, 1);
    handed->disabled = false;
    if (!dJointIsEnabled(joint)) return PINCH_OK; /* the program has switched it off */
    pinch_status status = pinch_take_contact(p, contact, handed->body[0], handed->body[1], index, &taken);
    if (status == PINCH_OK && taken) p->handed.count++;
    return status;
}

pinch_status pinch_ode_note_joint(pinch_ode *p, dJointID joint)
{
    pinch_joint_pose pose;
    if (!p || !joint || !pinch_joint_pose_now(joint, &pose)) return PINCH_INVALID_ARGUMENT;
    pinch_joint_pose_keep(p->joint_poses, &pose);
    return PINCH_OK;
}

pinch_status pinch_ode_set_stepper(pinch_ode *p, pinch_ode_stepper stepper)
{
    if (!p || (stepper != PINCH_ODE_WORLDSTEP && stepper != PINCH_ODE_QUICKSTEP)) return PINCH_INVALID_ARGUMENT;
    p->settings.stepper = stepper;
    return PINCH_OK;
}

pinch_status pinch_ode_contacts(const pinch_ode *p, const pinch_ode_contact **list, int *count)
{
    if (!p || !list || !count) return PINCH_INVALID_ARGUMENT;
    *list = p->contacts.items;
    *count = p->contacts.count;
    return PINCH_OK;
}

/* bytes of a PINCH_LIST and of a key map */
#define LIST_BYTES(list) ((size_t)(list).room * sizeof *(list).items)

static size_t map_bytes(const pinch_key_map *map)
{
    return map->capacity * (sizeof *map->keys + sizeof *map->values);
}

size_t pinch_desk_bytes(const pinch_desk *desk)
{
    return LIST_BYTES(desk->bodies) + LIST_BYTES(desk->contacts) + LIST_BYTES(desk->rows);
}

pinch_ode_stats pinch_ode_statistics(const pinch_ode *p)
{
    pinch_ode_stats stats = p->stats;
    stats.memory = sizeof *p + p->points.bytes + p->own_laws.bytes + LIST_BYTES(p->geoms) + LIST_BYTES(p->materials) +
                   LIST_BYTES(p->poses) + LIST_BYTES(p->pairs) + LIST_BYTES(p->taken) + LIST_BYTES(p->surfaces) +
                   LIST_BYTES(p->directions) + LIST_BYTES(p->handed) + LIST_BYTES(p->drives) +
                   LIST_BYTES(p->references) + LIST_BYTES(p->bodies) + LIST_BYTES(p->joints) + LIST_BYTES(p->attached) +
                   LIST_BYTES(p->islands) + LIST_BYTES(p->pair_of) + LIST_BYTES(p->body_of) + LIST_BYTES(p->joint_of) +
                   LIST_BYTES(p->contacts) + LIST_BYTES(p->left_contacts) + LIST_BYTES(p->order) +
                   pinch_item_index_bytes(&p->geom_index) + pinch_item_index_bytes(&p->drive_index) +
                   pinch_item_index_bytes(&p->pair_index) + pinch_item_index_bytes(&p->body_index) +
                   pinch_item_index_bytes(&p->joint_index) + pinch_item_index_bytes(&p->reference_index) +
                   map_bytes(&p->surface_index) + pinch_desk_bytes(&p->kept);
    for (int k = 0; k < p->memories.count; k++) stats.memory += pinch_step_memory_size(p->memories.items[k]);
    for (int k = 0; k < p->threads; k++)
        stats.memory += pinch_step_solver_memory(p->solver[k], NULL) + pinch_desk_bytes(&p->desk[k]);
    return stats;
}

void pinch_ode_reset_statistics(pinch_ode *p)
{
    memset(&p->stats, 0, sizeof p->stats);
    p->recount = true;
}
