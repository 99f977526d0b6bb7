/* Pairs of geoms for `pinch bench collide`, about 1 m large, and the ways in which they meet. */
#ifndef PINCH_BENCH_COLLIDE_PAIRS_H
#define PINCH_BENCH_COLLIDE_PAIRS_H

#include <ode/ode.h>

#include <stdbool.h>

enum { COLLIDE_CASES = 9, COLLIDE_PAIRS = 23, COLLIDE_POSES = 500 };

/* A way to meet: the upper geom comes down on the lower one's top. */
typedef enum collide_turn {
    COLLIDE_TUMBLED, /* at random angles, half of them nearly upright */
    COLLIDE_UPRIGHT, /* its axis is the vertical, turned about it at random */
    COLLIDE_LYING    /* its axis is level */
} collide_turn;

typedef struct collide_case {
    const char *name;
    collide_turn turn;
    double overlap;   /* m, of the bounding boxes */
    bool border;      /* at the border of the lower one's top; otherwise well inside it */
    bool lower_lying; /* the lower geom lies on its side */
} collide_case;

extern const collide_case collide_cases[COLLIDE_CASES];

typedef struct collide_pair {
    const char *name; /* upper, lower */
    bool odes_too;    /* ODE has a collider */
    dGeomID upper, lower;
    double border;               /* m, from the lower geom's axis; 0: its top is a dome */
    bool has_turns, lower_turns; /* its turn makes a difference */
} collide_pair;

/* False: out of memory. */
bool collide_make_pairs(collide_pair pairs[COLLIDE_PAIRS]);
void collide_free_pairs(collide_pair pairs[COLLIDE_PAIRS]);

/* Whether the pair can meet like that. */
bool collide_has_case(const collide_pair *pair, const collide_case *c);

/* Where the upper geom is. */
typedef struct collide_pose {
    dQuaternion turn;
    double x, y, z;
} collide_pose;

/* Turns the lower geom, which is about the origin. */
void collide_set_lower(collide_pair *pair, const collide_case *c);
/* The upper one's poses (dRand), the lower one having been set. */
void collide_draw_poses(collide_pair *pair, const collide_case *c, collide_pose poses[COLLIDE_POSES]);

#endif
