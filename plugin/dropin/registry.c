#define _XOPEN_SOURCE 700 /* tsearch */

#include "dropin/registry.h"

#include <search.h>
#include <stdlib.h>
#include <string.h>

struct pinch_live_group {
    dJointGroupID id;
    pinch_live_joint *first, *last;
};

/* Orders records by their first member, the handle that they are found by. */
static int by_handle(const void *a, const void *b)
{
    uintptr_t x = (uintptr_t) * (void *const *)a, y = (uintptr_t) * (void *const *)b;
    return (x > y) - (x < y);
}

static void *find(void *const *tree, void *handle)
{
    void *const *node = tfind(&handle, tree, by_handle);
    return node ? *node : NULL;
}

pinch_live_world *pinch_registry_find_world(pinch_registry *r, dWorldID id)
{
    if (!r->last_world || r->last_world->id != id) r->last_world = find(&r->world_tree, id);
    return r->last_world;
}

pinch_live_world *pinch_registry_world(pinch_registry *r, dWorldID id)
{
    pinch_live_world *world = pinch_registry_find_world(r, id);
    if (world) return world;
    world = calloc(1, sizeof *world);
    if (!world) return NULL;
    world->id = id;
    if (!tsearch(world, &r->world_tree, by_handle)) {
        free(world);
        return NULL;
    }
    world->next = r->worlds;
    if (r->worlds) r->worlds->previous = world;
    return r->worlds = r->last_world = world;
}

static pinch_live_group *group_of(pinch_registry *r, dJointGroupID id)
{
    if (r->last_group && r->last_group->id == id) return r->last_group;
    pinch_live_group *group = find(&r->group_tree, id);
    if (group) return r->last_group = group;
    group = calloc(1, sizeof *group);
    if (!group) return NULL;
    group->id = id;
    if (!tsearch(group, &r->group_tree, by_handle)) {
        free(group);
        return NULL;
    }
    return r->last_group = group;
}

static pinch_live_joint *new_joint(pinch_registry *r)
{
    int room;
    r->joints.item_size = sizeof(pinch_live_joint);
    return pinch_block_take(&r->joints, 1, &room);
}

static void append(pinch_live_world *world, pinch_joint_list *list, pinch_live_group *group, pinch_live_joint *joint)
{
    joint->world = world;
    joint->list = list;
    joint->next = NULL;
    joint->previous = list->last;
    if (list->last)
        list->last->next = joint;
    else
        list->first = joint;
    list->last = joint;
    list->count++;

    joint->group = group;
    joint->group_next = NULL;
    joint->group_previous = group ? group->last : NULL;
    if (!group) return;
    if (group->last)
        group->last->group_next = joint;
    else
        group->first = joint;
    group->last = joint;
}

static bool is_gone(const pinch_live_world *world, dGeomID geom)
{
    return geom && (world->any_gone || pinch_key_map_get(&world->gone, (uint64_t)(uintptr_t)geom) >= 0);
}

static bool has_gone(const pinch_live_world *world)
{
    return world->any_gone || world->gone.entries.count > 0;
}

static void clear_gone(pinch_live_world *world)
{
    pinch_key_map_clear(&world->gone);
    world->any_gone = false;
}

/* Takes a joint out of its world and its group, or of the tree where it has none, and frees it. */
static void drop(pinch_registry *r, pinch_live_joint *joint)
{
    pinch_live_world *world = joint->world;
    pinch_joint_list *list = joint->list;
    pinch_live_group *group = joint->group;
    *(joint->previous ? &joint->previous->next : &list->first) = joint->next;
    *(joint->next ? &joint->next->previous : &list->last) = joint->previous;
    if (--list->count == 0 && list == &world->contacts) clear_gone(world);
    if (r->joint_gone && list == &world->others) r->joint_gone(world, joint->joint);
    if (group) {
        *(joint->group_previous ? &joint->group_previous->group_next : &group->first) = joint->group_next;
        *(joint->group_next ? &joint->group_next->group_previous : &group->last) = joint->group_previous;
    } else {
        (void)tdelete(joint, &r->joint_tree, by_handle);
    }
    pinch_block_give(&r->joints, joint, 1);
}

