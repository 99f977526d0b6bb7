/*
 * Which points that the collider did not return in a step the geoms still bear.
 *
 * Colliders leave points out: of a line one end, another one in the next step. But a point also goes because the
 * program takes it away, or because a shape is another one now. Where that is so, nothing may be left of it: what lies
 * on it would hover. So each point that is to be kept is asked for.
 */
#ifndef PINCH_CONTACTS_KEPT_POINTS_H
#define PINCH_CONTACTS_KEPT_POINTS_H

#include "contacts/contact_store.h"

enum { PINCH_MOST_FOUND = 128 };

/* What the collider returns when it is asked for a pair's contacts once more. */
typedef enum pinch_found_again {
    PINCH_NOT_ASKED_AGAIN,
    PINCH_FOUND_AGAIN,      /* among others, what the program handed over */
    PINCH_FOUND_BY_PROGRAM, /* not what the program handed over: that comes from elsewhere */
} pinch_found_again;

/* What is asked about the points of one pair in one step. */
typedef struct pinch_kept_points {
    const pinch_contact_store *store;
    const pinch_pair *pair;
    const pinch_pose *pose;
    double merge_distance;   /* m */
    pinch_found_again again; /* PINCH_NOT_ASKED_AGAIN at first */
    int found_count;
    dContactGeom found[PINCH_MOST_FOUND];
} pinch_kept_points;

void pinch_kept_points_init(pinch_kept_points *kept, const pinch_contact_store *store, const pinch_pair *pair,
                            const pinch_pose pose[2], double merge_distance);

/* Tells whether the geoms still bear the point, which has been moved along with them, and the program still wants it:
 * pinch_manifold_rules.bears for `kept`, a pinch_kept_points. */
bool pinch_geoms_bear(void *kept, const pinch_manifold_point *point, double slack);

/*
 * A program may dig a mesh or a height field away below a kept point, and hand over the contacts that it did before:
 * the pair would seem unchanged. So such points are watched. Returns the bits of those among `points` that are not
 * among the detected ones.
 */
uint64_t pinch_points_to_watch(const pinch_kept_points *kept, const pinch_manifold *points,
                               const pinch_detected_point *detected, int count);
/* Tells whether the watched points of a pair are still there whose contacts are those of the last step. */
bool pinch_watched_points_stay(const pinch_kept_points *kept);

#endif
