/*
 * The contact store: everything about contacts that lives on from step to step.
 *
 *     geoms, materials     geoms that have been in a contact, and the materials they were given
 *     pairs                pairs of geoms in contact, each with its persistent manifold
 *     surfaces             ODE surface parameters in use, each kept once
 *     buffer               the contacts handed over for the next step, in the order in which they came
 *     results              the contact points of the last step, as pinch_ode_contacts reads them out
 */
#ifndef PINCH_CONTACTS_CONTACT_STORE_H
#define PINCH_CONTACTS_CONTACT_STORE_H

#include "contacts/manifold.h"
#include "contacts/surface.h"
#include "util/block_pool.h"
#include "util/key_map.h"
#include "util/list.h"
#include "util/prefetch.h"

#include <stdatomic.h>
#include <threads.h>

/*
 * One side of contacts: a geom that has been in one or was given a material, or, where contacts come without a geom,
 * a whole body or the world. Its number orders the sides of a pair. What comes at the address of one that is forgotten
 * has the record, and a new number: the order is not to depend on where memory lies.
 */
typedef struct pinch_geom_record {
    uint64_t key; /* the geom's address, or the body's, which is even, plus one */
    long number;  /* > 0, in the order in which they came; 0: forgotten, until it comes again */
    dGeomID geom; /* NULL: not known */
    dBodyID body; /* where the geom is not known; NULL: the world */
    double size;  /* diagonal of the box around it in its own axes, m; infinite for a plane; < 0: not measured yet */
    int material; /* index, -1 for none */
    bool forgot;  /* the pairs that it is in are forgotten */
} pinch_geom_record;

/* A material that one or more geoms share. */
typedef struct pinch_kept_material {
    pinch_material material;
    int users; /* geoms; 0: its place is free */
} pinch_kept_material;

/* Surface parameters that one or more contacts share. */
typedef struct pinch_kept_surface {
    uint64_t key; /* a hash of the parameters */
    pinch_surface surface;
} pinch_kept_surface;

/* Where a geom was, for contact laws that depend on its pose. */
typedef struct pinch_seen_pose {
    double pose[12]; /* position and rotation (rows) in the last step in which it had a contact */
    long step;       /* that step */
    bool stays;      /* it had the same pose, to the bit, in the step before */
} pinch_seen_pose;

/* How the program moves the bodies of a pair into each other by their poses, beside their velocities. */
typedef struct pinch_pose_motion {
    long seen_step;    /* the last in which it was solved */
    double seen_depth; /* of its deepest point then, m */
    double seen_normal[3];
    double apart;  /* of its bodies' centres along that normal at the end of that step, m */
    double way;    /* m, > 0: by which it last came in deeper than velocities explain; 0: never */
    long way_step; /* the step in which that was */
    long steps;    /* from the way before to that one; 0: there was none, or long before */
    double speed;  /* m/s, >= 0: of both ways, for as many steps more; 0: no pose is set */
} pinch_pose_motion;

/* A pair of geoms in contact, or of what stands for them. geom[0] has the smaller number. */
typedef struct pinch_pair {
    dGeomID id[2]; /* NULL: not known */
    dBodyID body[2];
    long last_step;                      /* the step it was last handed over for */
    int first_buffered, last_buffered;   /* its contacts in the buffer */
    int buffered_count, buffered_before; /* their number in this step and in the last */
    int expected;     /* where the last step had the contact that is to come next, -1: it had no more */
    int step_body[2]; /* its bodies in this step, -1: does not move by itself */
    bool unchanged;   /* its contacts are those of the last step, to the bit, and nothing moves them, or did so then */
    bool is_prescribed; /* a body of it moves as its owner prescribes */
    bool has_material;  /* otherwise its points have surface parameters of their own */
    uint64_t watched;   /* a bit for each of its points that is kept on a mesh or height field: see kept_points.h */
    int geom[2];        /* records */
    pinch_manifold manifold;
    int room;              /* points there is room for in the manifold's block */
    int island;            /* of this step */
    int points_when_built; /* points it had when the islands were built */
    int first_result;      /* of its points in the list of results */
    int first_in_island;   /* of its points among its island's contacts */
    bool overlaps_deeply;  /* its bodies are in each other rather than in touch: see island_contacts.c */
    double approach_depth; /* how deep its bodies have come into each other by their own motion within a step, m; no
                            * more than they are now */
    /* m: by how much its bodies have come into each other of late, the less the longer ago; and as the last step left
     * it, as a step may fill in its contacts more than once */
    double recent_approach, recent_approach_before;
    double paced_step; /* s, its longest step of late: its bodies part at the pace of that. See island_contacts.c */
    pinch_pose_motion posed;        /* where its points have laws of their own */
    double turned[3];               /* rad: how far body 0 turned against body 1 in the last step */
    double slip_total, twist_total; /* m, rad: paths slipped and twisted since its points began to press */
} pinch_pair;