static bool is_geom(pinch_registry *r, dGeomID geom)
{
    if (!geom || (geom != r->last_geom && pinch_key_map_get(&r->geoms, (uint64_t)(uintptr_t)geom) != 1)) return false;
    r->last_geom = geom;
    return true;
}

void pinch_registry_note_geom(pinch_registry *r, dGeomID geom)
{
    (void)pinch_key_map_set(&r->geoms, (uint64_t)(uintptr_t)geom, 1);
}

void pinch_registry_drop_geom(pinch_registry *r, dGeomID geom)
{
    if (is_geom(r, geom)) (void)pinch_key_map_set(&r->geoms, (uint64_t)(uintptr_t)geom, 0);
    r->last_geom = NULL;
}

bool pinch_registry_add_joint(pinch_registry *r, pinch_live_world *world, dJointGroupID group, dJointID joint,
                              const dContact *contact)
{
    pinch_live_group *owner = group ? group_of(r, group) : NULL;
    pinch_live_joint *live = group && !owner ? NULL : new_joint(r);
    if (!live) return false;
    live->joint = joint;
    if (!group) {
        pinch_registry_drop_joint(r, joint); /* it was destroyed where nobody saw it */
        if (!tsearch(live, &r->joint_tree, by_handle)) {
            pinch_block_give(&r->joints, live, 1);
            return false;
        }
    }
    if (!contact) {
        append(world, &world->others, owner, live);
        return true;
    }
    /* a new geom where one was destroyed: the older contacts lose its name first */
    if (has_gone(world) && (is_gone(world, contact->geom.g1) || is_gone(world, contact->geom.g2)))
        pinch_registry_drop_names(world);
    live->contact = *contact;
    live->known[0] = is_geom(r, contact->geom.g1);
    live->known[1] = is_geom(r, contact->geom.g2);
    append(world, &world->contacts, owner, live);
    return true;
}

void pinch_registry_drop_joint(pinch_registry *r, dJointID joint)
{
    pinch_live_joint *live = find(&r->joint_tree, joint);
    if (live) drop(r, live);
}

void pinch_registry_empty_group(pinch_registry *r, dJointGroupID id)
{
    pinch_live_group *group = r->last_group && r->last_group->id == id ? r->last_group : find(&r->group_tree, id);
    while (group && group->last) drop(r, group->last);
}

void pinch_registry_drop_group(pinch_registry *r, dJointGroupID id)
{
    pinch_registry_empty_group(r, id);
    pinch_live_group *group = find(&r->group_tree, id);
    if (!group) return;
    if (r->last_group == group) r->last_group = NULL;
    (void)tdelete(group, &r->group_tree, by_handle);
    free(group);
}

void pinch_registry_take_world(pinch_registry *r, pinch_live_world *world)
{
    while (world->contacts.last) drop(r, world->contacts.last);
    while (world->others.last) drop(r, world->others.last);
    if (r->last_world == world) r->last_world = NULL;
    (void)tdelete(world, &r->world_tree, by_handle);
    *(world->previous ? &world->previous->next : &r->worlds) = world->next;
    if (world->next) world->next->previous = world->previous;
}

void pinch_registry_free_world(pinch_live_world *world)
{
    pinch_key_map_free(&world->gone);
    pinch_joint_poses_free(&world->joint_poses);
    free(world->waiting.items);
    free(world->materials.items);
    free(world);
}

static void unname(pinch_live_world *world, dGeomID geom)
{
    for (pinch_live_joint *joint = world->contacts.first; joint; joint = joint->next) {
        dContactGeom *g = &joint->contact.geom;
        if (geom ? g->g1 == geom : is_gone(world, g->g1)) g->g1 = NULL;
        if (geom ? g->g2 == geom : is_gone(world, g->g2)) g->g2 = NULL;
    }
}

void pinch_registry_drop_names(pinch_live_world *world)
{
    if (!has_gone(world)) return;
    unname(world, NULL);
    clear_gone(world);
}

void pinch_registry_forget_geom(pinch_live_world *world, dGeomID geom)
{
    if (!world->contacts.count || !geom || is_gone(world, geom)) return;
    if (!pinch_key_map_add(&world->gone, (uint64_t)(uintptr_t)geom, 1)) unname(world, geom);
}

void pinch_registry_forget_any_geom(pinch_live_world *world)
{
    world->any_gone = world->contacts.count > 0;
}
