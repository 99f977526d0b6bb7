/*
 * The registry knows which joints are alive, world by world in the order of their creation, and of contact joints the
 * contact that each was made from, as ODE has no getter for it. Every event costs constant time per joint, and the
 * logarithm of how many worlds, groups or joints outside of groups there are.
 *
 * Nothing in here calls ODE or takes a lock; all of it runs under the lock of state.c.
 */
#ifndef PINCH_DROPIN_REGISTRY_H
#define PINCH_DROPIN_REGISTRY_H

#include "joints/joint_pose.h"
#include "util/block_pool.h"
#include "util/key_map.h"

#include <pinch/ode_dropin.h>

typedef struct pinch_live_world pinch_live_world;
typedef struct pinch_live_group pinch_live_group;

typedef struct pinch_live_joint {
    dJointID joint;
    pinch_live_world *world;
    struct pinch_joint_list *list; /* of the world's: contact joints or others */
    pinch_live_group *group;       /* NULL: a joint of its own */
    struct pinch_live_joint *next, *previous;
    struct pinch_live_joint *group_next, *group_previous;
    dContact contact; /* of a contact joint */
    bool known[2];    /* g1 and g2 were geoms when it was made */
} pinch_live_joint;

typedef struct pinch_joint_list {
    pinch_live_joint *first, *last;
    long count;
} pinch_joint_list;

typedef struct pinch_layer_material {
    dGeomID geom;
    pinch_material material;
} pinch_layer_material;

/* What was destroyed: one of these. */
typedef struct pinch_layer_gone {
    dGeomID geom;
    dBodyID body;
    dJointID joint;
} pinch_layer_gone;

struct pinch_live_world {
    dWorldID id;
    pinch_live_world *next, *previous;
    pinch_joint_list contacts,
        others; /* contact joints; all others, through which the bodies that have any are found */
    /* Destroyed geoms that contacts of live joints may still name. Names are taken out before the next step, and before
     * a new geom in the same place of memory comes into a contact. */
    pinch_key_map gone;
    bool any_gone; /* some geoms of which nobody knows which they were: any name may be of one */

    pinch_joint_poses joint_poses;

    pinch_ode *plugin;                    /* NULL: no contact yet */
    bool busy;                            /* a step is under way: the plugin is that thread's */
    PINCH_LIST(pinch_layer_gone) waiting; /* destroyed meanwhile, for the plugin to forget */
    bool waiting_lost;    /* memory ran out for the list, or for what the plugin forgets: it starts afresh */
    bool asleep;          /* all that touches or has joints was disabled when it was last stepped */
    bool to_reset;        /* the statistics were reset meanwhile, those of the plugin will be */
    bool moved_callbacks; /* a body of it has had one: ODE moves all of them, and calls them */
    bool told;            /* that something in it was left to ODE for a while */
    PINCH_LIST(pinch_layer_material) materials;

    pinch_dropin_stats stats; /* .ode: of plugins that are gone */
    pinch_ode_stats current;  /* of the plugin */
};

typedef struct pinch_registry {
    pinch_live_world *worlds; /* newest first */
    void *world_tree, *group_tree, *joint_tree;
    pinch_key_map geoms;          /* 1 for those that there are, 0 for those that were */
    dGeomID last_geom;            /* found there last; NULL: none */
    pinch_live_world *last_world; /* looked up last */
    pinch_live_group *last_group;
    void (*joint_gone)(pinch_live_world *world, dJointID joint); /* NULL: nobody asks; not for contact joints */
    pinch_block_pool joints;                                     /* where the joints are; kept for good */
    pinch_dropin_stats ended;                                    /* of destroyed worlds */
} pinch_registry;

/* Returns NULL where the world is not known. */
pinch_live_world *pinch_registry_find_world(pinch_registry *r, dWorldID id);
/* Returns the world, which is known from now on; NULL when memory runs out. */
pinch_live_world *pinch_registry_world(pinch_registry *r, dWorldID id);
/* Takes a world and its joints out; the caller frees it with pinch_registry_free_world. */
void pinch_registry_take_world(pinch_registry *r, pinch_live_world *world);
void pinch_registry_free_world(pinch_live_world *world);

/* Adds a joint that was made. contact: NULL for one that is no contact joint. Returns false when memory runs out.
 * `group` may be NULL. */
bool pinch_registry_add_joint(pinch_registry *r, pinch_live_world *world, dJointGroupID group, dJointID joint,
                              const dContact *contact);
/* Drops a joint outside of groups; ODE does not destroy a joint of a group by itself. */
void pinch_registry_drop_joint(pinch_registry *r, dJointID joint);
void pinch_registry_empty_group(pinch_registry *r, dJointGroupID group);
void pinch_registry_drop_group(pinch_registry *r, dJointGroupID group);

/* Notes that there is a geom. Where memory runs out, it is a geom that nobody knows. */
void pinch_registry_note_geom(pinch_registry *r, dGeomID geom);
/* Notes that a geom is destroyed. */
void pinch_registry_drop_geom(pinch_registry *r, dGeomID geom);

/* Takes the name of a geom out of the contacts of live joints, or puts that off. */
void pinch_registry_forget_geom(pinch_live_world *world, dGeomID geom);
/* The same for geoms that nobody knows: it may be any name. */
void pinch_registry_forget_any_geom(pinch_live_world *world);
/* Does what these have put off. */
void pinch_registry_drop_names(pinch_live_world *world);

#endif