/* A contact as it was handed over. What comes in the same place in the next step mostly is the same one again. */
typedef struct pinch_buffered_contact {
    double found[7]; /* position, normal, depth */
    int pair;        /* -1: it was forgotten after this came */
    int next;        /* the pair's next contact, -1 for its last */
    int surface;     /* index of its surface parameters, -1: the pair has a material */
    int direction;   /* index of the first friction direction that the program gave, -1 for none */
    int joint;       /* index of the contact joint it came with, -1 for none */
    int8_t point;    /* its place in the manifold, -1 for none */
    bool swapped;    /* the pair's first geom is the contact's second */
} pinch_buffered_contact;

typedef PINCH_LIST(pinch_buffered_contact) pinch_buffered_list;

/* A first friction direction as it was handed over. */
typedef struct pinch_direction {
    double tangent[3]; /* unit, world */
} pinch_direction;

/* A contact joint that the program made itself. */
typedef struct pinch_contact_joint {
    dJointID joint;
    dBodyID body[2]; /* as the program attached it */
    bool disabled;   /* while ODE steps */
} pinch_contact_joint;

typedef struct pinch_contact_store {
    PINCH_LIST(pinch_geom_record) geoms;
    pinch_item_index geom_index;
    long last_number;                       /* of a geom */
    PINCH_LIST(pinch_seen_pose) seen_poses; /* of the geoms, where laws_follow_poses */
    bool laws_follow_poses; /* a contact's law may depend on more of the geoms' poses than its own place */
    PINCH_LIST(pinch_kept_material) materials;
    int free_material; /* where the next free place is looked for first */

    PINCH_LIST(pinch_pair) pairs;
    pinch_item_index pair_index;
    bool forgot_pairs;                 /* some of them are, and go before the next contact comes: */
    pinch_key_map forgotten_bodies;    /* those of these, and of geoms that forgot theirs */
    PINCH_LIST(int) pairs_by_island;   /* indices of the pairs that have points, island by island */
    pinch_block_pool points, own_laws; /* of the pairs' manifolds */
    PINCH_LIST(pinch_detected_point) detected[PINCH_ODE_MOST_THREADS]; /* scratch of each worker */

    PINCH_LIST(pinch_kept_surface) surfaces;
    pinch_item_index surface_index;
    PINCH_LIST(int) surface_places; /* scratch of the sweep */
    bool any_bounces;               /* is there, or was there, a surface that does? */
    int surfaces_swept;             /* how many there were when unused ones were last dropped */
    int last_surface;               /* asked for, -1 for none */
    struct {
        dSurfaceParameters parameters; /* as the program gave them */
        bool swapped;                  /* see pinch_surface_of */
        int surface;                   /* -1: not known */
    } last_given;

    pinch_buffered_list buffer;
    PINCH_LIST(pinch_direction) directions;
    PINCH_LIST(pinch_contact_joint) contact_joints;
    int buffered_before, directions_before; /* the last step's, which are there as far as this step has not replaced
                                             * them; -1: unknown */
    struct {
        pinch_buffered_list contacts;
        PINCH_LIST(pinch_direction) directions;
        int first, first_direction; /* the places in the last step that these had */
        bool any;
    } put_aside; /* of the last step, where this one's contacts come in another order */
    bool behind; /* this step's contacts come behind those of the last step, whose directions are put aside */
    atomic_bool chains_cross; /* the contacts of some pair do not follow each other */
    int expected;             /* where the last step had what mostly comes next */
    PINCH_LIST(pinch_ode_contact) results;

    /* what is still as in the last step, as far as the contacts handed over so far tell */
    bool same_places;    /* pairs are where they were in their list, or their contacts know where they are */
    bool same_bodies;    /* pairs are between the bodies they were between */
    bool all_pairs_came; /* all that were handed over then have been so for this step */
    bool same_points;    /* and have as many points as when islands were built; known when they are up to date */
    bool unchanged;      /* all contacts are those of the last step, to the bit, and nothing moves them */

    mtx_t workers_lock; /* held while a worker takes blocks from the pools or gives them back, or has ODE compute the
                         * pose of a geom; stays where it is, and so comes last */
} pinch_contact_store;

void pinch_contact_store_init(pinch_contact_store *store);
void pinch_contact_store_free(pinch_contact_store *store);
/* Frees what the store has, and gives it what `other` has, which is not to be used any more. */
void pinch_contact_store_take(pinch_contact_store *store, pinch_contact_store *other);
size_t pinch_contact_store_bytes(const pinch_contact_store *store);

/* To be called when something was changed by hand, so that nothing of the last step is reused. */
void pinch_invalidate_step_cache(pinch_contact_store *store);

