#ifndef PINCH_COMPARE_JOBS_H
#define PINCH_COMPARE_JOBS_H

#include "command_status.h"

#include <jansson.h>
#include <stdatomic.h>
#include <stdbool.h>

/* Pieces of work in processes of their own, several at a time. A piece cannot disturb another one through memory,
 * random numbers, ODE's globals or a crash, and the results do not depend on how many run at once. */

typedef struct job_result {
    command_status status;
    json_t *document; /* NULL: none */
    char *messages;   /* what the process wrote to standard error; NULL: nothing */
} job_result;

/* How far a piece of work has come, in memory that its process shares with the one that waits for it. */
typedef struct job_share {
    _Atomic long done, all; /* steps; all is 0 before it is known */
    _Atomic double step;    /* s of simulated time */
} job_share;

/* There will be `all` steps of `step` seconds. */
void job_share_start(job_share *share, long all, double step);
/* A step is done. */
void job_share_step(job_share *share);

typedef struct job_list {
    int count, at_a_time;
    command_status (*work)(void *context, int index, job_share *share, json_t **document); /* runs in the child */
    const char *(*name)(void *context, int index);                                         /* for messages */
    void *context;
    bool progress; /* show a line on a terminal */
} job_list;

/* `results` has room for list->count results and gets them in order. Returns false when no process could be started or
 * followed; the reason is in errno. */
bool jobs_run(const job_list *list, job_result *results);
void jobs_free(job_result *results, int count);

/* The number of processors. */
int jobs_default(void);

#endif
