#ifndef PINCH_VIEW_FILM_H
#define PINCH_VIEW_FILM_H

#include "scenes/world/world.h"

/* A run as pictures: where every body is, and what every contact does, at a chosen rate. A frame is the state after a
 * step (the first one: before any step), so that its numbers are those of the run and not interpolated. A film outlives
 * its world, but not its scene. */

enum { FILM_NAME = 200 };

typedef enum film_kind { FILM_OBJECT = 0, FILM_FINGER, FILM_ENVIRONMENT } film_kind;

/* A shape of a body, placed in the body's axes. */
typedef struct film_part {
    scene_shape shape; /* its vertices are the scene's */
    double pose[7];    /* m; quaternion */
    dGeomID geom;      /* to be compared with others only */
} film_part;

typedef struct film_body {
    const char *name;
    film_kind kind;
    int part_count;
    film_part *parts;
    dBodyID body; /* NULL: it stands still at `place` */
    double place[7];
} film_body;

/* What one contact point does in a frame. A point keeps its pair and its place among the pair's points. */
typedef struct film_contact {
    int pair, place;
    pinch_contact_state state;
    double position[3], normal[3]; /* m; unit, into the pair's first body */
    double force[3];               /* N, on the pair's first body */
    double normal_force;           /* N */
    double friction;               /* coefficient */
    double margin;                 /* 1 - tangential force / friction limit; NAN without load or friction */
} film_contact;

/* Two bodies that touch, by their numbers. The force is that on the first one, which is the object if one is. */
typedef struct film_pair {
    int bodies[2];
    int places; /* the most points that it has in a frame */
} film_pair;

typedef struct film_finger {
    pinch_contact_state state;
    double normal_force, tangential_force; /* N */
    double margin;                         /* world_least_margin */
    double slip;                           /* m, path length */
    double force[3];                       /* N, on the object */
} film_finger;

/* What a finger did at most, over every step of the run and not only those of frames. NAN: never. */
typedef struct film_extremes {
    double first_slip;                      /* s: the end of the first step in which it slips as a whole */
    double least_margin, least_margin_time; /* world_least_margin; s */
    double peak_force, peak_force_time;     /* N, normal; s */
} film_extremes;

typedef struct film_frame {
    long step;
    double time; /* s */
    size_t first_contact;
    int contact_count;
} film_frame;

typedef struct film {
    const scene *scene;
    world_solver solver;
    double rate; /* frames a second, > 0 */
    int body_count, finger_count, pair_count;
    film_body *bodies;
    film_pair *pairs;
    size_t frame_count, contact_count;
    film_frame *frames;
    double *poses;                   /* body_count x 7 per frame */
    film_finger *fingers;            /* finger_count per frame */
    film_extremes *extremes;         /* finger_count */
    char (*finger_names)[FILM_NAME]; /* finger_count; of a link among several objects "LINK on OBJECT" */
    film_contact *contacts;
    double largest_force; /* N, of a contact point in any frame */
    size_t frame_room, contact_room, pair_room;
} film;

/* Begins with the world as it is. At most `most` frames are taken per second of simulated time, and at most one per
 * step. NULL when memory runs out. */
film *film_start(const world *w, double rate);
/* The hands of a world that has not made a step, as they are, without its objects. NULL when memory runs out. */
film *film_of_hands(const world *w);
/* Takes a frame where one is due; called after every step. Returns false when memory runs out. */
bool film_step(film *f, const world *w);
/* Takes the state in which the run has ended as the last frame, where it has not been taken. */
bool film_finish(film *f, const world *w);
void film_free(film *f); /* NULL is fine */

/* The body's pose in a frame. */
const double *film_pose(const film *f, size_t frame, int body);
/* The pair's point in a frame. NULL where the pair has not as many points. */
const film_contact *film_contact_at(const film *f, size_t frame, int pair, int place);

#endif
