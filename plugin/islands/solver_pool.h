/*
 * The solver pool: threads, each with a solver of its own and buffers that problems are written into.
 */
#ifndef PINCH_ISLANDS_SOLVER_POOL_H
#define PINCH_ISLANDS_SOLVER_POOL_H

#include "util/list.h"
#include "util/workers.h"

#include <pinch/problem.h>

/* Where a problem is written: that of the island a thread solves, or those of all islands one behind the other. A
 * thread's lists count the most that was needed since pinch_trim_solver_pool last looked. */
typedef struct pinch_problem_buffers {
    PINCH_LIST(pinch_body) bodies;
    PINCH_LIST(pinch_contact) contacts;
    PINCH_LIST(pinch_joint_row) rows; /* as many as pinch_island_joints.room for an island */
} pinch_problem_buffers;

/* A body as it comes up out of overlaps; see rise.c. */
typedef struct pinch_rising_body {
    double speed, way; /* m/s that contacts ask for, m that it goes, where those below it come up as well */
    double fastest;    /* m/s, that one contact asks for */
    double pace;       /* the part of `speed` that it, and what lies on it, may have */
    int below, above;  /* its first pairs in which it is the upper body, or the lower one; -1: none */
    int awaited;       /* bodies below it that have not been gone through */
} pinch_rising_body;

/* A pair of geoms whose contacts push the upper body up: the fastest of them, and the deepest. */
typedef struct pinch_rising_pair {
    double speed;                     /* m/s, the upward part of what an overlap asks for */
    double way;                       /* m, that of a depth */
    int upper, lower;                 /* its bodies, -1 for the ground */
    int next_of_upper, next_of_lower; /* pairs */
} pinch_rising_pair;

/* What the contacts of a part of an island's pairs ask for before its solve, and do in it; see push_out.c. */
typedef struct pinch_push_part {
    double asked;             /* J that overlaps ask for */
    double fastest, sum;      /* m/s that one of them asks for, and all */
    double steepest;          /* 1/s, of one over its depth */
    double surfaces;          /* m/s of the fastest surface */
    double power_of_surfaces; /* W */
    double lifting;           /* J of lifting where pairs come out of their overlaps, */
    double ways;              /* m that they come out, summed over */
    int leaving;              /* so many of them */
} pinch_push_part;

/* A thread's lists count as those of problem buffers. */
typedef struct pinch_rise {
    PINCH_LIST(pinch_rising_pair) pairs;
    PINCH_LIST(pinch_rising_body) bodies;
    PINCH_LIST(int) order; /* of bodies: each comes after those that it lies on */
    PINCH_LIST(pinch_push_part) parts;
    double up[3];         /* against what presses the bodies down */
    double acceleration;  /* m/s^2 by which it does, 0: nothing does */
    double sum, steepest; /* as in the parts, of all */
    bool slows;           /* the pace of a body is less than 1 */
} pinch_rise;

typedef struct pinch_solver_thread {
    pinch_step_solver *solver;
    pinch_problem_buffers buffers;
    pinch_problem_buffers first; /* an answer that stands until there is a better one */
    pinch_rise rise;
    pinch_problem_buffers before;     /* with a recorder: the problem as it was before its solve, */
    pinch_step_memory *memory_before; /* and its memory */
} pinch_solver_thread;

typedef struct pinch_solver_pool {
    int threads;            /* >= 1, the caller's own counted */
    pinch_workers *workers; /* NULL: one thread */
    pinch_crew crew;        /* the same for the loops of one island; not while they go through islands */
    pinch_solver_thread *thread;
    pinch_problem_buffers kept; /* with settings.keep_islands, instead of the threads' */
    long last_trim, trim_span;  /* the step of the last trim, steps until the next */
    size_t missed_above;        /* bytes above which what was last given back is missed; 0: nothing
                                 * was given back */
} pinch_solver_pool;

/* Returns false when memory runs out or the system gives no threads; the pool has to be destroyed all the same. */
bool pinch_solver_pool_create(pinch_solver_pool *pool, int threads);
void pinch_solver_pool_destroy(pinch_solver_pool *pool);
size_t pinch_solver_pool_bytes(const pinch_solver_pool *pool);

/* Makes room in the buffers. Returns false when memory runs out. */
bool pinch_reserve_problem(pinch_problem_buffers *buffers, int bodies, int contacts, int rows);
/* Makes a copy of a problem with items of its own, in these buffers. Returns false when memory runs out. */
bool pinch_copy_problem(const pinch_problem *problem, pinch_problem_buffers *to, pinch_problem *copy);
/* Copies the items of a problem to one that has as many. */
void pinch_copy_items(const pinch_problem *from, pinch_problem *to);
/* Makes room for the bodies and pairs of an island, and for the parts. Returns false when memory runs out. */
bool pinch_reserve_rise(pinch_rise *rise, int bodies, int pairs, int parts);
void pinch_problem_buffers_free(pinch_problem_buffers *buffers);
/* Gives back what a span of steps has not needed. */
void pinch_trim_solver_pool(pinch_solver_pool *pool, long step);

#endif
