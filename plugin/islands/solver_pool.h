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
    int place;         /* by height */
    int first;         /* its first contact with what is below it; -1: none */
} pinch_rising_body;

/* A contact that pushes bodies up. */
typedef struct pinch_rising_contact {
    double push;  /* m/s that its overlap asks for */
    double lifts; /* the upward part of a push by 1 */
    double pace;  /* the part of the push that is not too fast */
    int below;    /* the lower body, -1 for the ground */
    int next;     /* the next one of the upper body */
} pinch_rising_contact;

typedef struct pinch_height {
    double height; /* m */
    int body;
} pinch_height;

/* A thread's lists count as those of problem buffers. */
typedef struct pinch_rise {
    PINCH_LIST(pinch_height) order;
    PINCH_LIST(pinch_rising_body) bodies;
    PINCH_LIST(pinch_rising_contact) contacts;
    bool slows; /* the pace of a contact is less than 1 */
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
/* Makes room for the bodies and contacts of a problem. Returns false when memory runs out. */
bool pinch_reserve_rise(pinch_rise *rise, int bodies, int contacts);
void pinch_problem_buffers_free(pinch_problem_buffers *buffers);
/* Gives back what a span of steps has not needed. */
void pinch_trim_solver_pool(pinch_solver_pool *pool, long step);

#endif