/* Returns the index of a geom's record, -1 where it has none. */
int pinch_find_geom(const pinch_contact_store *store, dGeomID geom);
/* Returns the index of a geom's record, or of a body's, or the world's, where the geom is NULL; it is made where there
 * is none. -1 when memory runs out. */
int pinch_add_side(pinch_contact_store *store, dGeomID geom, dBodyID body);
/* Forgets a side, whose pairs have to be forgotten: a geom, or a body where the geom is NULL. The material stays. */
void pinch_forget_side(pinch_contact_store *store, dGeomID geom, dBodyID body);
/* Tells whether a geom can have a pose: a plane has none, and a heightfield only where it was made so. */
bool pinch_geom_has_pose(dGeomID geom);
/* Returns the pose of a geom, or of a body where the geom is NULL, or the world's where both are. */
pinch_pose pinch_side_pose(dGeomID geom, dBodyID body);
/* Tells whether a side has the pose, to the bit, that it had when last asked for, in step `now` - 1. Only one thread
 * at a time may call this. */
bool pinch_geom_stays(pinch_contact_store *store, int record, long now);

/* Returns the index of surface parameters, where `guess` is an index to try first; -1 when memory runs out. Indices
 * that are kept elsewhere than in buffered contacts and own laws do not outlive the call. */
int pinch_keep_surface(pinch_contact_store *store, const pinch_surface *surface, int guess);
/* Tells whether an index is that of surface parameters. */
bool pinch_is_kept_surface(const pinch_contact_store *store, int index, const pinch_surface *surface);

/* load.c: sums up the results of the last step for a geom, with all partners where `partner` is NULL; see
 * pinch_ode_load. about: NULL for the centre of mass of the geom's body. PINCH_INVALID_ARGUMENT where it is not finite.
 */
pinch_status pinch_sum_load(const pinch_contact_store *store, dGeomID geom, dGeomID partner, const double *about,
                            pinch_ode_load *load);

/* Returns the k-th pair of an island, whose pairs are a range of the list pairs_by_island. */
static inline pinch_pair *pinch_island_pair(const pinch_contact_store *store, pinch_range range, int k)
{
    return &store->pairs.items[store->pairs_by_island.items[range.first + k]];
}

/* Asks ahead for a pair's points. */
static inline void pinch_prefetch_points(const pinch_pair *pair)
{
    size_t count = (size_t)pair->manifold.count;
    if (count > 0) pinch_prefetch(pair->manifold.point, count * sizeof *pair->manifold.point);
}

/* Asks ahead for their results. */
static inline void pinch_prefetch_results(const pinch_contact_store *store, const pinch_pair *pair)
{
    size_t count = (size_t)pair->manifold.count;
    if (count > 0) pinch_prefetch(&store->results.items[pair->first_result], count * sizeof *store->results.items);
}

/* Asks ahead for the laws of points that have their own. The points have been asked for before. */
static inline void pinch_prefetch_own_laws(const pinch_pair *pair)
{
    for (int k = 0; k < pair->manifold.count && !pair->has_material; k++)
        pinch_prefetch(pair->manifold.point[k].own, sizeof *pair->manifold.point[k].own);
}

/* What a pass reads of an island's pairs, besides their points. */
enum { PINCH_READS_RESULTS = 1, PINCH_READS_OWN_LAWS = 2 };

/* Asks ahead, at the k-th pair of an island, for the pairs that follow, and for what the pass reads of nearer ones. */
static inline void pinch_prefetch_island_pairs(const pinch_contact_store *store, pinch_range range, int k,
                                               unsigned reads)
{
    enum { PAIRS = 12, POINTS = 8, LAWS = 4 };
    if (k + PAIRS >= range.count) return;
    const pinch_pair *next = pinch_island_pair(store, range, k + POINTS);
    pinch_prefetch(pinch_island_pair(store, range, k + PAIRS), sizeof *next);
    pinch_prefetch_points(next);
    if (reads & PINCH_READS_RESULTS) pinch_prefetch_results(store, next);
    if (reads & PINCH_READS_OWN_LAWS) pinch_prefetch_own_laws(pinch_island_pair(store, range, k + LAWS));
}

/* Returns how far the centres of a pair's bodies are from each other along the normal that it was last seen with, m. */
static inline double pinch_pair_apart(const pinch_pair *pair)
{
    double apart = 0;
    for (int side = 0; side < 2; side++) {
        const double *x = pair->body[side] ? dBodyGetPosition(pair->body[side]) : NULL;
        for (int i = 0; i < 3 && x; i++) apart += (side ? -1 : 1) * pair->posed.seen_normal[i] * x[i];
    }
    return apart;
}

/* Returns the size of the smaller side of a pair, m. */
static inline double pinch_pair_size(const pinch_contact_store *store, const pinch_pair *pair)
{
    double a = store->geoms.items[pair->geom[0]].size, b = store->geoms.items[pair->geom[1]].size;
    return a < b ? a : b;
}

#endif
